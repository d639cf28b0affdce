"""Loops of `shapery_segmentation.seeding.symmetry`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def _value_at(image: Array, matrix: Array, offset: Array, i: int, j: int, k: int, outside: float) -> float:
    """Return the trilinear value of `image` at ``matrix @ (i, j, k) + offset``, beyond it `outside`."""
    x = matrix[0, 0] * i + matrix[0, 1] * j + matrix[0, 2] * k + offset[0]
    y = matrix[1, 0] * i + matrix[1, 1] * j + matrix[1, 2] * k + offset[1]
    z = matrix[2, 0] * i + matrix[2, 1] * j + matrix[2, 2] * k + offset[2]
    x0, y0, z0 = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    value = 0.0
    for a in range(2):
        wx = x - x0 if a == 1 else 1.0 - (x - x0)
        for b in range(2):
            wy = y - y0 if b == 1 else 1.0 - (y - y0)
            for c in range(2):
                w = wx * wy * (z - z0 if c == 1 else 1.0 - (z - z0))
                p, q, r = x0 + a, y0 + b, z0 + c
                inside = 0 <= p < image.shape[0] and 0 <= q < image.shape[1] and 0 <= r < image.shape[2]
                value += w * (image[p, q, r] if inside else outside)
    return value


@njit(cache=True, nogil=True)
def mirrored_correlation(image: Array, weight: Array, matrix: Array, offset: Array) -> float:
    """Return the correlation of `image` with itself at ``matrix @ index + offset``, over voxels of weight above 0.

    Voxels whose mirror image lies outside the array meet the value of the array's corner, which is background.
    """
    nx, ny, nz = image.shape
    outside = float(image[0, 0, 0])
    n = 0.0
    sx = sy = sxx = syy = sxy = 0.0
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if weight[i, j, k] <= 0.0:
                    continue
                value = _value_at(image, matrix, offset, i, j, k, outside)
                here = float(image[i, j, k])
                n += 1.0
                sx += here
                sy += value
                sxx += here * here
                syy += value * value
                sxy += here * value
    if n == 0.0:
        return 0.0
    vx = sxx - sx * sx / n
    vy = syy - sy * sy / n
    if vx <= 0.0 or vy <= 0.0:
        return 0.0
    return float((sxy - sx * sy / n) / np.sqrt(vx * vy))


@njit(cache=True, nogil=True)
def mirrored(image: Array, matrix: Array, offset: Array, out: Array) -> None:
    """Write into `out` the trilinear value of `image` at ``matrix @ index + offset``; 0 outside."""
    nx, ny, nz = image.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                out[i, j, k] = _value_at(image, matrix, offset, i, j, k, 0.0)

"""Loops of `shapery_segmentation.seeding.symmetry`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shapery_geometry.compilation import inlined, inner

Array = NDArray[Any]


@inner
def _across_border(image: Array, x: float, y: float, z: float, outside: float) -> float:
    """Return the trilinear value of `image` at a place whose cell may lie partly or wholly beyond it, as `outside`."""
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
    return float(value)


@inlined
def _value_at(image: Array, flat: Array, x: float, y: float, z: float, outside: float) -> float:
    """Return the trilinear value of `image`, of which `flat` is a view, at a place; beyond it `outside`."""
    nx, ny, nz = image.shape
    if not (0.0 <= x < nx - 1 and 0.0 <= y < ny - 1 and 0.0 <= z < nz - 1):
        return float(_across_border(image, x, y, z, outside))
    x0, y0, z0 = np.uint64(x), np.uint64(y), np.uint64(z)
    u, v, w = x - x0, y - y0, z - z0
    # Unsigned, or every index would be asked whether it counts from the end.
    one, row, plane = np.uint64(1), np.uint64(nz), np.uint64(ny * nz)
    at = x0 * plane + y0 * row + z0
    beyond = at + plane
    near = (1.0 - v) * ((1.0 - w) * flat[at] + w * flat[at + one]) + v * (
        (1.0 - w) * flat[at + row] + w * flat[at + row + one]
    )
    far = (1.0 - v) * ((1.0 - w) * flat[beyond] + w * flat[beyond + one]) + v * (
        (1.0 - w) * flat[beyond + row] + w * flat[beyond + row + one]
    )
    return float((1.0 - u) * near + u * far)


@njit(cache=True, nogil=True)
def mirrored_correlation(image: Array, weight: Array, matrix: Array, offset: Array) -> float:
    """Return the correlation of `image` with itself at ``matrix @ index + offset``, over voxels of weight above 0.

    Voxels whose mirror image lies outside the array meet the value of the array's corner, which is background. `image`
    is contiguous.
    """
    nx, ny, nz = image.shape
    flat = image.ravel()
    outside = float(image[0, 0, 0])
    n = 0.0
    sx = sy = sxx = syy = sxy = 0.0
    for i in range(nx):
        for j in range(ny):
            x = matrix[0, 0] * i + matrix[0, 1] * j + offset[0]
            y = matrix[1, 0] * i + matrix[1, 1] * j + offset[1]
            z = matrix[2, 0] * i + matrix[2, 1] * j + offset[2]
            for k in range(nz):
                if weight[i, j, k] <= 0.0:
                    continue
                value = _value_at(
                    image, flat, x + matrix[0, 2] * k, y + matrix[1, 2] * k, z + matrix[2, 2] * k, outside
                )
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
    """Write into `out` the trilinear value of `image`, contiguous, at ``matrix @ index + offset``; 0 outside."""
    nx, ny, nz = image.shape
    flat = image.ravel()
    for i in range(nx):
        for j in range(ny):
            x = matrix[0, 0] * i + matrix[0, 1] * j + offset[0]
            y = matrix[1, 0] * i + matrix[1, 1] * j + offset[1]
            z = matrix[2, 0] * i + matrix[2, 1] * j + offset[2]
            for k in range(nz):
                out[i, j, k] = _value_at(
                    image, flat, x + matrix[0, 2] * k, y + matrix[1, 2] * k, z + matrix[2, 2] * k, 0.0
                )

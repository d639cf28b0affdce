"""Loops over voxels that look for tubular structure."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def smooth(values: Array, result: Array) -> None:
    """Write means over 3³ voxels with the weights 1 2 1 along each axis; the border is repeated."""
    ni, nj, nk = values.shape
    plane = np.empty((nj, nk), dtype=np.float32)
    for i in range(ni):
        a, b = max(i - 1, 0), min(i + 1, ni - 1)
        for j in range(nj):
            for k in range(nk):
                plane[j, k] = 0.25 * (values[a, j, k] + values[b, j, k]) + 0.5 * values[i, j, k]
        for j in range(nj):
            c, d = max(j - 1, 0), min(j + 1, nj - 1)
            for k in range(nk):
                result[i, j, k] = 0.25 * (plane[c, k] + plane[d, k]) + 0.5 * plane[j, k]
            before = result[i, j, 0]
            for k in range(nk):
                here = result[i, j, k]
                after = result[i, j, min(k + 1, nk - 1)]
                result[i, j, k] = 0.25 * (before + after) + 0.5 * here
                before = here


@njit(cache=True, nogil=True)
def tubeness(values: Array, spacing: Array, unit: float, bright: Array, dark: Array) -> None:
    """Write how much each voxel lies on a bright, and on a dark, tube.

    Parameters
    ----------
    values : (I, J, K) float32
        Smoothed.
    spacing : (3,) float64
        mm.
    unit : float
        mm: the length that makes second derivatives differences.
    bright, dark : (I, J, K) float32
        Receive the least curvature across the tube, less that along it, where both across have the right sign.
    """
    ni, nj, nk = values.shape
    xx, yy, zz = (unit / spacing[0]) ** 2, (unit / spacing[1]) ** 2, (unit / spacing[2]) ** 2
    xy = unit * unit / (4 * spacing[0] * spacing[1])
    xz = unit * unit / (4 * spacing[0] * spacing[2])
    yz = unit * unit / (4 * spacing[1] * spacing[2])
    for i in range(1, ni - 1):
        for j in range(1, nj - 1):
            for k in range(1, nk - 1):
                c = 2.0 * values[i, j, k]
                a = (values[i + 1, j, k] + values[i - 1, j, k] - c) * xx
                d = (values[i, j + 1, k] + values[i, j - 1, k] - c) * yy
                f = (values[i, j, k + 1] + values[i, j, k - 1] - c) * zz
                b = (
                    values[i + 1, j + 1, k]
                    - values[i + 1, j - 1, k]
                    - values[i - 1, j + 1, k]
                    + values[i - 1, j - 1, k]
                ) * xy
                g = (
                    values[i + 1, j, k + 1]
                    - values[i + 1, j, k - 1]
                    - values[i - 1, j, k + 1]
                    + values[i - 1, j, k - 1]
                ) * xz
                e = (
                    values[i, j + 1, k + 1]
                    - values[i, j + 1, k - 1]
                    - values[i, j - 1, k + 1]
                    + values[i, j - 1, k - 1]
                ) * yz
                low, middle, high = eigenvalues(a, b, g, d, e, f)
                if middle < 0.0:
                    bright[i, j, k] = max(0.0, -middle - abs(high))
                elif middle > 0.0:
                    dark[i, j, k] = max(0.0, middle - abs(low))


@njit(cache=True, nogil=True)
def eigenvalues(a: float, b: float, c: float, d: float, e: float, f: float) -> tuple[float, float, float]:
    """Return the eigenvalues, rising, of the symmetric matrix [[a, b, c], [b, d, e], [c, e, f]]."""
    off = b * b + c * c + e * e
    q = (a + d + f) / 3.0
    p = np.sqrt(((a - q) ** 2 + (d - q) ** 2 + (f - q) ** 2 + 2.0 * off) / 6.0)
    if p <= 1e-12:
        return q, q, q
    u, v, w = (a - q) / p, (d - q) / p, (f - q) / p
    r, s, t = b / p, c / p, e / p
    half = 0.5 * (u * (v * w - t * t) - r * (r * w - t * s) + s * (r * t - v * s))
    angle = np.arccos(min(max(half, -1.0), 1.0)) / 3.0
    high = q + 2.0 * p * np.cos(angle)
    low = q + 2.0 * p * np.cos(angle + 2.0 * np.pi / 3.0)
    return low, 3.0 * q - high - low, high

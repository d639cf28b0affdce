"""Loops of `shapery_segmentation.registration`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def joint_histogram(
    data: Array, matrix: Array, offset: Array, points: Array, fixed: Array, low: float, high: float, joint: Array
) -> int:
    """Count which classes of the moving volume meet which of the fixed one.

    Parameters
    ----------
    data : (I, J, K) float32
        The moving volume.
    matrix, offset : (3, 3), (3,) float64
        From a point (RAS mm) to its index in `data`.
    points : (n, 3) float64
        Where the two are compared.
    fixed : (n,) int64
        Class of the fixed volume at each point.
    low, high : float
        Range of `data` that the classes divide. A value counts for the two classes it lies between, by its nearness.
    joint : (B, B) float64
        Receives the counts: fixed classes by moving ones.

    Returns
    -------
    int
        How many points lie in the moving volume; the outermost voxels reach half a voxel beyond their centres.
    """
    ni, nj, nk = data.shape
    bins = joint.shape[1]
    joint[:] = 0.0
    scale = (bins - 2) / max(high - low, 1e-30)
    count = 0
    for n in range(points.shape[0]):
        p, q, r = points[n, 0], points[n, 1], points[n, 2]
        x = matrix[0, 0] * p + matrix[0, 1] * q + matrix[0, 2] * r + offset[0]
        y = matrix[1, 0] * p + matrix[1, 1] * q + matrix[1, 2] * r + offset[1]
        z = matrix[2, 0] * p + matrix[2, 1] * q + matrix[2, 2] * r + offset[2]
        if not (-0.5 <= x <= ni - 0.5 and -0.5 <= y <= nj - 0.5 and -0.5 <= z <= nk - 0.5):
            continue
        count += 1
        x, y, z = min(max(x, 0.0), ni - 1.0), min(max(y, 0.0), nj - 1.0), min(max(z, 0.0), nk - 1.0)
        i, j, k = min(int(x), max(ni - 2, 0)), min(int(y), max(nj - 2, 0)), min(int(z), max(nk - 2, 0))
        i1, j1, k1 = min(i + 1, ni - 1), min(j + 1, nj - 1), min(k + 1, nk - 1)
        u, v, w = x - i, y - j, z - k
        a = (data[i, j, k] * (1.0 - w) + data[i, j, k1] * w) * (1.0 - v)
        a += (data[i, j1, k] * (1.0 - w) + data[i, j1, k1] * w) * v
        b = (data[i1, j, k] * (1.0 - w) + data[i1, j, k1] * w) * (1.0 - v)
        b += (data[i1, j1, k] * (1.0 - w) + data[i1, j1, k1] * w) * v
        at = (a * (1.0 - u) + b * u - low) * scale
        at = min(max(at, 0.0), bins - 2.0)
        lower = int(at)
        joint[fixed[n], lower] += 1.0 - (at - lower)
        joint[fixed[n], lower + 1] += at - lower
    return count


@njit(cache=True, nogil=True)
def mutual_information(joint: Array, count: int) -> float:
    """Return the mutual information in nat of a joint histogram (B, B) whose sum is `count`."""
    rows, columns = joint.sum(axis=1), joint.sum(axis=0)
    total = 0.0
    for i in range(joint.shape[0]):
        for j in range(joint.shape[1]):
            if joint[i, j] > 0.0:
                total += joint[i, j] * np.log(joint[i, j] * count / (rows[i] * columns[j]))
    return total / count

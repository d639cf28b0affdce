"""Loops of `shapery_segmentation.phantoms.vessels`: the share of every voxel that lies in a set of capsules."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shapery_segmentation.phantoms._anatomy_kernels import capsule

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def add_coverage(capsules: Array, boxes: Array, affine: Array, samples: int, coverage: Array) -> None:
    """Raise `coverage` to the share of each voxel that lies in the union of `capsules`.

    Parameters
    ----------
    capsules : (n, 8) float64
        Two ends and their radii, RAS mm.
    boxes : (n, 6) int64
        First and past-the-end voxel along each axis around each capsule.
    affine : (3, 4) float64
    samples : int
        Points along each axis at which a voxel at the border is looked at.
    coverage : (I, J, K) float32
        Zero where nothing was drawn.

    Notes
    -----
    Every voxel is looked at once, when the first capsule with it in its box is drawn; the others whose boxes hold it
    follow in the list of its block of 8³ voxels.
    """
    ni, nj, nk = coverage.shape
    a, b, c = (ni + 7) // 8, (nj + 7) // 8, (nk + 7) // 8
    count = np.zeros(a * b * c + 1, dtype=np.int64)
    for n in range(boxes.shape[0]):
        for i in range(boxes[n, 0] // 8, (boxes[n, 1] + 7) // 8):
            for j in range(boxes[n, 2] // 8, (boxes[n, 3] + 7) // 8):
                for k in range(boxes[n, 4] // 8, (boxes[n, 5] + 7) // 8):
                    count[(i * b + j) * c + k + 1] += 1
    first = np.cumsum(count)
    fill = first.copy()
    names = np.empty(first[-1], dtype=np.int64)
    for n in range(boxes.shape[0]):
        for i in range(boxes[n, 0] // 8, (boxes[n, 1] + 7) // 8):
            for j in range(boxes[n, 2] // 8, (boxes[n, 3] + 7) // 8):
                for k in range(boxes[n, 4] // 8, (boxes[n, 5] + 7) // 8):
                    block = (i * b + j) * c + k
                    names[fill[block]] = n
                    fill[block] += 1
    reach = 0.0
    for axis in range(3):
        reach += 0.5 * np.sqrt(affine[0, axis] ** 2 + affine[1, axis] ** 2 + affine[2, axis] ** 2)
    for block in range(a * b * c):
        if first[block] == first[block + 1]:
            continue
        i0, j0, k0 = 8 * (block // (b * c)), 8 * (block // c % b), 8 * (block % c)
        for i in range(i0, min(i0 + 8, ni)):
            for j in range(j0, min(j0 + 8, nj)):
                for k in range(k0, min(k0 + 8, nk)):
                    d = _distance(capsules, names, first[block], first[block + 1], affine, float(i), float(j), float(k))
                    if d >= reach:
                        continue
                    if d <= -reach:
                        coverage[i, j, k] = 1.0
                        continue
                    inside = 0
                    for u in range(samples):
                        for v in range(samples):
                            for w in range(samples):
                                x = i + (u + 0.5) / samples - 0.5
                                y = j + (v + 0.5) / samples - 0.5
                                z = k + (w + 0.5) / samples - 0.5
                                if _distance(capsules, names, first[block], first[block + 1], affine, x, y, z) < 0.0:
                                    inside += 1
                    coverage[i, j, k] = max(coverage[i, j, k], inside / samples**3)


@njit(cache=True, nogil=True)
def _distance(
    capsules: Array, names: Array, first: int, last: int, affine: Array, i: float, j: float, k: float
) -> float:
    x = affine[0, 0] * i + affine[0, 1] * j + affine[0, 2] * k + affine[0, 3]
    y = affine[1, 0] * i + affine[1, 1] * j + affine[1, 2] * k + affine[1, 3]
    z = affine[2, 0] * i + affine[2, 1] * j + affine[2, 2] * k + affine[2, 3]
    least = 1e9
    for n in range(first, last):
        least = min(least, capsule(x, y, z, capsules[names[n]]))
    return least

"""The flood from a seed: for every voxel the least tolerance with which a path from the seed reaches it."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray


@numba.njit(cache=True)
def flood(
    cost: NDArray[np.uint16], start: NDArray[np.int64], most: int, level: NDArray[np.uint16], volume: NDArray[np.int64]
) -> int:
    """Fill `level` with the least over all paths of the largest `cost` on the path; return how many are reached.

    Parameters
    ----------
    cost : (I, J, K) uint16
        Below ``len(volume)``; voxels of at least that are never entered.
    start : (n, 3) int64
        Voxels of level 0.
    most
        Voxels after which the flood ends.
    level : (I, J, K) uint16
        Written where reached; to be filled with the largest value before.
    volume : (levels,) int64
        Counts the voxels reached at each level.

    Notes
    -----
    A queue for each level, as lists through one array: the time is that of looking at each voxel's neighbours once.
    """
    ni, nj, nk = cost.shape
    levels = len(volume)
    head = np.full(levels, -1, dtype=np.int64)
    following = np.full(ni * nj * nk, -1, dtype=np.int64)
    seen = np.zeros(ni * nj * nk, dtype=np.uint8)
    for n in range(len(start)):
        at = (start[n, 0] * nj + start[n, 1]) * nk + start[n, 2]
        if not seen[at]:
            seen[at] = 1
            following[at] = head[0]
            head[0] = at
    reached = 0
    current = 0
    while current < levels and reached < most:
        at = head[current]
        if at < 0:
            current += 1
            continue
        head[current] = following[at]
        k = at % nk
        j = (at // nk) % nj
        i = at // (nk * nj)
        level[i, j, k] = current
        volume[current] += 1
        reached += 1
        for side in range(6):
            a, b, c = i, j, k
            step = 1 if side % 2 else -1
            if side < 2:
                a += step
            elif side < 4:
                b += step
            else:
                c += step
            if a < 0 or b < 0 or c < 0 or a >= ni or b >= nj or c >= nk:
                continue
            neighbour = (a * nj + b) * nk + c
            if seen[neighbour]:
                continue
            seen[neighbour] = 1
            rise = max(current, int(cost[a, b, c]))
            if rise < levels:
                following[neighbour] = head[rise]
                head[rise] = neighbour
    return reached

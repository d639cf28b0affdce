"""How a region grows from a seed, voxel by voxel, and how firmly each stage of it hangs together with the rest."""

from __future__ import annotations

import heapq

import numba
import numpy as np
from numpy.typing import NDArray


@numba.njit(cache=True)
def _neighbour(at: int, side: int, ni: int, nj: int, nk: int) -> int:
    """Return the number of the voxel beyond one of the six sides of a voxel, or −1 at the end of the array."""
    a, b, c = at // (nk * nj), (at // nk) % nj, at % nk
    step = 1 if side % 2 else -1
    if side < 2:
        a += step
    elif side < 4:
        b += step
    else:
        c += step
    if a < 0 or b < 0 or c < 0 or a >= ni or b >= nj or c >= nk:
        return -1
    return (a * nj + b) * nk + c


@numba.njit(cache=True)
def grow(
    values: NDArray[np.float32],
    seed: NDArray[np.int64],
    center: float,
    unlike: float,
    step: float,
    scale: float,
    most: int,
    order: NDArray[np.int64],
    held: NDArray[np.float64],
) -> int:
    """Write the voxels in the order in which a path from the seed reaches them at the least cost; return how many.

    A path costs `step` for each voxel on it, and the square of how far its value is from `center`, in `unlike`.

    Parameters
    ----------
    values : (I, J, K) float32
        Finite, in one piece of memory.
    seed : (3,) int64
    center, unlike, step : float
    scale : float
        A link between neighbours holds exp(−difference / scale).
    most
        Voxels after which it ends.
    order : (most,) int64
        Receives the voxels, numbered as in memory.
    held : (most,) float64
        Receives what the links hold between the region that ends there and the rest.
    """
    ni, nj, nk = values.shape
    flat = values.reshape(-1)
    cost = np.full(flat.size, np.inf, dtype=np.float32)
    inside = np.zeros(flat.size, dtype=np.bool_)
    first = (seed[0] * nj + seed[1]) * nk + seed[2]
    cost[first] = 0.0
    queue = [(np.float32(0.0), first)]
    count = 0
    total = 0.0
    while len(queue) > 0 and count < most:
        so_far, at = heapq.heappop(queue)
        if inside[at]:
            continue
        inside[at] = True
        order[count] = at
        for side in range(6):
            neighbour = _neighbour(at, side, ni, nj, nk)
            if neighbour < 0:
                continue
            link = np.exp(-abs(flat[neighbour] - flat[at]) / scale)
            if inside[neighbour]:
                total -= link
                continue
            total += link
            off = (flat[neighbour] - center) / unlike
            price = np.float32(so_far + step + off * off)
            if price < cost[neighbour]:
                cost[neighbour] = price
                heapq.heappush(queue, (price, neighbour))
        held[count] = total
        count += 1
    return count

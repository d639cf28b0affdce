"""How a region grows from a seed, voxel by voxel, and how firmly each stage of it hangs together with the rest."""

from __future__ import annotations

import heapq

import numba
import numpy as np
from numpy.typing import NDArray


@numba.njit(cache=True)
def _links(values, at, shape, scale, inside):  # type: ignore[no-untyped-def]
    """Return by how much the links across the border grow when a voxel joins the region."""
    ni, nj, nk = shape
    k = at % nk
    j = (at // nk) % nj
    i = at // (nk * nj)
    change = 0.0
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
        link = np.exp(-abs(values[neighbour] - values[at]) / scale)
        change += -link if inside[neighbour] else link
    return change


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
        total += _links(flat, at, values.shape, scale, inside)
        order[count] = at
        held[count] = total
        count += 1
        k = at % nk
        j = (at // nk) % nj
        i = at // (nk * nj)
        for side in range(6):
            a, b, c = i, j, k
            way = 1 if side % 2 else -1
            if side < 2:
                a += way
            elif side < 4:
                b += way
            else:
                c += way
            if a < 0 or b < 0 or c < 0 or a >= ni or b >= nj or c >= nk:
                continue
            neighbour = (a * nj + b) * nk + c
            if inside[neighbour]:
                continue
            off = (flat[neighbour] - center) / unlike
            price = np.float32(so_far + step + off * off)
            if price < cost[neighbour]:
                cost[neighbour] = price
                heapq.heappush(queue, (price, neighbour))
    return count

"""Shortest paths through the voxels of a vessel."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def shortest_paths(
    index: Array,
    voxels: Array,
    steps: Array,
    lengths: Array,
    cost: Array,
    sources: Array,
    distance: Array,
    parent: Array,
) -> None:
    """Dijkstra's algorithm over voxels and their 26 neighbours.

    Parameters
    ----------
    index : (I, J, K) int32
        Rank of each voxel, or −1; at least one layer of −1 all around.
    voxels : (n, 3) int32
    steps : (26, 3) int64
    lengths : (26,) float64
        mm.
    cost : (n,) float64
        Per mm, at each voxel.
    sources : (m,) int64
    distance : (n,) float64
        Receives the cost of the cheapest path; infinite where there is none.
    parent : (n,) int32
        Receives the voxel before on that path, −1 at sources.
    """
    n = voxels.shape[0]
    distance[:] = np.inf
    parent[:] = -1
    heap = np.empty(n, dtype=np.int64)
    place = np.full(n, -1, dtype=np.int64)
    size = 0
    for s in sources:
        distance[s] = 0.0
        size = _push(heap, place, distance, size, s)
    while size > 0:
        v = heap[0]
        size = _pop(heap, place, distance, size)
        place[v] = -2
        for q in range(steps.shape[0]):
            w = np.int64(index[voxels[v, 0] + steps[q, 0], voxels[v, 1] + steps[q, 1], voxels[v, 2] + steps[q, 2]])
            if w < 0 or place[w] == -2:
                continue
            way = distance[v] + 0.5 * lengths[q] * (cost[v] + cost[w])
            if way < distance[w]:
                distance[w] = way
                parent[w] = v
                if place[w] < 0:
                    size = _push(heap, place, distance, size, w)
                else:
                    _rise(heap, place, distance, place[w])


@njit(cache=True, nogil=True)
def _push(heap: Array, place: Array, key: Array, size: int, v: int) -> int:
    heap[size] = v
    place[v] = size
    _rise(heap, place, key, size)
    return size + 1


@njit(cache=True, nogil=True)
def _rise(heap: Array, place: Array, key: Array, at: int) -> None:
    v = heap[at]
    while at > 0:
        above = (at - 1) // 2
        u = heap[above]
        if key[u] <= key[v]:
            break
        heap[at] = u
        place[u] = at
        at = above
    heap[at] = v
    place[v] = at


@njit(cache=True, nogil=True)
def _pop(heap: Array, place: Array, key: Array, size: int) -> int:
    size -= 1
    if size == 0:
        return 0
    v = heap[size]
    at = 0
    while True:
        below = 2 * at + 1
        if below >= size:
            break
        if below + 1 < size and key[heap[below + 1]] < key[heap[below]]:
            below += 1
        u = heap[below]
        if key[v] <= key[u]:
            break
        heap[at] = u
        place[u] = at
        at = below
    heap[at] = v
    place[v] = at
    return size


@njit(cache=True, nogil=True)
def cover(index: Array, voxels: Array, path: Array, reach: Array, spacing: Array, covered: Array) -> None:
    """Note at the voxels within `reach` (mm, one for each) of the voxels of a path the first of these, if none is."""
    for n in range(path.shape[0]):
        v = path[n]
        r = reach[n]
        a, b, c = int(r / spacing[0]), int(r / spacing[1]), int(r / spacing[2])
        for i in range(-a, a + 1):
            for j in range(-b, b + 1):
                for k in range(-c, c + 1):
                    x, y, z = i * spacing[0], j * spacing[1], k * spacing[2]
                    if x * x + y * y + z * z > r * r:
                        continue
                    p, q, s = voxels[v, 0] + i, voxels[v, 1] + j, voxels[v, 2] + k
                    if 0 <= p < index.shape[0] and 0 <= q < index.shape[1] and 0 <= s < index.shape[2]:
                        w = index[p, q, s]
                        if w >= 0 and covered[w] < 0:
                            covered[w] = v

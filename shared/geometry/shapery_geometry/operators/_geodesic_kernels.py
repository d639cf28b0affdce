"""Compiled loops of `shapery_geometry.operators.geodesics`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def _push(heap_keys, heap_items, size, key, item):
    place = size
    while place > 0:
        parent = (place - 1) >> 1
        if heap_keys[parent] <= key:
            break
        heap_keys[place] = heap_keys[parent]
        heap_items[place] = heap_items[parent]
        place = parent
    heap_keys[place] = key
    heap_items[place] = item


@njit(cache=True, nogil=True)
def _sink(heap_keys, heap_items, size):
    """Put the last of `size` + 1 entries on top, where one was taken away."""
    key, item = heap_keys[size], heap_items[size]
    place = 0
    while True:
        child = 2 * place + 1
        if child >= size:
            break
        if child + 1 < size and heap_keys[child + 1] < heap_keys[child]:
            child += 1
        if heap_keys[child] >= key:
            break
        heap_keys[place] = heap_keys[child]
        heap_items[place] = heap_items[child]
        place = child
    heap_keys[place] = key
    heap_items[place] = item


@njit(cache=True, nogil=True)
def across(da, db, ab, bc, ca):
    """Distance of c through the triangle abc from a source whose distances from a and b are known.

    The source is laid out in the plane beyond ab. Infinite where the straight line does not cross ab.
    """
    x = (da * da - db * db + ab * ab) / (2 * ab)
    square = da * da - x * x
    if square < 0:
        return np.inf
    y = -np.sqrt(square)
    cx = (ca * ca - bc * bc + ab * ab) / (2 * ab)
    cy = np.sqrt(max(ca * ca - cx * cx, 0.0))
    if cy - y <= 0:
        return np.inf
    at = x + (cx - x) * (-y) / (cy - y)
    if at < 0 or at > ab:
        return np.inf
    return np.hypot(cx - x, cy - y)


@njit(cache=True, nogil=True)
def fans(faces, lengths, corners):
    """Lay out the faces around each vertex: (c, 2) their other corners, and (c, 3) the lengths va, ab and bv."""
    ends = np.empty((len(corners), 2), dtype=np.int32)
    sides = np.empty((len(corners), 3))
    for at in range(len(corners)):
        f, k = corners[at] // 3, corners[at] % 3
        ends[at, 0], ends[at, 1] = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
        sides[at, 0], sides[at, 1], sides[at, 2] = lengths[f, k], lengths[f, (k + 1) % 3], lengths[f, (k + 2) % 3]
    return ends, sides


@njit(cache=True, nogil=True)
def march(source, ends, sides, starts, link_starts, links, link_lengths, distances, done, keys, items):
    """Fill `distances` (n,) from one vertex: the fast marching method with point sources, plus links as they are."""
    n = len(distances)
    for v in range(n):
        distances[v] = np.inf
        done[v] = False
    distances[source] = 0.0
    size = 1
    keys[0] = 0.0
    items[0] = source
    while size > 0:
        v, key = items[0], keys[0]
        size -= 1
        _sink(keys, items, size)
        if done[v]:
            continue
        done[v] = True
        for at in range(link_starts[v], link_starts[v + 1]):
            w = links[at]
            d = key + link_lengths[at]
            if d < distances[w] and size < len(keys):
                distances[w] = d
                _push(keys, items, size, d, w)
                size += 1
        for at in range(starts[v], starts[v + 1]):
            a, b = ends[at, 0], ends[at, 1]
            if not done[a]:
                d = key + sides[at, 0]
                if done[b]:
                    d = min(d, across(key, distances[b], sides[at, 2], sides[at, 1], sides[at, 0]))
                if d < distances[a] and size < len(keys):
                    distances[a] = d
                    _push(keys, items, size, d, a)
                    size += 1
            if not done[b]:
                d = key + sides[at, 2]
                if done[a]:
                    d = min(d, across(key, distances[a], sides[at, 0], sides[at, 1], sides[at, 2]))
                if d < distances[b] and size < len(keys):
                    distances[b] = d
                    _push(keys, items, size, d, b)
                    size += 1


@njit(cache=True, nogil=True)
def march_all(sources, n, ends, sides, starts, link_starts, links, link_lengths):
    """(k, n) distances from each source."""
    result = np.empty((len(sources), n))
    done = np.empty(n, dtype=np.bool_)
    room = 4 * len(ends) + len(links) + 16
    keys, items = np.empty(room), np.empty(room, dtype=np.int64)
    for i in range(len(sources)):
        march(sources[i], ends, sides, starts, link_starts, links, link_lengths, result[i], done, keys, items)
    return result


@njit(cache=True, nogil=True)
def farthest_points(first, count, n, ends, sides, starts, link_starts, links, link_lengths):
    """(count,) vertices, each the farthest from those before it, and their (count, n) distances."""
    chosen = np.empty(count, dtype=np.int64)
    result = np.empty((count, n))
    done = np.empty(n, dtype=np.bool_)
    room = 4 * len(ends) + len(links) + 16
    keys, items = np.empty(room), np.empty(room, dtype=np.int64)
    nearest = np.full(n, np.inf)
    following = first
    for i in range(count):
        chosen[i] = following
        march(following, ends, sides, starts, link_starts, links, link_lengths, result[i], done, keys, items)
        farthest = -1.0
        for v in range(n):
            nearest[v] = min(nearest[v], result[i, v])
            if nearest[v] > farthest and np.isfinite(nearest[v]):
                farthest = nearest[v]
                following = v
    return chosen, result

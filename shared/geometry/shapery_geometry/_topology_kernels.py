"""Loops of `shapery_geometry.topology`: sets that are joined (union and find)."""

from __future__ import annotations

from typing import Any

from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(nogil=True)
def _root(parent: Array, a: int) -> int:
    """Return the first member of the set of `a`, and shorten the way to it."""
    while parent[a] != a:
        parent[a] = parent[parent[a]]
        a = parent[a]
    return a


@njit(nogil=True)
def _join(parent: Array, a: int, b: int) -> None:
    """Make one set of those of `a` and `b`; its root is its first member."""
    a, b = _root(parent, a), _root(parent, b)
    if a < b:
        parent[b] = a
    else:
        parent[a] = b


@njit(cache=True, nogil=True)
def join_pairs(a: Array, b: Array, parent: Array) -> None:
    """Join the sets of ``a[i]`` and ``b[i]`` for every i, and write the first member of its set to each of `parent`.

    Parameters
    ----------
    a, b : (k,) int32
    parent : (n,) int32
        Each its own parent at first.
    """
    for i in range(len(a)):
        _join(parent, a[i], b[i])
    for i in range(len(parent)):
        parent[i] = _root(parent, i)


@njit(cache=True, nogil=True)
def count_fans(faces: Array, face_edges: Array, last: Array, parent: Array, fans: Array) -> None:
    """Write to `fans` into how many fans the faces of each vertex fall: faces that are linked through edges at it.

    Parameters
    ----------
    faces, face_edges : (m, 3) int32
        Vertices of each face, and the edges from each corner to the next.
    last : (e,) int32
        −1 throughout; room.
    parent : (3m,) int32
        Each its own parent; room.
    fans : (n,) int64
        0 throughout.
    """
    for f in range(len(faces)):
        for k in range(3):
            side = 3 * f + k
            edge = face_edges[f, k]
            other = int(last[edge])
            last[edge] = side
            if other < 0:
                continue
            start, end = side, 3 * f + (k + 1) % 3
            g = other // 3
            for step in range(2):
                corner = other if step == 0 else 3 * g + (other % 3 + 1) % 3
                vertex = faces[g, corner % 3]
                if vertex == faces[f, k]:
                    _join(parent, start, corner)
                elif vertex == faces[f, (k + 1) % 3]:
                    _join(parent, end, corner)
    for corner in range(len(parent)):
        if parent[corner] == corner:
            fans[faces[corner // 3, corner % 3]] += 1

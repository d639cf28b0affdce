"""Loops of `shapery_segmentation.seeding.ball`: growth without change of topology, and the surface of the result.

The grid is cut into tetrahedra, each cube into six around one of its diagonals. A voxel then has 14 neighbours (those
it shares a tetrahedron with), inside and outside connect through the same 14, and the surface between them is a
manifold whatever the voxels.
"""

from __future__ import annotations

import heapq
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]

_UP = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (1, 1, 1))
OFFSETS = np.array(_UP + tuple((-a, -b, -c) for a, b, c in _UP), dtype=np.int64)
"""(14, 3) the neighbours in this tetrahedralisation."""

_DIFFERENCE = OFFSETS[:, None, :] - OFFSETS[None, :, :]
ADJACENT = (_DIFFERENCE[:, :, None, :] == OFFSETS).all(axis=3).any(axis=2)
"""(14, 14) which of the neighbours are neighbours of each other: the link of a voxel, a triangulated sphere."""

TETRAHEDRA = np.array(
    [[0, 4, 6, 7], [0, 6, 2, 7], [0, 2, 3, 7], [0, 3, 1, 7], [0, 1, 5, 7], [0, 5, 4, 7]], dtype=np.int64
)
"""(6, 4) corners of a cube, numbered 4·i + 2·j + k, of the tetrahedra around its diagonal from 0 to 7."""


@njit(cache=True, nogil=True)
def simple_table(adjacent: Array, table: Array) -> None:
    """Write for each of the 2¹⁴ neighbourhoods whether flipping its centre keeps the topology.

    On a sphere that is so exactly if the neighbours inside are one piece and those outside are one piece.
    """
    stack = np.empty(14, np.int64)
    for code in range(table.shape[0]):
        pieces_in, pieces_out = 0, 0
        seen = np.zeros(14, np.bool_)
        for start in range(14):
            if seen[start]:
                continue
            value = (code >> start) & 1
            if value == 1:
                pieces_in += 1
            else:
                pieces_out += 1
            stack[0] = start
            seen[start] = True
            top = 1
            while top > 0:
                top -= 1
                u = stack[top]
                for v in range(14):
                    if adjacent[u, v] and not seen[v] and (code >> v) & 1 == value:
                        seen[v] = True
                        stack[top] = v
                        top += 1
        table[code] = pieces_in == 1 and pieces_out == 1


@njit(cache=True, nogil=True)
def grow(priority: Array, start: Array, offsets: Array, table: Array, ball: Array) -> int:
    """Add to `ball` voxels of positive `priority`, highest first, as long as none changes the topology.

    Parameters
    ----------
    priority : (I, J, K) float32
        0 where the ball may not go. The outermost layer must be 0.
    start : (3,) int64
        The first voxel.
    ball : (I, J, K) bool
        Written; empty at first.

    Returns
    -------
    The number of voxels.
    """
    queued = np.zeros(priority.shape, np.bool_)
    ny, nz = priority.shape[1], priority.shape[2]
    heap = [(-float(priority[start[0], start[1], start[2]]), (start[0] * ny + start[1]) * nz + start[2])]
    queued[start[0], start[1], start[2]] = True
    count = 0
    while len(heap) > 0:
        _, key = heapq.heappop(heap)
        i, j, k = key // (ny * nz), (key // nz) % ny, key % nz
        queued[i, j, k] = False
        code = 0
        for n in range(14):
            if ball[i + offsets[n, 0], j + offsets[n, 1], k + offsets[n, 2]]:
                code |= 1 << n
        if count > 0 and not table[code]:
            # A neighbour that joins later asks again.
            continue
        ball[i, j, k] = True
        count += 1
        for n in range(14):
            a, b, c = i + offsets[n, 0], j + offsets[n, 1], k + offsets[n, 2]
            if priority[a, b, c] > 0 and not ball[a, b, c] and not queued[a, b, c]:
                queued[a, b, c] = True
                heapq.heappush(heap, (-float(priority[a, b, c]), (a * ny + b) * nz + c))
    return count


@njit(cache=True, nogil=True)
def march(ball: Array, tetrahedra: Array, pairs: Array) -> int:
    """Write the triangles between inside and outside: each corner as the pair of voxels it lies half-way between.

    Parameters
    ----------
    ball : (I, J, K) bool
        The outermost layer must be outside.
    pairs : (m, 3, 2) int64
        Written: flat indices of the voxels inside and outside. Nothing is written if m is 0.

    Returns
    -------
    The number of triangles.
    """
    nx, ny, nz = ball.shape
    write = pairs.shape[0] > 0
    corner = np.empty(8, np.int64)
    inside = np.empty(4, np.int64)
    outside = np.empty(4, np.int64)
    position = np.empty((4, 3))
    count = 0
    for i in range(nx - 1):
        for j in range(ny - 1):
            for k in range(nz - 1):
                total = 0
                for c in range(8):
                    a, b, d = i + (c >> 2), j + ((c >> 1) & 1), k + (c & 1)
                    corner[c] = (a * ny + b) * nz + d
                    if ball[a, b, d]:
                        total += 1
                if total == 0 or total == 8:
                    continue
                for t in range(6):
                    n_in, n_out = 0, 0
                    for n in range(4):
                        c = tetrahedra[t, n]
                        if ball[i + (c >> 2), j + ((c >> 1) & 1), k + (c & 1)]:
                            inside[n_in] = c
                            n_in += 1
                        else:
                            outside[n_out] = c
                            n_out += 1
                    if n_in == 0 or n_out == 0:
                        continue
                    quads = 2 if n_in == 2 else 1
                    if write:
                        # Corners in turn around the section: a triangle or, for two and two, a quadrilateral.
                        if n_in == 1:
                            order = ((inside[0], outside[0]), (inside[0], outside[1]), (inside[0], outside[2]))
                        elif n_in == 3:
                            order = ((inside[0], outside[0]), (inside[1], outside[0]), (inside[2], outside[0]))
                        else:
                            order = ((inside[0], outside[0]), (inside[0], outside[1]), (inside[1], outside[1]))
                        for n in range(3):
                            for axis in range(3):
                                bit = 2 - axis
                                position[n, axis] = 0.5 * ((order[n][0] >> bit) & 1) + 0.5 * ((order[n][1] >> bit) & 1)
                        for axis in range(3):
                            bit = 2 - axis
                            position[3, axis] = float((outside[0] >> bit) & 1) - float((inside[0] >> bit) & 1)
                        # The normal must point from inside to outside.
                        u, v = position[1] - position[0], position[2] - position[0]
                        outward = (
                            (u[1] * v[2] - u[2] * v[1]) * position[3, 0]
                            + (u[2] * v[0] - u[0] * v[2]) * position[3, 1]
                            + (u[0] * v[1] - u[1] * v[0]) * position[3, 2]
                        )
                        first, second = (1, 2) if outward > 0 else (2, 1)
                        for place, source in ((0, 0), (first, 1), (second, 2)):
                            pairs[count, place, 0] = corner[order[source][0]]
                            pairs[count, place, 1] = corner[order[source][1]]
                        if quads == 2:
                            # The other half: first, third and fourth corner, turned the same way.
                            pairs[count + 1, 0, 0] = corner[inside[0]]
                            pairs[count + 1, 0, 1] = corner[outside[0]]
                            pairs[count + 1, first, 0] = corner[inside[1]]
                            pairs[count + 1, first, 1] = corner[outside[1]]
                            pairs[count + 1, second, 0] = corner[inside[1]]
                            pairs[count + 1, second, 1] = corner[outside[0]]
                    count += quads
    return count

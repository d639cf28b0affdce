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

NEAREST = 0.1
"""Share of the way between two voxels that the surface keeps from both."""

_TETRAHEDRA = ((0, 4, 6, 7), (0, 6, 2, 7), (0, 2, 3, 7), (0, 3, 1, 7), (0, 1, 5, 7), (0, 5, 4, 7))
"""Corners of a cube, numbered 4·i + 2·j + k, of the tetrahedra around its diagonal from 0 to 7."""


def _rings() -> Array:
    """Return the neighbours that an edge to one of the first seven has around it, as `number_crossings` takes them."""
    rings = np.full((7, 6, 2), -1, dtype=np.int64)
    index = {tuple(offset): n for n, offset in enumerate(OFFSETS.tolist())}
    for d in range(7):
        left = [n for n in range(14) if ADJACENT[n, d]]
        turn = [left.pop(0)]
        while left:
            after = next(n for n in left if ADJACENT[n, turn[-1]])
            left.remove(after)
            turn.append(after)
        for place, n in enumerate(turn):
            rings[d, place] = n, index[tuple((OFFSETS[n] - OFFSETS[d]).tolist())]
    return rings


def _triangles() -> tuple[Array, Array]:
    """Return the triangles in a cube for each choice of its corners, as `march` takes them, and how many they are."""
    place = [np.array((c >> 2, (c >> 1) & 1, c & 1)) for c in range(8)]
    index = {tuple(offset): n for n, offset in enumerate(OFFSETS.tolist())}
    triangles = np.zeros((256, 12, 3, 2), dtype=np.int64)
    sizes = np.zeros(256, dtype=np.int64)
    for at in range(256):
        for tetrahedron in _TETRAHEDRA:
            inside = [c for c in tetrahedron if (at >> c) & 1]
            outside = [c for c in tetrahedron if not (at >> c) & 1]
            turns: list[list[tuple[int, int]]] = []
            if len(inside) == 2:
                (a, b), (c, d) = inside, outside
                turns = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
            elif inside and outside:
                turns = [[(a, b) for a in inside for b in outside]]
            for turn in turns:
                p, q, r = (place[a] + place[b] for a, b in turn)
                if np.dot(np.cross(q - p, r - p), place[outside[0]] - place[inside[0]]) < 0:
                    turn.reverse()
                triangles[at, sizes[at]] = [(a, index[tuple((place[b] - place[a]).tolist())]) for a, b in turn]
                sizes[at] += 1
    return triangles, sizes


RINGS = _rings()
TRIANGLES, SIZES = _triangles()


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
def piece_table(adjacent: Array, pieces: Array, counts: Array) -> None:
    """Write how the crossings of a voxel inside are drawn together, for each of the 2¹⁴ neighbourhoods.

    The neighbours outside, as points of the sphere that all neighbours form, fall into pieces. One that is a disc, with
    a border of at least three voxels, may become one vertex; the crossings of others stay by themselves.

    Parameters
    ----------
    adjacent : (14, 14) bool
    pieces : (2¹⁴, 14) int8
        Receives for each neighbour outside the number of its vertex.
    counts : (2¹⁴,) int8
        Receives how many vertices there are.
    """
    stack = np.empty(14, np.int64)
    piece = np.empty(14, np.int64)
    size = np.empty(14, np.int64)
    for code in range(counts.shape[0]):
        piece[:] = -1
        total = 0
        for start in range(14):
            if piece[start] >= 0:
                continue
            value = (code >> start) & 1
            stack[0] = start
            piece[start] = total
            size[total] = 0
            top = 1
            while top > 0:
                top -= 1
                u = stack[top]
                size[total] += 1
                for v in range(14):
                    if adjacent[u, v] and piece[v] < 0 and (code >> v) & 1 == value:
                        piece[v] = total
                        stack[top] = v
                        top += 1
            total += 1
        count = 0
        for number in range(total):
            border = -1
            disc = True
            first = -1
            for u in range(14):
                if piece[u] != number or (code >> u) & 1:
                    continue
                first = u if first < 0 else first
                for v in range(14):
                    if adjacent[u, v] and (code >> v) & 1:
                        disc = disc and border in (-1, piece[v])
                        border = piece[v]
            if first < 0:
                continue
            disc = disc and border >= 0 and size[border] >= 3
            for u in range(14):
                if piece[u] == number:
                    pieces[code, u] = count
                    count += not disc
            count += disc
        counts[code] = count


@njit(cache=True, nogil=True)
def number_crossings(
    ball: Array, offsets: Array, rings: Array, pieces: Array, counts: Array, even: bool, first: Array, code: Array
) -> int:
    """Give numbers to the vertices of the surface between inside and outside.

    Parameters
    ----------
    ball : (I, J, K) bool
        The outermost layer must be outside.
    offsets : (14, 3) int64
    rings : (7, 6, 2) int64
        The voxels around an edge, in turn, as neighbours of its two ends; −1 beyond the fourth of four.
    pieces, counts
        Of `piece_table`.
    even : bool
        Draw crossings together where that keeps the surface a manifold.
    first : (I, J, K) int32
        Receives the first vertex of each voxel inside that has neighbours outside.
    code : (I, J, K) int32
        Receives its neighbourhood, plus 2¹⁴ where every crossing is a vertex by itself.

    Returns
    -------
    The number of vertices.
    """
    nx, ny, nz = ball.shape
    whole = (1 << 14) - 1
    for i in range(1, nx - 1):
        for j in range(1, ny - 1):
            for k in range(1, nz - 1):
                if not ball[i, j, k]:
                    continue
                found = 0 if even else 1 << 14
                for n in range(14):
                    if ball[i + offsets[n, 0], j + offsets[n, 1], k + offsets[n, 2]]:
                        found |= 1 << n
                code[i, j, k] = found
    count = 0
    p = np.empty(3, np.int64)
    r = np.empty(3, np.int64)
    for i in range(1, nx - 1):
        for j in range(1, ny - 1):
            for k in range(1, nz - 1):
                own = code[i, j, k]
                if not ball[i, j, k] or own & whole == whole:
                    continue
                # Two vertices must not be joined twice: once on either side of something thin.
                for d in range(7):
                    other = code[i + offsets[d, 0], j + offsets[d, 1], k + offsets[d, 2]]
                    if own > whole or not (own >> d) & 1 or other >= whole:
                        continue
                    length = 6 if rings[d, 5, 0] >= 0 else 4
                    runs = 0
                    for n in range(length):
                        a, before = rings[d, n, 0], rings[d, (n + length - 1) % length, 0]
                        if not (own >> a) & 1 and (own >> before) & 1:
                            p[runs], r[runs] = pieces[own, a], pieces[other, rings[d, n, 1]]
                            for m in range(runs):
                                if p[m] == p[runs] and r[m] == r[runs]:
                                    own |= 1 << 14
                                    break
                            if own > whole:
                                break
                            runs += 1
                code[i, j, k] = own
                first[i, j, k] = count
                if own <= whole:
                    count += counts[own]
                else:
                    for n in range(14):
                        count += not (own >> n) & 1
    return count


@njit(cache=True, nogil=True)
def march(
    ball: Array,
    level: Array,
    offsets: Array,
    triangles: Array,
    sizes: Array,
    pieces: Array,
    first: Array,
    code: Array,
    points: Array,
) -> Array:
    """Return the triangles (m, 3) int32 between inside and outside, which look outwards.

    Parameters
    ----------
    ball, offsets, pieces, first, code
        As in `number_crossings`, whose work is done.
    level : (I, J, K) float32
        Where it is positive inside and negative outside, crossings lie where it vanishes in between; elsewhere, or
        where it is empty, half-way.
    triangles : (256, 12, 3, 2) int64
        For each of the ways in which the corners of a cube can lie inside, the crossings that its triangles join: a
        corner inside, and which of its neighbours lies outside.
    sizes : (256,) int64
        How many triangles these are.
    points : (n, 3) float64
        Receives the vertices in voxels: the means of their crossings.
    """
    nx, ny, nz = ball.shape
    whole = (1 << 14) - 1
    amount = np.zeros(points.shape[0], np.int64)
    points[:] = 0.0
    for i in range(1, nx - 1):
        for j in range(1, ny - 1):
            for k in range(1, nz - 1):
                own = code[i, j, k]
                if not ball[i, j, k] or own & whole == whole:
                    continue
                rank = 0
                for n in range(14):
                    if (own >> n) & 1:
                        continue
                    v = first[i, j, k] + (rank if own > whole else pieces[own, n])
                    rank += 1
                    share = 0.5
                    if level.size:
                        here = level[i, j, k]
                        there = level[i + offsets[n, 0], j + offsets[n, 1], k + offsets[n, 2]]
                        if here > 0.0 and there < 0.0:
                            share = min(max(here / (here - there), NEAREST), 1.0 - NEAREST)
                    amount[v] += 1
                    points[v, 0] += i + share * offsets[n, 0]
                    points[v, 1] += j + share * offsets[n, 1]
                    points[v, 2] += k + share * offsets[n, 2]
    for v in range(points.shape[0]):
        for axis in range(3):
            points[v, axis] /= amount[v]

    faces = np.empty((2 * points.shape[0] + 64, 3), np.int32)
    corner = np.empty(3, np.int64)
    count = 0
    for i in range(nx - 1):
        for j in range(ny - 1):
            # Bit 4·a + 2·b + c for the corner (i + a, j + b, k + c).
            ahead = (
                (ball[i, j, 0] << 1)
                | (ball[i, j + 1, 0] << 3)
                | (ball[i + 1, j, 0] << 5)
                | (ball[i + 1, j + 1, 0] << 7)
            )
            for k in range(nz - 1):
                at = ahead >> 1
                ahead = (
                    (ball[i, j, k + 1] << 1)
                    | (ball[i, j + 1, k + 1] << 3)
                    | (ball[i + 1, j, k + 1] << 5)
                    | (ball[i + 1, j + 1, k + 1] << 7)
                )
                at |= ahead
                for t in range(sizes[at]):
                    for n in range(3):
                        c, d = triangles[at, t, n, 0], triangles[at, t, n, 1]
                        a, b, e = i + (c >> 2), j + ((c >> 1) & 1), k + (c & 1)
                        own = code[a, b, e]
                        rank = 0
                        if own <= whole:
                            rank = pieces[own, d]
                        else:
                            for m in range(d):
                                rank += not (own >> m) & 1
                        corner[n] = first[a, b, e] + rank
                    if corner[0] == corner[1] or corner[1] == corner[2] or corner[2] == corner[0]:
                        continue
                    if count == faces.shape[0]:
                        larger = np.empty((2 * count, 3), np.int32)
                        larger[:count] = faces
                        faces = larger
                    for n in range(3):
                        faces[count, n] = corner[n]
                    count += 1
    return faces[:count].copy()

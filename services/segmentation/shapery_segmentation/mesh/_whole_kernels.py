"""Does the surface touch itself? Asked of all of it, or around what was moved, and answered by the faces that do.

What only `_motion_kernels.verify` moved need not be asked, unless it was told to look at a part alone.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.mesh._cells_kernels import ANY, gather
from shapery_segmentation.mesh._grid_kernels import SINGLE, measure_face, normal
from shapery_segmentation.mesh._motion_kernels import contact, faces_touch, is_graph, touch_apart
from shapery_segmentation.mesh._operation_kernels import following, origin, preceding, twin
from shapery_segmentation.mesh.arrays import (
    CLEARANCE,
    FACE_TOP,
    INVERSE_CELL,
    LARGEST_RADIUS,
    MASK,
    NORMAL,
    ORIGIN,
    OUT,
    RADIUS,
    SHIFT,
)
from shapery_segmentation.mesh.compiled import inner, kernel


@inner
def _note(m, f, g, concerned):
    """Set `concerned` at the vertices of two faces, where it has room."""
    if concerned.shape[0] > 0:
        for k in range(3):
            concerned[origin(m, 3 * f + k)] = True
            concerned[origin(m, 3 * g + k)] = True


@inner
def _later_contacts(m, cells, at, gap, concerned):
    """Count the faces at later places of `cells` that the one at place `at` touches and shares no vertex with."""
    start, records, names = cells.start, cells.records, cells.names
    f = np.int64(names[at])
    own = normal(m, f)
    px, py, pz, radius = records[at, 0], records[at, 1], records[at, 2], records[at, RADIUS] + np.float32(gap)
    inverse = m.bound[INVERSE_CELL]
    rounding = np.float32(SINGLE) * (abs(px) + abs(py) + abs(pz))
    reach = np.float64(radius) + m.bound[LARGEST_RADIUS] + rounding
    nx, ny, nz = records[at, NORMAL], records[at, NORMAL + 1], records[at, NORMAL + 2]
    off = np.float32(gap) + rounding
    mx, my, mz = m.layout[MASK], m.layout[MASK + 1], m.layout[MASK + 2]
    x0, x1 = np.int64(np.floor((px - reach) * inverse)), np.int64(np.floor((px + reach) * inverse))
    y0, y1 = np.int64(np.floor((py - reach) * inverse)), np.int64(np.floor((py + reach) * inverse))
    z0, z1 = np.int64(np.floor((pz - reach) * inverse)), np.int64(np.floor((pz + reach) * inverse))
    # Where the reach exceeds the period, every cell is visited once.
    x1, y1, z1 = min(x1, x0 + mx), min(y1, y0 + my), min(z1, z0 + mz)
    first = z0 & mz
    last = first + (z1 - z0)
    count = 0
    for x in range(x0, x1 + 1):
        for y in range(y0, y1 + 1):
            row = ((x & mx) << m.layout[SHIFT]) | ((y & my) << m.layout[SHIFT + 1])
            if start[row + mz + 1] <= at:
                continue
            for part in range(2):
                if part == 0:
                    a, b = start[row + first], start[row + min(last, mz) + 1]
                elif last > mz:
                    a, b = start[row], start[row + (last & mz) + 1]
                else:
                    break
                for i in range(max(a, at + 1), b):
                    dx, dy, dz = records[i, 0] - px, records[i, 1] - py, records[i, 2] - pz
                    near = radius + records[i, RADIUS]
                    # Out of reach, or its sphere beyond the plane of `f`.
                    height = abs(dx * nx + dy * ny + dz * nz)
                    if (dx * dx + dy * dy + dz * dz > near * near) | (height > records[i, RADIUS] + off):
                        continue
                    g = np.int64(names[i])
                    if touch_apart(m, f, g, own, gap):
                        _note(m, f, g, concerned)
                        count += 1
    return count


@inner
def _star_contacts(m, v, concerned):
    """Count the pairs of faces around `v` that have more in common than they share."""
    if is_graph(m, v):
        return 0
    count = 0
    first = np.int64(m.vertices[v, OUT])
    h = first
    while True:
        k = twin(m, preceding(h))
        while k != first:
            if faces_touch(m, h // 3, k // 3):
                _note(m, h // 3, k // 3, concerned)
                count += 1
            k = twin(m, preceding(k))
        h = twin(m, preceding(h))
        if h == first:
            return count


@kernel
def find_contacts(m, cells, first, end, concerned):
    """Return how many of a part of the faces touch others that follow them in the cells and share no vertex with them.

    Parameters
    ----------
    m, cells
        Mesh and its faces sorted by cell.
    first, end : int
        Places in the cells.
    concerned : (V,) bool
        Receives true for the vertices of faces that touch others. If it is empty, the first that does ends the search.
    """
    gap = m.bound[CLEARANCE]
    total = 0
    for at in range(first, end):
        total += _later_contacts(m, cells, at, gap, concerned)
        if total > 0 and concerned.shape[0] == 0:
            return total
    return total


@kernel
def find_star_contacts(m, first, end, concerned):
    """Return how many pairs of faces around a part of the vertices have more in common than they share.

    Parameters
    ----------
    m
        Mesh.
    first, end : int
        Slots of vertices.
    concerned : (V,) bool
        See `find_contacts`.
    """
    total = 0
    for v in range(first, end):
        if m.vertices[v, OUT] >= 0:
            total += _star_contacts(m, v, concerned)
            if total > 0 and concerned.shape[0] == 0:
                return total
    return total


@kernel
def find_contacts_around(m, cells, chosen, concerned, found):
    """Return in how many ways the faces around some vertices touch others, which is 0 where they do not.

    Parameters
    ----------
    m, cells
        Mesh and its faces sorted by cell.
    chosen : (n,) int64
        Vertices. Faces that none of them belongs to are taken to be sound.
    concerned : (V,) bool
        Receives true for the vertices of faces that touch others.
    found : (F,) int32
        Room.
    """
    total = 0
    for i in range(chosen.shape[0]):
        first = np.int64(m.vertices[chosen[i], OUT])
        h = first
        while True:
            f = h // 3
            g = contact(m, cells, f, 0.0, 0, ANY, found)
            if g >= 0:
                _note(m, f, g, concerned)
                total += 1
            total += _star_contacts(m, origin(m, following(h)), concerned)
            h = twin(m, preceding(h))
            if h == first:
                break
        total += _star_contacts(m, np.int64(chosen[i]), concerned)
    return total


@kernel
def count_contacts(m, cells):
    """Return how many faces touch a face with a higher number: every pair is tested, no star is taken for sound.

    Parameters
    ----------
    m, cells
        Mesh and its faces sorted by cell.
    """
    found = np.empty(m.links.shape[0], dtype=np.int32)
    total = 0
    for f in range(m.layout[FACE_TOP]):
        if m.half_edges[3 * f, ORIGIN] < 0:
            continue
        c = (np.float64(m.facets[f, 0]), np.float64(m.facets[f, 1]), np.float64(m.facets[f, 2]))
        reach = m.facets[f, RADIUS] + m.bound[CLEARANCE]
        n = gather(m.layout, m.bound, cells, c, reach, 1.0, normal(m, f), ANY, found)
        for i in range(n):
            g = np.int64(found[i])
            if g > f and faces_touch(m, f, g):
                total += 1
                break
    return total


@kernel
def draw_together(m, chosen):
    """Put vertices, one after the other, where the mean of their neighbours is, without any test.

    Parameters
    ----------
    m : MeshArrays
    chosen : (n,) int64
        The vertices.
    """
    for i in range(chosen.shape[0]):
        v = chosen[i]
        for axis in range(3):
            total = 0.0
            degree = 0
            first = np.int64(m.vertices[v, OUT])
            h = first
            while True:
                total += m.points[origin(m, following(h)), axis]
                degree += 1
                h = twin(m, preceding(h))
                if h == first:
                    break
            m.points[v, axis] = np.float64(np.float32(total / degree))
        first = np.int64(m.vertices[v, OUT])
        h = first
        while True:
            measure_face(m, h // 3)
            h = twin(m, preceding(h))
            if h == first:
                break

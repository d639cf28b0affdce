"""Which faces are near: a hash of the faces by their centroids, and the test of one face against the others.

The grid repeats itself in space (a cell's coordinates are taken modulo powers of two), so it needs no bounds: what is
far away in the same cell costs a distance test and nothing else. Its size follows the region that the mesh fills.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.mesh._contact_kernels import dot, subtract, touching
from shapery_segmentation.mesh.arrays import (
    AFTER,
    AREA,
    BEFORE,
    CARELESS,
    CELL,
    CLEARANCE,
    CORNER,
    FACE_COUNT,
    FACE_TOP,
    INVERSE_CELL,
    LARGEST_RADIUS,
    MASK,
    NORMAL,
    ORIGIN,
    RADIUS,
    SHIFT,
    SKIP,
)
from shapery_segmentation.mesh.compiled import inlined, inner, kernel

SINGLE = 1.2e-7
"""Relative rounding error of a float32, with a margin."""

OPEN_FOLD = -0.999
"""Faces over one edge whose normals have a larger product than this cannot be folded onto each other."""


@inner
def point(m, v):
    """Return the position of vertex `v`."""
    return m.points[v, 0], m.points[v, 1], m.points[v, 2]


@inner
def corners(m, f):
    """Return the numbers of the vertices of face `f` as last measured."""
    return np.int64(m.links[f, CORNER]), np.int64(m.links[f, CORNER + 1]), np.int64(m.links[f, CORNER + 2])


@inner
def normal(m, f):
    """Return the unit normal of face `f` as last measured."""
    return np.float64(m.facets[f, NORMAL]), np.float64(m.facets[f, NORMAL + 1]), np.float64(m.facets[f, NORMAL + 2])


@inner
def measure_face(m, f):
    """Compute what is stored of face `f` from its half-edges and positions."""
    for k in range(3):
        m.links[f, CORNER + k] = m.half_edges[3 * f + k, ORIGIN]
    i, j, k = corners(m, f)
    ax, ay, az = point(m, i)
    bx, by, bz = point(m, j)
    cx, cy, cz = point(m, k)
    gx, gy, gz = (ax + bx + cx) / 3.0, (ay + by + cy) / 3.0, (az + bz + cz) / 3.0
    ra = (ax - gx) ** 2 + (ay - gy) ** 2 + (az - gz) ** 2
    rb = (bx - gx) ** 2 + (by - gy) ** 2 + (bz - gz) ** 2
    rc = (cx - gx) ** 2 + (cy - gy) ** 2 + (cz - gz) ** 2
    # In single precision the centroid moves a little; the sphere still has to hold the face.
    radius = np.sqrt(max(ra, rb, rc)) + SINGLE * (abs(gx) + abs(gy) + abs(gz))
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    inverse = 1.0 / length if length > 0.0 else 0.0
    row = m.facets
    row[f, 0] = gx
    row[f, 1] = gy
    row[f, 2] = gz
    row[f, RADIUS] = radius
    row[f, NORMAL] = nx * inverse
    row[f, NORMAL + 1] = ny * inverse
    row[f, NORMAL + 2] = nz * inverse
    row[f, AREA] = 0.5 * length
    m.bound[LARGEST_RADIUS] = max(m.bound[LARGEST_RADIUS], radius)


@inner
def unlink_face(m, f):
    """Take face `f` out of the grid."""
    cell = m.links[f, CELL]
    if cell < 0:
        return
    before, after = m.links[f, BEFORE], m.links[f, AFTER]
    if before >= 0:
        m.links[before, AFTER] = after
    else:
        m.head[cell] = after
    if after >= 0:
        m.links[after, BEFORE] = before
    m.links[f, CELL] = -1


@inner
def link_face(m, f):
    """Put face `f` where its centroid is, moving it if it is in the grid already."""
    inverse = m.bound[INVERSE_CELL]
    x = np.int64(np.floor(m.facets[f, 0] * inverse)) & m.layout[MASK]
    y = np.int64(np.floor(m.facets[f, 1] * inverse)) & m.layout[MASK + 1]
    z = np.int64(np.floor(m.facets[f, 2] * inverse)) & m.layout[MASK + 2]
    cell = (x << m.layout[SHIFT]) | (y << m.layout[SHIFT + 1]) | z
    if m.links[f, CELL] == cell:
        return
    unlink_face(m, f)
    first = m.head[cell]
    m.links[f, CELL] = cell
    m.links[f, BEFORE] = -1
    m.links[f, AFTER] = first
    if first >= 0:
        m.links[first, BEFORE] = f
    m.head[cell] = f


@kernel
def measure_all(m):
    """Measure all faces."""
    for f in range(m.layout[FACE_TOP]):
        if m.half_edges[3 * f, ORIGIN] >= 0:
            measure_face(m, f)


@kernel
def measure_extent(m, extent):
    """Write the sides of the box that the faces' centres fill to `extent` (3,); return the faces' mean area."""
    total = 0.0
    x0 = y0 = z0 = np.inf
    x1 = y1 = z1 = -np.inf
    for f in range(m.layout[FACE_TOP]):
        if m.half_edges[3 * f, ORIGIN] >= 0:
            x, y, z = m.facets[f, 0], m.facets[f, 1], m.facets[f, 2]
            x0, y0, z0 = min(x0, x), min(y0, y), min(z0, z)
            x1, y1, z1 = max(x1, x), max(y1, y), max(z1, z)
            total += m.facets[f, AREA]
    extent[0], extent[1], extent[2] = max(x1 - x0, 0.0), max(y1 - y0, 0.0), max(z1 - z0, 0.0)
    return total / max(m.layout[FACE_COUNT], 1)


@kernel
def build_grid(m):
    """Put all faces into the grid, whose cells the caller has sized and emptied."""
    m.bound[LARGEST_RADIUS] = 0.0
    for f in range(m.layout[FACE_TOP]):
        m.links[f, CELL] = -1
        if m.half_edges[3 * f, ORIGIN] >= 0:
            measure_face(m, f)
            link_face(m, f)


@inlined
def _apart_at_once(m, ids, p, n, g, gap):
    """Return whether the plane of either face tells at once that they do not touch; most pairs end here."""
    other = normal(m, g)
    i0, i1, i2 = ids
    j0, j1, j2 = corners(m, g)
    level = dot(n, p[0])
    shared = 0
    above = 0
    below = 0
    for j in (j0, j1, j2):
        if j in (i0, i1, i2):
            shared += 1
        else:
            s = n[0] * m.points[j, 0] + n[1] * m.points[j, 1] + n[2] * m.points[j, 2] - level
            above += s > gap
            below += s < -gap
    if shared >= 2:
        return shared == 2 and dot(n, other) > OPEN_FOLD
    if above + shared == 3 or below + shared == 3:
        return True
    level = dot(other, point(m, j0))
    above = 0
    below = 0
    for k in range(3):
        if ids[k] not in (j0, j1, j2):
            s = dot(other, p[k]) - level
            above += s > gap
            below += s < -gap
    return above + shared == 3 or below + shared == 3


@inner
def _patch_face(patch_ids, patch, row):
    """Return vertices, corners and normal of a row of the patch."""
    return (
        (np.int64(patch_ids[row, 0]), np.int64(patch_ids[row, 1]), np.int64(patch_ids[row, 2])),
        (
            (patch[row, 0], patch[row, 1], patch[row, 2]),
            (patch[row, 3], patch[row, 4], patch[row, 5]),
            (patch[row, 6], patch[row, 7], patch[row, 8]),
        ),
        (patch[row, 9], patch[row, 10], patch[row, 11]),
    )


@inner
def _patch_touches(m, size, g, gap):
    """Return whether a face of the patch touches face `g` of the mesh."""
    c = (np.float64(m.facets[g, 0]), np.float64(m.facets[g, 1]), np.float64(m.facets[g, 2]))
    radius = m.facets[g, RADIUS] + gap
    for row in range(size):
        d = subtract(c, (m.patch[row, 12], m.patch[row, 13], m.patch[row, 14]))
        near = radius + m.patch[row, 15]
        if dot(d, d) > near * near:
            continue
        ids, p, n = _patch_face(m.patch_ids, m.patch, row)
        if _apart_at_once(m, ids, p, n, g, gap):
            continue
        other = corners(m, g)
        q = (point(m, other[0]), point(m, other[1]), point(m, other[2]))
        if touching(ids, p, n, other, q, normal(m, g), gap):
            return True
    return False


@inner
def patch_is_clear(m, size):
    """Return whether the faces in the first `size` rows of the patch touch neither each other nor the mesh.

    Where the mesh is changed without care, only the first is asked.
    """
    gap = m.bound[CLEARANCE]
    for i in range(size):
        ids, p, n = _patch_face(m.patch_ids, m.patch, i)
        if n[0] == 0.0 and n[1] == 0.0 and n[2] == 0.0:
            return False
        for j in range(i):
            other, q, k = _patch_face(m.patch_ids, m.patch, j)
            if touching(ids, p, n, other, q, k, gap):
                return False
    if m.layout[CARELESS]:
        return True
    # One search for all: in the box around the patch, wider by what a face can reach from its centroid.
    reach = m.bound[LARGEST_RADIUS] + gap
    inverse = m.bound[INVERSE_CELL]
    low0 = low1 = low2 = np.inf
    high0 = high1 = high2 = -np.inf
    for i in range(size):
        for k in range(3):
            low0, high0 = min(low0, m.patch[i, 3 * k]), max(high0, m.patch[i, 3 * k])
            low1, high1 = min(low1, m.patch[i, 3 * k + 1]), max(high1, m.patch[i, 3 * k + 1])
            low2, high2 = min(low2, m.patch[i, 3 * k + 2]), max(high2, m.patch[i, 3 * k + 2])
    low0, low1, low2 = low0 - reach, low1 - reach, low2 - reach
    high0, high1, high2 = high0 + reach, high1 + reach, high2 + reach
    mx, my, mz = m.layout[MASK], m.layout[MASK + 1], m.layout[MASK + 2]
    x0, x1 = np.int64(np.floor(low0 * inverse)), np.int64(np.floor(high0 * inverse))
    y0, y1 = np.int64(np.floor(low1 * inverse)), np.int64(np.floor(high1 * inverse))
    z0, z1 = np.int64(np.floor(low2 * inverse)), np.int64(np.floor(high2 * inverse))
    # Where the box exceeds the period, every cell is visited once.
    x1, y1, z1 = min(x1, x0 + mx), min(y1, y0 + my), min(z1, z0 + mz)
    for x in range(x0, x1 + 1):
        for y in range(y0, y1 + 1):
            row = ((x & mx) << m.layout[SHIFT]) | ((y & my) << m.layout[SHIFT + 1])
            for z in range(z0, z1 + 1):
                g = np.int64(m.head[row | (z & mz)])
                while g >= 0:
                    if (
                        low0 <= m.facets[g, 0] <= high0
                        and low1 <= m.facets[g, 1] <= high1
                        and low2 <= m.facets[g, 2] <= high2
                        and m.links[g, SKIP] == 0
                        and _patch_touches(m, size, g, gap)
                    ):
                        return False
                    g = np.int64(m.links[g, AFTER])
    return True

"""Which faces are near: a hash of the faces by their centroids, and the test of one face against the others.

The grid repeats itself in space (a cell's coordinates are taken modulo powers of two), so it needs no bounds: what is
far away in the same cell costs a distance test and nothing else. Its size follows the region that the mesh fills.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit

from shapery_segmentation.mesh._contact_kernels import dot, inner, subtract, touching
from shapery_segmentation.mesh.arrays import (
    AFTER,
    AREA,
    BEFORE,
    CELL,
    CLEARANCE,
    FACE_TOP,
    INVERSE_CELL,
    LARGEST_RADIUS,
    MASK,
    NORMAL,
    ORIGIN,
    RADIUS,
    SHIFT,
    SKIP,
    STAMP,
)

OPEN_FOLD = -0.999
"""Faces over one edge whose normals have a larger product than this cannot be folded onto each other."""


@inner
def point(m, v):
    """Return the position of vertex `v`."""
    return m.points[v, 0], m.points[v, 1], m.points[v, 2]


@inner
def corners(m, f):
    """Return the numbers of the vertices of face `f`."""
    return (
        np.int64(m.half_edges[3 * f, ORIGIN]),
        np.int64(m.half_edges[3 * f + 1, ORIGIN]),
        np.int64(m.half_edges[3 * f + 2, ORIGIN]),
    )


@inner
def normal(m, f):
    """Return the unit normal of face `f` as last measured."""
    return m.facets[f, NORMAL], m.facets[f, NORMAL + 1], m.facets[f, NORMAL + 2]


@inner
def measure_face(m, f):
    """Compute centroid, radius, normal and area of face `f` from the positions."""
    i, j, k = corners(m, f)
    ax, ay, az = point(m, i)
    bx, by, bz = point(m, j)
    cx, cy, cz = point(m, k)
    gx, gy, gz = (ax + bx + cx) / 3.0, (ay + by + cy) / 3.0, (az + bz + cz) / 3.0
    ra = (ax - gx) ** 2 + (ay - gy) ** 2 + (az - gz) ** 2
    rb = (bx - gx) ** 2 + (by - gy) ** 2 + (bz - gz) ** 2
    rc = (cx - gx) ** 2 + (cy - gy) ** 2 + (cz - gz) ** 2
    radius = np.sqrt(max(ra, rb, rc))
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


@njit(cache=True, nogil=True)
def build_grid(m):
    """Measure all faces and put them into the grid, whose cells the caller has emptied and sized."""
    m.bound[LARGEST_RADIUS] = 0.0
    for f in range(m.layout[FACE_TOP]):
        m.links[f, CELL] = -1
        if m.half_edges[3 * f, ORIGIN] >= 0:
            measure_face(m, f)
            link_face(m, f)


@inner
def _apart_at_once(m, ids, p, n, level, g):
    """Return whether the plane of either face tells at once that they do not touch; most pairs end here."""
    gap = m.bound[CLEARANCE]
    other = normal(m, g)
    i0, i1, i2 = ids
    j0, j1, j2 = corners(m, g)
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
    level = other[0] * m.facets[g, 0] + other[1] * m.facets[g, 1] + other[2] * m.facets[g, 2]
    above = 0
    below = 0
    for k in range(3):
        if ids[k] != j0 and ids[k] != j1 and ids[k] != j2:
            s = dot(other, p[k]) - level
            above += s > gap
            below += s < -gap
    return above + shared == 3 or below + shared == 3


@inner
def first_contact(m, ids, p, n, own, batch):
    """Return a face of the mesh that a given face touches, or −1.

    Parameters
    ----------
    m : MeshArrays
    ids
        The face's vertices.
    p
        Its corners.
    n
        Its unit normal.
    own : int
        Its number, if it is in the mesh; else −1.
    batch : int
        If positive: faces below `own` that carry this stamp are left out, because they are tested against this one.
    """
    c = (
        (p[0][0] + p[1][0] + p[2][0]) / 3.0,
        (p[0][1] + p[1][1] + p[2][1]) / 3.0,
        (p[0][2] + p[1][2] + p[2][2]) / 3.0,
    )
    radius = 0.0
    for k in range(3):
        d = subtract(p[k], c)
        radius = max(radius, dot(d, d))
    radius = np.sqrt(radius) + m.bound[CLEARANCE]
    level = dot(n, c)
    reach = radius + m.bound[LARGEST_RADIUS]
    inverse = m.bound[INVERSE_CELL]
    mx, my, mz = m.layout[MASK], m.layout[MASK + 1], m.layout[MASK + 2]
    x0, x1 = np.int64(np.floor((c[0] - reach) * inverse)), np.int64(np.floor((c[0] + reach) * inverse))
    y0, y1 = np.int64(np.floor((c[1] - reach) * inverse)), np.int64(np.floor((c[1] + reach) * inverse))
    z0, z1 = np.int64(np.floor((c[2] - reach) * inverse)), np.int64(np.floor((c[2] + reach) * inverse))
    # Where the reach exceeds the period, every cell is visited once.
    x1, y1, z1 = min(x1, x0 + mx), min(y1, y0 + my), min(z1, z0 + mz)
    for x in range(x0, x1 + 1):
        for y in range(y0, y1 + 1):
            row = ((x & mx) << m.layout[SHIFT]) | ((y & my) << m.layout[SHIFT + 1])
            for z in range(z0, z1 + 1):
                g = np.int64(m.head[row | (z & mz)])
                while g >= 0:
                    dx, dy, dz = m.facets[g, 0] - c[0], m.facets[g, 1] - c[1], m.facets[g, 2] - c[2]
                    near = radius + m.facets[g, RADIUS]
                    if (
                        dx * dx + dy * dy + dz * dz <= near * near
                        and g != own
                        and m.links[g, SKIP] == 0
                        and not (batch > 0 and g < own and m.links[g, STAMP] == batch)
                        and not _apart_at_once(m, ids, p, n, level, g)
                    ):
                        ids_g = corners(m, g)
                        q = (point(m, ids_g[0]), point(m, ids_g[1]), point(m, ids_g[2]))
                        if touching(ids, p, n, ids_g, q, normal(m, g), m.bound[CLEARANCE]):
                            return g
                    g = np.int64(m.links[g, AFTER])
    return -1


@inner
def face_contact(m, f, batch):
    """Return a face that face `f` of the mesh touches, or −1."""
    ids = corners(m, f)
    p = (point(m, ids[0]), point(m, ids[1]), point(m, ids[2]))
    return first_contact(m, ids, p, normal(m, f), f, batch)


@njit(cache=True, nogil=True)
def count_contacts(m, batch):
    """Return how many faces touch a face with a higher number; `batch` is a stamp that no face carries yet."""
    found = 0
    for f in range(m.layout[FACE_TOP]):
        m.links[f, STAMP] = batch
    for f in range(m.layout[FACE_TOP]):
        if m.half_edges[3 * f, ORIGIN] >= 0 and face_contact(m, f, batch) >= 0:
            found += 1
    return found


@inner
def patch_is_clear(m, size):
    """Return whether the faces in the first `size` rows of the patch touch neither each other nor the mesh."""
    for i in range(size):
        ids, p, n = _patch_face(m, i)
        if n[0] == 0.0 and n[1] == 0.0 and n[2] == 0.0:
            return False
        if first_contact(m, ids, p, n, -1, 0) >= 0:
            return False
        for j in range(i):
            other_ids, q, other = _patch_face(m, j)
            if touching(ids, p, n, other_ids, q, other, m.bound[CLEARANCE]):
                return False
    return True


@inner
def _patch_face(m, row):
    """Return vertices, corners and normal of a row of the patch."""
    a, b = m.patch_ids, m.patch
    return (
        (np.int64(a[row, 0]), np.int64(a[row, 1]), np.int64(a[row, 2])),
        (
            (b[row, 0], b[row, 1], b[row, 2]),
            (b[row, 3], b[row, 4], b[row, 5]),
            (b[row, 6], b[row, 7], b[row, 8]),
        ),
        (b[row, 9], b[row, 10], b[row, 11]),
    )

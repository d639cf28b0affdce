"""An open surface in arrays that grow: its half-edges, its boundary, and its faces sorted into a grid."""

# mypy: allow-untyped-defs, allow-untyped-calls

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shapery_segmentation.mesh._contact_kernels import cross, dot, subtract
from shapery_segmentation.mesh.compiled import inner, kernel

Array = NDArray[Any]

# Entries of `Front.layout`.
VERTICES = 0
FACES = 1
GROWN = 2  # vertices that the flow put in
STITCHED = 3  # faces put in without a vertex
REFUSED = 4  # corners given up
LAYOUT = 5

# Values of `Front.mode`.
ACTIVE = 1
INACTIVE = 0

# What `grow` ended with.
DONE = 0
NO_ROOM = 1
LIMIT = 2

CELLS = 64
"""Cells of the grid along each axis; space repeats beyond them."""

MARGIN = 128
"""Free slots that a step may need."""

LARGEST_LOOP = 64
"""Edges of a hole that is closed by a fan about a point in its middle."""

FOLD = -0.5
"""Product of the normals of two faces over one edge below which they are folded."""


class Front(NamedTuple):
    """A surface with a boundary, in arrays with room to grow.

    Attributes
    ----------
    points, normals : (V, 3) float64
        RAS mm; outward unit normals of the field's level.
    mode : (V,) int8
        Whether the vertex, if it lies on the boundary, may still grow.
    free : (V,) int32
        Boundary half-edges that start at the vertex; 0 in the interior.
    corners : (F, 3) int32
    planes : (F, 3) float64
        Unit normals.
    twin : (3F,) int32
        Half-edge 3·face + corner runs from that corner to the next; its twin, or −1 on the boundary.
    keys, values : (H,) int64, int32
        Hash table from directed edges to half-edges; H is a power of two.
    head, after : (64³,) int32, (F,) int32
        Grid of faces by their centroids.
    layout : (5,) int64
    """

    points: Array
    normals: Array
    mode: Array
    free: Array
    corners: Array
    planes: Array
    twin: Array
    keys: Array
    values: Array
    head: Array
    after: Array
    layout: Array


class Dials(NamedTuple):
    """Numbers that the growth depends on; see `shapery_segmentation.flow.tangential.TangentialFlowParams`."""

    threshold: float
    length: float
    rate: float
    least_step: float
    largest_step: float
    snap: float
    prominence: float
    agreement: float
    gap: float
    voxel: float


@inner
def _following(h):
    return h - 2 if h % 3 == 2 else h + 1


@inner
def _preceding(h):
    return h + 2 if h % 3 == 0 else h - 1


@inner
def origin(m, h):
    return np.int64(m.corners[h // 3, h % 3])


@inner
def end(m, h):
    return origin(m, _following(h))


@inner
def point(m, v):
    return m.points[v, 0], m.points[v, 1], m.points[v, 2]


@inner
def normal(m, v):
    return m.normals[v, 0], m.normals[v, 1], m.normals[v, 2]


@inner
def unit(a):
    size = np.sqrt(dot(a, a))
    if size <= 0.0:
        return (0.0, 0.0, 0.0)
    return (a[0] / size, a[1] / size, a[2] / size)


@inner
def _slot(m, u, v):
    """Return the place of the directed edge (u, v) in the table, or the free one where it belongs."""
    key = np.int64(u) * np.int64(1 << 32) + np.int64(v) + 1
    mask = m.keys.shape[0] - 1
    at = (key * np.int64(-7046029254386353131)) >> np.int64(20)
    at = at & mask
    while m.keys[at] != 0 and m.keys[at] != key:
        at = (at + 1) & mask
    return at, key


@inner
def half_edge(m, u, v):
    """Return the half-edge that runs from `u` to `v`, or −1."""
    at, key = _slot(m, u, v)
    return np.int64(m.values[at]) if m.keys[at] == key else np.int64(-1)


@inner
def next_on_boundary(m, h):
    """Return the boundary half-edge that starts where the boundary half-edge `h` ends, in the same fan of faces."""
    g = _following(h)
    while m.twin[g] >= 0:
        g = _following(np.int64(m.twin[g]))
    return g


@inner
def open_angle(m, h):
    """Return 2π less the angles of the faces at the end of the boundary half-edge `h`."""
    g = _following(h)
    angle = 2.0 * np.pi
    while True:
        v = origin(m, g)
        a, b = (
            subtract(point(m, end(m, g)), point(m, v)),
            subtract(point(m, origin(m, _preceding(g))), point(m, v)),
        )
        c = dot(a, b) / max(np.sqrt(dot(a, a) * dot(b, b)), 1e-30)
        angle -= np.arccos(max(-1.0, min(1.0, c)))
        if m.twin[g] < 0:
            return angle
        g = _following(np.int64(m.twin[g]))


@inner
def _cell(x, size):
    return np.int64(np.floor(x / size)) & (CELLS - 1)


@inner
def _put_in_grid(m, f, size):
    a, b, c = m.corners[f, 0], m.corners[f, 1], m.corners[f, 2]
    x = (m.points[a, 0] + m.points[b, 0] + m.points[c, 0]) / 3.0
    y = (m.points[a, 1] + m.points[b, 1] + m.points[c, 1]) / 3.0
    z = (m.points[a, 2] + m.points[b, 2] + m.points[c, 2]) / 3.0
    cell = (_cell(x, size) * CELLS + _cell(y, size)) * CELLS + _cell(z, size)
    m.after[f] = m.head[cell]
    m.head[cell] = f


@inner
def add_face(m, a, b, c, size):
    """Add the face (a, b, c), which has been tested; return its number."""
    f = m.layout[FACES]
    m.layout[FACES] += 1
    m.corners[f, 0], m.corners[f, 1], m.corners[f, 2] = a, b, c
    n = unit(cross(subtract(point(m, b), point(m, a)), subtract(point(m, c), point(m, a))))
    for axis in range(3):
        m.planes[f, axis] = n[axis]
    for k in range(3):
        u, v = np.int64(m.corners[f, k]), np.int64(m.corners[f, (k + 1) % 3])
        h = 3 * f + k
        at, key = _slot(m, u, v)
        m.keys[at] = key
        m.values[at] = h
        t = half_edge(m, v, u)
        m.twin[h] = t
        if t >= 0:
            m.twin[t] = h
            m.free[v] -= 1
        else:
            m.free[u] += 1
    _put_in_grid(m, f, size)
    return f


@inner
def add_vertex(m, p, n):
    v = m.layout[VERTICES]
    m.layout[VERTICES] += 1
    for axis in range(3):
        m.points[v, axis] = np.float64(np.float32(p[axis]))
        m.normals[v, axis] = n[axis]
    m.mode[v] = ACTIVE
    m.free[v] = 0
    return v


@inner
def plane_of(p, q, r):
    return unit(cross(subtract(q, p), subtract(r, p)))


@kernel
def begin(m, length):
    """Enter the faces `m.corners[:layout[FACES]]` into table and grid, which are empty; return whether they fit.

    They do where no directed edge occurs twice.
    """
    count = m.layout[FACES]
    for f in range(count):
        for k in range(3):
            u, v = np.int64(m.corners[f, k]), np.int64(m.corners[f, (k + 1) % 3])
            at, key = _slot(m, u, v)
            if m.keys[at] == key:
                return False
            m.keys[at] = key
            m.values[at] = 3 * f + k
        n = plane_of(point(m, m.corners[f, 0]), point(m, m.corners[f, 1]), point(m, m.corners[f, 2]))
        for axis in range(3):
            m.planes[f, axis] = n[axis]
        _put_in_grid(m, f, 2.0 * length)
    for h in range(3 * count):
        m.twin[h] = half_edge(m, end(m, h), origin(m, h))
        if m.twin[h] < 0:
            m.free[origin(m, h)] += 1
    return True

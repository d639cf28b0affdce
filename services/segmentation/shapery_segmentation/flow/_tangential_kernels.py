"""Loops of the tangential flow: an open surface grows from its boundary, corner by corner."""

# mypy: allow-untyped-defs, allow-untyped-calls

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shapery_segmentation.flow._speed_kernels import sample
from shapery_segmentation.mesh._contact_kernels import cross, dot, subtract, touching
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
def _origin(m, h):
    return np.int64(m.corners[h // 3, h % 3])


@inner
def _end(m, h):
    return _origin(m, _following(h))


@inner
def _point(m, v):
    return m.points[v, 0], m.points[v, 1], m.points[v, 2]


@inner
def _normal(m, v):
    return m.normals[v, 0], m.normals[v, 1], m.normals[v, 2]


@inner
def _unit(a):
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
def _half_edge(m, u, v):
    """Return the half-edge that runs from `u` to `v`, or −1."""
    at, key = _slot(m, u, v)
    return np.int64(m.values[at]) if m.keys[at] == key else np.int64(-1)


@inner
def _next_on_boundary(m, h):
    """Return the boundary half-edge that starts where the boundary half-edge `h` ends, in the same fan of faces."""
    g = _following(h)
    while m.twin[g] >= 0:
        g = _following(np.int64(m.twin[g]))
    return g


@inner
def _open_angle(m, h):
    """Return 2π less the angles of the faces at the end of the boundary half-edge `h`."""
    g = _following(h)
    angle = 2.0 * np.pi
    while True:
        v = _origin(m, g)
        a, b = (
            subtract(_point(m, _end(m, g)), _point(m, v)),
            subtract(_point(m, _origin(m, _preceding(g))), _point(m, v)),
        )
        c = dot(a, b) / max(np.sqrt(dot(a, a) * dot(b, b)), 1e-30)
        angle -= np.arccos(max(-1.0, min(1.0, c)))
        if m.twin[g] < 0:
            return angle
        g = _following(np.int64(m.twin[g]))


@inner
def gradient(field, inverse, p, half):
    """Return the gradient of `field` (per mm) at `p` by central differences over `half` mm, and whether it is known."""
    x1, a = sample(field, inverse, (p[0] + half, p[1], p[2]))
    x0, b = sample(field, inverse, (p[0] - half, p[1], p[2]))
    y1, c = sample(field, inverse, (p[0], p[1] + half, p[2]))
    y0, d = sample(field, inverse, (p[0], p[1] - half, p[2]))
    z1, e = sample(field, inverse, (p[0], p[1], p[2] + half))
    z0, f = sample(field, inverse, (p[0], p[1], p[2] - half))
    scale = 0.5 / half
    return ((x1 - x0) * scale, (y1 - y0) * scale, (z1 - z0) * scale), a and b and c and d and e and f


@inner
def pull(field, inverse, dials, p):
    """Return the point of the border nearest to `p`, its outward normal, and whether there is one with a gradient.

    Newton steps along the gradient, each of at most half a voxel.
    """
    q = p
    n = (0.0, 0.0, 0.0)
    for _ in range(6):
        g, known = gradient(field, inverse, q, 0.35 * dials.voxel)
        value, inside = sample(field, inverse, q)
        size = np.sqrt(dot(g, g))
        if not (known and inside) or size * dials.voxel < dials.prominence:
            return q, n, False
        n = (-g[0] / size, -g[1] / size, -g[2] / size)
        step = (value - dials.threshold) / size
        limit = 0.5 * dials.voxel
        step = max(-limit, min(limit, step))
        q = (q[0] + step * n[0], q[1] + step * n[1], q[2] + step * n[2])
        if abs(step) < 0.02 * dials.voxel:
            return q, n, True
    value, inside = sample(field, inverse, q)
    return q, n, inside and abs(value - dials.threshold) < 0.15


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
def _add_face(m, a, b, c, size):
    """Add the face (a, b, c), which has been tested; return its number."""
    f = m.layout[FACES]
    m.layout[FACES] += 1
    m.corners[f, 0], m.corners[f, 1], m.corners[f, 2] = a, b, c
    n = _unit(cross(subtract(_point(m, b), _point(m, a)), subtract(_point(m, c), _point(m, a))))
    for axis in range(3):
        m.planes[f, axis] = n[axis]
    for k in range(3):
        u, v = np.int64(m.corners[f, k]), np.int64(m.corners[f, (k + 1) % 3])
        h = 3 * f + k
        at, key = _slot(m, u, v)
        m.keys[at] = key
        m.values[at] = h
        t = _half_edge(m, v, u)
        m.twin[h] = t
        if t >= 0:
            m.twin[t] = h
            m.free[v] -= 1
        else:
            m.free[u] += 1
    _put_in_grid(m, f, size)
    return f


@inner
def _add_vertex(m, p, n):
    v = m.layout[VERTICES]
    m.layout[VERTICES] += 1
    for axis in range(3):
        m.points[v, axis] = np.float64(np.float32(p[axis]))
        m.normals[v, axis] = n[axis]
    m.mode[v] = ACTIVE
    m.free[v] = 0
    return v


@inner
def _fits(m, dials, ia, pa, na, least, extra_ids, extra_points, extra_normals, extras):
    """Return whether a new face keeps the surface manifold, oriented and free of contacts.

    Parameters
    ----------
    ia, pa : 3 int64, 3 points
        Its vertices; a new vertex has the number it would get.
    na : point
        Its unit normal.
    least : float
        Least product of its normal with the mean normal of its vertices, and with those of the faces beside it.
    extra_ids, extra_points, extra_normals, extras
        Faces that are to be added with it.
    """
    count = m.layout[VERTICES]
    for k in range(3):
        u, v = ia[k], ia[(k + 1) % 3]
        if u < count:
            if m.free[u] == 0 or dot(na, _normal(m, u)) < least:
                return False
            if v < count:
                if _half_edge(m, u, v) >= 0:
                    return False
                t = _half_edge(m, v, u)
                if t >= 0 and (
                    m.twin[t] >= 0
                    or dot(na, (m.planes[t // 3, 0], m.planes[t // 3, 1], m.planes[t // 3, 2])) < min(FOLD, least)
                ):
                    return False
    size = 2.0 * dials.length
    c = (
        (pa[0][0] + pa[1][0] + pa[2][0]) / 3.0,
        (pa[0][1] + pa[1][1] + pa[2][1]) / 3.0,
        (pa[0][2] + pa[1][2] + pa[2][2]) / 3.0,
    )
    d0, d1, d2 = subtract(pa[0], c), subtract(pa[1], c), subtract(pa[2], c)
    reach = np.sqrt(max(dot(d0, d0), dot(d1, d1), dot(d2, d2))) + 1.5 * dials.length
    low0, high0 = np.int64(np.floor((c[0] - reach) / size)), np.int64(np.floor((c[0] + reach) / size))
    low1, high1 = np.int64(np.floor((c[1] - reach) / size)), np.int64(np.floor((c[1] + reach) / size))
    low2, high2 = np.int64(np.floor((c[2] - reach) / size)), np.int64(np.floor((c[2] + reach) / size))
    for x in range(low0, high0 + 1):
        for y in range(low1, high1 + 1):
            for z in range(low2, high2 + 1):
                f = np.int64(m.head[((x & (CELLS - 1)) * CELLS + (y & (CELLS - 1))) * CELLS + (z & (CELLS - 1))])
                while f >= 0:
                    ib = (np.int64(m.corners[f, 0]), np.int64(m.corners[f, 1]), np.int64(m.corners[f, 2]))
                    pb = (_point(m, ib[0]), _point(m, ib[1]), _point(m, ib[2]))
                    d = subtract(pb[0], c)
                    if dot(d, d) < (reach + 2.0 * dials.length) ** 2 and touching(
                        ia, pa, na, ib, pb, (m.planes[f, 0], m.planes[f, 1], m.planes[f, 2]), dials.gap
                    ):
                        return False
                    f = np.int64(m.after[f])
    for e in range(extras):
        ib = (np.int64(extra_ids[e, 0]), np.int64(extra_ids[e, 1]), np.int64(extra_ids[e, 2]))
        pb = (
            (extra_points[e, 0, 0], extra_points[e, 0, 1], extra_points[e, 0, 2]),
            (extra_points[e, 1, 0], extra_points[e, 1, 1], extra_points[e, 1, 2]),
            (extra_points[e, 2, 0], extra_points[e, 2, 1], extra_points[e, 2, 2]),
        )
        if touching(ia, pa, na, ib, pb, (extra_normals[e, 0], extra_normals[e, 1], extra_normals[e, 2]), dials.gap):
            return False
    return True


@inner
def _nearest(m, dials, p, n, reach, interior, skip0, skip1, skip2):
    """Return the vertex (of the boundary, or any) nearest to `p` within `reach` whose normal agrees with `n`, or −1."""
    size = 2.0 * dials.length
    far = reach + 1.5 * dials.length
    best = reach * reach
    found = np.int64(-1)
    for x in range(np.int64(np.floor((p[0] - far) / size)), np.int64(np.floor((p[0] + far) / size)) + 1):
        for y in range(np.int64(np.floor((p[1] - far) / size)), np.int64(np.floor((p[1] + far) / size)) + 1):
            for z in range(np.int64(np.floor((p[2] - far) / size)), np.int64(np.floor((p[2] + far) / size)) + 1):
                f = np.int64(m.head[((x & (CELLS - 1)) * CELLS + (y & (CELLS - 1))) * CELLS + (z & (CELLS - 1))])
                while f >= 0:
                    for k in range(3):
                        v = np.int64(m.corners[f, k])
                        if (interior or m.free[v] > 0) and v != skip0 and v != skip1 and v != skip2:
                            d = subtract(_point(m, v), p)
                            if dot(d, d) < best and dot(n, _normal(m, v)) > dials.agreement:
                                best = dot(d, d)
                                found = v
                    f = np.int64(m.after[f])
    return found


@inner
def _plane(p, q, r):
    return _unit(cross(subtract(q, p), subtract(r, p)))


@inner
def _thick(p, q, r):
    """Return whether a triangle is more than a needle."""
    a, b, c = subtract(q, p), subtract(r, q), subtract(p, r)
    n = cross(a, c)
    return np.sqrt(dot(n, n)) > 0.08 * max(dot(a, a), dot(b, b), dot(c, c))


@inner
def _close_corner(m, dials, h, least, ids, points, normals):
    """Add the face over the corner at the end of the boundary half-edge `h` and its neighbours; return whether it fits.

    This is the stitch of Figs 3.9 and 3.10: three adjacent vertices of the boundary.
    """
    g = _next_on_boundary(m, h)
    v, left, right = _end(m, h), _origin(m, h), _end(m, g)
    if left == right:
        return False
    pv, pl, pr = _point(m, v), _point(m, left), _point(m, right)
    if not _thick(pr, pv, pl):
        return False
    n = _plane(pr, pv, pl)
    if not _fits(m, dials, (right, v, left), (pr, pv, pl), n, least, ids, points, normals, 0):
        return False
    _add_face(m, right, v, left, 2.0 * dials.length)
    m.layout[STITCHED] += 1
    m.mode[left] = ACTIVE
    m.mode[right] = ACTIVE
    return True


@inner
def _fill_corner(m, field, inverse, dials, h, angle, ids, points, normals, rim, rim_points, rim_normals):
    """Fill the corner at the end of the boundary half-edge `h` with a fan of faces; return whether it fits.

    New vertices lie in the tangent plane, at a distance that the curvature of the boundary gives (Eq. 3.6, 3.7, 3.9),
    and are pulled to the border. One that comes to lie near another vertex of the boundary is replaced by it.
    """
    g = _next_on_boundary(m, h)
    v, left, right = _end(m, h), _origin(m, h), _end(m, g)
    parts = np.int64(np.floor(angle / (np.pi / 3.0) + 0.5))
    if parts < 2:
        parts = np.int64(2)
    elif parts > 5:
        parts = np.int64(5)
    pv, pl, pr = _point(m, v), _point(m, left), _point(m, right)
    n = _normal(m, v)
    a, b = subtract(pl, pv), subtract(pr, pv)
    la, lb = np.sqrt(dot(a, a)), np.sqrt(dot(b, b))
    chord = subtract(pl, pr)
    area = cross(a, b)
    k = 2.0 * np.sqrt(dot(area, area)) / max(la * lb * np.sqrt(dot(chord, chord)), 1e-30)
    step = max(dials.least_step, min(dials.largest_step, dials.rate * k)) * dials.length
    # From the right neighbour, turning clockwise as seen from outside, the open side comes first.
    along = dot(b, n)
    e1 = _unit((b[0] - along * n[0], b[1] - along * n[1], b[2] - along * n[2]))
    e2 = cross(e1, n)
    rim[0] = right
    for axis in range(3):
        rim_points[0, axis] = pr[axis]
    fresh = m.layout[VERTICES]
    for s in range(1, parts):
        turn = angle * s / parts
        x, y = step * np.cos(turn), step * np.sin(turn)
        p = (pv[0] + x * e1[0] + y * e2[0], pv[1] + x * e1[1] + y * e2[1], pv[2] + x * e1[2] + y * e2[2])
        q, outward, found = pull(field, inverse, dials, p)
        if not found or dot(outward, n) < 0.0:
            return False
        d = subtract(q, pv)
        if dot(d, d) > 2.5 * step * step or dot(d, d) < 0.2 * step * step:
            return False
        near = _nearest(m, dials, q, outward, dials.snap * dials.length, True, v, left, right)
        if near >= 0:
            if m.free[near] == 0:
                return False
            for e in range(s):
                if near == rim[e]:
                    return False
            rim[s] = near
            q = _point(m, near)
        else:
            rim[s] = fresh
            fresh += 1
            q = (np.float64(np.float32(q[0])), np.float64(np.float32(q[1])), np.float64(np.float32(q[2])))
        for axis in range(3):
            rim_points[s, axis] = q[axis]
            rim_normals[s, axis] = outward[axis]
    rim[parts] = left
    for axis in range(3):
        rim_points[parts, axis] = pl[axis]
    for s in range(parts):
        p = (rim_points[s, 0], rim_points[s, 1], rim_points[s, 2])
        q = (rim_points[s + 1, 0], rim_points[s + 1, 1], rim_points[s + 1, 2])
        if not _thick(p, pv, q):
            return False
        plane = _plane(p, pv, q)
        if not _fits(
            m, dials, (np.int64(rim[s]), v, np.int64(rim[s + 1])), (p, pv, q), plane, 0.2, ids, points, normals, s
        ):
            return False
        ids[s, 0], ids[s, 1], ids[s, 2] = rim[s], v, rim[s + 1]
        for axis in range(3):
            points[s, 0, axis] = p[axis]
            points[s, 1, axis] = pv[axis]
            points[s, 2, axis] = q[axis]
            normals[s, axis] = plane[axis]
    base = m.layout[VERTICES]
    for s in range(1, parts):
        if rim[s] >= base:
            _add_vertex(
                m,
                (rim_points[s, 0], rim_points[s, 1], rim_points[s, 2]),
                (rim_normals[s, 0], rim_normals[s, 1], rim_normals[s, 2]),
            )
            m.layout[GROWN] += 1
        else:
            m.mode[rim[s]] = ACTIVE
    for s in range(parts):
        _add_face(m, np.int64(rim[s]), v, np.int64(rim[s + 1]), 2.0 * dials.length)
    m.mode[left] = ACTIVE
    m.mode[right] = ACTIVE
    return True


@inner
def _join_edge(m, dials, h, ids, points, normals):
    """Add a face over the boundary half-edge `h` whose third vertex is one of the boundary; return whether one fits."""
    u, v = _origin(m, h), _end(m, h)
    pu, pv = _point(m, u), _point(m, v)
    n = _unit((
        m.normals[u, 0] + m.normals[v, 0], m.normals[u, 1] + m.normals[v, 1], m.normals[u, 2] + m.normals[v, 2],
    ))  # fmt: skip
    away = cross(subtract(pv, pu), n)
    size = np.sqrt(dot(away, away))
    if size <= 0.0:
        return False
    t = 0.4 * dials.length / size
    p = (
        0.5 * (pu[0] + pv[0]) + t * away[0],
        0.5 * (pu[1] + pv[1]) + t * away[1],
        0.5 * (pu[2] + pv[2]) + t * away[2],
    )
    skip = np.int64(-1)
    for _ in range(3):
        w = _nearest(m, dials, p, n, 1.1 * dials.length, False, u, v, skip)
        if w < 0:
            return False
        pw = _point(m, w)
        if dot(subtract(pw, pu), away) > 0.0 and _thick(pv, pu, pw):
            plane = _plane(pv, pu, pw)
            if _fits(m, dials, (v, u, w), (pv, pu, pw), plane, 0.1, ids, points, normals, 0):
                _add_face(m, v, u, w, 2.0 * dials.length)
                m.layout[STITCHED] += 1
                m.mode[u] = ACTIVE
                m.mode[v] = ACTIVE
                m.mode[w] = ACTIVE
                return True
        skip = w
    return False


@inner
def _fill_loop(m, dials, h, lift, ids, points, normals, rim):
    """Close the hole at the boundary half-edge `h` by a fan about the mean of its vertices; return whether it fits.

    The point is lifted by `lift` edge lengths along the mean of their normals.
    """
    count = 0
    x, y, z = 0.0, 0.0, 0.0
    a, b, c = 0.0, 0.0, 0.0
    g = h
    while True:
        if count == LARGEST_LOOP:
            return False
        v = _origin(m, g)
        rim[count] = v
        count += 1
        x, y, z = x + m.points[v, 0], y + m.points[v, 1], z + m.points[v, 2]
        a, b, c = a + m.normals[v, 0], b + m.normals[v, 1], c + m.normals[v, 2]
        g = _next_on_boundary(m, g)
        if g == h:
            break
    n = _unit((a, b, c))
    t = lift * dials.length
    p = (
        np.float64(np.float32(x / count + t * n[0])),
        np.float64(np.float32(y / count + t * n[1])),
        np.float64(np.float32(z / count + t * n[2])),
    )
    fresh = m.layout[VERTICES]
    for s in range(count):
        u, v = np.int64(rim[s]), np.int64(rim[(s + 1) % count])
        for e in range(s):
            if rim[e] == u:
                return False
        pu, pv = _point(m, u), _point(m, v)
        plane = _plane(pv, pu, p)
        if not _thick(pv, pu, p):
            return False
        if not _fits(m, dials, (v, u, np.int64(fresh)), (pv, pu, p), plane, -1.0, ids, points, normals, s):
            return False
        ids[s, 0], ids[s, 1], ids[s, 2] = v, u, fresh
        for axis in range(3):
            points[s, 0, axis] = pv[axis]
            points[s, 1, axis] = pu[axis]
            points[s, 2, axis] = p[axis]
            normals[s, axis] = plane[axis]
    _add_vertex(m, p, n)
    m.layout[GROWN] += 1
    for s in range(count):
        _add_face(m, np.int64(rim[(s + 1) % count]), np.int64(rim[s]), np.int64(fresh), 2.0 * dials.length)
    return True


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
        n = _plane(_point(m, m.corners[f, 0]), _point(m, m.corners[f, 1]), _point(m, m.corners[f, 2]))
        for axis in range(3):
            m.planes[f, axis] = n[axis]
        _put_in_grid(m, f, 2.0 * length)
    for h in range(3 * count):
        m.twin[h] = _half_edge(m, _end(m, h), _origin(m, h))
        if m.twin[h] < 0:
            m.free[_origin(m, h)] += 1
    return True


@kernel
def grow(m, field, inverse, dials, limit, queue, state):
    """Let every active vertex of the boundary grow, round by round, until none can.

    Parameters
    ----------
    m : Front
    field : (I, J, K) float32
    inverse : (3, 4) float64
        From RAS mm to voxel index.
    dials : Dials
    limit : int
        Vertices at which to stop.
    queue : (3F,) int32
        Room for boundary half-edges.
    state : (2,) int64
        Rounds so far.

    Returns
    -------
    int
        `DONE`, `NO_ROOM` (the same call with larger arrays goes on), or `LIMIT`.
    """
    ids = np.empty((6, 3), dtype=np.int64)
    points, normals = np.empty((6, 3, 3)), np.empty((6, 3))
    rim, rim_points, rim_normals = np.empty(7, dtype=np.int64), np.empty((7, 3)), np.empty((7, 3))
    seen = state[1]
    while True:
        # The boundary now: what was added in this round is for the next.
        count = 0
        top = 3 * m.layout[FACES]
        for e in range(top):
            if m.twin[e] < 0 and m.mode[_end(m, e)] == ACTIVE:
                queue[count] = e
                count += 1
        if count == 0:
            return DONE
        state[0] += 1
        changed = False
        for turn in range(2):
            for i in range(count):
                h = np.int64(queue[i])
                if m.twin[h] >= 0:
                    continue
                v = _end(m, h)
                if m.mode[v] != ACTIVE:
                    continue
                if m.layout[VERTICES] + MARGIN > m.points.shape[0] or m.layout[FACES] + MARGIN > m.corners.shape[0]:
                    return NO_ROOM
                if m.layout[VERTICES] >= limit:
                    return LIMIT
                angle = _open_angle(m, h)
                # Sharp corners first: they are where the boundary is most curved.
                if turn == 0 and angle > 0.5 * np.pi:
                    continue
                done = False
                if angle <= 0.5 * np.pi:
                    done = _close_corner(m, dials, h, 0.1, ids, points, normals)
                if not done and angle > 0.4 * np.pi:
                    done = _fill_corner(
                        m, field, inverse, dials, h, angle, ids, points, normals, rim, rim_points, rim_normals
                    )
                if not done:
                    done = _join_edge(m, dials, h, ids, points, normals)
                if not done and angle <= 0.8 * np.pi:
                    done = _close_corner(m, dials, h, 0.1, ids, points, normals)
                if done:
                    changed = True
                else:
                    m.mode[v] = INACTIVE
                    m.layout[REFUSED] += 1
        if not changed:
            return DONE
        seen += 1
        state[1] = seen


@kernel
def stitch(m, dials, least, queue):
    """Close what is left of the boundary by faces over three adjacent vertices, the smallest first.

    Parameters
    ----------
    m, dials
    least : float
        Least product of a face's normal with those of its vertices.
    queue : (n,) int32
        Room for boundary half-edges.

    Returns
    -------
    int
        `DONE`, or `NO_ROOM`.
    """
    ids = np.empty((LARGEST_LOOP, 3), dtype=np.int64)
    points, normals = np.empty((LARGEST_LOOP, 3, 3)), np.empty((LARGEST_LOOP, 3))
    rim = np.empty(LARGEST_LOOP, dtype=np.int64)
    while True:
        count = 0
        for e in range(3 * m.layout[FACES]):
            if m.twin[e] < 0:
                queue[count] = e
                count += 1
        if count == 0:
            return DONE
        cost = np.empty(count)
        for i in range(count):
            h = np.int64(queue[i])
            g = _next_on_boundary(m, h)
            d = subtract(_point(m, _origin(m, h)), _point(m, _end(m, g)))
            cost[i] = dot(d, d)
        order = np.argsort(cost)
        changed = False
        for i in range(count):
            h = np.int64(queue[order[i]])
            if m.twin[h] >= 0:
                continue
            if m.layout[FACES] + MARGIN > m.corners.shape[0] or m.layout[VERTICES] + MARGIN > m.points.shape[0]:
                return NO_ROOM
            if _close_corner(m, dials, h, least, ids, points, normals):
                changed = True
        if not changed:
            # No three adjacent vertices will do: a point in the middle may.
            for i in range(count):
                h = np.int64(queue[order[i]])
                for turn in range(3):
                    if m.twin[h] < 0 and m.layout[VERTICES] + MARGIN <= m.points.shape[0]:
                        lift = 0.0 if turn == 0 else (0.5 if turn == 1 else -0.5)
                        if _fill_loop(m, dials, h, lift, ids, points, normals, rim):
                            changed = True
            if not changed:
                return DONE


@kernel
def first_triangle(field, inverse, point, threshold, edge, voxel, corners):
    """Write three points of the border, counter-clockwise seen from outside; return whether there are any.

    From `point` (3,) one goes straight on, in each of 26 directions in turn, to where the field falls below the
    threshold; around the nearest such place the triangle is laid, and pulled to the border.
    """
    dials = Dials(threshold, edge, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, voxel)
    best = 1e30
    p = (0.0, 0.0, 0.0)
    for a in range(-1, 2):
        for b in range(-1, 2):
            for c in range(-1, 2):
                size = np.sqrt(np.float64(a * a + b * b + c * c))
                if size == 0.0:
                    continue
                t = 0.0
                while t < min(best, 500.0 * voxel):
                    t += 0.5 * voxel
                    q = (point[0] + t * a / size, point[1] + t * b / size, point[2] + t * c / size)
                    value, inside = sample(field, inverse, q)
                    if not inside:
                        break
                    if value < threshold:
                        if t < best:
                            best = t
                            p = q
                        break
    if best >= 1e30:
        return False
    p, n, found = pull(field, inverse, dials, p)
    if not found:
        return False
    axis = (1.0, 0.0, 0.0) if abs(n[0]) < 0.6 else (0.0, 1.0, 0.0)
    e1 = _unit(cross(n, axis))
    e2 = cross(n, e1)
    for k in range(3):
        turn = 2.0 * np.pi * k / 3.0
        x, y = edge / np.sqrt(3.0) * np.cos(turn), edge / np.sqrt(3.0) * np.sin(turn)
        q = (p[0] + x * e1[0] + y * e2[0], p[1] + x * e1[1] + y * e2[1], p[2] + x * e1[2] + y * e2[2])
        q, _, found = pull(field, inverse, dials, q)
        if not found:
            return False
        for axis_number in range(3):
            corners[k, axis_number] = q[axis_number]
    return True

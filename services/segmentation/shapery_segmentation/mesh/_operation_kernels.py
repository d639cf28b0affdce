"""The three local operations on a closed mesh: split, flip and collapse of an edge.

Each either does all of its work and returns true, or finds a reason against it and leaves the mesh as it was. They keep
the surface closed, manifold, oriented, of the same genus and free of contacts: new faces are tested as a patch before
anything is changed.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.mesh._contact_kernels import cross, dot, subtract
from shapery_segmentation.mesh._grid_kernels import (
    corners,
    link_face,
    measure_face,
    normal,
    patch_is_clear,
    point,
    unlink_face,
)
from shapery_segmentation.mesh.arrays import (
    AREA,
    CARELESS,
    CORNER,
    CREATED,
    FACE_COUNT,
    FACE_TOP,
    FREE_FACE,
    FREE_VERTEX,
    LARGEST_STAR,
    ORIGIN,
    OUT,
    RELINKED,
    SCALE,
    SKIP,
    TOUCHED,
    TWIN,
    VERTEX_COUNT,
    VERTEX_TOP,
)
from shapery_segmentation.mesh.compiled import inner

LEAST_TURN = 0.3
"""Least product of the unit normals of a face and of what replaces it."""

LEAST_SHAPE = 0.1
"""Least compactness (1 for an equilateral triangle) of a new face, unless the one that it replaces had less."""

LEAST_VALENCE = 4
"""Edges that a flip leaves at a vertex at least."""

TARGET_VALENCE = 9
"""Edges above which an operation adds none to a vertex."""


@inner
def following(h):
    """Return the next half-edge around the face."""
    return h - 2 if h % 3 == 2 else h + 1


@inner
def preceding(h):
    """Return the previous half-edge around the face."""
    return h + 2 if h % 3 == 0 else h - 1


@inner
def origin(m, h):
    """Return the vertex at which a half-edge starts."""
    return np.int64(m.half_edges[h, ORIGIN])


@inner
def twin(m, h):
    """Return the same edge as seen from the other face."""
    return np.int64(m.half_edges[h, TWIN])


@inner
def valence(m, v):
    """Return the number of edges at `v`."""
    start = m.vertices[v, OUT]
    h = start
    n = 0
    while True:
        n += 1
        h = twin(m, preceding(h))
        if h == start:
            return n


@inner
def edge_between(m, u, v):
    """Return whether `u` and `v` are joined."""
    start = m.vertices[u, OUT]
    h = start
    while True:
        if origin(m, following(h)) == v:
            return True
        h = twin(m, preceding(h))
        if h == start:
            return False


@inner
def squared_length(m, u, v):
    """Return the squared distance of two vertices."""
    dx, dy, dz = m.points[u, 0] - m.points[v, 0], m.points[u, 1] - m.points[v, 1], m.points[u, 2] - m.points[v, 2]
    return dx * dx + dy * dy + dz * dz


@inner
def _pair(m, h, t):
    """Make `h` and `t` the two sides of one edge."""
    m.half_edges[h, TWIN] = t
    m.half_edges[t, TWIN] = h


@inner
def _touch(m, v):
    """Note that the star of `v` changed."""
    m.vertices[v, TOUCHED] = max(m.vertices[v, TOUCHED], RELINKED)


@inner
def _refresh(m, f):
    """Bring what is derived from face `f` up to date."""
    measure_face(m, f)
    if not m.layout[CARELESS]:
        link_face(m, f)


@inner
def stage_face(m, row, ids, p):
    """Write a face with vertices `ids` at the points `p` to a row of the patch; return its compactness."""
    for k in range(3):
        m.patch_ids[row, k] = ids[k]
        for axis in range(3):
            m.patch[row, 3 * k + axis] = p[k][axis]
    u, v = subtract(p[1], p[0]), subtract(p[2], p[0])
    w = subtract(u, v)
    n = cross(u, v)
    length = np.sqrt(dot(n, n))
    inverse = 1.0 / length if length > 0.0 else 0.0
    radius = 0.0
    center = (
        (p[0][0] + p[1][0] + p[2][0]) / 3.0,
        (p[0][1] + p[1][1] + p[2][1]) / 3.0,
        (p[0][2] + p[1][2] + p[2][2]) / 3.0,
    )
    for k in range(3):
        d = subtract(p[k], center)
        radius = max(radius, dot(d, d))
        m.patch[row, 9 + k] = n[k] * inverse
        m.patch[row, 12 + k] = center[k]
    m.patch[row, 15] = np.sqrt(radius)
    sides = dot(u, u) + dot(v, v) + dot(w, w)
    return 2.0 * np.sqrt(3.0) * length / sides if sides > 0.0 else 0.0


@inner
def compactness(m, f):
    """Return 4√3·area / sum of squared sides of face `f`: 1 for an equilateral triangle, 0 for a needle."""
    a, b, c = corners(m, f)
    sides = squared_length(m, a, b) + squared_length(m, b, c) + squared_length(m, c, a)
    return 4.0 * np.sqrt(3.0) * m.facets[f, AREA] / sides if sides > 0.0 else 0.0


@inner
def _turn(m, row, f):
    """Return the product of the normals of a staged face and of face `f`."""
    return dot((m.patch[row, 9], m.patch[row, 10], m.patch[row, 11]), normal(m, f))


@inner
def _next_vertex(m):
    """Return the slot that `_new_vertex` will take."""
    free = m.layout[FREE_VERTEX]
    return free if free >= 0 else m.layout[VERTEX_TOP]


@inner
def _new_vertex(m):
    """Take a free vertex slot; the caller has made sure that there is one."""
    v = _next_vertex(m)
    if m.layout[FREE_VERTEX] >= 0:
        m.layout[FREE_VERTEX] = -2 - m.vertices[v, OUT]
    else:
        m.layout[VERTEX_TOP] += 1
    m.layout[VERTEX_COUNT] += 1
    return v


@inner
def _new_face(m):
    """Take a free face slot; the caller has made sure that there is one."""
    f = m.layout[FREE_FACE]
    if f >= 0:
        m.layout[FREE_FACE] = -2 - origin(m, 3 * f)
    else:
        f = m.layout[FACE_TOP]
        m.layout[FACE_TOP] += 1
    m.layout[FACE_COUNT] += 1
    return f


@inner
def _drop_vertex(m, v):
    """Return vertex `v` to the free slots."""
    m.vertices[v, OUT] = -2 - m.layout[FREE_VERTEX]
    m.layout[FREE_VERTEX] = v
    m.layout[VERTEX_COUNT] -= 1


@inner
def _drop_face(m, f):
    """Return face `f` to the free slots."""
    if not m.layout[CARELESS]:
        unlink_face(m, f)
    for k in range(3):
        m.half_edges[3 * f + k, ORIGIN] = -1
        m.half_edges[3 * f + k, TWIN] = -1
    m.links[f, CORNER] = -1
    m.half_edges[3 * f, ORIGIN] = -2 - m.layout[FREE_FACE]
    m.layout[FREE_FACE] = f
    m.layout[FACE_COUNT] -= 1


@inner
def room_for_split(m):
    """Return whether the arrays have room for one more vertex and two more faces."""
    return m.layout[VERTEX_COUNT] < m.vertices.shape[0] and m.layout[FACE_COUNT] + 2 <= m.links.shape[0]


@inner
def split_edge(m, h):
    """Put a vertex in the middle of an edge, and so four faces in place of two (Fig. 3.1).

    Returns
    -------
    int
        The new vertex, or −1 where a new face would touch another.
    """
    t = twin(m, h)
    f, g = h // 3, t // 3
    hn, hp, tn, tp = following(h), preceding(h), following(t), preceding(t)
    u, v, a, b = origin(m, h), origin(m, t), origin(m, hp), origin(m, tp)
    p, q, pa, pb = point(m, u), point(m, v), point(m, a), point(m, b)
    middle = (
        np.float64(np.float32(0.5 * (p[0] + q[0]))),
        np.float64(np.float32(0.5 * (p[1] + q[1]))),
        np.float64(np.float32(0.5 * (p[2] + q[2]))),
    )
    w = _next_vertex(m)
    stage_face(m, 0, (u, w, a), (p, middle, pa))
    stage_face(m, 1, (w, v, a), (middle, q, pa))
    stage_face(m, 2, (v, w, b), (q, middle, pb))
    stage_face(m, 3, (w, u, b), (middle, p, pb))
    m.links[f, SKIP] = 1
    m.links[g, SKIP] = 1
    clear = patch_is_clear(m, 4)
    m.links[f, SKIP] = 0
    m.links[g, SKIP] = 0
    if not clear:
        return -1

    w = _new_vertex(m)
    f2, g2 = _new_face(m), _new_face(m)
    for axis in range(3):
        m.points[w, axis] = middle[axis]
    # The lesser, not the mean: of that the halves might be short enough to collapse again.
    m.points[w, SCALE] = min(m.points[u, SCALE], m.points[v, SCALE])
    hn_twin, tn_twin = twin(m, hn), twin(m, tn)
    # f becomes (u, w, a) and f2 = (w, v, a); g becomes (v, w, b) and g2 = (w, u, b).
    m.half_edges[hn, ORIGIN] = w
    m.half_edges[tn, ORIGIN] = w
    m.half_edges[3 * f2, ORIGIN] = w
    m.half_edges[3 * f2 + 1, ORIGIN] = v
    m.half_edges[3 * f2 + 2, ORIGIN] = a
    m.half_edges[3 * g2, ORIGIN] = w
    m.half_edges[3 * g2 + 1, ORIGIN] = u
    m.half_edges[3 * g2 + 2, ORIGIN] = b
    _pair(m, h, 3 * g2)
    _pair(m, t, 3 * f2)
    _pair(m, hn, 3 * f2 + 2)
    _pair(m, tn, 3 * g2 + 2)
    _pair(m, hn_twin, 3 * f2 + 1)
    _pair(m, tn_twin, 3 * g2 + 1)
    m.vertices[w, OUT] = 3 * f2
    m.vertices[u, OUT] = h
    m.vertices[v, OUT] = t
    m.vertices[a, OUT] = hp
    m.vertices[b, OUT] = tp
    m.vertices[w, TOUCHED] = CREATED
    _touch(m, u)
    _touch(m, v)
    _touch(m, a)
    _touch(m, b)
    _refresh(m, f)
    _refresh(m, g)
    _refresh(m, f2)
    _refresh(m, g2)
    return w


@inner
def flip_edge(m, h):
    """Replace an edge by the other diagonal of its two faces (Fig. 3.2); return whether that was done.

    Refused where the other diagonal is an edge already, a vertex would have too few or too many edges, a face would
    turn by more than `LEAST_TURN` allows, get too thin, or touch another.
    """
    t = twin(m, h)
    f, g = h // 3, t // 3
    hn, hp, tn, tp = following(h), preceding(h), following(t), preceding(t)
    u, v, a, b = origin(m, h), origin(m, t), origin(m, hp), origin(m, tp)
    if valence(m, u) <= LEAST_VALENCE or valence(m, v) <= LEAST_VALENCE:
        return False
    if valence(m, a) >= TARGET_VALENCE or valence(m, b) >= TARGET_VALENCE or edge_between(m, a, b):
        return False
    least = min(compactness(m, f), compactness(m, g), LEAST_SHAPE)
    p, q, pa, pb = point(m, u), point(m, v), point(m, a), point(m, b)
    if stage_face(m, 0, (u, b, a), (p, pb, pa)) < least or stage_face(m, 1, (v, a, b), (q, pa, pb)) < least:
        return False
    if min(_turn(m, 0, f), _turn(m, 0, g), _turn(m, 1, f), _turn(m, 1, g)) < LEAST_TURN:
        return False
    m.links[f, SKIP] = 1
    m.links[g, SKIP] = 1
    clear = patch_is_clear(m, 2)
    m.links[f, SKIP] = 0
    m.links[g, SKIP] = 0
    if not clear:
        return False
    hn_twin, hp_twin, tn_twin, tp_twin = (
        twin(m, hn),
        twin(m, hp),
        twin(m, tn),
        twin(m, tp),
    )
    # f becomes (b, a, u) from h on, g becomes (a, b, v) from t on; h and t stay each other's twins.
    m.half_edges[h, ORIGIN] = b
    m.half_edges[hn, ORIGIN] = a
    m.half_edges[hp, ORIGIN] = u
    m.half_edges[t, ORIGIN] = a
    m.half_edges[tn, ORIGIN] = b
    m.half_edges[tp, ORIGIN] = v
    _pair(m, hn, hp_twin)
    _pair(m, hp, tn_twin)
    _pair(m, tn, tp_twin)
    _pair(m, tp, hn_twin)
    m.vertices[u, OUT] = hp
    m.vertices[v, OUT] = tp
    m.vertices[a, OUT] = t
    m.vertices[b, OUT] = h
    _touch(m, u)
    _touch(m, v)
    _touch(m, a)
    _touch(m, b)
    _refresh(m, f)
    _refresh(m, g)
    return True


@inner
def _common_neighbours(m, u, v):
    """Return the number of vertices that are joined to both `u` and `v`."""
    start = m.vertices[u, OUT]
    h = start
    n = 0
    while True:
        w = origin(m, following(h))
        if w != v and edge_between(m, v, w):
            n += 1
        h = twin(m, preceding(h))
        if h == start:
            return n


@inner
def collapse_edge(m, h, longest):
    """Pull the start of a half-edge into its end, which takes a vertex and two faces away (Fig. 3.3).

    Parameters
    ----------
    m : MeshArrays
    h : int
        Half-edge from the vertex that goes to the one that stays.
    longest : float
        Length that no new edge may exceed where the scale of both its ends is 1; elsewhere the lesser scale times this.

    Returns
    -------
    bool
        Whether it was done. Refused where the two have other common neighbours than the two corners opposite (the link
        condition: the surface would be pinched, or its genus change), a corner would be left with two edges, a face
        would turn, get too thin, or touch another.
    """
    t = twin(m, h)
    f, g = h // 3, t // 3
    hn, hp, tn, tp = following(h), preceding(h), following(t), preceding(t)
    u, v, a, b = origin(m, h), origin(m, t), origin(m, hp), origin(m, tp)
    n = valence(m, u)
    if m.layout[VERTEX_COUNT] <= 4 or n > LARGEST_STAR or n + valence(m, v) - 4 > TARGET_VALENCE + 2:
        return False
    if valence(m, a) <= 3 or valence(m, b) <= 3 or _common_neighbours(m, u, v) != 2:
        return False

    rows = 0
    fits = True
    k = twin(m, hp)
    while k != tn:
        # k starts at u; its face is (u, p, q), neither f nor g.
        p, q = origin(m, following(k)), origin(m, preceding(k))
        shape = stage_face(m, rows, (v, p, q), (point(m, v), point(m, p), point(m, q)))
        # Those to the corners opposite are there already; each other is met in one face as its first side.
        limit = longest * min(m.points[v, SCALE], m.points[p, SCALE])
        if (
            shape < min(LEAST_SHAPE, compactness(m, k // 3))
            or _turn(m, rows, k // 3) < LEAST_TURN
            or (p != a and squared_length(m, v, p) > limit * limit)
        ):
            fits = False
            break
        rows += 1
        k = twin(m, preceding(k))
    if not fits:
        return False
    _mark_star(m, u, 1)
    clear = patch_is_clear(m, rows)
    _mark_star(m, u, 0)
    if not clear:
        return False

    # The inner sides of f and g vanish; their outer neighbours meet.
    hn_twin, hp_twin, tn_twin, tp_twin = (
        twin(m, hn),
        twin(m, hp),
        twin(m, tn),
        twin(m, tp),
    )
    k = hp_twin
    while k != tn:
        m.half_edges[k, ORIGIN] = v
        k = twin(m, preceding(k))
    _pair(m, hn_twin, hp_twin)
    _pair(m, tn_twin, tp_twin)
    m.vertices[v, OUT] = hp_twin
    m.vertices[a, OUT] = hn_twin
    m.vertices[b, OUT] = tn_twin
    _drop_face(m, f)
    _drop_face(m, g)
    _drop_vertex(m, u)
    start = m.vertices[v, OUT]
    k = start
    while True:
        _touch(m, origin(m, following(k)))
        _refresh(m, k // 3)
        k = twin(m, preceding(k))
        if k == start:
            break
    _touch(m, v)
    return True


@inner
def _mark_star(m, v, value):
    """Set ``skip`` of all faces around `v`."""
    start = m.vertices[v, OUT]
    h = start
    while True:
        m.links[h // 3, SKIP] = value
        h = twin(m, preceding(h))
        if h == start:
            return

"""Passes over all edges: split the long, collapse the short, flip those that triangles squeeze."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.mesh._contact_kernels import cross, dot, subtract
from shapery_segmentation.mesh._grid_kernels import point
from shapery_segmentation.mesh._operation_kernels import (
    collapse_edge,
    flip_edge,
    following,
    origin,
    preceding,
    room_for_split,
    split_edge,
    squared_length,
    twin,
    valence,
)
from shapery_segmentation.mesh.arrays import (
    AREA,
    CREATED,
    FACE_TOP,
    NORMAL,
    ORIGIN,
    OUT,
    SCALE,
    TOUCHED,
    TWIN,
)
from shapery_segmentation.mesh.compiled import inner, kernel


@inner
def _longest_of_face(m, h):
    """Return whether no other edge of its face is longer than `h`."""
    hn, hp = following(h), preceding(h)
    own = squared_length(m, origin(m, h), origin(m, hn))
    return own >= squared_length(m, origin(m, hn), origin(m, hp)) and own >= squared_length(
        m, origin(m, hp), origin(m, h)
    )


@kernel
def split_pass(m, start, stop, length, ratio, active):
    """Split edges that are longer than their target and the longest of one of their faces.

    Parameters
    ----------
    m : MeshArrays
    start, stop : int
        Half-edges to look at, and those that come to be on the way.
    length : float
        Target edge length in mm where ``scale`` is 1; elsewhere the lesser of its ends' scales times this.
    ratio : float
        Multiple of the target above which an edge is split.
    active : (V,) int8
        An edge is looked at where this is set at one of its ends, or one was created since that was last forgotten.

    Returns
    -------
    done : int
        Edges split.
    resume : int
        Where to go on after the arrays have grown; −1 when the pass is finished.
    """
    done = 0
    h = start
    while h < min(stop, 3 * m.layout[FACE_TOP]):
        t = twin(m, h)
        if t > h:
            u, v = origin(m, h), origin(m, t)
            if active[u] or active[v] or m.vertices[u, TOUCHED] == CREATED or m.vertices[v, TOUCHED] == CREATED:
                limit = ratio * length * min(m.points[u, SCALE], m.points[v, SCALE])
                if squared_length(m, u, v) > limit * limit and (_longest_of_face(m, h) or _longest_of_face(m, t)):
                    if not room_for_split(m):
                        return done, h
                    if split_edge(m, h) >= 0:
                        done += 1
        h += 1
    return done, -1


@inner
def _shortest_of_vertex(m, h):
    """Return whether no other edge at the start of `h` is shorter."""
    u = origin(m, h)
    own = squared_length(m, u, origin(m, following(h)))
    k = twin(m, preceding(h))
    while k != h:
        if squared_length(m, u, origin(m, following(k))) < own:
            return False
        k = twin(m, preceding(k))
    return True


@kernel
def collapse_pass(m, start, stop, length, ratio, longest, active, unwanted):
    """Collapse edges that are shorter than `ratio` times their target, and vertices of three short edges.

    Parameters
    ----------
    m : MeshArrays
    start, stop, length, ratio, active
        As in `split_pass`; also edges are looked at whose ends an operation touched.
    longest : float
        Multiple of the target that no new edge may exceed.
    unwanted : (V,) int8
        1 for vertices that are to collapse into their nearest neighbour, whatever the distance.

    Returns
    -------
    int
        Edges collapsed.
    """
    done = 0
    for h in range(start, min(stop, 3 * m.layout[FACE_TOP])):
        t = twin(m, h)
        if t < 0:
            continue
        u, v = origin(m, h), origin(m, t)
        if not (active[u] or active[v] or m.vertices[u, TOUCHED] or m.vertices[v, TOUCHED] or unwanted[u]):
            continue
        target = length * min(m.points[u, SCALE], m.points[v, SCALE])
        limit = ratio * target
        squared = squared_length(m, u, v)
        short = t > h and squared < limit * limit
        # A vertex of three edges lies in one triangle of its neighbours and does little but thin its faces.
        spare = squared < 4.0 * limit * limit and valence(m, u) == 3
        if unwanted[u] == 1 and _shortest_of_vertex(m, h):
            unwanted[u] = 0
            spare = True
        if not (short or spare):
            continue
        if collapse_edge(m, h, longest * length) or (short and collapse_edge(m, t, longest * length)):
            done += 1
    return done


@inner
def _cotangent(m, w, u, v):
    """Return the cotangent of the angle at `w` towards `u` and `v`."""
    o = point(m, w)
    a, b = subtract(point(m, u), o), subtract(point(m, v), o)
    n = cross(a, b)
    sine, cosine = np.sqrt(dot(n, n)), dot(a, b)
    return cosine / max(sine, 1e-12 * (abs(cosine) + 1e-300))


@kernel
def flip_pass(m, start, stop, slack, active):
    """Flip edges that do not satisfy the Delaunay condition; return how many were flipped.

    Parameters
    ----------
    m : MeshArrays
    start, stop, active
        As in `collapse_pass`.
    slack : float
        An edge is flipped where the cotangents of the two angles opposite sum to less than minus this.
    """
    done = 0
    for h in range(start, min(stop, 3 * m.layout[FACE_TOP])):
        t = twin(m, h)
        if t <= h:
            continue
        u, v = origin(m, h), origin(m, t)
        if not (active[u] or active[v] or m.vertices[u, TOUCHED] or m.vertices[v, TOUCHED]):
            continue
        a, b = origin(m, preceding(h)), origin(m, preceding(t))
        if _cotangent(m, a, u, v) + _cotangent(m, b, u, v) < -slack and flip_edge(m, h):
            done += 1
    return done


@inner
def vertex_normal(m, v, n):
    """Write the unit normal at `v`, its faces weighted by area, to `n` (3,); return the length before scaling."""
    x = y = z = 0.0
    start = m.vertices[v, OUT]
    h = start
    g = m.facets
    while True:
        f = h // 3
        w = g[f, AREA]
        x += w * g[f, NORMAL]
        y += w * g[f, NORMAL + 1]
        z += w * g[f, NORMAL + 2]
        h = twin(m, preceding(h))
        if h == start:
            break
    length = np.sqrt(x * x + y * y + z * z)
    inverse = 1.0 / length if length > 0.0 else 0.0
    n[0] = x * inverse
    n[1] = y * inverse
    n[2] = z * inverse
    return length


@inner
def umbrella(m, v, d):
    """Write the mean of the neighbours of `v`, minus `v`, to `d` (3,)."""
    x = y = z = 0.0
    n = 0
    start = m.vertices[v, OUT]
    h = start
    while True:
        w = origin(m, following(h))
        x += m.points[w, 0]
        y += m.points[w, 1]
        z += m.points[w, 2]
        n += 1
        h = twin(m, preceding(h))
        if h == start:
            break
    d[0] = x / n - m.points[v, 0]
    d[1] = y / n - m.points[v, 1]
    d[2] = z / n - m.points[v, 2]


@kernel
def signed_volume(m):
    """Return the enclosed volume, positive where the faces look outwards."""
    total = 0.0
    first = -1
    for f in range(m.layout[FACE_TOP]):
        if origin(m, 3 * f) < 0:
            continue
        if first < 0:
            first = origin(m, 3 * f)
        g = m.facets
        x, y, z = g[f, 0] - m.points[first, 0], g[f, 1] - m.points[first, 1], g[f, 2] - m.points[first, 2]
        total += g[f, AREA] * (x * g[f, NORMAL] + y * g[f, NORMAL + 1] + z * g[f, NORMAL + 2])
    return total / 3.0


@kernel
def link_twins(m, vertices, faces):
    """Find the twin of every half-edge, and one half-edge that leaves every vertex, from the origins.

    Parameters
    ----------
    m : MeshArrays
    vertices, faces : int
        Slots to look at, all in use.

    Returns
    -------
    int
        Half-edges without exactly one that runs the other way, or whose like occurs twice; if there are none, minus the
        number of vertices whose faces form more than one fan. 0 for a closed, oriented manifold.
    """
    first = np.zeros(vertices + 1, dtype=np.int64)
    for h in range(3 * faces):
        first[m.half_edges[h, ORIGIN] + 1] += 1
    for v in range(vertices):
        first[v + 1] += first[v]
    leaving = np.empty(3 * faces, dtype=np.int32)
    fill = first[:-1].copy()
    for h in range(3 * faces):
        v = m.half_edges[h, ORIGIN]
        leaving[fill[v]] = h
        fill[v] += 1
    wrong = np.int64(0)
    for h in range(3 * faces):
        u, v = origin(m, h), origin(m, following(h))
        found = 0
        for i in range(first[v], first[v + 1]):
            t = np.int64(leaving[i])
            if origin(m, following(t)) == u:
                m.half_edges[h, TWIN] = t
                found += 1
        like = 0
        for i in range(first[u], first[u + 1]):
            like += origin(m, following(np.int64(leaving[i]))) == v
        wrong += found != 1 or like != 1 or u == v
    if wrong > 0:
        return wrong
    for v in range(vertices):
        start = np.int64(leaving[first[v]])
        m.vertices[v, OUT] = start
        n = 1
        around = twin(m, preceding(start))
        while around != start:
            n += 1
            around = twin(m, preceding(around))
        wrong -= n != first[v + 1] - first[v]
    return wrong

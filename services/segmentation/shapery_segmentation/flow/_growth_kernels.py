"""An open surface grows from its boundary, corner by corner, and closes what it meets (3.4.3)."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.flow._fit_kernels import fits, nearest, thick
from shapery_segmentation.flow._front_kernels import (
    ACTIVE,
    DONE,
    FACES,
    GROWN,
    INACTIVE,
    LIMIT,
    MARGIN,
    NO_ROOM,
    REFUSED,
    STITCHED,
    VERTICES,
    add_face,
    add_vertex,
    end,
    next_on_boundary,
    normal,
    open_angle,
    origin,
    plane_of,
    point,
    unit,
)
from shapery_segmentation.flow._level_kernels import pull
from shapery_segmentation.mesh._contact_kernels import cross, dot, subtract
from shapery_segmentation.mesh.compiled import inner, kernel


@inner
def close_corner(m, dials, h, least, ids, points, normals):
    """Add the face over the corner at the end of the boundary half-edge `h` and its neighbours; return whether it fits.

    This is the stitch of Figs 3.9 and 3.10: three adjacent vertices of the boundary.
    """
    g = next_on_boundary(m, h)
    v, left, right = end(m, h), origin(m, h), end(m, g)
    if left == right:
        return False
    pv, pl, pr = point(m, v), point(m, left), point(m, right)
    if not thick(pr, pv, pl):
        return False
    n = plane_of(pr, pv, pl)
    if not fits(m, dials, (right, v, left), (pr, pv, pl), n, least, ids, points, normals, 0):
        return False
    add_face(m, right, v, left, 2.0 * dials.length)
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
    g = next_on_boundary(m, h)
    v, left, right = end(m, h), origin(m, h), end(m, g)
    parts = np.int64(np.floor(angle / (np.pi / 3.0) + 0.5))
    if parts < 2:
        parts = np.int64(2)
    elif parts > 5:
        parts = np.int64(5)
    pv, pl, pr = point(m, v), point(m, left), point(m, right)
    n = normal(m, v)
    a, b = subtract(pl, pv), subtract(pr, pv)
    la, lb = np.sqrt(dot(a, a)), np.sqrt(dot(b, b))
    chord = subtract(pl, pr)
    area = cross(a, b)
    k = 2.0 * np.sqrt(dot(area, area)) / max(la * lb * np.sqrt(dot(chord, chord)), 1e-30)
    step = max(dials.least_step, min(dials.largest_step, dials.rate * k)) * dials.length
    # From the right neighbour, turning clockwise as seen from outside, the open side comes first.
    along = dot(b, n)
    e1 = unit((b[0] - along * n[0], b[1] - along * n[1], b[2] - along * n[2]))
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
        near = nearest(m, dials, q, outward, dials.snap * dials.length, True, v, left, right)
        if near >= 0:
            if m.free[near] == 0:
                return False
            for e in range(s):
                if near == rim[e]:
                    return False
            rim[s] = near
            q = point(m, near)
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
        if not thick(p, pv, q):
            return False
        plane = plane_of(p, pv, q)
        if not fits(
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
            add_vertex(
                m,
                (rim_points[s, 0], rim_points[s, 1], rim_points[s, 2]),
                (rim_normals[s, 0], rim_normals[s, 1], rim_normals[s, 2]),
            )
            m.layout[GROWN] += 1
        else:
            m.mode[rim[s]] = ACTIVE
    for s in range(parts):
        add_face(m, np.int64(rim[s]), v, np.int64(rim[s + 1]), 2.0 * dials.length)
    m.mode[left] = ACTIVE
    m.mode[right] = ACTIVE
    return True


@inner
def _join_edge(m, dials, h, ids, points, normals):
    """Add a face over the boundary half-edge `h` whose third vertex is one of the boundary; return whether one fits."""
    u, v = origin(m, h), end(m, h)
    pu, pv = point(m, u), point(m, v)
    n = unit((
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
        w = nearest(m, dials, p, n, 1.1 * dials.length, False, u, v, skip)
        if w < 0:
            return False
        pw = point(m, w)
        if dot(subtract(pw, pu), away) > 0.0 and thick(pv, pu, pw):
            plane = plane_of(pv, pu, pw)
            if fits(m, dials, (v, u, w), (pv, pu, pw), plane, 0.1, ids, points, normals, 0):
                add_face(m, v, u, w, 2.0 * dials.length)
                m.layout[STITCHED] += 1
                m.mode[u] = ACTIVE
                m.mode[v] = ACTIVE
                m.mode[w] = ACTIVE
                return True
        skip = w
    return False


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
            if m.twin[e] < 0 and m.mode[end(m, e)] == ACTIVE:
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
                v = end(m, h)
                if m.mode[v] != ACTIVE:
                    continue
                if m.layout[VERTICES] + MARGIN > m.points.shape[0] or m.layout[FACES] + MARGIN > m.corners.shape[0]:
                    return NO_ROOM
                if m.layout[VERTICES] >= limit:
                    return LIMIT
                angle = open_angle(m, h)
                # Sharp corners first: they are where the boundary is most curved.
                if turn == 0 and angle > 0.5 * np.pi:
                    continue
                done = False
                if angle <= 0.5 * np.pi:
                    done = close_corner(m, dials, h, 0.1, ids, points, normals)
                if not done and angle > 0.4 * np.pi:
                    done = _fill_corner(
                        m, field, inverse, dials, h, angle, ids, points, normals, rim, rim_points, rim_normals
                    )
                if not done:
                    done = _join_edge(m, dials, h, ids, points, normals)
                if not done and angle <= 0.8 * np.pi:
                    done = close_corner(m, dials, h, 0.1, ids, points, normals)
                if done:
                    changed = True
                else:
                    m.mode[v] = INACTIVE
                    m.layout[REFUSED] += 1
        if not changed:
            return DONE
        seen += 1
        state[1] = seen

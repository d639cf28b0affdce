"""Holes of an open surface are closed: corner by corner, then by a fan (3.4.3, Figs 3.9 and 3.10)."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.flow._fit_kernels import fits, thick
from shapery_segmentation.flow._front_kernels import (
    DONE,
    FACES,
    GROWN,
    LARGEST_LOOP,
    MARGIN,
    NO_ROOM,
    VERTICES,
    add_face,
    add_vertex,
    end,
    next_on_boundary,
    origin,
    plane_of,
    point,
    unit,
)
from shapery_segmentation.flow._growth_kernels import close_corner
from shapery_segmentation.mesh._contact_kernels import dot, subtract
from shapery_segmentation.mesh.compiled import inner, kernel


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
        v = origin(m, g)
        rim[count] = v
        count += 1
        x, y, z = x + m.points[v, 0], y + m.points[v, 1], z + m.points[v, 2]
        a, b, c = a + m.normals[v, 0], b + m.normals[v, 1], c + m.normals[v, 2]
        g = next_on_boundary(m, g)
        if g == h:
            break
    n = unit((a, b, c))
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
        pu, pv = point(m, u), point(m, v)
        plane = plane_of(pv, pu, p)
        if not thick(pv, pu, p):
            return False
        if not fits(m, dials, (v, u, np.int64(fresh)), (pv, pu, p), plane, -1.0, ids, points, normals, s):
            return False
        ids[s, 0], ids[s, 1], ids[s, 2] = v, u, fresh
        for axis in range(3):
            points[s, 0, axis] = pv[axis]
            points[s, 1, axis] = pu[axis]
            points[s, 2, axis] = p[axis]
            normals[s, axis] = plane[axis]
    add_vertex(m, p, n)
    m.layout[GROWN] += 1
    for s in range(count):
        add_face(m, np.int64(rim[(s + 1) % count]), np.int64(rim[s]), np.int64(fresh), 2.0 * dials.length)
    return True


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
            g = next_on_boundary(m, h)
            d = subtract(point(m, origin(m, h)), point(m, end(m, g)))
            cost[i] = dot(d, d)
        order = np.argsort(cost)
        changed = False
        for i in range(count):
            h = np.int64(queue[order[i]])
            if m.twin[h] >= 0:
                continue
            if m.layout[FACES] + MARGIN > m.corners.shape[0] or m.layout[VERTICES] + MARGIN > m.points.shape[0]:
                return NO_ROOM
            if close_corner(m, dials, h, least, ids, points, normals):
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

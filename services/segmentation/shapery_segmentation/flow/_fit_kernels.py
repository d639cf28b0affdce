"""Whether new faces fit to an open surface: nothing touched, nothing folded, and what is near."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.flow._front_kernels import CELLS, FOLD, VERTICES, half_edge, normal, point
from shapery_segmentation.mesh._contact_kernels import cross, dot, subtract, touching
from shapery_segmentation.mesh.compiled import inner


@inner
def fits(m, dials, ia, pa, na, least, extra_ids, extra_points, extra_normals, extras):
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
            if m.free[u] == 0 or dot(na, normal(m, u)) < least:
                return False
            if v < count:
                if half_edge(m, u, v) >= 0:
                    return False
                t = half_edge(m, v, u)
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
                    pb = (point(m, ib[0]), point(m, ib[1]), point(m, ib[2]))
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
def nearest(m, dials, p, n, reach, interior, skip0, skip1, skip2):
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
                            d = subtract(point(m, v), p)
                            if dot(d, d) < best and dot(n, normal(m, v)) > dials.agreement:
                                best = dot(d, d)
                                found = v
                    f = np.int64(m.after[f])
    return found


@inner
def thick(p, q, r):
    """Return whether a triangle is more than a needle."""
    a, b, c = subtract(q, p), subtract(r, q), subtract(p, r)
    n = cross(a, c)
    return np.sqrt(dot(n, n)) > 0.08 * max(dot(a, a), dot(b, b), dot(c, c))

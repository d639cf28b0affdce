"""The pairwise triangle test behind `shapery_geometry.intersections`, and the search for pairs.

Points are rows of one array and are named by their index: a segment is the triangle (p, q, q), a point is (p, p, p), so
that one closed triangle test answers all questions. Every decision is the sign of an exact predicate.

Notes
-----
Numba's cache does not notice that a function called from another module has changed: after an edit of
``_predicates_kernels`` touch this file too.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit

from shapery_geometry._predicates_kernels import orient2d, orient3d


@njit(cache=True, nogil=True)
def same_point(v, a, b):
    """Whether two vertices lie at one place."""
    return v[a, 0] == v[b, 0] and v[a, 1] == v[b, 1] and v[a, 2] == v[b, 2]


@njit(cache=True, nogil=True)
def collinear(v, a, b, c):
    """Whether three points lie on one line."""
    if a == b or b == c or c == a:
        return True
    # a loop, as numba would compile one more version of the predicate for every literal axis
    straight = True
    for axis in range(3):
        straight = straight and orient2d(v, a, b, c, (axis + 1) % 3, (axis + 2) % 3) == 0
    return straight


@njit(cache=True, nogil=True)
def outside(v, p, q, side, a, b, c, x, y):
    """Whether a, b, c lie strictly right of the line pq for `side` 1, left for −1, all on either side for 0."""
    first = orient2d(v, p, q, a, x, y)
    if first == 0 or first == side:
        return False
    return orient2d(v, p, q, b, x, y) == first and orient2d(v, p, q, c, x, y) == first


@njit(cache=True, nogil=True)
def coplanar_triangles_meet(v, t):
    """Whether the closed triangles t[:3] and t[3:], of one plane and with common boxes, share a point.

    Two convex polygons of one plane are apart exactly where a side of one of them parts them; this holds for segments
    and points too, unless all lies on one line, where the boxes have decided already.
    """
    for axis in range(3):
        x = (axis + 1) % 3
        y = (axis + 2) % 3
        first = orient2d(v, t[0], t[1], t[2], x, y)
        second = orient2d(v, t[3], t[4], t[5], x, y)
        spanned = first != 0 or second != 0
        if not spanned:
            for p in range(3):
                for q in range(3):
                    spanned = spanned or orient2d(v, t[p], t[(p + 1) % 3], t[3 + q], x, y) != 0
                    spanned = spanned or orient2d(v, t[p], t[3 + q], t[3 + (q + 1) % 3], x, y) != 0
        if not spanned:
            # seen from this axis, the plane is a line
            continue
        for k in range(3):
            if outside(v, t[k], t[(k + 1) % 3], first, t[3], t[4], t[5], x, y):
                return False
            if outside(v, t[3 + k], t[3 + (k + 1) % 3], second, t[0], t[1], t[2], x, y):
                return False
        return True
    return True


@njit(cache=True, nogil=True)
def line_meets_triangle(v, p, q, a, b, c):
    """Whether the line pq, which is not parallel to the plane of abc, passes through the closed triangle abc."""
    s = orient3d(v, p, q, a, b)
    t = orient3d(v, p, q, b, c)
    if s * t < 0:
        return False
    u = orient3d(v, p, q, c, a)
    return s * u >= 0 and t * u >= 0


@njit(cache=True, nogil=True)
def triangles_meet(v, t):
    """Whether the closed triangles t[:3] and t[3:] share a point. Either may be a segment or a point."""
    for axis in range(3):
        if max(v[t[0], axis], v[t[1], axis], v[t[2], axis]) < min(v[t[3], axis], v[t[4], axis], v[t[5], axis]):
            return False
        if max(v[t[3], axis], v[t[4], axis], v[t[5], axis]) < min(v[t[0], axis], v[t[1], axis], v[t[2], axis]):
            return False
    flat_1 = collinear(v, t[0], t[1], t[2])
    flat_2 = collinear(v, t[3], t[4], t[5])
    if flat_1 and flat_2:
        for p in range(3):
            for q in range(3):
                if orient3d(v, t[p], t[(p + 1) % 3], t[3 + q], t[3 + (q + 1) % 3]) != 0:
                    return False
        return coplanar_triangles_meet(v, t)
    if not flat_2:
        s0 = orient3d(v, t[3], t[4], t[5], t[0])
        s1 = orient3d(v, t[3], t[4], t[5], t[1])
        s2 = orient3d(v, t[3], t[4], t[5], t[2])
        if (s0 > 0 and s1 > 0 and s2 > 0) or (s0 < 0 and s1 < 0 and s2 < 0):
            return False
        if s0 == 0 and s1 == 0 and s2 == 0:
            return coplanar_triangles_meet(v, t)
        # a side with one end in the plane and the other beside it is tested like one that crosses the plane; a side
        # that lies in the plane is covered by the two others' ends and by the sides of the second triangle
        if s0 * s1 <= 0 and s0 != s1 and line_meets_triangle(v, t[0], t[1], t[3], t[4], t[5]):
            return True
        if s1 * s2 <= 0 and s1 != s2 and line_meets_triangle(v, t[1], t[2], t[3], t[4], t[5]):
            return True
        if s2 * s0 <= 0 and s2 != s0 and line_meets_triangle(v, t[2], t[0], t[3], t[4], t[5]):
            return True
        if flat_1:
            return False
    s0 = orient3d(v, t[0], t[1], t[2], t[3])
    s1 = orient3d(v, t[0], t[1], t[2], t[4])
    s2 = orient3d(v, t[0], t[1], t[2], t[5])
    if (s0 > 0 and s1 > 0 and s2 > 0) or (s0 < 0 and s1 < 0 and s2 < 0):
        return False
    if s0 == 0 and s1 == 0 and s2 == 0:
        return coplanar_triangles_meet(v, t)
    if s0 * s1 <= 0 and s0 != s1 and line_meets_triangle(v, t[3], t[4], t[0], t[1], t[2]):
        return True
    if s1 * s2 <= 0 and s1 != s2 and line_meets_triangle(v, t[4], t[5], t[0], t[1], t[2]):
        return True
    return s2 * s0 <= 0 and s2 != s0 and line_meets_triangle(v, t[5], t[3], t[0], t[1], t[2])


@njit(cache=True, nogil=True)
def fans_overlap(v, apex, a, b, c, d):
    """Whether the triangles (apex, a, b) and (apex, c, d) share a point other than the apex.

    A common point beside the apex can be moved away from it until it leaves one of the two, which happens on the side
    opposite the apex: so those two sides decide. A triangle without area has no such side, and its ends decide.
    """
    sc = orient3d(v, apex, a, b, c)
    sd = orient3d(v, apex, a, b, d)
    if (sc > 0 and sd > 0) or (sc < 0 and sd < 0):
        return False
    sa = orient3d(v, apex, c, d, a)
    sb = orient3d(v, apex, c, d, b)
    if (sa > 0 and sb > 0) or (sa < 0 and sb < 0):
        return False
    if collinear(v, apex, a, b):
        if not same_point(v, apex, a) and triangles_meet(v, (a, a, a, apex, c, d)):
            return True
        if not same_point(v, apex, b) and triangles_meet(v, (b, b, b, apex, c, d)):
            return True
    elif triangles_meet(v, (a, b, b, apex, c, d)):
        return True
    if collinear(v, apex, c, d):
        if not same_point(v, apex, c) and triangles_meet(v, (c, c, c, apex, a, b)):
            return True
        return not same_point(v, apex, d) and triangles_meet(v, (d, d, d, apex, a, b))
    return triangles_meet(v, (c, d, d, apex, a, b))


@njit(cache=True, nogil=True)
def wings_overlap(v, p, q, a, b):
    """Whether the triangles (p, q, a) and (p, q, b) share a point beside the edge pq."""
    if same_point(v, p, q):
        return fans_overlap(v, p, q, a, q, b)
    if orient3d(v, p, q, a, b) != 0:
        return False
    for axis in range(3):
        i = (axis + 1) % 3
        j = (axis + 2) % 3
        side = orient2d(v, p, q, a, i, j)
        if side != 0:
            return orient2d(v, p, q, b, i, j) == side
    if not collinear(v, p, q, b):
        return False
    # both are segments on the line of the edge, and overlap where both reach beyond the same end
    for axis in range(3):
        if v[p, axis] != v[q, axis]:
            low = min(v[p, axis], v[q, axis])
            high = max(v[p, axis], v[q, axis])
            return (v[a, axis] < low and v[b, axis] < low) or (v[a, axis] > high and v[b, axis] > high)
    return False


@njit(cache=True, nogil=True)
def faces_overlap(v, faces, i, j):
    """Whether faces i and j share a point beside the vertices or the edge that they have in common by index."""
    # one integer type for all that follows, or numba compiles each function several times
    i0, i1, i2 = np.int64(faces[i, 0]), np.int64(faces[i, 1]), np.int64(faces[i, 2])
    j0, j1, j2 = np.int64(faces[j, 0]), np.int64(faces[j, 1]), np.int64(faces[j, 2])
    # turn both so that what is common comes first and in the same order
    count = 0
    if i0 in (j0, j1, j2):
        count += 1
    if i1 in (j0, j1, j2) and i1 != i0:
        count += 1
        if count == 1:
            i0, i1 = i1, i0
    if i2 in (j0, j1, j2) and i2 != i0 and i2 != i1:
        count += 1
        if count == 1:
            i0, i2 = i2, i0
        elif count == 2:
            i1, i2 = i2, i1
    if count == 0:
        return triangles_meet(v, (i0, i1, i2, j0, j1, j2))
    if count == 3:
        return True
    if i0 == j1:
        j0, j1 = j1, j0
    elif i0 == j2:
        j0, j2 = j2, j0
    if count == 1:
        return fans_overlap(v, i0, i1, i2, j1, j2)
    if i1 == j2:
        j1, j2 = j2, j1
    return wings_overlap(v, i0, i1, i2, j2)


@njit(cache=True, nogil=True)
def overlapping_pairs(v, faces, order, boxes, nodes, first_leaf, leaf_size, asked, limit):
    """(k, 2) pairs of faces that overlap, at most `limit`, of which one at least is `asked` for."""
    pairs = np.empty((64, 2), dtype=np.int32)
    count = 0
    stack = np.empty(128, dtype=np.int64)
    for place in range(len(order)):
        i = order[place]
        if not asked[i]:
            continue
        x0, y0, z0 = boxes[i, 0], boxes[i, 1], boxes[i, 2]
        x1, y1, z1 = boxes[i, 3], boxes[i, 4], boxes[i, 5]
        stack[0] = 0
        top = 1
        while top > 0:
            top -= 1
            node = stack[top]
            if (
                nodes[node, 0] > x1
                or nodes[node, 3] < x0
                or nodes[node, 1] > y1
                or nodes[node, 4] < y0
                or nodes[node, 2] > z1
                or nodes[node, 5] < z0
            ):
                continue
            if node < first_leaf:
                stack[top] = 2 * node + 1
                stack[top + 1] = 2 * node + 2
                top += 2
                continue
            start = (node - first_leaf) * leaf_size
            for other in range(start, min(start + leaf_size, len(order))):
                j = order[other]
                # of two faces that are both asked for, the earlier one in the order finds the pair
                if other == place or (other < place and asked[j]):
                    continue
                if (
                    boxes[j, 0] > x1
                    or boxes[j, 3] < x0
                    or boxes[j, 1] > y1
                    or boxes[j, 4] < y0
                    or boxes[j, 2] > z1
                    or boxes[j, 5] < z0
                ):
                    continue
                if faces_overlap(v, faces, i, j):
                    if count == len(pairs):
                        larger = np.empty((2 * count, 2), dtype=np.int32)
                        # a loop, since numba takes seconds to compile the assignment of a slice
                        for k in range(count):
                            larger[k, 0] = pairs[k, 0]
                            larger[k, 1] = pairs[k, 1]
                        pairs = larger
                    pairs[count, 0] = min(i, j)
                    pairs[count, 1] = max(i, j)
                    count += 1
                    if count == limit:
                        return pairs[:count]
    return pairs[:count]

"""Do two triangles touch? Answered on the safe side, with a clearance.

A pair counts as apart only where a plane is found that separates it: strictly, or, where the two share a corner,
through that corner with the rest of one triangle strictly on one side. Rounding can therefore turn "apart" into
"touching", never the reverse, as long as the clearance exceeds the rounding error of a few products of face-sized
differences by far (1e-4 mm against 1e-13 mm).

Points are tuples (x, y, z) and triangles tuples of three points, which live in registers.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.mesh.compiled import inner

FOLD_SINE = 1e-3
"""Two faces over one edge are folded onto each other where the sine of the angle between them is below this."""

PARALLEL = 1e-12
"""Squared length, relative to that of its factors, below which a cross product gives no direction."""


@inner
def subtract(a, b):
    """Return a − b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inner
def cross(a, b):
    """Return a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inner
def dot(a, b):
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner
def _axis_separates(p, q, d, gap):
    """Return whether the projections of triangles `p` and `q` on the direction `d` lie more than `gap` apart."""
    margin = gap * np.sqrt(dot(d, d))
    p0, p1, p2 = dot(p[0], d), dot(p[1], d), dot(p[2], d)
    q0, q1, q2 = dot(q[0], d), dot(q[1], d), dot(q[2], d)
    return max(p0, p1, p2) + margin < min(q0, q1, q2) or max(q0, q1, q2) + margin < min(p0, p1, p2)


@inner
def _boxes_apart(p, q, gap):
    """Return whether the bounding boxes of two triangles lie more than `gap` apart along an axis."""
    for k in range(3):
        if max(p[0][k], p[1][k], p[2][k]) + gap < min(q[0][k], q[1][k], q[2][k]):
            return True
        if max(q[0][k], q[1][k], q[2][k]) + gap < min(p[0][k], p[1][k], p[2][k]):
            return True
    return False


@inner
def _separated_apart(p, q, gap):
    """Return whether triangles without a common corner are separated by a plane across a face, or along two edges.

    With the planes of the two faces, which the caller has tried, these are all the directions that the separating axis
    theorem asks for.
    """
    # About a corner, so that far from the origin no digits are lost.
    o = p[0]
    p = ((0.0, 0.0, 0.0), subtract(p[1], o), subtract(p[2], o))
    q = (subtract(q[0], o), subtract(q[1], o), subtract(q[2], o))
    # Faces of one plane, the most frequent case, are told apart by the first kind.
    for turn in range(2):
        t = p if turn == 0 else q
        n = cross(subtract(t[1], t[0]), subtract(t[2], t[0]))
        for i in range(3):
            d = cross(n, subtract(t[(i + 1) % 3], t[i]))
            if dot(d, d) > 0.0 and _axis_separates(p, q, d, gap):
                return True
    for i in range(3):
        e = subtract(p[(i + 1) % 3], p[i])
        for j in range(3):
            f = subtract(q[(j + 1) % 3], q[j])
            d = cross(e, f)
            if dot(d, d) > PARALLEL * dot(e, e) * dot(f, f) and _axis_separates(p, q, d, gap):
                return True
    return False


@inner
def _beyond(d, keep, u, v, gap):
    """Return whether `u` and `v` lie strictly on that side of the plane with normal `d` on which `keep` does not."""
    margin = gap * np.sqrt(dot(d, d))
    du, dv = dot(d, u), dot(d, v)
    if dot(d, keep) > 0.0:
        return du < -margin and dv < -margin
    return du > margin and dv > margin


@inner
def _separated_at_corner(a1, a2, b1, b2, gap):
    """Return whether two triangles with one common corner have nothing else in common.

    Parameters
    ----------
    a1, a2
        The first triangle's other corners, from the common one.
    b1, b2
        Likewise of the second.
    gap
        Distance from the separating plane that the corners on at least one side must keep.

    Notes
    -----
    Near the corner both are cones, and they meet elsewhere if and only if the cones do. The planes tried: through an
    edge of one and across its face; half-way between the bisectors (for opposite angles in one plane, where the others
    only touch); through one edge of each. The faces' own planes have been tried by the caller.
    """
    n = cross(a1, a2)
    if _beyond(cross(n, a1), a2, b1, b2, gap) or _beyond(cross(n, a2), a1, b1, b2, gap):
        return True
    n = cross(b1, b2)
    if _beyond(cross(n, b1), b2, a1, a2, gap) or _beyond(cross(n, b2), b1, a1, a2, gap):
        return True
    la1, la2, lb1, lb2 = np.sqrt(dot(a1, a1)), np.sqrt(dot(a2, a2)), np.sqrt(dot(b1, b1)), np.sqrt(dot(b2, b2))
    longest = max(la1, la2, lb1, lb2)
    if min(la1, la2, lb1, lb2) <= gap:
        return False
    d = (
        b1[0] / lb1 + b2[0] / lb2 - a1[0] / la1 - a2[0] / la2,
        b1[1] / lb1 + b2[1] / lb2 - a1[1] / la1 - a2[1] / la2,
        b1[2] / lb1 + b2[2] / lb2 - a1[2] / la1 - a2[2] / la2,
    )
    margin = gap * np.sqrt(dot(d, d))
    if dot(d, a1) < -margin and dot(d, a2) < -margin and dot(d, b1) > margin and dot(d, b2) > margin:
        return True
    for turn in range(4):
        a, other_a = (a1, a2) if turn < 2 else (a2, a1)
        b, other_b = (b1, b2) if turn % 2 == 0 else (b2, b1)
        d = cross(a, b)
        length = np.sqrt(dot(d, d))
        # Edges that are nearly parallel span no plane.
        if length > gap * longest:
            margin = gap * length
            sa, sb = dot(d, other_a), dot(d, other_b)
            if (sa < -margin and sb > margin) or (sa > margin and sb < -margin):
                return True
    return False


@inner
def _folded(u, v, a, b):
    """Return whether the faces (u, v, a) and (v, u, b) lie on each other: no angle between them at their edge."""
    e, s, t = subtract(v, u), subtract(a, u), subtract(b, u)
    ee = dot(e, e)
    if ee == 0.0:
        return True
    ps, pt = dot(s, e) / ee, dot(t, e) / ee
    s = (s[0] - ps * e[0], s[1] - ps * e[1], s[2] - ps * e[2])
    t = (t[0] - pt * e[0], t[1] - pt * e[1], t[2] - pt * e[2])
    ss, tt, along = dot(s, s), dot(t, t), dot(s, t)
    if min(ss, tt) <= PARALLEL * ee:
        return True
    if along <= 0.0:
        return False
    return ss * tt - along * along <= FOLD_SINE * FOLD_SINE * ss * tt


@inner
def _one_side(n, o, q, skip, gap):
    """Return whether the corners of `q` but `skip` lie on one side of the plane with normal `n` through `o`."""
    above = True
    below = True
    for k in range(3):
        if k != skip:
            s = dot(n, subtract(q[k], o))
            above = above and s > gap
            below = below and s < -gap
    return above or below


@inner
def touching(ia, p, na, ib, q, nb, gap):
    """Return whether two faces of a mesh have more in common than the vertices that they share, or might have.

    Parameters
    ----------
    ia, ib
        Numbers of their vertices, which tell what is shared.
    p, q
        Corners.
    na, nb
        Unit normals; zero for a degenerate face.
    gap
        Clearance.
    """
    shared = 0
    a = 0
    b = 0
    for i in range(3):
        for j in range(3):
            if ia[i] == ib[j]:
                shared += 1
                a += i
                b += j
    if shared == 0:
        if _boxes_apart(p, q, gap) or _one_side(na, p[0], q, -1, gap) or _one_side(nb, q[0], p, -1, gap):
            return False
        return not _separated_apart(p, q, gap)
    if shared == 1:
        o = p[a]
        if _one_side(na, o, q, b, gap) or _one_side(nb, o, p, a, gap):
            return False
        return not _separated_at_corner(
            subtract(p[(a + 1) % 3], o),
            subtract(p[(a + 2) % 3], o),
            subtract(q[(b + 1) % 3], o),
            subtract(q[(b + 2) % 3], o),
            gap,
        )
    if shared == 2:
        # The corner that is not shared is what is missing from 0 + 1 + 2.
        a, b = 3 - a, 3 - b
        return _folded(p[(a + 1) % 3], p[(a + 2) % 3], p[a], q[b])
    return True

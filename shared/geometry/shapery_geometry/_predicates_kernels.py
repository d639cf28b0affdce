"""On which side of a line or a plane a point lies, without rounding error.

The sign of a determinant is taken from plain arithmetic where its error bound allows, then from arithmetic in twice the
precision, and at last from expansions: sums of doubles of falling size that represent a number exactly.

References
----------
J. R. Shewchuk, Adaptive precision floating-point arithmetic and fast robust geometric predicates, Discrete &
Computational Geometry 18, 1997, doi:10.1007/PL00009321.
T. J. Dekker, A floating-point technique for extending the available precision, Numerische Mathematik 18, 1971,
doi:10.1007/BF01397083.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit

EPSILON = 2.0**-53
ORIENT2D_BOUND = (3.0 + 16.0 * EPSILON) * EPSILON
ORIENT3D_BOUND = (7.0 + 56.0 * EPSILON) * EPSILON
PAIR_BOUND = 2.0**-95
"""A factor of 30 above the sum of the bounds of all steps in twice the precision."""
SPLITTER = 2.0**27 + 1.0


@njit(cache=True, nogil=True)
def two_sum(a, b):
    """Return the rounded sum and its rounding error."""
    total = a + b
    virtual = total - a
    return total, (a - (total - virtual)) + (b - virtual)


@njit(cache=True, nogil=True)
def two_product(a, b):
    """Return the rounded product and its rounding error (Dekker, Veltkamp)."""
    product = a * b
    c = SPLITTER * a
    a_high = c - (c - a)
    a_low = a - a_high
    c = SPLITTER * b
    b_high = c - (c - b)
    b_low = b - b_high
    return product, a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)


@njit(cache=True, nogil=True)
def expansion_sum(e, n, f, m, h):
    """Write the sum of the expansions e[:n] and f[:m], smallest term first, to `h` without zeros; return its length."""
    length = 0
    i = 0
    j = 0
    carry = 0.0
    started = False
    while i < n or j < m:
        if j >= m or (i < n and abs(e[i]) < abs(f[j])):
            term = e[i]
            i += 1
        else:
            term = f[j]
            j += 1
        if not started:
            carry = term
            started = True
            continue
        carry, error = two_sum(carry, term)
        if error != 0.0:
            h[length] = error
            length += 1
    if carry != 0.0:
        h[length] = carry
        length += 1
    return length


@njit(cache=True, nogil=True)
def expansion_scale(e, n, factor, h):
    """Write e[:n] times `factor` to `h` without zeros; return its length."""
    length = 0
    if n == 0 or factor == 0.0:
        return 0
    carry, error = two_product(e[0], factor)
    if error != 0.0:
        h[length] = error
        length += 1
    for i in range(1, n):
        high, low = two_product(e[i], factor)
        carry, error = two_sum(carry, low)
        if error != 0.0:
            h[length] = error
            length += 1
        carry, error = two_sum(high, carry)
        if error != 0.0:
            h[length] = error
            length += 1
    if carry != 0.0:
        h[length] = carry
        length += 1
    return length


@njit(cache=True, nogil=True)
def expansion_product(e, n, f, m, h, work):
    """Write e[:n] times f[:m], with m at most 2, to `h`; return its length. `work` needs two rows of 2n."""
    if m == 0 or n == 0:
        return 0
    if m == 1:
        return expansion_scale(e, n, f[0], h)
    first = expansion_scale(e, n, f[0], work[0])
    second = expansion_scale(e, n, f[1], work[1])
    return expansion_sum(work[0], first, work[1], second, h)


@njit(cache=True, nogil=True)
def exact_difference(a, b, h):
    """Write a − b to `h`; return its length, 0 to 2."""
    high, low = two_sum(a, -b)
    length = 0
    if low != 0.0:
        h[0] = low
        length = 1
    if high != 0.0:
        h[length] = high
        length += 1
    return length


@njit(cache=True, nogil=True)
def exact_minor(d, n, p, q, x, y, h, work):
    """Write d[p, x] d[q, y] − d[q, x] d[p, y], over expansions of at most 2 terms, to `h`; return its length."""
    left = expansion_product(d[p, x], n[p, x], d[q, y], n[q, y], work[2], work)
    right = expansion_product(d[q, x], n[q, x], d[p, y], n[p, y], work[3], work)
    for i in range(right):
        work[3, i] = -work[3, i]
    return expansion_sum(work[2], left, work[3], right, h)


@njit(cache=True, nogil=True)
def orient2d_exact(v, a, b, c, x, y):
    """Sign of `orient2d` by expansions."""
    d = np.empty((2, 3, 2))
    n = np.empty((2, 3), dtype=np.int64)
    for axis in (x, y):
        n[0, axis] = exact_difference(v[a, axis], v[c, axis], d[0, axis])
        n[1, axis] = exact_difference(v[b, axis], v[c, axis], d[1, axis])
    work = np.empty((5, 16))
    length = exact_minor(d, n, 0, 1, x, y, work[4], work)
    return 0 if length == 0 else (1 if work[4, length - 1] > 0 else -1)


@njit(cache=True, nogil=True)
def orient3d_exact(v, a, b, c, e):
    """Sign of `orient3d` by expansions."""
    d = np.empty((3, 3, 2))
    n = np.empty((3, 3), dtype=np.int64)
    for axis in range(3):
        n[0, axis] = exact_difference(v[a, axis], v[e, axis], d[0, axis])
        n[1, axis] = exact_difference(v[b, axis], v[e, axis], d[1, axis])
        n[2, axis] = exact_difference(v[c, axis], v[e, axis], d[2, axis])
    # rows 0 to 3 for the minors, 4 the minor, 5 its product, 6 and 7 in turn the sum so far
    work = np.empty((8, 192))
    length = 0
    total = 6
    for row in range(3):
        p = (row + 1) % 3
        q = (row + 2) % 3
        k = exact_minor(d, n, p, q, 0, 1, work[4], work)
        k = expansion_product(work[4], k, d[row, 2], n[row, 2], work[5], work)
        length = expansion_sum(work[total], length, work[5], k, work[13 - total])
        total = 13 - total
    return 0 if length == 0 else (1 if work[total, length - 1] > 0 else -1)


@njit(cache=True, nogil=True)
def pair_product(a, a_low, b, b_low):
    """Product of two numbers of twice the precision; relative error below 2⁻¹⁰¹."""
    high, low = two_product(a, b)
    return two_sum(high, low + (a * b_low + a_low * b))


@njit(cache=True, nogil=True)
def pair_sum(a, a_low, b, b_low):
    """Sum of two numbers of twice the precision; error below 2⁻¹⁰³ of the larger one."""
    high, error = two_sum(a, b)
    low, rest = two_sum(a_low, b_low)
    high, error = two_sum(high, error + low)
    return two_sum(high, error + rest)


@njit(cache=True, nogil=True)
def pair_minor(a, a_low, b, b_low, c, c_low, d, d_low):
    """Return a b − c d."""
    left, left_low = pair_product(a, a_low, b, b_low)
    right, right_low = pair_product(c, c_low, d, d_low)
    return pair_sum(left, left_low, -right, -right_low)


@njit(cache=True, nogil=True)
def orient2d(v, a, b, c, x, y):
    """Return 1 where (a, b, c), seen in the axes x and y, turns left, −1 where right, 0 where it is straight."""
    left = (v[a, x] - v[c, x]) * (v[b, y] - v[c, y])
    right = (v[a, y] - v[c, y]) * (v[b, x] - v[c, x])
    det = left - right
    size = abs(left) + abs(right)
    if abs(det) > ORIENT2D_BOUND * size:
        return 1 if det > 0 else -1
    if size == 0.0:
        # the difference of two unequal doubles is never zero, so these products vanish exactly
        return 0
    ax, ax_low = two_sum(v[a, x], -v[c, x])
    ay, ay_low = two_sum(v[a, y], -v[c, y])
    bx, bx_low = two_sum(v[b, x], -v[c, x])
    by, by_low = two_sum(v[b, y], -v[c, y])
    if ax_low == 0.0 and ay_low == 0.0 and bx_low == 0.0 and by_low == 0.0:
        # rounding keeps the order of the products, and their errors decide between equal ones
        left, left_low = two_product(ax, by)
        right, right_low = two_product(ay, bx)
        if left == right:
            left, right = left_low, right_low
        return 1 if left > right else (-1 if left < right else 0)
    det, _ = pair_minor(ax, ax_low, by, by_low, ay, ay_low, bx, bx_low)
    if abs(det) > PAIR_BOUND * size:
        return 1 if det > 0 else -1
    return orient2d_exact(v, a, b, c, x, y)


@njit(cache=True, nogil=True)
def orient3d_pairs(v, a, b, c, d):
    """`orient3d`'s determinant in twice the precision."""
    ax, ax_low = two_sum(v[a, 0], -v[d, 0])
    ay, ay_low = two_sum(v[a, 1], -v[d, 1])
    az, az_low = two_sum(v[a, 2], -v[d, 2])
    bx, bx_low = two_sum(v[b, 0], -v[d, 0])
    by, by_low = two_sum(v[b, 1], -v[d, 1])
    bz, bz_low = two_sum(v[b, 2], -v[d, 2])
    cx, cx_low = two_sum(v[c, 0], -v[d, 0])
    cy, cy_low = two_sum(v[c, 1], -v[d, 1])
    cz, cz_low = two_sum(v[c, 2], -v[d, 2])
    m, m_low = pair_minor(bx, bx_low, cy, cy_low, cx, cx_low, by, by_low)
    first, first_low = pair_product(m, m_low, az, az_low)
    m, m_low = pair_minor(cx, cx_low, ay, ay_low, ax, ax_low, cy, cy_low)
    second, second_low = pair_product(m, m_low, bz, bz_low)
    m, m_low = pair_minor(ax, ax_low, by, by_low, bx, bx_low, ay, ay_low)
    third, third_low = pair_product(m, m_low, cz, cz_low)
    first, first_low = pair_sum(first, first_low, second, second_low)
    return pair_sum(first, first_low, third, third_low)[0]


@njit(cache=True, nogil=True)
def orient3d(v, a, b, c, d):
    """Return the sign of det(a − d, b − d, c − d): 0 where the four points lie in one plane."""
    ax = v[a, 0] - v[d, 0]
    ay = v[a, 1] - v[d, 1]
    az = v[a, 2] - v[d, 2]
    bx = v[b, 0] - v[d, 0]
    by = v[b, 1] - v[d, 1]
    bz = v[b, 2] - v[d, 2]
    cx = v[c, 0] - v[d, 0]
    cy = v[c, 1] - v[d, 1]
    cz = v[c, 2] - v[d, 2]
    bxcy = bx * cy
    cxby = cx * by
    cxay = cx * ay
    axcy = ax * cy
    axby = ax * by
    bxay = bx * ay
    det = az * (bxcy - cxby) + bz * (cxay - axcy) + cz * (axby - bxay)
    size = (abs(bxcy) + abs(cxby)) * abs(az) + (abs(cxay) + abs(axcy)) * abs(bz) + (abs(axby) + abs(bxay)) * abs(cz)
    if abs(det) > ORIENT3D_BOUND * size:
        return 1 if det > 0 else -1
    if size == 0.0 or a == b or b == c or c == a:
        return 0
    det = orient3d_pairs(v, a, b, c, d)
    if abs(det) > PAIR_BOUND * size:
        return 1 if det > 0 else -1
    return orient3d_exact(v, a, b, c, d)

"""Compiled loops of `shapery_retrieval.correspondence`: the samples of two surfaces laid on each other."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit

from shapery_retrieval._matching_kernels import FAST, settle, transport


@njit(**FAST)
def _gain(alike, turned, masses, other):
    """Return how much nearer, by the nearest on either side, single samples are as they are than mirrored."""
    k, l = alike.shape  # noqa: E741
    result = np.float32(0.0)
    column, turned_column = alike[0].copy(), turned[0].copy()
    for i in range(k):
        least, turned_least = alike[i, 0], turned[i, 0]
        for j in range(l):
            least, turned_least = min(least, alike[i, j]), min(turned_least, turned[i, j])
            column[j], turned_column[j] = min(column[j], alike[i, j]), min(turned_column[j], turned[i, j])
        result += masses[i] * (turned_least - least)
    for j in range(l):
        result += other[j] * (turned_column[j] - column[j])
    return result


@njit(**FAST)
def _misfit(around, distances, places, distances2):
    """(s, t) how badly each sample fits at each of another surface: by those around it, laid at `places` there.

    It is the mean square of what their distances would change. Four are gone through at once, for speed.
    """
    s, t = len(distances), len(distances2)
    few = around.shape[1]
    by_fours = few - few % 4
    share = np.float32(1.0) / np.float32(few)
    result = np.zeros((s, t), dtype=np.float32)
    for i in range(s):
        out, near, own = result[i], around[i], distances[i]
        for q in range(0, by_fours, 4):
            a, b, c, d = own[near[q]], own[near[q + 1]], own[near[q + 2]], own[near[q + 3]]
            e, f = distances2[places[near[q]]], distances2[places[near[q + 1]]]
            g, h = distances2[places[near[q + 2]]], distances2[places[near[q + 3]]]
            for j in range(t):
                w, x, y, z = a - e[j], b - f[j], c - g[j], d - h[j]
                out[j] += share * (w * w + x * x + y * y + z * z)
        for q in range(by_fours, few):
            a, e = own[near[q]], distances2[places[near[q]]]
            for j in range(t):
                w = a - e[j]
                out[j] += share * w * w
    return result


@njit(**FAST)
def _lengths(distances, unit):
    """Return distances that are kept in units as they are."""
    result = np.empty(distances.shape, dtype=np.float32)
    for i in range(len(distances)):
        row, out = distances[i], result[i]
        for j in range(len(row)):
            out[j] = unit * np.float32(row[j])
    return result


@njit(**FAST)
def _largest_of_columns(matrix):
    """(t,) the first row where each column of a matrix (s, t) is largest.

    What is less by a ten-thousandth counts as large: on a surface with symmetries places are as good as others, and
    which one is taken must not hang on rounding.
    """
    s, t = matrix.shape
    most = matrix[0].copy()
    for i in range(1, s):
        row = matrix[i]
        for j in range(t):
            most[j] = max(most[j], row[j])
    for j in range(t):
        most[j] *= np.float32(1.0 - 1e-4)
    result = np.zeros(t, dtype=np.int32)
    for i in range(s - 1, -1, -1):
        row = matrix[i]
        for j in range(t):
            if row[j] >= most[j]:
                result[j] = i
    return result


@njit(**FAST)
def lay(
    masses, known, sides, squares, bare, unit, around, gathered,
    masses2, known2, sides2, squares2, bare2, unit2, around2, gathered2,
    alpha, warm, epsilon, outer, rounds, fine_epsilon,
    few, near_alpha, near_epsilon, near_rounds, mirrored, relaxed, plan,
):  # fmt: skip
    """Fill `plan` (s, t) with what lays the samples of one surface on those of another.

    Arguments are the fields of two `shapery_retrieval.correspondence.SampledSurface`, and that module's constants.
    """
    s, t, k, l = len(masses), len(masses2), len(gathered), len(gathered2)  # noqa: E741
    every, every2 = _lengths(bare, unit), _lengths(bare2, unit2)
    distances, distances2 = np.ascontiguousarray(every[:, :k]), np.ascontiguousarray(every2[:, :l])
    products, by_sides = np.dot(known, known2.T), np.dot(sides, sides2.T)
    alike, turned = np.empty((k, l), dtype=np.float32), np.empty((k, l), dtype=np.float32)
    for i in range(k):
        for j in range(l):
            both = squares[i] + squares2[j] - np.float32(2.0) * products[i, j]
            alike[i, j] = both - np.float32(2.0) * by_sides[i, j]
            turned[i, j] = both + np.float32(2.0) * by_sides[i, j]
    coarse = np.empty((k, l), dtype=np.float32)
    coarse_cost = transport(
        alike, gathered, distances[:k], gathered2, distances2[:l],
        alpha, warm, epsilon, outer, rounds, relaxed, coarse,
    )  # fmt: skip
    sign = np.float32(1.0)
    if _gain(alike, turned, gathered, gathered2) < 0:
        other = np.empty((k, l), dtype=np.float32)
        turned_cost = transport(
            turned, gathered, distances[:k], gathered2, distances2[:l],
            alpha, warm, epsilon, outer, rounds, relaxed, other,
        )  # fmt: skip
        if turned_cost < mirrored * coarse_cost:
            sign, coarse = np.float32(-1.0), other
    # Σ_kl (C_ik − D_jl)² T_kl = (C² T1)_i + (D² Tᵀ1)_j − 2 (C T Dᵀ)_ij, with distances to the coarse samples
    across = np.dot(np.dot(distances, coarse), distances2.T)
    carried, borne = np.zeros(k, dtype=np.float32), np.zeros(l, dtype=np.float32)
    for i in range(k):
        for j in range(l):
            carried[i] += coarse[i, j]
            borne[j] += coarse[i, j]
    beta = np.float32(1.0) - alpha
    row, column = np.empty(s, dtype=np.float32), np.empty(t, dtype=np.float32)
    for i in range(s):
        total = np.float32(0.0)
        for a in range(k):
            total += distances[i, a] * distances[i, a] * carried[a]
        row[i] = beta * squares[i] + alpha * total
    for j in range(t):
        total = np.float32(0.0)
        for b in range(l):
            total += distances2[j, b] * distances2[j, b] * borne[b]
        column[j] = beta * squares2[j] + alpha * total
    cost = np.empty((s, t), dtype=np.float32)
    for i in range(s):
        for j in range(t):
            products[i, j] += sign * by_sides[i, j]
            inner = beta * products[i, j] + alpha * across[i, j]
            cost[i, j] = row[i] + column[j] - np.float32(2.0) * inner
    settle(cost, masses, masses2, fine_epsilon, rounds, relaxed, plan)
    # where a sample was laid the most, and what was laid there; columns are gone through far faster than rows
    places, back = _largest_of_columns(np.ascontiguousarray(plan.T)), _largest_of_columns(plan)
    misfit = _misfit(around[:, :few], every, places, every2)
    if not relaxed:  # of a part's whole much may stay bare, and what is laid there says nothing
        behind = _misfit(around2[:, :few], every2, back, every)
        for i in range(s):
            for j in range(t):
                misfit[i, j] = np.float32(0.5) * (misfit[i, j] + behind[j, i])
    beta = np.float32(1.0) - near_alpha
    for i in range(s):
        for j in range(t):
            unlike = squares[i] + squares2[j] - np.float32(2.0) * products[i, j]
            cost[i, j] = beta * unlike + near_alpha * misfit[i, j]
    settle(cost, masses, masses2, near_epsilon, near_rounds, relaxed, plan)


@njit(**FAST)
def gathered_by_parts(plan, parts, count, parts2, count2):
    """(count, count2) sums of a plan (s, t) over the parts that samples lie in; those of part −1 are left out."""
    rows = np.zeros((count, plan.shape[1]), dtype=np.float32)
    for i in range(len(parts)):
        if parts[i] >= 0:
            into, of = rows[parts[i]], plan[i]
            for j in range(len(of)):
                into[j] += of[j]
    result = np.zeros((count, count2))
    for p in range(count):
        into, of = result[p], rows[p]
        for j in range(len(parts2)):
            if parts2[j] >= 0:
                into[parts2[j]] += of[j]
    return result


@njit(**FAST)
def overlaid(plan, parts, count, masses2, bare):
    """(t,) the part of which a plan (s, t) brings the most to each sample of the other surface.

    It is −1 where less comes, for the sample's share of the surface, than `bare` of what comes on average.
    """
    t = plan.shape[1]
    brought = np.zeros((count, t), dtype=np.float32)
    for i in range(len(parts)):
        if parts[i] >= 0:
            into, of = brought[parts[i]], plan[i]
            for j in range(t):
                into[j] += of[j]
    density = np.zeros(t, dtype=np.float32)
    result = np.zeros(t, dtype=np.int64)
    mean = np.float32(0.0)
    for j in range(t):
        total, most = np.float32(0.0), np.float32(-1.0)
        for part in range(count):
            total += brought[part, j]
            if brought[part, j] > most:
                result[j], most = part, brought[part, j]
        density[j] = total / max(masses2[j], np.float32(1e-12))
        mean += total * density[j]
    for j in range(t):
        if density[j] < bare * mean:
            result[j] = -1
    return result

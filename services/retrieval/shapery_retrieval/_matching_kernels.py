"""Compiled loops of `shapery_retrieval.matching`: fused Gromov–Wasserstein transport between small graphs."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit

FAST = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"nnan", "ninf", "nsz", "reassoc", "contract"},
}


@njit(**FAST)
def _exponentials(row, left, right, sharpness, l, out):  # noqa: E741
    """Fill a row of the kernel: exp of minus the excess over the half of two least values, bounded by 30.

    e^x is (1 + y + y²/2)^1024 with y = x/1024, to 3·10⁻³ where it is 10⁻¹³ and far better above. The library's function
    would be called number by number; this runs on whole registers, without a loop inside.
    """
    for j in range(l):
        excess = (row[j] - np.float32(0.5) * (left + right[j])) * sharpness
        y = -min(excess, np.float32(30.0)) * np.float32(1 / 1024)
        e = np.float32(1.0) + y + np.float32(0.5) * y * y
        e *= e
        e *= e
        e *= e
        e *= e
        e *= e
        e *= e
        e *= e
        e *= e
        e *= e
        e *= e
        out[j] = e


@njit(**FAST)
def _balance(kernel, masses, other, k, l, rounds, relaxed, plan):  # noqa: E741
    """Scale a kernel to the given margins, both sides at once, so that the plan of (y, x) is that of (x, y) transposed.

    With `relaxed` only the first margin is met.
    """
    u = np.ones(k, dtype=np.float32)
    v = np.ones(l, dtype=np.float32)
    rows = np.empty(k, dtype=np.float32)
    columns = np.empty(l, dtype=np.float32)
    if relaxed:
        v[:] = other
    else:
        for j in range(l):
            if other[j] <= 0:
                v[j] = 0.0
        for _ in range(rounds):
            columns[:] = 0.0
            for i in range(k):
                row = kernel[i]
                ui = u[i]
                total = np.float32(0.0)
                for j in range(l):
                    total += row[j] * v[j]
                    columns[j] += row[j] * ui
                rows[i] = total
            for i in range(k):
                u[i] = np.sqrt(u[i] * masses[i] / max(rows[i], np.float32(1e-30)))
            for j in range(l):
                v[j] = np.sqrt(v[j] * other[j] / max(columns[j], np.float32(1e-30)))
    carried = np.float32(0.0)
    for i in range(k):
        row = kernel[i]
        total = np.float32(0.0)
        for j in range(l):
            total += row[j] * v[j]
        rows[i] = total
        carried += u[i] * total
    share = np.float32(1.0) / max(carried, np.float32(1e-30))
    for i in range(k):
        row, out = kernel[i], plan[i]
        factor = masses[i] / max(rows[i], np.float32(1e-30)) if relaxed else u[i] * share
        for j in range(l):
            out[j] = factor * row[j] * v[j]


@njit(**FAST)
def _least(row, l):  # noqa: E741
    """Return the least of the first numbers of a row, in eight lanes: compilers keep a single one in its order."""
    by_eights = l - l % 8
    a = b = c = d = e = f = g = h = row[0]
    for j in range(0, by_eights, 8):
        a, b, c, d = min(a, row[j]), min(b, row[j + 1]), min(c, row[j + 2]), min(d, row[j + 3])
        e, f, g, h = min(e, row[j + 4]), min(f, row[j + 5]), min(g, row[j + 6]), min(h, row[j + 7])
    result = min(min(min(a, b), min(c, d)), min(min(e, f), min(g, h)))
    for j in range(by_eights, l):
        result = min(result, row[j])
    return result


@njit(**FAST)
def _settle(cost, masses, other, sharpness, rounds, relaxed, left, right, kernel, plan):
    k, l = len(masses), len(other)  # noqa: E741
    right[:] = cost[0]
    for i in range(k):
        row = cost[i]
        left[i] = _least(row, l)
        for j in range(l):
            right[j] = min(right[j], row[j])
    # Shifts by row and by column change no plan. Taken half each they keep the plan of (y, x) that of (x, y)
    # transposed; the bound keeps columns from vanishing in single precision.
    for i in range(k):
        _exponentials(cost[i], left[i], right, sharpness, l, kernel[i])
    _balance(kernel, masses, other, k, l, rounds, relaxed, plan)


@njit(**FAST)
def settle(cost, masses, other, epsilon, rounds, relaxed, plan):
    """Fill `plan` (k, l) with what carries the masses at the given costs, softened by entropy."""
    k, l = len(masses), len(other)  # noqa: E741
    kernel = np.empty((k, l), dtype=np.float32)
    left = np.empty(k, dtype=np.float32)
    right = np.empty(l, dtype=np.float32)
    _settle(cost, masses, other, np.float32(1.0) / epsilon, rounds, relaxed, left, right, kernel, plan)


@njit(**FAST)
def transport(
    cost, masses, distances, other_masses, other_distances, alpha, warm, epsilon, outer, rounds, relaxed, plan
):  # fmt: skip
    """Fill `plan` (k, l) and return its cost: (1 − α)⟨M, T⟩ + α Σ (C_ik − D_jl)² T_ij T_kl.

    M is `cost` (k, l), that of putting two nodes together. Entropy falls from `warm` at the first step to `epsilon` at
    the last.
    """
    k, l = len(masses), len(other_masses)  # noqa: E741
    kernel = np.empty((k, l), dtype=np.float32)
    gradient = np.empty((k, l), dtype=np.float32)
    half = np.empty((k, l), dtype=np.float32)
    left = np.empty(k, dtype=np.float32)
    right = np.empty(l, dtype=np.float32)
    lengths = np.empty(l, dtype=np.float32)
    beta = np.float32(1.0) - alpha
    for i in range(k):
        for j in range(l):
            gradient[i, j] = cost[i, j]
    linear = np.float32(0.0)
    structure = np.float32(0.0)
    for step in range(outer + 1):
        # the first plan is that of the nodes alone
        left_over = np.float32(outer - step) / np.float32(max(outer, 1))
        sharpness = np.float32(1.0) / (epsilon * (warm / epsilon) ** left_over)
        _settle(gradient, masses, other_masses, sharpness, rounds, relaxed, left, right, kernel, plan)
        # Σ_kl (C_ik − D_jl)² T_kl = (C² T1)_i + (D² Tᵀ1)_j − 2 (C T D)_ij
        for i in range(k):
            row = np.float32(0.0)
            for j in range(l):
                row += plan[i, j]
            left[i] = row
        for j in range(l):
            right[j] = 0.0
        for i in range(k):
            for j in range(l):
                right[j] += plan[i, j]
        np.dot(distances, plan, half)
        np.dot(half, other_distances, gradient)
        for j in range(l):
            own = np.float32(0.0)
            for b in range(l):
                own += other_distances[j, b] * other_distances[j, b] * right[b]
            lengths[j] = own
        for i in range(k):
            own = np.float32(0.0)
            for a in range(k):
                own += distances[i, a] * distances[i, a] * left[a]
            for j in range(l):
                gradient[i, j] = own + lengths[j] - np.float32(2.0) * gradient[i, j]
        linear = np.float32(0.0)
        structure = np.float32(0.0)
        for i in range(k):
            for j in range(l):
                linear += cost[i, j] * plan[i, j]
                structure += gradient[i, j] * plan[i, j]
                gradient[i, j] = beta * cost[i, j] + 2 * alpha * gradient[i, j]
    return beta * linear + alpha * structure


@njit(**FAST)
def transport_many(
    costs, masses, distances, bank_masses, bank_distances, chosen, alpha, epsilon, outer, rounds, relaxed
):  # fmt: skip
    """(c,) cost of one graph against the chosen ones of a bank, from (c, k, l) costs of putting nodes together."""
    result = np.empty(len(chosen), dtype=np.float32)
    plan = np.empty((len(masses), bank_masses.shape[1]), dtype=np.float32)
    for place in range(len(chosen)):
        x = chosen[place]
        result[place] = transport(
            costs[place], masses, distances, bank_masses[x], bank_distances[x],
            alpha, epsilon, epsilon, outer, rounds, relaxed, plan,
        )  # fmt: skip
    return result


@njit(**FAST)
def transport_to_self(costs, masses, distances, alpha, epsilon, outer, rounds):
    """(n,) cost of each graph with itself, from (n, k, k) costs of putting nodes together."""
    result = np.empty(len(masses), dtype=np.float32)
    plan = np.empty((masses.shape[1], masses.shape[1]), dtype=np.float32)
    for x in range(len(masses)):
        result[x] = transport(
            costs[x], masses[x], distances[x], masses[x], distances[x],
            alpha, epsilon, epsilon, outer, rounds, False, plan,
        )  # fmt: skip
    return result

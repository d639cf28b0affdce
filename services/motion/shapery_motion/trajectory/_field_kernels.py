"""Coefficient fields: one number per vertex and mode, coded down a cluster's pairing tree.

A node holds the mean of its vertices. Going down, each pair needs the difference of its children's means; it is
predicted from the nodes around, and what remains is coded at a step of 1 in the orthonormal (Haar) scaling.

The stream comes in four editions. From the second on, what earlier clusters say of the vertices beside a cluster
helps to predict it, predictions are trusted as far as they proved right, and links are weighted anew as modes are
known. In the third, a cluster's mean trajectory is a function of its own, whose field needs no numbers. In the fourth,
numbers are quantised dependently (`_trellis_kernels`).
"""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

import numpy as np

from shapery_motion.compiled import inlined, inner, kernel
from shapery_motion.entropy._coder_kernels import BINS, CONTEXTS, DECODE, MODE, code_value, value_costs
from shapery_motion.trajectory._level_kernels import (
    MAX_LEVEL,
    MAX_MODE,
    MIXER_ROWS,
    ROWS,
    describe,
    long_memory,
    moved,
    plan_level,
    trusted,
)
from shapery_motion.trajectory._trellis_kernels import (
    CANDIDATES,
    DELAY,
    NEXT,
    NUMBERS,
    REALS,
    STATES,
    candidates_of,
    level_of,
)

SWEEPS: Final = 3
"""Passes of relaxation in which a level is predicted from the one above."""
GUIDES: Final = (3, 6, 12, 24)
"""Numbers of decoded modes after which their fields, as coordinates, weight the links of later modes; the first
edition knows the first number only."""
PRIOR: Final = 5.0
"""With how many squared steps a prediction is trusted before it was tried."""
NEAREST: Final = 0.1


@inlined
def optimum(pair, children, sizes, links, link_starts, link_weights, inner_weight, means, center, outer_weights, outer):
    """Return the difference of the children's means at which the squared differences along edges are least."""
    a, b = children[pair, 0], children[pair, 1]
    whole = float(sizes[a] + sizes[b])
    share_a, share_b = sizes[b] / whole, sizes[a] / whole
    pull, stiffness = 0.0, inner_weight
    for e in range(link_starts[2 * pair], link_starts[2 * pair + 1]):
        w = share_a * link_weights[e]
        pull += w * (means[links[e]] - center)
        stiffness += share_a * w
    for e in range(link_starts[2 * pair + 1], link_starts[2 * pair + 2]):
        w = share_b * link_weights[e]
        pull -= w * (means[links[e]] - center)
        stiffness += share_b * w
    if len(outer):
        if outer_weights[a] > 0.0:
            w = share_a * outer_weights[a]
            pull += w * (outer[a] - center)
            stiffness += share_a * w
        if outer_weights[b] > 0.0:
            w = share_b * outer_weights[b]
            pull -= w * (outer[b] - center)
            stiffness += share_b * w
    return pull / stiffness if stiffness > 0.0 else 0.0


@inner
def add_squares(children, links, link_starts, means, outer, link_squares, inner_squares, outer_squares):
    """Add the squared differences of a mode's means along all links to those of the modes before it."""
    for pair in range(len(children)):
        for side in range(2):
            node = children[pair, side]
            for e in range(link_starts[2 * pair + side], link_starts[2 * pair + side + 1]):
                step = means[node] - means[links[e]]
                link_squares[e] += step * step
            if len(outer):
                step = means[node] - outer[node]
                outer_squares[node] += step * step
        step = means[children[pair, 0]] - means[children[pair, 1]]
        inner_squares[pair] += step * step


@inner
def weigh_links(
    children, levels, link_starts, link_counts, link_squares, link_weights,
    inner_counts, inner_squares, inner_weights, outer_counts, outer_squares, outer_weights,
):  # fmt: skip
    """Set the weights of links to what they are in space: the count of edges / distance ^ 3/2 in each level."""
    low, pairs = 0, len(levels)
    while low < pairs:
        high = low
        total, count = 0.0, 0
        while high < pairs and levels[high] == levels[low]:
            for e in range(link_starts[2 * high], link_starts[2 * high + 2]):
                total += np.sqrt(link_squares[e])
                count += 1
            high += 1
        unit = total / count if count else 1.0
        if unit > 0.0:
            for pair in range(low, high):
                for e in range(link_starts[2 * pair], link_starts[2 * pair + 2]):
                    d = max(np.sqrt(link_squares[e]) / unit, NEAREST)
                    link_weights[e] = link_counts[e] / (d * np.sqrt(d))
                d = max(np.sqrt(inner_squares[pair]) / unit, NEAREST)
                inner_weights[pair] = inner_counts[pair] / (d * np.sqrt(d))
                if len(outer_counts):
                    for side in range(2):
                        node = children[pair, side]
                        if outer_counts[node] > 0.0:
                            d = max(np.sqrt(outer_squares[node]) / unit, NEAREST)
                            outer_weights[node] = outer_counts[node] / (d * np.sqrt(d))
        low = high


@kernel
def code_fields(
    state, buffer, probabilities, hits, weights, bases,
    children, levels, sizes, links, link_starts, link_counts, inner_counts, parents, outer_counts, outer_values,
    targets, carry, rank, quantised, decoded, costs, trade,
):  # fmt: skip
    """Code the fields of one cluster: `rank` modes over n vertices.

    Two rows of `bases` (1 or 2, 8), where the contexts of each kind begin, tell that quantisation is dependent.

    Encoding, `targets` (n, rank) holds what is to be coded in units of the step, `costs` the bits of a probability and
    `trade` how much squared error a bit is worth. `decoded` (rank, n) receives the values that a decoder has, and
    `quantised` (rank, 1 + pairs) the whole numbers, by which later modes are predicted. A share `carry` (rank, rank) of
    each mode's error is added to the targets of later ones.

    In the second edition `outer_counts` (n,) are the edges of each vertex that lead to earlier clusters, and
    `outer_values` (rank, n) the mean of what is beyond them, 0 where there are none; in the first both are empty.
    """
    pairs = len(children)
    n = pairs + 1
    slots = np.zeros(CONTEXTS, dtype=np.int64)
    logits = np.zeros(CONTEXTS, dtype=np.int64)
    means = np.zeros(n + pairs)
    second = len(outer_counts) > 0
    link_weights, inner_weights = link_counts.copy(), inner_counts.copy()
    link_squares, inner_squares = np.zeros(len(link_counts)), np.zeros(pairs)
    nodes = n + pairs if second else 0
    counts_outside, squares_outside, outer = np.zeros(nodes), np.zeros(nodes), np.zeros(nodes)
    if second:
        counts_outside[:n] = outer_counts
        for pair in range(pairs):
            counts_outside[n + pair] = counts_outside[children[pair, 0]] + counts_outside[children[pair, 1]]
    outer_weights = counts_outside.copy()
    agreed, tried = np.zeros(MAX_LEVEL), np.zeros(MAX_LEVEL)
    wanted = np.zeros(n + pairs)
    running = np.zeros(MAX_LEVEL, dtype=np.int64)
    values, bits = np.zeros(CANDIDATES, dtype=np.int64), np.zeros(CANDIDATES)
    numbers, reals = np.zeros((NUMBERS, STATES, DELAY), dtype=np.int64), np.zeros((REALS, STATES, DELAY))
    kept = np.zeros((pairs, 2))
    encoding = state[MODE] != DECODE
    dependent = len(bases) > 1
    for mode in range(rank):
        now = quantised[mode]
        before = quantised[max(mode - 1, 0)]
        earlier = quantised[max(mode - 2, 0)]
        third = quantised[max(mode - 3, 0)]
        for k in range(MAX_LEVEL):
            running[k] = 64
            agreed[k] = 0.5 * agreed[k] + PRIOR
            tried[k] = 0.5 * tried[k] + PRIOR
        if second:
            outer[:n] = outer_values[mode]
            for pair in range(pairs):
                a, b = children[pair, 0], children[pair, 1]
                count = counts_outside[n + pair]
                total = counts_outside[a] * outer[a] + counts_outside[b] * outer[b]
                outer[n + pair] = total / count if count > 0.0 else 0.0
        if encoding:
            for v in range(n):
                wanted[v] = targets[v, mode]
            for pair in range(pairs):
                a, b = children[pair, 0], children[pair, 1]
                wanted[n + pair] = (sizes[a] * wanted[a] + sizes[b] * wanted[b]) / (sizes[a] + sizes[b])
        # the root
        trellis = 0
        root = n + pairs - 1 if pairs else 0
        for k in range(CONTEXTS):
            slots[k] = (bases[0, k] + (min(mode, 15) if k % 2 else 0)) * BINS
        slots[0] = (bases[0, 0] + (MAX_LEVEL - 1) * MAX_MODE + min(mode, MAX_MODE - 1)) * BINS
        root_scale = np.sqrt(float(n))
        value = 0
        if encoding:
            value = int(np.rint(wanted[root] * root_scale))
        value = code_value(state, buffer, probabilities, hits, slots, weights, 0, ROWS * BINS, logits, -1, value)
        now[pairs] = value
        means[root] = value / root_scale
        high = pairs
        while high > 0:
            level = levels[high - 1]
            low = high
            while low > 0 and levels[low - 1] == level:
                low -= 1
            for pair in range(low, high):
                center = means[n + pair]
                means[children[pair, 0]] = center
                means[children[pair, 1]] = center
            for _ in range(SWEEPS):
                for pair in range(low, high):
                    a, b = children[pair, 0], children[pair, 1]
                    center = means[n + pair]
                    delta = optimum(
                        pair, children, sizes, links, link_starts, link_weights, inner_weights[pair], means, center,
                        outer_weights, outer,
                    )  # fmt: skip
                    whole = float(sizes[a] + sizes[b])
                    means[a] = center + sizes[b] / whole * delta
                    means[b] = center - sizes[a] / whole * delta
            depth = min(level, MAX_LEVEL - 2)
            if encoding and dependent:
                plan_level(
                    probabilities, weights, bases, low, high, depth, mode, trellis,
                    children, sizes, links, link_starts, link_weights, inner_weights, parents, outer_weights, outer,
                    wanted, means, quantised, running[depth], agreed[depth], tried[depth], costs, trade,
                    slots, logits, values, bits, numbers, reals, kept,
                )  # fmt: skip
            for pair in range(low, high):
                a, b = children[pair, 0], children[pair, 1]
                center = means[n + pair]
                whole = float(sizes[a] + sizes[b])
                delta = optimum(
                    pair, children, sizes, links, link_starts, link_weights, inner_weights[pair], means, center,
                    outer_weights, outer,
                )  # fmt: skip
                gain = np.sqrt(sizes[a] * (sizes[b] / whole))
                # magnitudes around
                near, count, past = 0, 0, 0
                for e in range(link_starts[2 * pair], link_starts[2 * pair + 2]):
                    other = parents[links[e]]
                    if mode > 0:
                        past += abs(before[other])
                    if (other < pair and other >= low) or other >= high:
                        near += abs(now[other])
                        count += 1
                width = link_starts[2 * pair + 2] - link_starts[2 * pair]
                up = abs(now[parents[n + pair]])
                e1 = abs(before[pair]) if mode > 0 else 0
                e2 = abs(earlier[pair]) if mode > 1 else 0
                e3 = abs(third[pair]) if mode > 2 else 0
                long = long_memory(quantised, mode, pair)
                odd = trellis & 1
                row, other = describe(
                    slots,
                    bases[odd],
                    dependent,
                    mode,
                    depth,
                    near,
                    count,
                    past,
                    width,
                    up,
                    e1,
                    e2,
                    e3,
                    long,
                    running[depth],
                )
                row += odd * MIXER_ROWS * BINS
                other += odd * MIXER_ROWS * BINS
                plain = gain * delta
                guess = plain
                if second:
                    guess = trusted(plain, agreed[depth], tried[depth])
                value = now[pair]
                if encoding and not dependent:
                    rest = gain * (wanted[a] - wanted[b]) - guess
                    candidates_of(rest, 0, values)
                    value_costs(probabilities, slots, weights, row, other, logits, costs, values, bits)
                    best = np.inf
                    for c in range(CANDIDATES):
                        error = rest - values[c]
                        loss = error * error + trade * bits[c]
                        if loss < best:
                            best, value = loss, values[c]
                value = code_value(state, buffer, probabilities, hits, slots, weights, row, other, logits, -1, value)
                now[pair] = value
                running[depth] = moved(running[depth], value)
                level_here = 0.5 * level_of(value, odd)
                if dependent:
                    trellis = NEXT[trellis, value & 1]
                agreed[depth] += plain * (guess + level_here)
                tried[depth] += plain * plain
                delta = (guess + level_here) / gain
                means[a] = center + sizes[b] / whole * delta
                means[b] = center - sizes[a] / whole * delta
            high = low
        for v in range(n):
            decoded[mode, v] = means[v]
        if encoding and len(carry):
            for later in range(mode + 1, rank):
                share = carry[mode, later]
                for v in range(n):
                    targets[v, later] += share * (targets[v, mode] - means[v])
        if mode < GUIDES[3 if second else 0]:
            add_squares(children, links, link_starts, means, outer, link_squares, inner_squares, squares_outside)
        for k in range(4 if second else 1):
            if mode + 1 == GUIDES[k]:
                weigh_links(
                    children, levels, link_starts, link_counts, link_squares, link_weights,
                    inner_counts, inner_squares, inner_weights, counts_outside, squares_outside, outer_weights,
                )  # fmt: skip

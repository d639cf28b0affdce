"""Coefficient fields: one number per vertex and mode, coded down a cluster's pairing tree.

A node holds the mean of its vertices. Going down, each pair needs the difference of its children's means; it is
predicted from the nodes around, and what remains is coded at a step of 1 in the orthonormal (Haar) scaling.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

import numpy as np

from shapery_motion.compiled import inlined, inner, kernel
from shapery_motion.entropy._coder_kernels import (
    BINS,
    CONTEXTS,
    DECODE,
    MODE,
    bit_length,
    code_value,
    value_cost,
)

ROWS: Final = 8
"""Sets of mixing weights."""
SWEEPS: Final = 3
"""Passes of relaxation in which a level is predicted from the one above."""
GUIDES: Final = 3
"""Modes whose decoded fields stand for coordinates, by which the links of later modes are weighted."""
NEAREST: Final = 0.1
MAX_LEVEL: Final = 12
MAX_MODE: Final = 24
SCALES: Final = 16
FIELD_SIZES: Final = np.array(
    [
        (MAX_LEVEL) * (MAX_MODE),
        SCALES * SCALES,
        SCALES * SCALES,
        SCALES * SCALES,
        SCALES * 8,
        SCALES * SCALES * 3,
        64 * 4,
        SCALES * SCALES,
    ],
    dtype=np.int64,
)
"""How many contexts there are of each of the eight kinds."""


@inlined
def scale(quarters):
    """Return the class, 0 … 15, of a magnitude given in quarters: fine where small, in halves of an octave above."""
    if quarters < 6:
        return quarters
    length = bit_length(quarters)
    return min(2 * length + ((quarters >> (length - 2)) & 1), SCALES - 1)


@inlined
def optimum(pair, children, sizes, links, link_starts, link_weights, inner_weight, means, center):
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
    return pull / stiffness if stiffness > 0.0 else 0.0


@inlined
def distance(places, a, b):
    """Return how far two nodes lie apart."""
    total = 0.0
    for k in range(GUIDES):
        step = places[a, k] - places[b, k]
        total += step * step
    return np.sqrt(total)


@inner
def weigh_links(children, levels, links, link_starts, link_weights, inner_weights, places):
    """Replace the weights of links by what they are in space: the count of edges / distance ^ 3/2 in each level."""
    low, pairs = 0, len(children)
    while low < pairs:
        high = low
        total, count = 0.0, 0
        while high < pairs and levels[high] == levels[low]:
            for side in range(2):
                for e in range(link_starts[2 * high + side], link_starts[2 * high + side + 1]):
                    total += distance(places, children[high, side], links[e])
                    count += 1
            high += 1
        unit = total / count if count else 1.0
        if unit > 0.0:
            for pair in range(low, high):
                for side in range(2):
                    for e in range(link_starts[2 * pair + side], link_starts[2 * pair + side + 1]):
                        d = max(distance(places, children[pair, side], links[e]) / unit, NEAREST)
                        link_weights[e] = link_weights[e] / (d * np.sqrt(d))
                d = max(distance(places, children[pair, 0], children[pair, 1]) / unit, NEAREST)
                inner_weights[pair] = inner_weights[pair] / (d * np.sqrt(d))
        low = high


@kernel
def code_fields(
    state, buffer, probabilities, hits, weights, bases,
    children, levels, sizes, links, link_starts, link_weights, inner_weights, parents,
    targets, rank, quantised, decoded, costs, trade,
):  # fmt: skip
    """Code the fields of one cluster: `rank` modes over n vertices.

    Encoding, `targets` (n, rank) holds what is to be coded in units of the step, `costs` the bits of a probability and
    `trade` how much squared error a bit is worth. `decoded` (rank, n) receives the values that a decoder has, and
    `quantised` (rank, 1 + pairs) the whole numbers, by which later modes are predicted.
    """
    pairs = len(children)
    n = pairs + 1
    slots = np.zeros(CONTEXTS, dtype=np.int64)
    logits = np.zeros(CONTEXTS, dtype=np.int64)
    means = np.zeros(n + pairs)
    places = np.zeros((n + pairs, GUIDES))
    wanted = np.zeros(n + pairs)
    running = np.zeros(MAX_LEVEL, dtype=np.int64)
    encoding = state[MODE] != DECODE
    for mode in range(rank):
        now = quantised[mode]
        before = quantised[max(mode - 1, 0)]
        earlier = quantised[max(mode - 2, 0)]
        third = quantised[max(mode - 3, 0)]
        for k in range(MAX_LEVEL):
            running[k] = 64
        if encoding:
            for v in range(n):
                wanted[v] = targets[v, mode]
            for pair in range(pairs):
                a, b = children[pair, 0], children[pair, 1]
                wanted[n + pair] = (sizes[a] * wanted[a] + sizes[b] * wanted[b]) / (sizes[a] + sizes[b])
        # the root
        root = n + pairs - 1 if pairs else 0
        for k in range(CONTEXTS):
            slots[k] = (bases[k] + (min(mode, 15) if k % 2 else 0)) * BINS
        slots[0] = (bases[0] + (MAX_LEVEL - 1) * MAX_MODE + min(mode, MAX_MODE - 1)) * BINS
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
                        pair, children, sizes, links, link_starts, link_weights, inner_weights[pair], means, center
                    )
                    whole = float(sizes[a] + sizes[b])
                    means[a] = center + sizes[b] / whole * delta
                    means[b] = center - sizes[a] / whole * delta
            depth = min(level, MAX_LEVEL - 2)
            for pair in range(low, high):
                a, b = children[pair, 0], children[pair, 1]
                center = means[n + pair]
                whole = float(sizes[a] + sizes[b])
                delta = optimum(
                    pair, children, sizes, links, link_starts, link_weights, inner_weights[pair], means, center
                )
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
                beside = scale(4 * near // count) if count else SCALES - 1
                prior = scale(4 * past // width) if width else 0
                mean = scale(running[depth] >> 4)
                slots[0] = (bases[0] + depth * MAX_MODE + min(mode, MAX_MODE - 1)) * BINS
                slots[1] = (bases[1] + beside * SCALES + min(depth, SCALES - 1)) * BINS
                slots[2] = (bases[2] + scale(4 * e1) * SCALES + scale(2 * (e2 + e3))) * BINS
                slots[3] = (bases[3] + scale(4 * up) * SCALES + beside) * BINS
                blend = scale((8 * near // count if count else 4 * up) // 4 + up + e1 + e2 // 2)
                slots[4] = (bases[4] + blend * 8 + min(depth, 7)) * BINS
                slots[5] = (bases[5] + (mean * SCALES + beside) * 3 + min(e1, 2)) * BINS
                slots[6] = (bases[6] + min(mode, 63) * 4 + min(depth, 3)) * BINS
                slots[7] = (bases[7] + prior * SCALES + mean) * BINS
                row = (1 + min(depth, ROWS - 2)) * BINS
                other = (ROWS + blend) * BINS
                guess = gain * delta
                value = 0
                if encoding:
                    rest = gain * (wanted[a] - wanted[b]) - guess
                    value = int(np.rint(rest))
                    if value != 0 and trade > 0.0:
                        sign = 1 if value > 0 else -1
                        most = abs(value)
                        best = np.inf
                        chosen = value
                        for candidate in (most, most - 1, 0):
                            if candidate == 0 and most > 2:
                                continue
                            error = abs(rest) - candidate
                            loss = error * error + trade * value_cost(
                                probabilities, slots, weights, row, other, logits, costs, candidate
                            )
                            if loss < best:
                                best, chosen = loss, sign * candidate
                        value = chosen
                value = code_value(state, buffer, probabilities, hits, slots, weights, row, other, logits, -1, value)
                now[pair] = value
                running[depth] += ((abs(value) << 8) - running[depth] * 4 + 32) >> 6
                delta = (guess + value) / gain
                means[a] = center + sizes[b] / whole * delta
                means[b] = center - sizes[a] / whole * delta
            high = low
        for v in range(n):
            decoded[mode, v] = means[v]
        if mode < GUIDES:
            for node in range(n + pairs):
                places[node, mode] = means[node]
        if mode == GUIDES - 1:
            weigh_links(children, levels, links, link_starts, link_weights, inner_weights, places)

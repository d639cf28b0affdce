"""A level of a pairing tree: what its numbers' contexts are, and how an encoder chooses them together."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

import numpy as np

from shapery_motion.compiled import inlined, inner
from shapery_motion.entropy._coder_kernels import BINS, bit_length
from shapery_motion.trajectory._trellis_kernels import (
    BEHIND,
    CANDIDATES,
    DELAY,
    NEXT,
    STATES,
    candidates_of,
    costs_on_path,
    level_of,
)

ROWS: Final = 8
"""Sets of mixing weights by level."""
MOST_TRUST: Final = 1.3
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
MIXER_ROWS: Final = ROWS + SCALES
"""Sets of mixing weights of one quantiser."""
MEMORY: Final = 8
"""How many modes back a longer memory reaches."""


@inlined
def scale(quarters):
    """Return the class, 0 … 15, of a magnitude given in quarters: fine where small, in halves of an octave above."""
    if quarters < 6:
        return quarters
    length = bit_length(quarters)
    return min(2 * length + ((quarters >> (length - 2)) & 1), SCALES - 1)


@inlined
def long_memory(quantised, mode, pair):
    """Return the mean magnitude of a pair over up to eight modes before, in eighths."""
    many = min(mode, MEMORY)
    total = 0
    for k in range(mode - many, mode):
        total += abs(quantised[k, pair])
    return 8 * total // many if many > 0 else 0


@inlined
def describe(slots, bases, dependent, mode, depth, near, count, past, width, up, e1, e2, e3, long, average):
    """Set the contexts of a pair; return its first and its second mixer row."""
    beside = scale(4 * near // count) if count else SCALES - 1
    prior = scale(4 * past // width) if width else 0
    mean = scale(average >> 4)
    blend = scale((8 * near // count if count else 4 * up) // 4 + up + e1 + e2 // 2 + (long // 8 if dependent else 0))
    slots[0] = (bases[0] + depth * MAX_MODE + min(mode, MAX_MODE - 1)) * BINS
    slots[1] = (bases[1] + beside * SCALES + depth) * BINS
    slots[2] = (bases[2] + scale(4 * e1) * SCALES + scale(2 * (e2 + e3))) * BINS
    slots[3] = (bases[3] + scale(4 * up) * SCALES + beside) * BINS
    slots[4] = (bases[4] + blend * 8 + min(depth, 7)) * BINS
    slots[5] = (bases[5] + (mean * SCALES + beside) * 3 + min(e1, 2)) * BINS
    if dependent:
        slots[6] = (bases[6] + scale(long) * SCALES + beside) * BINS
    else:
        slots[6] = (bases[6] + min(mode, 63) * 4 + min(depth, 3)) * BINS
    slots[7] = (bases[7] + prior * SCALES + mean) * BINS
    return (1 + min(depth, ROWS - 2)) * BINS, (ROWS + blend) * BINS


@inlined
def moved(average, value):
    """Return a running mean of magnitudes after one more."""
    return average + (((abs(value) << 8) - average * 4 + 32) >> 6)


@inlined
def trusted(plain, agreed, tried):
    """Return a prediction as far as such predictions proved right."""
    return plain * min(max(agreed / tried, 0.0), MOST_TRUST)


@inner
def plan_level(
    probabilities, weights, bases, low, high, depth, mode, trellis,
    children, sizes, links, link_starts, link_weights, inner_weights, parents, outer_weights, outer,
    wanted, means, quantised, average, agreed, tried, costs, trade,
    slots, logits, values, bits, numbers, reals, kept,
):  # fmt: skip
    """Choose the whole numbers of a level's pairs for dependent quantisation: fill `quantised[mode, low:high]`.

    Viterbi's algorithm over the trellis; each of its paths has the predictions and contexts that follow from itself.
    What the probabilities would learn on the way is left out. `means` are left as they were;
    `numbers`, `reals` and `kept` are scratch.
    """
    # the numbers along each path, and the differences of the children's means
    paths, paths_then, steps, steps_then = numbers[0], numbers[1], reals[0], reals[1]
    averages, averages_then = numbers[2, 0], numbers[2, 1]
    origins, chosen = numbers[3, 0], numbers[3, 1]
    losses, losses_then, plains, steps_chosen = reals[2, 0], reals[2, 1], reals[2, 2], reals[2, 3]
    trusts, trusts_then = reals[3], reals[4]
    losses[:STATES] = np.inf
    averages[trellis] = average
    losses[trellis] = 0.0
    trusts[trellis, 0], trusts[trellis, 1] = agreed, tried
    now = quantised[mode]
    before = quantised[max(mode - 1, 0)]
    for pair in range(low, high):
        kept[pair, 0], kept[pair, 1] = means[children[pair, 0]], means[children[pair, 1]]
    nodes = len(children) + 1
    for pair in range(low, high):
        a, b = children[pair, 0], children[pair, 1]
        center = means[nodes + pair]
        whole = float(sizes[a] + sizes[b])
        share_a, share_b = sizes[b] / whole, sizes[a] / whole
        gain = np.sqrt(sizes[a] * share_a)
        begin, middle, end = link_starts[2 * pair], link_starts[2 * pair + 1], link_starts[2 * pair + 2]
        # what is the same along all paths
        plain_pull, stiffness, plain_near, count, past = 0.0, inner_weights[pair], 0, 0, 0
        for e in range(begin, end):
            node = links[e]
            there = parents[node]
            share = share_a if e < middle else -share_b
            w = share * link_weights[e]
            stiffness += share * w
            if mode > 0:
                past += abs(before[there])
            recent = low <= there < pair and pair - there <= DELAY
            if recent:
                plain_pull += w * (means[nodes + there] - center)
                count += 1
            else:
                plain_pull += w * (means[node] - center)
                if (low <= there < pair) or there >= high:
                    plain_near += abs(now[there])
                    count += 1
        if len(outer):
            if outer_weights[a] > 0.0:
                w = share_a * outer_weights[a]
                plain_pull += w * (outer[a] - center)
                stiffness += share_a * w
            if outer_weights[b] > 0.0:
                w = share_b * outer_weights[b]
                plain_pull -= w * (outer[b] - center)
                stiffness += share_b * w
        up = abs(now[parents[nodes + pair]])
        e1 = abs(before[pair]) if mode > 0 else 0
        e2 = abs(quantised[mode - 2, pair]) if mode > 1 else 0
        e3 = abs(quantised[mode - 3, pair]) if mode > 2 else 0
        long = long_memory(quantised, mode, pair)
        losses_then[:STATES] = np.inf
        for state in range(STATES):
            if losses[state] == np.inf:
                continue
            pull, near = plain_pull, plain_near
            for e in range(begin, end):
                node = links[e]
                there = parents[node]
                if low <= there < pair and pair - there <= DELAY:
                    near += abs(paths[state, there % DELAY])
                    first, second = children[there, 0], children[there, 1]
                    size = float(sizes[first] + sizes[second])
                    part = sizes[second] / size if node == first else -sizes[first] / size
                    share = share_a if e < middle else -share_b
                    pull += share * link_weights[e] * part * steps[state, there % DELAY]
            plain = gain * (pull / stiffness) if stiffness > 0.0 else 0.0
            guess = trusted(plain, trusts[state, 0], trusts[state, 1])
            plains[state] = plain
            odd = state & 1
            row, other = describe(
                slots,
                bases[odd],
                True,
                mode,
                depth,
                near,
                count,
                past,
                end - begin,
                up,
                e1,
                e2,
                e3,
                long,
                averages[state],
            )
            shift = odd * MIXER_ROWS * BINS
            rest = gain * (wanted[a] - wanted[b]) - guess
            candidates_of(rest, odd, values)
            costs_on_path(
                probabilities, slots, weights, row + shift, other + shift, logits, costs, values, bits,
                losses, state, numbers[5], reals[5],
            )  # fmt: skip
            for c in range(CANDIDATES):
                error = rest - 0.5 * level_of(values[c], odd)
                loss = losses[state] + error * error + trade * bits[c]
                to = NEXT[state, values[c] & 1]
                if loss < losses_then[to]:
                    losses_then[to], origins[to], chosen[to] = loss, state, values[c]
                    steps_chosen[to] = guess + 0.5 * level_of(values[c], odd)
        least = int(np.argmin(losses_then[:STATES]))
        best, most = origins[least], losses_then[least] + BEHIND
        settled = pair % DELAY
        done = pair - DELAY
        if done >= low:
            now[done] = paths[best, settled]
            first, second = children[done, 0], children[done, 1]
            size = float(sizes[first] + sizes[second])
            means[first] = means[nodes + done] + sizes[second] / size * steps[best, settled]
            means[second] = means[nodes + done] - sizes[first] / size * steps[best, settled]
        for state in range(STATES):
            losses[state] = losses_then[state]
            if losses[state] > most:
                losses[state] = np.inf
                continue
            origin = origins[state]
            if done >= low and steps[origin, settled] != steps[best, settled]:
                losses[state] = np.inf
                continue
            for k in range(DELAY):
                paths_then[state, k] = paths[origin, k]
                steps_then[state, k] = steps[origin, k]
            paths_then[state, settled] = chosen[state]
            steps_then[state, settled] = steps_chosen[state] / gain
            averages_then[state] = moved(averages[origin], chosen[state])
            trusts_then[state, 0] = trusts[origin, 0] + plains[origin] * steps_chosen[state]
            trusts_then[state, 1] = trusts[origin, 1] + plains[origin] * plains[origin]
        paths, paths_then = paths_then, paths
        steps, steps_then = steps_then, steps
        averages, averages_then = averages_then, averages
        trusts, trusts_then = trusts_then, trusts
    best = int(np.argmin(losses[:STATES]))
    for pair in range(max(high - DELAY, low), high):
        now[pair] = paths[best, pair % DELAY]
    for pair in range(low, high):
        means[children[pair, 0]], means[children[pair, 1]] = kept[pair, 0], kept[pair, 1]

"""Bases: for each mode of a cluster three functions of time, coded as cosine coefficients of runs of frames."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

import numpy as np

from shapery_motion.compiled import inlined, inner, kernel
from shapery_motion.entropy._coder_kernels import BINS, CONTEXTS, DECODE, MODE, bit_length, code_value, value_costs
from shapery_motion.trajectory._level_kernels import MEMORY, SCALES, moved, scale
from shapery_motion.trajectory._trellis_kernels import (
    BEHIND,
    CANDIDATES,
    DELAY,
    NEXT,
    NUMBERS,
    REALS,
    STATES,
    candidates_of,
    costs_on_path,
    level_of,
)

BANDS: Final = 20
ROWS: Final = 8
"""Sets of mixing weights by frequency."""
BASIS_SIZES: Final = np.array(
    [
        BANDS * 24,
        SCALES * SCALES,
        SCALES * SCALES,
        SCALES * SCALES,
        SCALES * BANDS,
        SCALES * SCALES * 3,
        64 * 6,
        SCALES * SCALES,
    ],
    dtype=np.int64,
)
"""How many contexts there are of each of the eight kinds."""
MIXER_ROWS: Final = ROWS + SCALES
"""Sets of mixing weights of one quantiser."""

SIGN_SLOTS: Final = 72
"""Probabilities of signs, behind those of the contexts."""


@inlined
def band(frequency):
    """Return the class of a frequency: alone up to 3, in halves of an octave above."""
    if frequency < 4:
        return frequency
    length = bit_length(frequency)
    return min(2 * length + ((frequency >> (length - 2)) & 1) - 2, BANDS - 1)


@inlined
def sign(value):
    """Return 0 for 0, 1 for a positive and 2 for a negative number."""
    if value == 0:
        return 0
    return 1 if value > 0 else 2


@inlined
def earlier_modes(quantised, mode, at, axis, first, last):
    """Return what the modes before tell: e1, e2, all1, all2, ahead and long of the specification."""
    e1, e2, all1, all2, ahead = 0, 0, 0, 0, 0
    if mode > 0:
        before = quantised[mode - 1]
        e1 = abs(before[at, axis])
        all1 = abs(before[at, 0]) + abs(before[at, 1]) + abs(before[at, 2])
        if not last:
            ahead = abs(before[at + 1, 0]) + abs(before[at + 1, 1]) + abs(before[at + 1, 2])
    if mode > 1:
        before = quantised[mode - 2]
        e2 = abs(before[at, axis])
        all2 = abs(before[at, 0]) + abs(before[at, 1]) + abs(before[at, 2])
    # what lies around, in the mean of up to eight modes
    long = 0
    many = min(mode, MEMORY)
    for k in range(mode - many, mode):
        before = quantised[k]
        long += 2 * (abs(before[at, 0]) + abs(before[at, 1]) + abs(before[at, 2]))
        if not first:
            long += abs(before[at - 1, 0]) + abs(before[at - 1, 1]) + abs(before[at - 1, 2])
        if not last:
            long += abs(before[at + 1, 0]) + abs(before[at + 1, 1]) + abs(before[at + 1, 2])
    if many > 0:
        long = long // (3 * many)
    return e1, e2, all1, all2, ahead, long


@inlined
def describe(
    slots, bases, dependent, mode, frequency, axis, low1, low2, beside, around,
    e1, e2, all1, all2, ahead, long, average,
):  # fmt: skip
    """Set the contexts of a coefficient; return its first and its second mixer row."""
    place = band(frequency)
    if frequency > 0:
        cross = scale(4 * (beside + around) // 3)
        near = scale(4 * (2 * low1 + low2) // 3)
    else:
        cross = scale(4 * beside // axis) if axis else SCALES - 1
        near = SCALES - 1
    mean = scale(average >> 4)
    blend = 2 * low1 + low2 + 2 * beside + around + e1 + all1 + all2 // 2 + ahead // 2
    if dependent:
        blend += long // 2
    blend = scale(blend // 2)
    slots[0] = (bases[0] + place * 24 + min(mode, 23)) * BINS
    slots[1] = (bases[1] + near * SCALES + cross) * BINS
    slots[2] = (bases[2] + scale(4 * e1) * SCALES + scale(4 * e2)) * BINS
    slots[3] = (bases[3] + scale(4 * all1 // 3) * SCALES + cross) * BINS
    slots[4] = (bases[4] + blend * BANDS + place) * BINS
    slots[5] = (bases[5] + (mean * SCALES + cross) * 3 + axis) * BINS
    if dependent:
        slots[6] = (bases[6] + scale(long) * SCALES + cross) * BINS
    else:
        slots[6] = (bases[6] + min(mode, 63) * 6 + min(place // 3, 5)) * BINS
    slots[7] = (bases[7] + scale(4 * (all1 + all2 + ahead) // 9) * SCALES + mean) * BINS
    return min(place // 2, ROWS - 1) * BINS, (ROWS + blend) * BINS


@inner
def plan_bases(
    probabilities, weights, bases, cuts, mode, targets, quantised, running, costs, trade,
    slots, logits, values, bits, numbers, reals,
):  # fmt: skip
    """Choose the whole numbers of a mode for dependent quantisation: fill `quantised[mode]`.

    Viterbi's algorithm over the trellis; each of its paths has the contexts that follow from itself. What the
    probabilities would learn on the way is left out. `numbers` and `reals` are scratch.
    """
    paths, paths_then, means, means_then = numbers[0], numbers[1], numbers[2], numbers[3]
    origins, chosen = numbers[4, 0], numbers[4, 1]
    losses, losses_then = reals[0, 0], reals[0, 1]
    losses[:STATES] = np.inf
    losses[0] = 0.0
    for k in range(BANDS):
        means[0, k] = running[k]
    now = quantised[mode]
    count = 0
    for run in range(len(cuts) - 1):
        first, length = cuts[run], cuts[run + 1] - cuts[run]
        for frequency in range(length):
            at = first + frequency
            place = band(frequency)
            for axis in range(3):
                e1, e2, all1, all2, ahead, long = earlier_modes(
                    quantised, mode, at, axis, frequency == 0, frequency + 1 == length
                )
                wanted = targets[mode, at, axis]
                losses_then[:STATES] = np.inf
                for state in range(STATES):
                    if losses[state] == np.inf:
                        continue
                    path = paths[state]
                    low1, low2, beside, around = 0, 0, 0, 0
                    for k in range(1, axis + 1):
                        beside += abs(path[(count - k) % DELAY])
                    if frequency > 0:
                        low1 = abs(path[(count - 3) % DELAY])
                        for k in range(axis + 1, 4):
                            around += abs(path[(count - k) % DELAY])
                    if frequency > 1:
                        low2 = abs(path[(count - 6) % DELAY])
                    row, other = describe(
                        slots, bases[state & 1], True, mode, frequency, axis, low1, low2, beside, around,
                        e1, e2, all1, all2, ahead, long, means[state, place],
                    )  # fmt: skip
                    shift = (state & 1) * MIXER_ROWS * BINS
                    candidates_of(wanted, state & 1, values)
                    costs_on_path(
                        probabilities, slots, weights, row + shift, other + shift, logits, costs, values, bits,
                        losses, state, numbers[5], reals[5],
                    )  # fmt: skip
                    for c in range(CANDIDATES):
                        error = wanted - 0.5 * level_of(values[c], state & 1)
                        loss = losses[state] + error * error + trade * bits[c]
                        to = NEXT[state, values[c] & 1]
                        if loss < losses_then[to]:
                            losses_then[to], origins[to], chosen[to] = loss, state, values[c]
                best = int(np.argmin(losses_then[:STATES]))
                most = losses_then[best] + BEHIND
                settled = count % DELAY
                if count >= DELAY:
                    now[(count - DELAY) // 3, (count - DELAY) % 3] = paths[origins[best], settled]
                for state in range(STATES):
                    losses[state] = losses_then[state]
                    if losses[state] > most:
                        losses[state] = np.inf
                        continue
                    origin = origins[state]
                    if count >= DELAY and paths[origin, settled] != paths[origins[best], settled]:
                        losses[state] = np.inf
                        continue
                    for k in range(DELAY):
                        paths_then[state, k] = paths[origin, k]
                    paths_then[state, settled] = chosen[state]
                    for k in range(BANDS):
                        means_then[state, k] = means[origin, k]
                    means_then[state, place] = moved(means[origin, place], chosen[state])
                paths, paths_then = paths_then, paths
                means, means_then = means_then, means
                count += 1
    best = int(np.argmin(losses[:STATES]))
    for k in range(max(count - DELAY, 0), count):
        now[k // 3, k % 3] = paths[best, k % DELAY]


@kernel
def code_bases(
    state, buffer, probabilities, hits, weights, bases, cuts, rank, targets, quantised, levels, costs, trade,
):  # fmt: skip
    """Code the bases of one cluster.

    Parameters
    ----------
    bases : (1 or 2, 8)
        Where the contexts of each kind begin; two rows tell that quantisation is dependent.
    cuts
        Where the runs of frames begin, and the number of frames last.
    targets : (rank, F, 3)
        Cosine coefficients in units of the step, run after run, when encoding.
    quantised : (rank, F, 3)
        The whole numbers, given or received.
    levels : (rank, F, 3)
        Receives the coefficients in half steps.
    """
    slots = np.zeros(CONTEXTS, dtype=np.int64)
    logits = np.zeros(CONTEXTS, dtype=np.int64)
    values, bits = np.zeros(CANDIDATES, dtype=np.int64), np.zeros(CANDIDATES)
    numbers, reals = np.zeros((NUMBERS, STATES, DELAY), dtype=np.int64), np.zeros((REALS, STATES, DELAY))
    encoding = state[MODE] != DECODE
    dependent = len(bases) > 1
    running = np.zeros(BANDS, dtype=np.int64)
    signs = (bases[-1, CONTEXTS - 1] + BASIS_SIZES[CONTEXTS - 1]) * BINS
    for mode in range(rank):
        now = quantised[mode]
        for k in range(BANDS):
            running[k] = (running[k] + 64) // 2 if mode else 64
        if encoding and dependent:
            plan_bases(
                probabilities, weights, bases, cuts, mode, targets, quantised, running, costs, trade,
                slots, logits, values, bits, numbers, reals,
            )  # fmt: skip
        trellis = 0
        for run in range(len(cuts) - 1):
            first, length = cuts[run], cuts[run + 1] - cuts[run]
            for frequency in range(length):
                at = first + frequency
                place = band(frequency)
                for axis in range(3):
                    low1 = abs(now[at - 1, axis]) if frequency > 0 else 0
                    low2 = abs(now[at - 2, axis]) if frequency > 1 else 0
                    beside = 0
                    for other in range(axis):
                        beside += abs(now[at, other])
                    around = 0
                    for other in range(axis, 3):
                        if frequency > 0:
                            around += abs(now[at - 1, other])
                    e1, e2, all1, all2, ahead, long = earlier_modes(
                        quantised, mode, at, axis, frequency == 0, frequency + 1 == length
                    )
                    odd = trellis & 1
                    row, other = describe(
                        slots, bases[odd], dependent, mode, frequency, axis, low1, low2, beside, around,
                        e1, e2, all1, all2, ahead, long, running[place],
                    )  # fmt: skip
                    row += odd * MIXER_ROWS * BINS
                    other += odd * MIXER_ROWS * BINS
                    sign1 = sign(now[at - 1, axis]) if frequency > 0 else 0
                    sign2 = sign(now[at - 2, axis]) if frequency > 1 else 0
                    sign_slot = signs + (min(frequency, 7) * 3 + sign1) * 3 + sign2
                    value = now[at, axis]
                    if encoding and not dependent:
                        candidates_of(targets[mode, at, axis], 0, values)
                        value_costs(probabilities, slots, weights, row, other, logits, costs, values, bits)
                        best = np.inf
                        for c in range(CANDIDATES):
                            error = targets[mode, at, axis] - values[c]
                            loss = error * error + trade * bits[c]
                            if loss < best:
                                best, value = loss, values[c]
                    value = code_value(
                        state, buffer, probabilities, hits, slots, weights, row, other, logits, sign_slot, value
                    )
                    now[at, axis] = value
                    levels[mode, at, axis] = level_of(value, odd)
                    if dependent:
                        trellis = NEXT[trellis, value & 1]
                    running[place] = moved(running[place], value)

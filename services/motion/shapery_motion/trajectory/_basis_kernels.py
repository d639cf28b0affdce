"""Bases: for each mode of a cluster three functions of time, coded as cosine coefficients of runs of frames."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

import numpy as np

from shapery_motion.compiled import inlined, kernel
from shapery_motion.entropy._coder_kernels import BINS, CONTEXTS, DECODE, MODE, bit_length, code_value, value_cost
from shapery_motion.trajectory._field_kernels import SCALES, scale

BANDS: Final = 20
ROWS: Final = 8
"""Sets of mixing weights."""
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


@kernel
def code_bases(
    state, buffer, probabilities, hits, weights, bases, cuts, rank, targets, quantised, costs, trade,
):  # fmt: skip
    """Code the bases of one cluster.

    Parameters
    ----------
    cuts
        Where the runs of frames begin, and the number of frames last.
    targets : (rank, F, 3)
        Cosine coefficients in units of the step, run after run, when encoding.
    quantised : (rank, F, 3)
        The whole numbers, given or received.
    """
    slots = np.zeros(CONTEXTS, dtype=np.int64)
    logits = np.zeros(CONTEXTS, dtype=np.int64)
    encoding = state[MODE] != DECODE
    running = np.zeros(BANDS, dtype=np.int64)
    signs = (bases[CONTEXTS - 1] + BASIS_SIZES[CONTEXTS - 1]) * BINS
    for mode in range(rank):
        now = quantised[mode]
        before = quantised[max(mode - 1, 0)]
        earlier = quantised[max(mode - 2, 0)]
        for k in range(BANDS):
            running[k] = (running[k] + 64) // 2 if mode else 64
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
                    if frequency > 0:
                        cross = scale(4 * (beside + around) // 3)
                    else:
                        cross = scale(4 * beside // axis) if axis else SCALES - 1
                    e1 = abs(before[at, axis]) if mode > 0 else 0
                    e2 = abs(earlier[at, axis]) if mode > 1 else 0
                    all1, all2 = 0, 0
                    for other in range(3):
                        if mode > 0:
                            all1 += abs(before[at, other])
                        if mode > 1:
                            all2 += abs(earlier[at, other])
                    ahead = 0
                    if mode > 0 and frequency + 1 < length:
                        for other in range(3):
                            ahead += abs(before[at + 1, other])
                    mean = scale(running[place] >> 4)
                    near = scale(4 * (2 * low1 + low2) // 3) if frequency > 0 else SCALES - 1
                    slots[0] = (bases[0] + place * 24 + min(mode, 23)) * BINS
                    slots[1] = (bases[1] + near * SCALES + cross) * BINS
                    slots[2] = (bases[2] + scale(4 * e1) * SCALES + scale(4 * e2)) * BINS
                    slots[3] = (bases[3] + scale(4 * all1 // 3) * SCALES + cross) * BINS
                    blend = (2 * low1 + low2 + 2 * beside + around + e1 + all1 + all2 // 2 + ahead // 2) // 2
                    slots[4] = (bases[4] + scale(blend) * BANDS + place) * BINS
                    slots[5] = (bases[5] + (mean * SCALES + cross) * 3 + axis) * BINS
                    slots[6] = (bases[6] + min(mode, 63) * 6 + min(place // 3, 5)) * BINS
                    slots[7] = (bases[7] + scale(4 * (all1 + all2 + ahead) // 9) * SCALES + mean) * BINS
                    row = min(place // 2, ROWS - 1) * BINS
                    other = (ROWS + scale(blend)) * BINS
                    sign1 = sign(now[at - 1, axis]) if frequency > 0 else 0
                    sign2 = sign(now[at - 2, axis]) if frequency > 1 else 0
                    sign_slot = signs + (min(frequency, 7) * 3 + sign1) * 3 + sign2
                    value = 0
                    if encoding:
                        wanted = targets[mode, at, axis]
                        value = int(np.rint(wanted))
                        if value != 0 and trade > 0.0:
                            direction = 1 if value > 0 else -1
                            most = abs(value)
                            best = np.inf
                            for candidate in (most, most - 1, 0):
                                if candidate == 0 and most > 2:
                                    continue
                                error = abs(wanted) - candidate
                                loss = error * error + trade * value_cost(
                                    probabilities, slots, weights, row, other, logits, costs, candidate
                                )
                                if loss < best:
                                    best, value = loss, direction * candidate
                    value = code_value(
                        state, buffer, probabilities, hits, slots, weights, row, other, logits, sign_slot, value
                    )
                    now[at, axis] = value
                    running[place] += ((abs(value) << 8) - running[place] * 4 + 32) >> 6

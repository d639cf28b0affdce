"""A carryless binary range coder over probabilities that several contexts predict and a mixer joins.

All arithmetic is in integers, so that every implementation makes the same bits; `api_schema/smc.md` states it.
Probabilities are of a one, in 1/65536. The same functions encode and decode, by the coder's mode: the two sides
cannot drift apart.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from shapery_motion.compiled import inlined, inner

DECODE: Final = 0
ENCODE: Final = 1

# The coder's state, an int64 array of six.
LOW: Final = 0
HIGH: Final = 1
CODE: Final = 2
"""The four bytes of the stream that decoding looks at."""
POSITION: Final = 3
"""Bytes written or read."""
MODE: Final = 4
PACE: Final = 5
"""How fast the mixer learns."""

CONTEXTS: Final = 8
"""How many contexts predict each decision of a value."""
BINS: Final = 32
"""Decisions that a context tells apart: 0 … 23 for the bit length, from 24 on for the bit below the highest."""
LENGTH_BINS: Final = 24
RATE_LIMIT: Final = 250
"""A probability's adaptation slows down until it has seen this many bits."""
BIAS: Final = 256

SQUASH_KNOTS: Final = (
    22, 36, 60, 98, 162, 267, 439, 720, 1179, 1921, 3108, 4971, 7812, 11955, 17625, 24743, 32768, 40793, 47911, 53581,
    57724, 60565, 62428, 63615, 64357, 64816, 65097, 65269, 65374, 65438, 65476, 65500, 65514,
)  # fmt: skip
"""65536 / (1 + exp(-x / 256)) at x = -2048, -1920, …, 2048."""


def _squash_table() -> NDArray[np.int64]:
    """Return the probabilities of the logits -2048 … 2047, linear between the knots."""
    knots = np.array(SQUASH_KNOTS, dtype=np.int64)
    x = np.arange(4096)
    low, part = x >> 7, x & 127
    return np.asarray((knots[low] * (128 - part) + knots[low + 1] * part + 64) >> 7)


def _stretch_table() -> NDArray[np.int64]:
    """Return the logit of each probability (in 1/4096, at the middle of its step): the inverse of `_squash_table`."""
    return np.searchsorted(_squash_table(), np.arange(4096) * 16 + 8) - 2048


# Tables and probabilities are kept small, so that they stay in the processor's cache; kernels widen them at once.
SQUASH: Final = _squash_table().astype(np.int32)
STRETCH: Final = np.minimum(_stretch_table(), 2047).astype(np.int16)
RATES: Final = np.array([65536 * 2 // (2 * n + 3) for n in range(RATE_LIMIT + 1)], dtype=np.int32)
"""Share, in 1/65536, by which a probability that has seen n bits moves towards the next."""


@inlined
def code_bit(state, buffer, p, bit):
    """Code one bit whose probability of being 1 is p / 65536; return it."""
    low, high = state[LOW], state[HIGH]
    spread = high - low
    middle = low + (spread >> 16) * p + (((spread & 0xFFFF) * p) >> 16)
    if state[MODE] == DECODE:
        bit = 1 if state[CODE] <= middle else 0
    if bit:
        high = middle
    else:
        low = middle + 1
    while ((low ^ high) & 0xFF000000) == 0:
        position = state[POSITION]
        if state[MODE] == DECODE:
            following = buffer[position] if position < len(buffer) else 0
            state[CODE] = ((state[CODE] << 8) & 0xFFFFFFFF) | following
        elif position < len(buffer):
            buffer[position] = high >> 24
        state[POSITION] = position + 1
        low = (low << 8) & 0xFFFFFFFF
        high = ((high << 8) & 0xFFFFFFFF) | 255
    state[LOW] = low
    state[HIGH] = high
    return bit


@inner
def start(state, buffer, mode):
    """Begin a stream."""
    state[LOW] = 0
    state[HIGH] = 0xFFFFFFFF
    state[CODE] = 0
    state[POSITION] = 0
    state[MODE] = mode
    if mode == DECODE:
        for k in range(4):
            state[CODE] = (state[CODE] << 8) | (buffer[k] if k < len(buffer) else 0)
        state[POSITION] = 4


@inner
def finish(state, buffer):
    """End an encoded stream; return its length, which is more than the buffer holds where that was too small."""
    position = state[POSITION]
    # any value in [low, high] will do: bytes that are missing are read as 0
    value = state[HIGH]
    for k in range(4):
        kept = value & (0xFFFFFFFF << (24 - 8 * k)) & 0xFFFFFFFF
        if position < len(buffer):
            buffer[position] = (value >> (24 - 8 * k)) & 255
        position += 1
        if kept >= state[LOW]:
            break
    return position


@inlined
def code_adaptive(state, buffer, probabilities, hits, slot, bit):
    """Code a bit by the adaptive probability in a slot alone."""
    p = np.int64(probabilities[slot])
    bit = code_bit(state, buffer, min(max(p, 32), 65504), bit)
    adapt(probabilities, hits, slot, bit)
    return bit


@inlined
def adapt(probabilities, hits, slot, bit):
    """Move the probability in a slot towards a bit."""
    n = np.int64(hits[slot])
    p = np.int64(probabilities[slot])
    probabilities[slot] = p + ((((65535 if bit else 0) - p) * RATES[n]) >> 16)
    if n < RATE_LIMIT:
        hits[slot] = n + 1


@inner
def mixed(probabilities, slots, offset, weights, row, other, logits):
    """Return the probability that the contexts predict together; their logits are left in `logits`."""
    total = (weights[row, CONTEXTS] + weights[other, CONTEXTS]) * BIAS
    for k in range(CONTEXTS):
        logit = np.int64(STRETCH[np.int64(probabilities[slots[k] + offset]) >> 4])
        logits[k] = logit
        total += (weights[row, k] + weights[other, k]) * logit
    x = min(max(total >> 16, -2048), 2047)
    return min(max(np.int64(SQUASH[x + 2048]), 32), 65504)


@inner
def code_mixed(state, buffer, probabilities, hits, slots, offset, weights, row, other, logits, bit):
    """Code a bit by the contexts' joint prediction, and let them learn."""
    p = mixed(probabilities, slots, offset, weights, row, other, logits)
    bit = code_bit(state, buffer, p, bit)
    error = ((65536 if bit else 0) - p) * state[PACE]
    for k in range(CONTEXTS):
        change = (logits[k] * error + 0x80000) >> 20
        weights[row, k] += change
        weights[other, k] += change
        adapt(probabilities, hits, slots[k] + offset, bit)
    change = (BIAS * error + 0x80000) >> 20
    weights[row, CONTEXTS] += change
    weights[other, CONTEXTS] += change
    return bit


@inlined
def bit_length(value):
    """Return the number of binary digits of a value that is not negative."""
    length = 0
    while value > 0:
        value >>= 1
        length += 1
    return length


@inner
def code_value(state, buffer, probabilities, hits, slots, weights, row, other, logits, sign_slot, value):
    """Code a whole number by the contexts in `slots`; return it.

    Its magnitude's bit length comes in unary, then the digits below the highest: the first by the contexts, the
    others and the sign as they are. `row` is the first of the mixer's `BINS` weight vectors.
    """
    magnitude = abs(value)
    length = bit_length(magnitude)
    found = 0
    while found < LENGTH_BINS:
        more = code_mixed(
            state,
            buffer,
            probabilities,
            hits,
            slots,
            found,
            weights,
            row + found,
            other + found,
            logits,
            1 if length > found else 0,
        )
        if not more:
            break
        found += 1
    if found == 0:
        return 0
    result = 1
    for k in range(found - 2, -1, -1):
        bit = (magnitude >> k) & 1
        if k == found - 2 and found < BINS - LENGTH_BINS + 2:
            offset = LENGTH_BINS + found - 2
            bit = code_mixed(
                state, buffer, probabilities, hits, slots, offset, weights, row + offset, other + offset, logits, bit
            )
        else:
            bit = code_bit(state, buffer, 32768, bit)
        result = (result << 1) | bit
    negative = 1 if value < 0 else 0
    if sign_slot < 0:
        negative = code_bit(state, buffer, 32768, negative)
    else:
        negative = code_adaptive(state, buffer, probabilities, hits, sign_slot, negative)
    return -result if negative else result


@inner
def value_costs(probabilities, slots, weights, row, other, logits, costs, values, bits):
    """Set `bits` to what `code_value` would take for each of some values, without learning; signs count 1."""
    longest = 0
    for value in values:
        longest = max(longest, bit_length(abs(value)))
    before = 0.0
    for k in range(min(longest + 1, LENGTH_BINS)):
        p = mixed(probabilities, slots, k, weights, row + k, other + k, logits)
        for c in range(len(values)):
            if bit_length(abs(values[c])) == k:
                bits[c] = before + costs[(65536 - p) >> 4]
        before += costs[p >> 4]
    for c in range(len(values)):
        magnitude = abs(values[c])
        length = bit_length(magnitude)
        if length >= LENGTH_BINS:
            bits[c] = before
        bits[c] += length
        if 2 <= length < BINS - LENGTH_BINS + 2:
            offset = LENGTH_BINS + length - 2
            p = mixed(probabilities, slots, offset, weights, row + offset, other + offset, logits)
            bits[c] += costs[(p if (magnitude >> (length - 2)) & 1 else 65536 - p) >> 4] - 1.0


NUMBER_SLOTS: Final = 64
"""Slots that `code_number` takes from its first."""


@inner
def code_number(state, buffer, probabilities, hits, slot, value):
    """Code a whole number below 2^31 that is not negative by the adaptive probabilities from `slot` on; return it.

    The number of binary digits of value + 1 comes in unary, then the digits below the highest: the first by the
    number of digits, the others as they are.
    """
    shifted = value + 1
    length = bit_length(shifted)
    found = 1
    while found < 32 and code_adaptive(
        state, buffer, probabilities, hits, slot + found - 1, 1 if length > found else 0
    ):
        found += 1
    result = 1
    for k in range(found - 2, -1, -1):
        bit = (shifted >> k) & 1
        if k == found - 2:
            bit = code_adaptive(state, buffer, probabilities, hits, slot + 31 + found, bit)
        else:
            bit = code_bit(state, buffer, 32768, bit)
        result = (result << 1) | bit
    return result - 1


@inner
def code_below(state, buffer, limit, value):
    """Code a whole number in [0, limit), all values being alike; return it. A damaged stream may give up to twice."""
    bits = bit_length(limit - 1)
    result = 0
    for k in range(bits - 1, -1, -1):
        result = (result << 1) | code_bit(state, buffer, 32768, (value >> k) & 1)
    return result

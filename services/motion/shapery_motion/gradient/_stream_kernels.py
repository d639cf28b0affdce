"""Compiled loops of `shapery_motion.gradient.streams`: whole numbers and labels through the range coder.

The same functions encode and decode, by the coder's mode, so that the two sides cannot drift apart.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

from typing import Final

from shapery_motion.compiled import inlined, inner, kernel
from shapery_motion.entropy import _coder_kernels as coder

LENGTHS: Final = 40
"""Slots of a context of `code_integers`: the bit length in unary, at most 31, then the highest bit below it."""
MAGNITUDES: Final = 16
"""Contexts of a column, by the size of what was coded next to it."""
MAX_BITS: Final = 31
PATTERNS: Final = 128
"""Contexts of a label, by which of its candidates exist and agree."""


@kernel
def begin(state, buffer, mode):
    """Begin a stream."""
    coder.start(state, buffer, mode)


@kernel
def end(state, buffer):
    """End an encoded stream; return its length."""
    return coder.finish(state, buffer)


@inner
def _integer(state, buffer, probabilities, hits, base, value):
    magnitude = abs(value)
    length = coder.bit_length(magnitude)
    found = 0
    while found < MAX_BITS:
        if not coder.code_adaptive(state, buffer, probabilities, hits, base + found, 1 if length > found else 0):
            break
        found += 1
    if found == 0:
        return 0
    result = 1
    for k in range(found - 2, -1, -1):
        bit = (magnitude >> k) & 1
        if k == found - 2 and found < LENGTHS - MAX_BITS:
            bit = coder.code_adaptive(state, buffer, probabilities, hits, base + MAX_BITS + found, bit)
        else:
            bit = coder.code_bit(state, buffer, 32768, bit)
        result = (result << 1) | bit
    return -result if coder.code_bit(state, buffer, 32768, 1 if value < 0 else 0) else result


@kernel
def code_integers(state, buffer, probabilities, hits, values):
    """Code the rows of `values` (k, c) in their order, in place.

    The context of a number is its column and the bit length of the sum of the magnitudes before it: in its column the
    row before, in its row the column before.
    """
    columns = values.shape[1]
    for row in range(len(values)):
        for column in range(columns):
            size = 0
            if row > 0:
                size += abs(values[row - 1, column])
            if column > 0:
                size += abs(values[row, column - 1])
            context = column * MAGNITUDES + min(coder.bit_length(size), MAGNITUDES - 1)
            values[row, column] = _integer(state, buffer, probabilities, hits, context * LENGTHS, values[row, column])


@inlined
def _tree(state, buffer, probabilities, hits, base, depth, value):
    """Code a number of `depth` bits, highest first, each in the context of those before it."""
    node = 1
    for k in range(depth - 1, -1, -1):
        node = (node << 1) | coder.code_adaptive(state, buffer, probabilities, hits, base + node, (value >> k) & 1)
    return node - (1 << depth)


@kernel
def code_labels(state, buffer, probabilities, hits, order, parents, across, ranks, previous, steady, count, labels):
    """Code the labels (m,) of a frame in place; return whether all of them are below `count`.

    A label is compared with that of the parent face, then of another neighbour that was visited before, then of the
    same face in the frame before (`previous`, where `steady`); if it is none of these, it is coded by its digits.
    """
    depth = coder.bit_length(count - 1)
    trees = 3 * PATTERNS + (1 << depth)
    for k in range(len(order)):
        f = order[k]
        label = labels[f]
        parent = parents[f]
        first = labels[parent] if parent >= 0 else -1
        second = -1
        for side in range(3):
            g = across[f, side]
            if g >= 0 and g != parent and ranks[g] < k and labels[g] != first:
                second = labels[g]
                break
        third = previous[f] if steady else -1
        pattern = 0
        if first >= 0:
            pattern |= 1
        if second >= 0:
            pattern |= 2
        if third >= 0:
            pattern |= 4
            if third == first:
                pattern |= 8
            if third == second:
                pattern |= 16
            if parent >= 0 and previous[parent] == third:
                pattern |= 32
            if parent >= 0 and previous[parent] == first:
                pattern |= 64
        found = -1
        if first >= 0 and coder.code_adaptive(state, buffer, probabilities, hits, pattern, 1 if label == first else 0):
            found = first
        if (
            found < 0
            and second >= 0
            and coder.code_adaptive(state, buffer, probabilities, hits, PATTERNS + pattern, 1 if label == second else 0)
        ):
            found = second
        if (
            found < 0
            and third >= 0
            and third != first
            and third != second
            and coder.code_adaptive(
                state, buffer, probabilities, hits, 2 * PATTERNS + pattern, 1 if label == third else 0
            )
        ):
            found = third
        if found < 0:
            found = _tree(state, buffer, probabilities, hits, trees, depth, label)
            if found >= count:
                return False
        labels[f] = found
    return True

"""Dependent quantisation: two quantisers of twice the spacing, of which the numbers before tell the next one's.

The even one has the levels 2k half steps, the odd one 2k - sign(k). A trellis of states tells which is used, driven by
the parity of each whole number k. Together they hold every half step, so that sequences of levels lie more densely than
those of a single quantiser at the same rate. An encoder seeks the best sequence by Viterbi's algorithm.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

import numpy as np

from shapery_motion.compiled import inlined, inner
from shapery_motion.entropy._coder_kernels import CONTEXTS, value_costs

NEXT: Final = np.array([[0, 2], [5, 7], [1, 3], [6, 4], [2, 0], [4, 6], [3, 1], [7, 5]], dtype=np.int64)
"""The state after an even and an odd number; odd states have the odd quantiser."""
STATES: Final = len(NEXT)
DELAY: Final = 64
"""Numbers after which an encoder's choice is final."""
CANDIDATES: Final = 3
BEHIND: Final = 0.6
"""Squared steps by which a path may lie behind the best before an encoder gives it up."""


@inlined
def level_of(value, odd):
    """Return the level, in half steps, of a whole number."""
    if odd:
        return 2 * value - (1 if value > 0 else 0) + (1 if value < 0 else 0)
    return 2 * value


@inlined
def candidates_of(wanted, odd, values):
    """Set `values` to the numbers of the two levels beside what is wanted, in steps, and to 0."""
    size = abs(wanted)
    low = int(np.floor(size + 0.5 if odd else size))
    values[0] = low if wanted > 0.0 else -low
    values[1] = low + 1 if wanted > 0.0 else -low - 1
    values[2] = 0


NUMBERS: Final = 6
REALS: Final = 6
"""Arrays of (STATES, DELAY) whole and real numbers that Viterbi's algorithm needs as scratch."""


@inner
def costs_on_path(
    probabilities, slots, weights, row, other, logits, costs, values, bits, losses, state, known, known_bits
):
    """Set `bits` as `value_costs` does, from what is known of another path where its contexts and values are the same.

    Paths soon join, so that most of them agree about what lies just behind. `known` and `known_bits` hold what the
    paths of lower states had.
    """
    for before in range(state & 1, state, 2):
        if losses[before] == np.inf or known[before, CONTEXTS] != row or known[before, CONTEXTS + 1] != other:
            continue
        same = True
        for k in range(CONTEXTS):
            if known[before, k] != slots[k]:
                same = False
                break
        for c in range(CANDIDATES):
            if known[before, CONTEXTS + 2 + c] != values[c]:
                same = False
        if same:
            for c in range(CANDIDATES):
                bits[c] = known_bits[before, c]
            break
    else:
        value_costs(probabilities, slots, weights, row, other, logits, costs, values, bits)
    for k in range(CONTEXTS):
        known[state, k] = slots[k]
    known[state, CONTEXTS], known[state, CONTEXTS + 1] = row, other
    for c in range(CANDIDATES):
        known[state, CONTEXTS + 2 + c] = values[c]
        known_bits[state, c] = bits[c]

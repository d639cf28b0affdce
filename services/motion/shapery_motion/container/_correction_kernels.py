"""Corrections: single vertices in single frames, moved by whole numbers of a step."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

from shapery_motion.compiled import kernel
from shapery_motion.entropy._coder_kernels import NUMBER_SLOTS, code_bit, code_number

FRAME_SLOT: Final = 0
VERTEX_SLOT: Final = NUMBER_SLOTS
MOVE_SLOT: Final = 2 * NUMBER_SLOTS
CORRECTION_SLOTS: Final = 3 * NUMBER_SLOTS


@kernel
def code_corrections(state, buffer, probabilities, hits, frames, vertices, places, moves):
    """Code corrections, ascending by frame and vertex; tell whether all lie within the group.

    Parameters
    ----------
    frames, vertices
        Of the group.
    places : (k, 2)
        Frame and vertex of each.
    moves : (k, 3)
        By how many steps.
    """
    frame, vertex = 0, -1
    for k in range(len(places)):
        later = code_number(state, buffer, probabilities, hits, FRAME_SLOT, places[k, 0] - frame)
        if later:
            frame += later
            vertex = -1
        vertex += 1 + code_number(state, buffer, probabilities, hits, VERTEX_SLOT, places[k, 1] - vertex - 1)
        if frame >= frames or vertex >= vertices:
            return False
        places[k, 0], places[k, 1] = frame, vertex
        for axis in range(3):
            move = moves[k, axis]
            size = code_number(state, buffer, probabilities, hits, MOVE_SLOT, abs(move))
            if size and code_bit(state, buffer, 32768, 1 if move < 0 else 0):
                size = -size
            moves[k, axis] = size
    return True

"""Section CORR: where a decoded vertex would be too far from its original, and by how much it is moved.

It stands at the end of a group, in any profile, and makes the bound on the largest error a promise.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shapery_motion.container import _correction_kernels as kernels
from shapery_motion.container.sections import CORRECTIONS, damaged
from shapery_motion.entropy.stream import Stream

FloatArray = NDArray[np.float64]

ITEM_BYTES: Final = 64
"""What each correction counts in the header's memory."""

_FIXED: Final = struct.Struct("<dI")


@dataclass(frozen=True, eq=False)
class Corrections:
    """The corrections of a group, ascending by frame and vertex."""

    step: float
    places: NDArray[np.int64]
    """(k, 2) frame within the group, and vertex."""
    moves: NDArray[np.int64]
    """(k, 3) in steps."""

    @classmethod
    def nothing(cls) -> Corrections:
        """Return no corrections."""
        return cls(1.0, np.zeros((0, 2), dtype=np.int64), np.zeros((0, 3), dtype=np.int64))

    def __len__(self) -> int:
        return len(self.places)

    @property
    def memory(self) -> int:
        """Bytes that they take, by the specification of the format."""
        return ITEM_BYTES * len(self)

    def apply(self, index: int, frame: FloatArray) -> None:
        """Move the vertices of a frame of the group in place."""
        first, stop = np.searchsorted(self.places[:, 0], (index, index + 1))
        if first < stop:
            frame[self.places[first:stop, 1]] += self.moves[first:stop] * self.step

    def pack(self, frames: int, vertices: int) -> bytes:
        """Return the payload of the section."""
        stream = Stream(kernels.CORRECTION_SLOTS, room=64 + 64 * len(self))
        kernels.code_corrections(*stream.parts, frames, vertices, self.places.copy(), self.moves.copy())
        return _FIXED.pack(self.step, len(self)) + stream.finished()

    @classmethod
    def unpack(cls, payload: memoryview, frames: int, vertices: int, memory: int) -> Corrections:
        """Read the section.

        Raises
        ------
        InvalidInput
            ``corrupt_file`` naming the section.
        """
        if len(payload) < _FIXED.size:
            raise damaged(CORRECTIONS, f"has {len(payload)} bytes, fewer than {_FIXED.size}")
        step, count = _FIXED.unpack_from(payload)
        if not math.isfinite(step) or step <= 0 or count > frames * vertices:
            raise damaged(CORRECTIONS, f"tells of {count} corrections in steps of {step}")
        if ITEM_BYTES * count > memory:
            raise damaged(CORRECTIONS, "asks for more memory than the header tells")
        places = np.zeros((count, 2), dtype=np.int64)
        moves = np.zeros((count, 3), dtype=np.int64)
        stream = Stream(kernels.CORRECTION_SLOTS, data=payload[_FIXED.size :])
        if not kernels.code_corrections(*stream.parts, frames, vertices, places, moves):
            raise damaged(CORRECTIONS, "names vertices or frames that are not there")
        stream.check_end(CORRECTIONS)
        return cls(step, places, moves)


def find_corrections(frames: FloatArray, decoded: list[FloatArray], largest: float) -> Corrections:
    """Return what brings every vertex of the decoded frames within `largest` of its original."""
    # rounding to a step moves each coordinate by half of it at most, a vertex by sqrt(3) / 2 of it
    step = largest * 1.1
    places, moves = [], []
    for number, (frame, found) in enumerate(zip(frames, decoded, strict=True)):
        rest = frame - found
        # a little early, for results are rounded to float32
        far = np.flatnonzero((rest**2).sum(axis=1) > (0.9999 * largest) ** 2)
        if len(far):
            places.append(np.stack((np.full(len(far), number), far), axis=1))
            moves.append(np.rint(rest[far] / step).astype(np.int64))
    if not places:
        return Corrections.nothing()
    return Corrections(step, np.concatenate(places).astype(np.int64), np.concatenate(moves))

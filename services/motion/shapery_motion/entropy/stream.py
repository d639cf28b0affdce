"""A stream of the range coder with the probabilities that its decisions learn."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_motion.compiled import kernel
from shapery_motion.container.sections import damaged
from shapery_motion.entropy import _coder_kernels as coder

IntArray = NDArray[np.int64]

start = kernel(coder.start.py_func)
finish = kernel(coder.finish.py_func)

SLACK = 64
"""Bytes by which a damaged stream may be read beyond its end before it is refused; a sound one needs at most 4."""


PACE = 8


class Stream:
    """The coder's state, its buffer and its probabilities, all of which the kernels change in place.

    Parameters
    ----------
    slots
        Number of adaptive probabilities.
    rows
        Number of weight vectors of the mixer.
    data
        What is to be decoded; without it the stream is one to encode.
    room
        Bytes that an encoded stream may take.
    pace
        How fast the mixer learns.
    """

    def __init__(
        self, slots: int, rows: int = 1, *, data: memoryview | None = None, room: int = 1 << 16, pace: int = PACE
    ) -> None:
        self.probabilities = np.full(slots, 32768, dtype=np.uint16)
        self.hits = np.zeros(slots, dtype=np.uint8)
        self.weights = np.full((rows, coder.CONTEXTS + 1), 65536 * 1 // 10, dtype=np.int32)
        self.weights[:, coder.CONTEXTS] = 0
        self.state: IntArray = np.zeros(6, dtype=np.int64)
        self.state[coder.PACE] = pace
        if data is None:
            self.buffer = np.empty(room, dtype=np.uint8)
            start(self.state, self.buffer, coder.ENCODE)
        else:
            self.buffer = np.frombuffer(data, dtype=np.uint8).copy()
            start(self.state, self.buffer, coder.DECODE)

    @property
    def parts(self) -> tuple[Any, ...]:
        """The state, the buffer, the probabilities and how often each was met: how the kernels take a stream."""
        return self.state, self.buffer, self.probabilities, self.hits

    def finished(self) -> bytes:
        """End an encoded stream and return its bytes."""
        length = int(finish(self.state, self.buffer))
        if length > len(self.buffer):
            raise ValueError(f"the stream has {length} bytes, and room for {len(self.buffer)}")
        return self.buffer[:length].tobytes()

    def check_end(self, tag: str) -> None:
        """Refuse a decoded stream that was read beyond its end, as those of section `tag`."""
        if int(self.state[coder.POSITION]) > len(self.buffer) + SLACK:
            raise damaged(tag, "ends before all that it should hold")

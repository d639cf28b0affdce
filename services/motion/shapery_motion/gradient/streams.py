"""Streams of whole numbers and of labels, range coded with adaptive contexts."""

from __future__ import annotations

from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from shapery_motion.entropy import _coder_kernels as coder
from shapery_motion.gradient import _stream_kernels as kernels
from shapery_motion.gradient.traversal import Integers, Traversal

MAX_CLUSTERS: Final = 1 << 16
NUMBER_LIMIT: Final = 1 << kernels.MAX_BITS
"""The magnitudes of whole numbers in a stream stay below this."""


class _Stream:
    """A range coder, its bytes, and the probabilities of its contexts."""

    def __init__(self, slots: int, data: memoryview | None) -> None:
        self._state = np.zeros(5, dtype=np.int64)
        self._decoding = data is not None
        self._buffer = np.frombuffer(data, dtype=np.uint8).copy() if data is not None else np.zeros(1 << 12, np.uint8)
        self._probabilities = np.full(slots, 1 << 15, dtype=np.int64)
        self._hits = np.zeros(slots, dtype=np.int64)
        kernels.begin(self._state, self._buffer, coder.DECODE if self._decoding else coder.ENCODE)

    def _reserve(self, more: int) -> None:
        """Make room for `more` bytes."""
        needed = int(self._state[coder.POSITION]) + more + 8
        if not self._decoding and needed > len(self._buffer):
            grown = np.zeros(max(needed, 2 * len(self._buffer)), dtype=np.uint8)
            grown[: len(self._buffer)] = self._buffer
            self._buffer = grown

    def copy(self) -> Self:
        """Return an encoder that goes on from here by itself, to find out what something would cost."""
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)
        for name in ("_state", "_buffer", "_probabilities", "_hits"):
            setattr(other, name, getattr(self, name).copy())
        return other

    @property
    def position(self) -> int:
        """Bytes written so far, up to four short of the end."""
        return int(self._state[coder.POSITION])

    @property
    def overrun(self) -> bool:
        """Whether more was decoded than the stream holds."""
        # the decoder looks four bytes ahead of what it used, and an encoder ends with at least one byte of its own
        return self.position > len(self._buffer) + 3

    @property
    def surplus(self) -> bool:
        """Whether the stream holds more than was decoded."""
        return self.position < len(self._buffer)

    def finish(self) -> bytes:
        """End the encoded stream and return its bytes."""
        self._reserve(8)
        return self._buffer[: kernels.end(self._state, self._buffer)].tobytes()


class IntegerStream(_Stream):
    """Whole numbers in rows of a fixed number of columns.

    Parameters
    ----------
    columns
        Numbers in a row.
    data
        The bytes to decode; none to encode.
    """

    def __init__(self, columns: int, data: memoryview | None = None) -> None:
        super().__init__(columns * kernels.MAGNITUDES * kernels.LENGTHS, data)
        self._columns = columns

    def write(self, values: NDArray[Any]) -> None:
        """Encode rows (k, columns)."""
        rows = np.array(values, dtype=np.int64).reshape(-1, self._columns)
        if rows.size and max(int(rows.max()), -int(rows.min())) >= NUMBER_LIMIT:
            raise OverflowError("a number is too large for the stream")
        self._reserve(9 * rows.size)
        kernels.code_integers(self._state, self._buffer, self._probabilities, self._hits, rows)

    def read(self, count: int) -> Integers:
        """Decode `count` rows."""
        rows = np.zeros((count, self._columns), dtype=np.int64)
        kernels.code_integers(self._state, self._buffer, self._probabilities, self._hits, rows)
        return rows


class LabelStream(_Stream):
    """The clusters of the faces, frame after frame.

    Parameters
    ----------
    traversal
        The order of the faces.
    data
        The bytes to decode; none to encode.
    """

    def __init__(self, traversal: Traversal, data: memoryview | None = None) -> None:
        super().__init__(3 * kernels.PATTERNS + 2 * MAX_CLUSTERS, data)
        self._traversal = traversal
        self._previous = np.zeros(len(traversal.face_order), dtype=np.int32)
        self._count = 0

    def write(self, labels: NDArray[np.int32], count: int) -> None:
        """Encode the labels (m,) of the next frame, which are below `count`."""
        # a label may take as many adaptive bits as it has digits, and three more, each of up to twelve bits
        self._reserve(30 * len(labels))
        if not self._code(labels.copy(), count):
            raise ValueError(f"a label is not below {count}")

    def read(self, count: int) -> NDArray[np.int32] | None:
        """Decode the labels of the next frame; nothing where one of them is not below `count`."""
        labels = np.zeros(len(self._previous), dtype=np.int32)
        return labels if self._code(labels, count) else None

    def _code(self, labels: NDArray[np.int32], count: int) -> bool:
        walk = self._traversal
        sound = bool(
            kernels.code_labels(
                self._state, self._buffer, self._probabilities, self._hits, walk.face_order, walk.parents, walk.across,
                walk.ranks, self._previous, self._count == count, count, labels,
            )
        )  # fmt: skip
        self._previous, self._count = labels, count
        return sound

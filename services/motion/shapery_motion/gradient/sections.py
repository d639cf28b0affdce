"""The sections of a group of the ``gradient`` profile, written and read frame by frame."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import IntArray
from shapery_motion.container.sections import damaged
from shapery_motion.gradient.group import FACTORS_KEPT, SOLVER_BYTES, Group, KeyFrame, PredictedFrame
from shapery_motion.gradient.streams import IntegerStream, LabelStream
from shapery_motion.gradient.traversal import Integers, Traversal

FRAMES, KEYS, LISTS, ANCHORS, MATRICES, LABELS = "GFRM", "GKEY", "GLST", "GANC", "GMAT", "GLAB"
PART_NAMES: Final = {
    FRAMES: "frame table",
    KEYS: "key frames",
    LISTS: "choice of anchors",
    ANCHORS: "anchors",
    MATRICES: "matrices",
    LABELS: "labels",
}

_HEAD: Final = struct.Struct("<4d")
_ENTRY: Final = struct.Struct("<BbHI")
_KEY, _PREDICTED = 1, 2
_CHANGES: Final = 4
"""Flag of a key frame that is stored by its difference from the key frame before it."""
_LISTED: Final = 8
"""Flag of a key frame with a list of anchors of its own; others have that of the key frame before them."""
_PRECISIONS: Final = range(-100, 61)
_FARTHEST: Final = 1 << 40
"""Whole numbers of a decoded file stay below this, so that sums of them cannot overflow."""
_FARTHEST_SHIFT: Final = 20
MOST: Final = 1e30
"""Coordinates of the origin stay below this, and the step between this and its inverse: no square overflows."""


class GroupWriter:
    """Write the frames of a group one after the other.

    Parameters
    ----------
    group
        Whose faces, origin and step are written.
    traversal
        Of its faces.
    """

    def __init__(self, group: Group, traversal: Traversal) -> None:
        self._walk = traversal
        self._table: list[bytes] = [_HEAD.pack(*group.origin, group.step)]
        self._keys, self._lists, self._anchors = IntegerStream(3), IntegerStream(1), IntegerStream(3)
        self._matrices, self._labels = IntegerStream(9), LabelStream(traversal)
        self._state = _Known()

    def copy(self) -> GroupWriter:
        """Return a writer that goes on from here by itself, to find out what a frame would cost."""
        other = GroupWriter.__new__(GroupWriter)
        other._walk, other._table = self._walk, self._table.copy()
        other._keys, other._lists, other._anchors = self._keys.copy(), self._lists.copy(), self._anchors.copy()
        other._matrices, other._labels = self._matrices.copy(), self._labels.copy()
        other._state = self._state.copy()
        return other

    @property
    def size(self) -> int:
        """Bytes written so far, nearly."""
        streams = (self._keys, self._lists, self._anchors, self._matrices, self._labels)
        return len(self._table) * _ENTRY.size + sum(stream.position for stream in streams)

    def write_key(self, frame: KeyFrame) -> None:
        """Write a key frame, by itself or by its difference from the last, whichever is shorter."""
        known, residuals = self._state, self._walk.residuals(frame.positions)
        kind = _KEY
        if known.positions is not None:
            changes = self._walk.residuals(frame.positions - known.positions)
            trials = [self._keys.copy() for _ in range(2)]
            for trial, values in zip(trials, (residuals, changes), strict=True):
                trial.write(values)
            if trials[1].position < trials[0].position:
                kind, residuals = kind | _CHANGES, changes
        self._keys.write(residuals)
        if not np.array_equal(frame.anchors, known.anchors):
            kind |= _LISTED
            self._lists.write(np.diff(frame.anchors, prepend=0).reshape(-1, 1))
        self._table.append(_ENTRY.pack(kind, 0, 0, len(frame.anchors)))
        known.start(frame)

    def write_predicted(self, frame: PredictedFrame) -> None:
        """Write a predicted frame."""
        count = len(frame.matrices)
        self._table.append(_ENTRY.pack(_PREDICTED, frame.precision, count - 1, len(frame.anchors)))
        self._anchors.write(frame.anchors - self._state.held[: len(frame.anchors)])
        self._matrices.write(frame.matrices - self._state.expected(count, frame.precision))
        self._labels.write(frame.labels, count)
        self._state.follow(frame)

    def finish(self) -> tuple[tuple[str, bytes], ...]:
        """Return the sections; streams of which nothing was written are empty."""
        streams = {
            KEYS: self._keys,
            LISTS: self._lists,
            ANCHORS: self._anchors,
            MATRICES: self._matrices,
            LABELS: self._labels,
        }
        payloads = {FRAMES: b"".join(self._table)} | {tag: stream.finish() for tag, stream in streams.items()}
        return tuple(payloads.items())


class _Known:
    """What writer and reader both know from the frames before."""

    def __init__(self) -> None:
        self.positions: Integers | None = None
        self.anchors: IntArray = np.zeros(0, dtype=np.int32)
        self.held: Integers = np.zeros((0, 3), dtype=np.int64)
        """(a, 3) where each anchor was last."""
        self.matrices: Integers = np.zeros((0, 9), dtype=np.int64)
        self.precision = 0

    def copy(self) -> _Known:
        other = _Known()
        other.__dict__.update(self.__dict__)
        return other

    def start(self, frame: KeyFrame) -> None:
        self.positions, self.anchors = frame.positions, frame.anchors
        self.held = frame.positions[frame.anchors]

    def expected(self, count: int, precision: int) -> Integers:
        """Return the matrices (count, 9) of the frame before in other units; zeros where they do not correspond."""
        if len(self.matrices) != count:
            return np.zeros((count, 9), dtype=np.int64)
        shift = precision - self.precision
        if abs(shift) > _FARTHEST_SHIFT:
            return np.zeros((count, 9), dtype=np.int64)
        return self.matrices << shift if shift >= 0 else self.matrices >> -shift

    def follow(self, frame: PredictedFrame) -> None:
        self.held = np.concatenate((frame.anchors, self.held[len(frame.anchors) :]))
        self.matrices, self.precision = frame.matrices, frame.precision


def declared_memory(vertices: int, faces: int, table: list[tuple[int, int, int, int]]) -> int:
    """Return the bytes that an open group takes, from the entries of its frame table."""
    keys = sum(1 for kind, *_ in table if kind & _KEY)
    predicted = sum(4 * faces + 72 * (count + 1) + 24 * anchors for kind, _, count, anchors in table if not kind & _KEY)
    solvers = FACTORS_KEPT * (SOLVER_BYTES * vertices + 500 * faces) if keys < len(table) else 0
    return 28 * vertices * keys + predicted + solvers + (1 << 20)


def table_of(payload: bytes | memoryview, frames: int) -> list[tuple[int, int, int, int]]:
    """Return the entries (kind, precision, clusters − 1, anchors) of section GFRM.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` naming the section.
    """
    if len(payload) != _HEAD.size + frames * _ENTRY.size:
        raise damaged(FRAMES, f"has {len(payload)} bytes, which do not fit {frames} frames")
    table = list(_ENTRY.iter_unpack(payload[_HEAD.size :]))
    if not table[0][0] & _KEY:
        raise damaged(FRAMES, "begins with a predicted frame")
    return table


def read_group(
    sections: Mapping[str, memoryview], frames: int, vertices: int, faces: IntArray, memory: int, walk: Traversal
) -> Group:
    """Decode the sections of a group.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` naming the section whose content contradicts itself, or asks for more than `memory`.
    """
    for tag in PART_NAMES:
        if tag not in sections:
            raise damaged(tag, "is missing")
    table = table_of(sections[FRAMES], frames)
    if declared_memory(vertices, len(faces), table) > memory:
        raise damaged(FRAMES, f"asks for more than the {memory} bytes of memory that the header allows")
    *origin, step = _HEAD.unpack_from(sections[FRAMES])
    if not (np.abs(origin).max() <= MOST and 1 / MOST <= step <= MOST):
        raise damaged(FRAMES, "has a grid that no encoder writes")
    group = Group(faces, np.array(origin), step)
    reader = _GroupReader(sections, vertices, walk)
    for kind, precision, count, anchors in table:
        if kind & _KEY and kind & ~(_KEY | _CHANGES | _LISTED) == 0:
            group.frames.append(reader.key(kind, anchors))
        elif kind == _PREDICTED and precision in _PRECISIONS:
            group.frames.append(reader.predicted(precision, count + 1, anchors))
        else:
            raise damaged(FRAMES, f"has an entry of kind {kind} and precision {precision}")
    reader.check_ends()
    return group


class _GroupReader:
    """Read the frames of a group one after the other."""

    def __init__(self, sections: Mapping[str, memoryview], vertices: int, walk: Traversal) -> None:
        self._vertices, self._walk, self._state = vertices, walk, _Known()
        self._integers = {
            KEYS: IntegerStream(3, sections[KEYS]),
            LISTS: IntegerStream(1, sections[LISTS]),
            ANCHORS: IntegerStream(3, sections[ANCHORS]),
            MATRICES: IntegerStream(9, sections[MATRICES]),
        }
        self._labels = LabelStream(walk, sections[LABELS])

    def key(self, kind: int, anchors: int) -> KeyFrame:
        known = self._state
        positions = self._walk.values(self._rows(KEYS, self._vertices))
        if kind & _CHANGES:
            if known.positions is None:
                raise damaged(FRAMES, "begins with changes from a frame before")
            positions = positions + known.positions
        self._bounded(KEYS, positions)
        chosen = known.anchors
        if kind & _LISTED:
            if anchors > self._vertices:
                raise damaged(FRAMES, f"tells of {anchors} anchors for {self._vertices} vertices")
            listed = np.cumsum(self._rows(LISTS, anchors).ravel())
            if listed.size and not (listed.min() >= 0 and listed.max() < self._vertices):
                raise damaged(LISTS, "names vertices that do not exist")
            if len(np.unique(listed)) != len(listed):
                raise damaged(LISTS, "names a vertex twice")
            chosen = listed.astype(np.int32)
        if len(chosen) != anchors:
            raise damaged(FRAMES, f"tells of {anchors} anchors in place of {len(chosen)}")
        frame = KeyFrame(positions, chosen)
        known.start(frame)
        return frame

    def predicted(self, precision: int, count: int, anchors: int) -> PredictedFrame:
        known = self._state
        if anchors > len(known.anchors):
            raise damaged(FRAMES, f"tells of {anchors} anchors of {len(known.anchors)}")
        held = self._rows(ANCHORS, anchors) + known.held[:anchors]
        matrices = self._rows(MATRICES, count) + known.expected(count, precision)
        self._bounded(ANCHORS, held)
        self._bounded(MATRICES, matrices)
        labels = self._labels.read(count)
        if labels is None:
            raise damaged(LABELS, f"names clusters beyond the {count} of a frame")
        if self._labels.overrun:
            raise damaged(LABELS, "ends too early")
        frame = PredictedFrame(labels, matrices, precision, held)
        known.follow(frame)
        return frame

    def check_ends(self) -> None:
        """Refuse streams that have more in them than was asked for."""
        for tag, stream in {**self._integers, LABELS: self._labels}.items():
            if stream.surplus:
                raise damaged(tag, "has more in it than its frames")

    def _rows(self, tag: str, count: int) -> Integers:
        stream = self._integers[tag]
        rows = stream.read(count)
        if stream.overrun:
            raise damaged(tag, "ends too early")
        return rows

    @staticmethod
    def _bounded(tag: str, values: NDArray[np.int64]) -> None:
        if values.size and max(int(values.max()), -int(values.min())) > _FARTHEST:
            raise damaged(tag, "has numbers that no encoder writes")

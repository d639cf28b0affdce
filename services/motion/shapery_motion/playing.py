"""Opening motion files: frames in any order, one group in memory at a time."""

from __future__ import annotations

import mmap
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats.model import corrupt
from shapery_geometry.mesh import IntArray
from shapery_geometry.sequence import MeshSequence
from shapery_motion.container.connectivity import unpack_connectivity
from shapery_motion.container.corrections import Corrections
from shapery_motion.container.header import Group, Header, Metadata, MotionLimits, unpack_groups
from shapery_motion.container.sections import CONNECTIVITY, CORRECTIONS, END, GROUPS, HEAD, MAGIC, META, SectionReader
from shapery_motion.profiles import OpenGroup, get_profile

FrameArray = NDArray[np.float32] | NDArray[np.float64]


class Motion:
    """A motion file that is open.

    Parameters
    ----------
    source
        The file, or its bytes.
    limits
        What it may ask for; by default `MotionLimits()`.

    Raises
    ------
    InvalidInput
        ``unknown_format``, ``corrupt_file`` naming the section, ``unsupported_format``.
    LimitExceeded
        ``too_large``.
    """

    def __init__(self, source: Path | str | bytes, limits: MotionLimits | None = None) -> None:
        limits = limits or MotionLimits()
        self._data = _view(source)
        if bytes(self._data[: len(MAGIC)]) != MAGIC:
            raise InvalidInput("unknown_format", "The file is no motion file: it does not begin as one.")
        reader = SectionReader(self._data, len(MAGIC), len(self._data))
        self.header = Header.unpack(reader.next(HEAD)[1], limits)
        self.metadata = Metadata.unpack(reader.next(META)[1])
        if self.header.file_bytes != len(self._data):
            raise corrupt(
                f"Section HEAD of the motion file tells of {self.header.file_bytes} bytes, and there are "
                f"{len(self._data)}: the file is cut off or has something behind it."
            )
        self.groups: list[Group] = unpack_groups(reader.next(GROUPS)[1], self.header)
        payload = reader.next(CONNECTIVITY)[1]
        last = self.groups[-1]
        SectionReader(self._data, last.offset + last.length, len(self._data)).next(END)
        self.faces: IntArray = unpack_connectivity(payload, self.header.vertices, self.header.faces)
        self.faces.setflags(write=False)
        self._firsts = np.array([group.first for group in self.groups])
        self._open: tuple[int, OpenGroup, Corrections] | None = None

    def __len__(self) -> int:
        return self.header.frames

    def frame(self, index: int) -> FrameArray:
        """Return the vertices (n, 3) of a frame, in the type of the original; negative indices count from the end.

        Opens the frame's group unless it was the last one asked for.
        """
        if not -len(self) <= index < len(self):
            raise InvalidInput("invalid_params", f"There is no frame {index}: the motion has {len(self)}.")
        index %= len(self)
        number = int(np.searchsorted(self._firsts, index, side="right")) - 1
        opened, corrections = self._group(number)
        within = index - self.groups[number].first
        frame = opened.frame(within)
        corrections.apply(within, frame)
        return frame if self.header.double else frame.astype(np.float32)

    def frames(self, first: int = 0, stop: int | None = None) -> Iterator[FrameArray]:
        """Yield frames one after the other in memory that does not grow."""
        for index in range(first, len(self) if stop is None else min(stop, len(self))):
            yield self.frame(index)

    def _group(self, number: int) -> tuple[OpenGroup, Corrections]:
        if self._open is None or self._open[0] != number:
            self._open = None
            self._open = (number, *self._opened(number))
        return self._open[1], self._open[2]

    def _opened(self, number: int) -> tuple[OpenGroup, Corrections]:
        group, header = self.groups[number], self.header
        reader = SectionReader(self._data, group.offset, group.offset + group.length)
        sections: dict[str, memoryview] = {}
        while reader.offset < group.offset + group.length:
            tag, payload = reader.next()
            sections[tag] = payload
        found = sections.pop(CORRECTIONS, None)
        memory = header.memory
        corrections = Corrections.nothing()
        if found is not None:
            corrections = Corrections.unpack(found, group.frames, header.vertices, memory)
            memory -= corrections.memory
        profile = get_profile(header.profile)
        return profile.open_group(sections, group.frames, header.vertices, self.faces, memory), corrections


def open_motion(source: Path | str | bytes, *, limits: MotionLimits | None = None) -> Motion:
    """Open a motion file; see `Motion`."""
    return Motion(source, limits)


def decode(source: Path | str | bytes, *, first: int = 0, stop: int | None = None) -> MeshSequence:
    """Decode frames of a motion file into memory.

    Parameters
    ----------
    source
        The file, or its bytes.
    first, stop
        The first frame, and the one after the last; by default all.

    Raises
    ------
    InvalidInput, LimitExceeded
        See `Motion`; ``invalid_params`` where the range holds no frame.
    """
    motion = open_motion(source)
    stop = len(motion) if stop is None else min(stop, len(motion))
    check_range(first, stop, len(motion))
    dtype = np.float64 if motion.header.double else np.float32
    vertices = np.empty((stop - first, motion.header.vertices, 3), dtype=dtype)
    for number, frame in enumerate(motion.frames(first, stop)):
        vertices[number] = frame
    return MeshSequence(vertices, motion.faces)


def check_range(first: int, stop: int, frames: int) -> None:
    """Refuse a range that holds no frame with ``invalid_params``."""
    if not 0 <= first < stop <= frames:
        raise InvalidInput("invalid_params", f"The motion has the frames 0 to {frames - 1}, not {first} to {stop - 1}.")


def _view(source: Path | str | bytes) -> memoryview:
    if isinstance(source, bytes):
        return memoryview(source)
    with Path(source).open("rb") as stream:
        if not Path(source).stat().st_size:
            raise InvalidInput("empty_content", "The file is empty.")
        return memoryview(mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ))

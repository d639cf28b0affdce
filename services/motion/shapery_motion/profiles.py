"""What a profile of the codec offers: it encodes a group of frames, and opens one again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import IntArray
from shapery_motion.container.header import PROFILES, refuse_profile

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GroupTask:
    """A group of frames that is to be encoded, and how well."""

    frames: FloatArray
    """(F, n, 3) finite coordinates."""
    faces: IntArray
    """(m, 3) as a decoder will have them."""
    squared_error: float
    """What the squared distances of all vertices in all frames may sum to; infinite where that is not bounded."""
    largest: float = np.inf
    """What the distance of any vertex from its original may be at most."""
    preset: Literal["default", "fast"] = "default"
    clusters: int | None = None
    """Number of clusters; by default chosen by rate and distortion."""
    key_frames: tuple[int, ...] = ()
    """Numbers within the group, for profiles that have key frames."""
    check_cancelled: Callable[[], None] = lambda: None
    on_progress: Callable[[float], None] = lambda _fraction: None


@dataclass(frozen=True, eq=False)
class EncodedGroup:
    """The sections of a group, and what a report tells about it."""

    sections: tuple[tuple[str, bytes], ...]
    """Tag of four characters and payload, in their order."""
    memory: int
    """Bytes that the opened group takes, by the profile's formula in the specification of the format."""
    labels: IntArray
    """(n,) the cluster of each vertex."""
    points: tuple[tuple[float, int], ...] = ()
    """Sums of squared errors and bytes at the chosen step and at others: as many for each group of a sequence."""
    part_names: Mapping[str, str] = field(default_factory=dict)
    """What each tag holds, for reports: ``{"TBAS": "bases"}``."""


class OpenGroup(Protocol):
    """A group whose streams were decoded."""

    def frame(self, index: int) -> FloatArray:
        """Return the vertices (n, 3) of a frame by its number within the group."""


class Profile(Protocol):
    """One way to encode motion. A profile is a module ``shapery_motion.NAME.profile`` with these functions."""

    def encode_group(self, task: GroupTask) -> EncodedGroup:
        """Encode a group so that its bounds hold for what `open_group` gives."""

    def open_group(
        self, sections: Mapping[str, memoryview], frames: int, vertices: int, faces: IntArray, memory: int
    ) -> OpenGroup:
        """Decode the streams of a group.

        Raises
        ------
        InvalidInput
            ``corrupt_file`` naming the section where its content contradicts itself, or asks for more than `memory`.
        """


def get_profile(name: str) -> Profile:
    """Return the profile called `name`.

    Raises
    ------
    InvalidInput
        ``unsupported_format``.
    """
    if name not in PROFILES.values():
        raise refuse_profile(name)
    try:
        module: Any = import_module(f"shapery_motion.{name}.profile")
    except ModuleNotFoundError as error:
        raise refuse_profile(name) from error
    profile: Profile = module
    return profile

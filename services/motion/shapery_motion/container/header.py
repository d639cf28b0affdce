"""The header of a motion file, and what must hold of it before anything is allocated."""

from __future__ import annotations

import json
import math
import struct
from dataclasses import dataclass, field
from typing import Final

from shapery_contracts.errors import InvalidInput, LimitExceeded
from shapery_contracts.formats.model import unsupported
from shapery_motion.container.sections import GROUPS, HEAD, META, damaged

VERSION: Final = (1, 3)
"""Major and minor version of the format that is written. Readers take any minor version of their major one."""
VERTEX_BYTES: Final = {"trajectory": 400, "gradient": 28}
"""Memory that any group takes for each vertex at least, by profile."""
PROFILES: Final = {1: "trajectory", 2: "gradient"}
MAX_GROUP_FRAMES: Final = 4096
MAX_META: Final = 1 << 16

_HEAD: Final = struct.Struct("<BBBB4I2Q7d")
_GROUP: Final = struct.Struct("<2I2Q")


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Bounds that a reader sets on what it opens."""

    vertices: int = 20_000_000
    faces: int = 40_000_000
    frames: int = 1_000_000
    memory: int = 4 << 30
    """Bytes that opening a group may take, by the header's word, which decoders hold files to."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """A triple of errors: what was asked for, or what was met; not a number where there is none."""

    kg_percent: float = math.nan
    rmse_edges: float = math.nan
    largest_fraction: float = math.nan


@dataclass(frozen=True, slots=True)
class Group:
    """A run of frames that is decoded as a whole, and where its sections lie."""

    first: int
    frames: int
    offset: int
    length: int


@dataclass(frozen=True, slots=True)
class Header:
    """What sections HEAD, META and GRPS tell."""

    profile: str
    vertices: int
    faces: int
    frames: int
    groups: int
    file_bytes: int
    memory: int
    """Bytes that a decoder needs at most for what a group holds once it is open; see `api_schema/smc.md`."""
    fps: float = 0.0
    """Frames per second; 0 where unknown."""
    asked: Bounds = field(default_factory=Bounds)
    met: Bounds = field(default_factory=Bounds)
    double: bool = False
    """Whether the original's coordinates were float64."""
    version: tuple[int, int] = VERSION

    def pack(self) -> bytes:
        """Return the payload of section HEAD."""
        code = next(code for code, name in PROFILES.items() if name == self.profile)
        asked, met = self.asked, self.met
        return _HEAD.pack(
            *self.version,
            code,
            int(self.double),
            self.vertices,
            self.faces,
            self.frames,
            self.groups,
            self.file_bytes,
            self.memory,
            self.fps,
            asked.kg_percent,
            asked.rmse_edges,
            asked.largest_fraction,
            met.kg_percent,
            met.rmse_edges,
            met.largest_fraction,
        )

    @classmethod
    def unpack(cls, payload: memoryview, limits: MotionLimits) -> Header:
        """Read section HEAD and hold it against `limits`.

        Raises
        ------
        InvalidInput
            ``corrupt_file`` naming the section, or ``unsupported_format`` for other versions and profiles.
        LimitExceeded
            ``too_large``.
        """
        if len(payload) >= 1 and payload[0] != VERSION[0]:
            raise unsupported(
                f"The motion file is of version {payload[0]} of the format; version {VERSION[0]} is read here.",
                "Install a newer version of Shapery.",
            )
        if len(payload) < _HEAD.size:
            raise damaged(HEAD, f"has {len(payload)} bytes in place of {_HEAD.size}")
        major, minor, code, flags, *counts = _HEAD.unpack_from(payload)
        vertices, faces, frames, groups, file_bytes, memory, fps, *errors = counts
        if code not in PROFILES:
            raise unsupported(f"The motion file has the profile {code}.", "Install a newer version of Shapery.")
        if not (1 <= groups <= frames and math.isfinite(fps) and fps >= 0):
            raise damaged(HEAD, f"tells of {frames} frames in {groups} groups at {fps} frames per second")
        for name, value, most in (
            ("vertices", vertices, limits.vertices),
            ("faces", faces, limits.faces),
            ("frames", frames, limits.frames),
            ("bytes of memory", memory, limits.memory),
        ):
            if value > most:
                raise LimitExceeded(
                    "too_large", f"The motion file asks for {value} {name}; at most {most} are allowed."
                )
        if memory < VERTEX_BYTES[PROFILES[code]] * vertices:
            raise damaged(HEAD, f"tells of {vertices} vertices, more than {memory} bytes of memory hold")
        return cls(
            profile=PROFILES[code],
            vertices=vertices,
            faces=faces,
            frames=frames,
            groups=groups,
            file_bytes=file_bytes,
            memory=memory,
            fps=fps,
            asked=Bounds(*errors[:3]),
            met=Bounds(*errors[3:]),
            double=bool(flags & 1),
            version=(major, minor),
        )


@dataclass(frozen=True, slots=True)
class Metadata:
    """Section META: what people and viewers want to know, as a JSON object."""

    name: str = ""
    unit: str = ""
    software: str = ""

    def pack(self) -> bytes:
        """Return the payload."""
        values = {"name": self.name, "unit": self.unit, "software": self.software}
        return json.dumps({k: v for k, v in values.items() if v}, ensure_ascii=False, sort_keys=True).encode()

    @classmethod
    def unpack(cls, payload: memoryview) -> Metadata:
        """Read the payload; fields that are not known are passed over.

        Raises
        ------
        InvalidInput
            ``corrupt_file`` naming the section.
        """
        if len(payload) > MAX_META:
            raise damaged(META, f"has {len(payload)} bytes, more than the {MAX_META} it may have")
        try:
            values = json.loads(bytes(payload).decode())
        except (ValueError, RecursionError) as error:
            raise damaged(META, "is no JSON") from error
        if not isinstance(values, dict):
            raise damaged(META, "is no JSON object")
        return cls(**{key: str(values.get(key, "")) for key in ("name", "unit", "software")})


def pack_groups(groups: list[Group]) -> bytes:
    """Return the payload of section GRPS."""
    return b"".join(_GROUP.pack(g.first, g.frames, g.offset, g.length) for g in groups)


def groups_bytes(count: int) -> int:
    """Return the length of the payload of section GRPS."""
    return count * _GROUP.size


def unpack_groups(payload: memoryview, header: Header) -> list[Group]:
    """Read section GRPS, whose groups must follow each other in time and lie within the file.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` naming the section.
    """
    if len(payload) != groups_bytes(header.groups):
        raise damaged(GROUPS, f"has {len(payload)} bytes in place of {groups_bytes(header.groups)}")
    groups = [Group(*values) for values in _GROUP.iter_unpack(payload)]
    expected = 0
    for number, group in enumerate(groups):
        if group.first != expected or not 1 <= group.frames <= MAX_GROUP_FRAMES:
            raise damaged(GROUPS, f"gives group {number} the frames from {group.first}, {group.frames} of them")
        if group.offset + group.length > header.file_bytes:
            raise damaged(GROUPS, f"places group {number} beyond the end of the file")
        expected += group.frames
    if expected != header.frames:
        raise damaged(GROUPS, f"tells of {expected} frames, and the header of {header.frames}")
    return groups


def refuse_profile(name: str) -> InvalidInput:
    """Return the error for a profile that this installation does not decode."""
    return unsupported(f"The motion file has the profile {name!r}, which is not decoded here.", "")

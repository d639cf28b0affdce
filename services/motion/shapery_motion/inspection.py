"""What a motion file tells without being decoded: header, metadata, and bytes by section. Loads no numerics."""

from __future__ import annotations

import math
from pathlib import Path

from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats.model import corrupt
from shapery_contracts.motion import MotionInfo
from shapery_motion.container.header import Header, Metadata, MotionLimits, unpack_groups
from shapery_motion.container.sections import END, FRAME_BYTES, GROUPS, HEAD, MAGIC, META, SectionReader

_UNLIMITED = MotionLimits(vertices=1 << 32, faces=1 << 32, frames=1 << 32, memory=1 << 64)


def info(source: Path | str | bytes) -> MotionInfo:
    """Read what a motion file tells of itself; every checksum is compared.

    Raises
    ------
    InvalidInput
        ``unknown_format``, ``corrupt_file`` naming the section, ``unsupported_format``.
    """
    data = memoryview(source if isinstance(source, bytes) else Path(source).read_bytes())
    if bytes(data[: len(MAGIC)]) != MAGIC:
        raise InvalidInput("unknown_format", "The file is no motion file: it does not begin as one.")
    reader = SectionReader(data, len(MAGIC), len(data))
    header = Header.unpack(reader.next(HEAD)[1], _UNLIMITED)
    if header.file_bytes != len(data):
        raise corrupt(f"Section HEAD tells of {header.file_bytes} bytes, and the file has {len(data)}: it is cut off.")
    metadata = Metadata.unpack(reader.next(META)[1])
    groups = unpack_groups(reader.next(GROUPS)[1], header)
    reader = SectionReader(data, len(MAGIC), len(data))
    sections: dict[str, int] = {}
    tag = ""
    while tag != END:
        tag, payload = reader.next()
        sections[tag.strip()] = sections.get(tag.strip(), 0) + len(payload) + FRAME_BYTES
    pairs = header.vertices * header.frames
    connectivity = sections["CONN"]
    asked, met = header.asked, header.met
    return MotionInfo(
        version=f"{header.version[0]}.{header.version[1]}",
        profile=header.profile,
        frames=header.frames,
        vertices=header.vertices,
        faces=header.faces,
        groups=[group.frames for group in groups],
        fps=header.fps or None,
        unit=metadata.unit,
        name=metadata.name,
        software=metadata.software,
        bytes=len(data),
        sections=sections,
        decoder_memory=header.memory,
        bits_per_vertex_frame=8.0 * len(data) / pairs,
        motion_bits_per_vertex_frame=8.0 * (len(data) - connectivity) / pairs,
        connectivity_bits_per_vertex=8.0 * connectivity / header.vertices,
        bounds=_present(asked.kg_percent, asked.rmse_edges, asked.largest_fraction),
        errors=_present(met.kg_percent, met.rmse_edges, met.largest_fraction),
    )


def _present(*values: float) -> dict[str, float]:
    names = ("kg", "rmse", "max_error")
    return {name: value for name, value in zip(names, values, strict=True) if math.isfinite(value)}

"""The headers of NRRD files, attached and detached, read without numerics.

References
----------
"Definition of NRRD File Format", teem.sourceforge.net/nrrd/format.html; section numbers below refer to it.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Final

from shapery_contracts.formats.model import (
    AssetKind,
    Details,
    FileFormat,
    check_data_fits,
    corrupt,
    finite_spacing,
    unsupported,
    voxel_count,
)

MAX_HEADER: Final = 1 << 20
MAGIC: Final = b"NRRD000"

_TYPES: Final = {
    name: (dtype, size)
    for dtype, size, names in (
        ("int8", 1, "signed char|int8|int8_t"),
        ("uint8", 1, "uchar|unsigned char|uint8|uint8_t"),
        ("int16", 2, "short|short int|signed short|signed short int|int16|int16_t"),
        ("uint16", 2, "ushort|unsigned short|unsigned short int|uint16|uint16_t"),
        ("int32", 4, "int|signed int|int32|int32_t"),
        ("uint32", 4, "uint|unsigned int|uint32|uint32_t"),
        ("int64", 8, "longlong|long long|long long int|signed long long|signed long long int|int64|int64_t"),
        ("uint64", 8, "ulonglong|unsigned long long|unsigned long long int|uint64|uint64_t"),
        ("float32", 4, "float"),
        ("float64", 8, "double"),
    )
    for name in names.split("|")
}
_ENCODINGS: Final = {
    "raw": "raw",
    "txt": "text",
    "text": "text",
    "ascii": "text",
    "hex": "hex",
    "gz": "gzip",
    "gzip": "gzip",
    "bz2": "bzip2",
    "bzip2": "bzip2",
}
_UNITS_MM: Final = {
    "mm": 1.0,
    "millimeter": 1.0,
    "millimeters": 1.0,
    "millimetre": 1.0,
    "cm": 10.0,
    "m": 1000.0,
    "um": 0.001,
    "µm": 0.001,
    "micron": 0.001,
    "microns": 0.001,
    "micrometer": 0.001,
}

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class NrrdHeader:
    """What a header says. Axes are in the file's order, the fastest first."""

    sizes: tuple[int, ...]
    dtype: str
    item_size: int
    encoding: str
    """``raw``, ``text``, ``hex``, ``gzip`` or ``bzip2``."""
    big_endian: bool
    kinds: tuple[str, ...]
    """Per axis, lower case; empty strings where the header says nothing."""
    spacings: tuple[float, ...]
    """Per axis; NaN where the header says nothing."""
    space: str
    """``RAS``, ``LAS``, ``LPS``, another name as it stands there, or empty."""
    directions: tuple[Vector | None, ...]
    """Per axis, in the file's unit; None for axes that are not of space."""
    origin: Vector | None
    unit_mm: float
    unit_known: bool
    data_file: str
    """Name of the detached data file; empty if the data follow the header."""
    byte_skip: int
    line_skip: int
    header_bytes: int
    """Where attached data begin."""

    @property
    def data_bytes(self) -> int:
        """Bytes of data after decoding."""
        return voxel_count(self.sizes) * self.item_size

    @property
    def space_axes(self) -> tuple[int, ...]:
        """The axes of the file that are axes of space."""
        if any(d is not None for d in self.directions):
            return tuple(axis for axis, d in enumerate(self.directions) if d is not None)
        if any(kind in ("domain", "space") for kind in self.kinds):
            return tuple(axis for axis, kind in enumerate(self.kinds) if kind in ("domain", "space"))
        other = [axis for axis, kind in enumerate(self.kinds) if kind and kind not in ("domain", "space", "none")]
        rest = [axis for axis in range(len(self.sizes)) if axis not in other]
        return tuple(rest[:3])


def parse_header(head: bytes) -> NrrdHeader:
    """Read the header at the start of `head`, which holds the first bytes of a file, at most `MAX_HEADER`.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` or ``unsupported_format``.
    """
    fields, header_bytes = _fields(head)
    sizes = _integers(fields, "sizes")
    dimension = _integers(fields, "dimension")
    if len(dimension) != 1 or dimension[0] != len(sizes) or not 1 <= len(sizes) <= 16:
        raise corrupt(f"The NRRD header gives dimension {fields['dimension']!r} and sizes {fields['sizes']!r}.")
    if min(sizes) < 1:
        raise corrupt(f"The NRRD header claims the size {' × '.join(map(str, sizes))}.")
    kind = fields.get("type", "").lower()
    if kind not in _TYPES:
        raise unsupported(f"The NRRD file holds data of type {kind!r}.", "Convert it to 16-bit integers or floats.")
    encoding = fields.get("encoding", "").lower()
    if encoding not in _ENCODINGS:
        raise unsupported(f"The NRRD data are encoded as {encoding!r}.", "Write the file with raw or gzip encoding.")
    dtype, item_size = _TYPES[kind]
    endian = fields.get("endian", "little").lower()
    if endian not in ("little", "big"):
        raise corrupt(f"The NRRD header gives the byte order {endian!r}.")
    axes = len(sizes)
    directions, space, origin = _orientation(fields, axes)
    unit_mm, unit_known = _unit(fields)
    return NrrdHeader(
        sizes=sizes,
        dtype=dtype,
        item_size=item_size,
        encoding=_ENCODINGS[encoding],
        big_endian=endian == "big",
        kinds=_per_axis(fields.get("kinds", "").lower().replace("???", "none").split(), axes, "kinds"),
        spacings=tuple(
            _number(word) for word in _per_axis(fields.get("spacings", "").split(), axes, "spacings", missing="nan")
        ),
        space=space,
        directions=directions,
        origin=origin,
        unit_mm=unit_mm,
        unit_known=unit_known,
        data_file=fields.get("data file", ""),
        byte_skip=_skip(fields, "byte skip"),
        line_skip=_skip(fields, "line skip"),
        header_bytes=header_bytes,
    )


def _fields(head: bytes) -> tuple[dict[str, str], int]:
    end = re.search(rb"\r?\n\r?\n", head)
    if end is None and len(head) >= MAX_HEADER:
        raise corrupt(f"The NRRD header does not end within {MAX_HEADER} bytes.")
    # A detached header may end with the file instead of an empty line.
    text = (head if end is None else head[: end.start()]).decode("latin-1")
    lines = text.splitlines()
    if not re.fullmatch(r"NRRD000[1-6]", lines[0].strip() if lines else ""):
        raise unsupported(f"The NRRD file has the unknown version {lines[0][:12]!r}.", "Write it as version 5.")
    fields: dict[str, str] = {}
    for line in lines[1:]:
        if line.startswith("#") or ":=" in line:
            continue
        key, colon, value = line.partition(":")
        if not colon:
            raise corrupt(f"The NRRD header has the line {line[:60]!r}, which is no field.")
        name = key.strip().lower()
        name = {"datafile": "data file", "byteskip": "byte skip", "lineskip": "line skip"}.get(name, name)
        if name in fields:
            raise corrupt(f"The NRRD header gives {name!r} twice.")
        fields[name] = value.strip()
    if end is None and "data file" not in fields:
        raise corrupt("The NRRD file is cut off inside its header.")
    for needed in ("dimension", "sizes", "type", "encoding"):
        if needed not in fields:
            raise corrupt(f"The NRRD header lacks the field {needed!r}.")
    return fields, len(head) if end is None else end.end()


def _integers(fields: dict[str, str], name: str) -> tuple[int, ...]:
    words = fields[name].split()
    if not words or not all(re.fullmatch(r"[0-9]{1,18}", word) for word in words):
        raise corrupt(f"The NRRD header gives {name!r} as {fields[name][:60]!r}, not as numbers.")
    return tuple(int(word) for word in words)


def _skip(fields: dict[str, str], name: str) -> int:
    word = fields.get(name, "0")
    if not re.fullmatch(r"-?[0-9]{1,12}", word) or (int(word) < 0 and (name, word) != ("byte skip", "-1")):
        raise corrupt(f"The NRRD header gives {name!r} as {word[:60]!r}.")
    return int(word)


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise corrupt(f"The NRRD header has {word[:40]!r} where a number belongs.") from None


def _per_axis(words: list[str], axes: int, name: str, missing: str = "") -> tuple[str, ...]:
    if not words:
        return (missing,) * axes
    if len(words) != axes:
        raise corrupt(f"The NRRD header gives {len(words)} {name} for {axes} axes.")
    return tuple(words)


_VECTOR: Final = re.compile(r"\s*(none|\(([^()]*)\))")


def _vectors(text: str) -> list[tuple[float, ...] | None]:
    found: list[tuple[float, ...] | None] = []
    position = 0
    while position < len(text) and (match := _VECTOR.match(text, position)):
        inside = match.group(2)
        found.append(None if inside is None else tuple(_number(word) for word in inside.split(",")))
        position = match.end()
    if text[position:].strip():
        raise corrupt(f"The NRRD header has {text[position : position + 40]!r} where a vector belongs.")
    return found


def _orientation(fields: dict[str, str], axes: int) -> tuple[tuple[Vector | None, ...], str, Vector | None]:
    name = fields.get("space", "").strip()
    short = {
        "right-anterior-superior": "RAS",
        "left-anterior-superior": "LAS",
        "left-posterior-superior": "LPS",
        "ras": "RAS",
        "las": "LAS",
        "lps": "LPS",
    }.get(name.lower(), name)
    given = _vectors(fields.get("space directions", ""))
    origins = _vectors(fields.get("space origin", ""))
    if given and len(given) != axes:
        raise corrupt(f"The NRRD header gives {len(given)} space directions for {axes} axes.")
    vectors = [v for v in (*given, *origins[:1]) if v is not None]
    if any(len(v) != 3 for v in vectors):
        raise unsupported(
            f"The NRRD file lies in a space of {max(len(v) for v in vectors)} dimensions.",
            "Write it with three-dimensional space directions.",
        )
    directions = tuple(None if v is None else (v[0], v[1], v[2]) for v in given) or (None,) * axes
    first = origins[0] if origins else None
    return directions, short, None if first is None else (first[0], first[1], first[2])


def _unit(fields: dict[str, str]) -> tuple[float, bool]:
    units = re.findall(r'"([^"]*)"', fields.get("space units", ""))
    known = [_UNITS_MM.get(unit.strip().lower()) for unit in units]
    if not known or None in known or len(set(known)) != 1:
        return 1.0, not units
    return known[0] or 1.0, True


def recognise(head: bytes, size: int, *, detached: int | None = None) -> FileFormat:
    """Tell what the header at the start of `head` says.

    Parameters
    ----------
    head
        The first bytes of the file.
    size
        Bytes of the file.
    detached
        Bytes of the data file where one was found beside the header.
    """
    header = parse_header(head)
    if header.data_file and detached is None:
        raise unsupported(
            f"The file is a detached NRRD header; its data stand in {header.data_file[:80]!r}.",
            "Send a zip with both, or a single .nrrd file.",
        )
    room = size - header.header_bytes if detached is None else detached
    if header.encoding in ("raw", "gzip", "hex"):
        claimed = header.data_bytes * (2 if header.encoding == "hex" else 1)
        check_data_fits("NRRD", claimed, room, deflated=header.encoding == "gzip")
    elif header.encoding == "text":
        check_data_fits("NRRD", 2 * voxel_count(header.sizes) - 1, room)
    spacing = [
        math.hypot(*direction) if direction is not None else value
        for direction, value in zip(header.directions, header.spacings, strict=True)
    ]
    details: Details = {
        "shape": list(header.sizes),
        "spacing": finite_spacing([v * header.unit_mm for v in spacing]),
        "dtype": header.dtype,
    }
    return FileFormat(
        kind=AssetKind.VOLUME,
        format="nrrd",
        media_type="application/x-nrrd" if detached is None else "application/zip",
        extension=".nrrd" if detached is None else ".zip",
        details=details,
    )

"""The headers of MetaImage files (MHA, and MHD with a raw file), read without numerics.

References
----------
"MetaIO/Documentation" of the Insight Toolkit, section "Tags of MetaImage"; where the documentation is silent, what
ITK's reader does decides.
"""

from __future__ import annotations

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

MAX_HEADER: Final = 1 << 16

_TYPES: Final = {
    "MET_CHAR": ("int8", 1),
    "MET_UCHAR": ("uint8", 1),
    "MET_SHORT": ("int16", 2),
    "MET_USHORT": ("uint16", 2),
    "MET_INT": ("int32", 4),
    "MET_UINT": ("uint32", 4),
    "MET_LONG_LONG": ("int64", 8),
    "MET_ULONG_LONG": ("uint64", 8),
    "MET_FLOAT": ("float32", 4),
    "MET_DOUBLE": ("float64", 8),
}


@dataclass(frozen=True, slots=True)
class MetaImageHeader:
    """What a header says. Axes are in the file's order, the fastest first."""

    sizes: tuple[int, ...]
    channels: int
    dtype: str
    item_size: int
    big_endian: bool
    compressed: bool
    spacing: tuple[float, ...]
    directions: tuple[tuple[float, ...], ...]
    """Row k is the direction of axis k, LPS."""
    origin: tuple[float, ...]
    """Centre of the first voxel, LPS mm."""
    data_file: str
    """Name of the data file; empty if the data follow the header."""
    skip: int
    """Bytes before the data in their file; -1: the data are its last bytes."""
    header_bytes: int
    oriented: bool
    """Whether the header says how the axes lie."""

    @property
    def data_bytes(self) -> int:
        """Bytes of data after decompression."""
        return voxel_count(self.sizes) * self.channels * self.item_size


_LINE: Final = re.compile(rb"[ \t]*([A-Za-z]+)[ \t]*[=:][ \t]*([^\r\n]*)\r?\n")


def looks_like_metaimage(head: bytes) -> bool:
    """Tell whether the first bytes are those of a MetaImage header."""
    return re.match(rb"\s*(ObjectType\s*=\s*\w|NDims\s*=\s*[0-9])", head) is not None


def parse_header(head: bytes) -> MetaImageHeader:
    """Read the header at the start of `head`, which holds the first bytes of a file, at most `MAX_HEADER`.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` or ``unsupported_format``.
    """
    fields, header_bytes = _fields(head)
    sizes = tuple(_integer(word, "DimSize") for word in fields["dimsize"].split())
    axes = _integer(fields.get("ndims", str(len(sizes))), "NDims")
    if axes != len(sizes) or not 1 <= axes <= 10:
        raise corrupt(f"The MetaImage header gives NDims = {axes} and DimSize = {fields['dimsize']}.")
    if min(sizes) < 1:
        raise corrupt(f"The MetaImage header claims the size {' × '.join(map(str, sizes))}.")
    kind = fields.get("elementtype", "").upper().removesuffix("_ARRAY")
    if kind not in _TYPES:
        raise unsupported(
            f"The MetaImage file holds elements of type {fields.get('elementtype', '')!r}.",
            "Convert it to 16-bit integers or floats.",
        )
    if fields.get("binarydata", "true").lower() not in ("true", "1"):
        raise unsupported("The MetaImage file holds its voxels as text.", "Write it with BinaryData = True.")
    channels = _integer(fields.get("elementnumberofchannels", "1"), "ElementNumberOfChannels")
    if not 1 <= channels <= 1 << 20:
        raise corrupt(f"The MetaImage header claims {channels} channels.")
    msb = fields.get("binarydatabyteordermsb", fields.get("elementbyteordermsb", "false"))
    matrix = fields.get("transformmatrix", fields.get("rotation", fields.get("orientation", "")))
    numbers = _numbers(matrix, axes * axes, "TransformMatrix", None)
    identity = tuple(tuple(float(row == column) for column in range(axes)) for row in range(axes))
    rows = tuple(numbers[row * axes : (row + 1) * axes] for row in range(axes)) if numbers else identity
    origin = fields.get("offset", fields.get("position", fields.get("origin", "")))
    spacing = fields.get("elementspacing", fields.get("elementsize", ""))
    dtype, item_size = _TYPES[kind]
    data_file = fields["elementdatafile"]
    return MetaImageHeader(
        sizes=sizes,
        channels=channels,
        dtype=dtype,
        item_size=item_size,
        big_endian=msb.lower() in ("true", "1"),
        compressed=fields.get("compresseddata", "false").lower() in ("true", "1"),
        spacing=_numbers(spacing, axes, "ElementSpacing", 1.0),
        directions=rows,
        origin=_numbers(origin, axes, "Offset", 0.0),
        data_file="" if data_file.upper() == "LOCAL" else data_file,
        skip=_integer(fields.get("headersize", "0"), "HeaderSize", least=-1),
        header_bytes=header_bytes,
        oriented=bool(numbers),
    )


def _fields(head: bytes) -> tuple[dict[str, str], int]:
    """Return the fields up to ``ElementDataFile``, after which the data begin."""
    fields: dict[str, str] = {}
    position = 0
    while True:
        match = _LINE.match(head, position)
        if match is None:
            # Only the last line of a detached header may lack its line break.
            last = re.match(rb"[ \t]*ElementDataFile[ \t]*=[ \t]*([^\r\n]*)$", head[position:])
            if last is None:
                line = head[position : position + 60].split(b"\n")[0].decode("latin-1")
                raise corrupt(f"The MetaImage header breaks off at {line!r}.")
            fields["elementdatafile"] = last.group(1).decode("latin-1").strip()
            position = len(head)
            break
        key = match.group(1).decode("ascii").lower()
        fields[key] = match.group(2).decode("latin-1").strip()
        position = match.end()
        if key == "elementdatafile":
            break
    if fields.get("objecttype", "Image").lower() != "image":
        raise unsupported(f"The MetaIO file holds a {fields['objecttype'][:40]}, not an image.", "Send an image.")
    if "dimsize" not in fields:
        raise corrupt("The MetaImage header lacks DimSize.")
    if not fields["elementdatafile"]:
        raise corrupt("The MetaImage header names no data file.")
    return fields, position


def _integer(word: str, name: str, least: int = 0) -> int:
    if not re.fullmatch(r"-?[0-9]{1,18}", word) or int(word) < least:
        raise corrupt(f"The MetaImage header gives {name} = {word[:40]!r}.")
    return int(word)


def _numbers(text: str, count: int, name: str, default: float | None) -> tuple[float, ...]:
    words = text.split()
    if not words:
        return () if default is None else (default,) * count
    try:
        values = tuple(float(word) for word in words)
    except ValueError:
        values = ()
    if len(values) != count:
        raise corrupt(f"The MetaImage header gives {name} = {text[:60]!r}, not {count} numbers.")
    return values


def check_data_file(header: MetaImageHeader) -> None:
    """Refuse data in several files.

    Raises
    ------
    InvalidInput
        ``unsupported_format``.
    """
    if header.data_file.split()[0:1] == ["LIST"] or "%" in header.data_file:
        raise unsupported(
            "The MetaImage header refers to one data file per slice.", "Write the volume as a single .mha file."
        )


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
    check_data_file(header)
    if header.data_file and detached is None:
        raise unsupported(
            f"The file is a MetaImage header; its data stand in {header.data_file[:80]!r}.",
            "Send a zip with both, or a single .mha file.",
        )
    room = size - header.header_bytes if detached is None else detached - max(header.skip, 0)
    check_data_fits("MetaImage", header.data_bytes, max(room, 0), deflated=header.compressed)
    shape = list(header.sizes) + ([header.channels] if header.channels > 1 else [])
    details: Details = {"shape": shape, "spacing": finite_spacing(header.spacing), "dtype": header.dtype}
    return FileFormat(
        kind=AssetKind.VOLUME,
        format="metaimage",
        media_type="application/x-metaimage" if detached is None else "application/zip",
        extension=".mha" if detached is None else ".zip",
        details=details,
    )

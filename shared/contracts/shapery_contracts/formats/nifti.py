"""The headers of NIfTI-1 and NIfTI-2 files, read without numerics.

References
----------
The field offsets follow ``nifti1.h`` (348 bytes) and ``nifti2.h`` (540 bytes) of the NIfTI Data Format Working Group.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

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

HEADER_BYTES: Final = 540
"""Bytes from the start of a file that decide; NIfTI-1 needs 348 of them."""

MAX_DATA_OFFSET: Final = 256 << 20
"""Extensions stand between header and data; nobody writes more of them than this."""

Storage = Literal["real", "complex", "rgb", "rgba"]


@dataclass(frozen=True, slots=True)
class NiftiType:
    """One data type: its name as NumPy spells it, bytes per voxel, and what a voxel is."""

    name: str
    size: int
    storage: Storage = "real"


TYPES: Final = MappingProxyType(
    {
        2: NiftiType("uint8", 1),
        4: NiftiType("int16", 2),
        8: NiftiType("int32", 4),
        16: NiftiType("float32", 4),
        32: NiftiType("complex64", 8, "complex"),
        64: NiftiType("float64", 8),
        128: NiftiType("uint8", 3, "rgb"),
        256: NiftiType("int8", 1),
        512: NiftiType("uint16", 2),
        768: NiftiType("uint32", 4),
        1024: NiftiType("int64", 8),
        1280: NiftiType("uint64", 8),
        1792: NiftiType("complex128", 16, "complex"),
        2304: NiftiType("uint8", 4, "rgba"),
    }
)
_UNREAD_TYPES: Final = {1: "single bits", 1536: "128-bit floats", 2048: "256-bit complex numbers"}

_UNIT_MM: Final = {0: 1.0, 1: 1000.0, 2: 1.0, 3: 0.001}


@dataclass(frozen=True, slots=True)
class NiftiHeader:
    """The fields of a header that say what the data is and where it lies, as they stand in the file."""

    version: Literal[1, 2]
    byte_order: Literal["<", ">"]
    shape: tuple[int, ...]
    """At least three axes; further ones only if they are longer than 1."""
    type: NiftiType
    pixdim: tuple[float, ...]
    """Eight numbers; the first is the handedness of the quaternion's frame."""
    data_offset: int
    slope: float
    intercept: float
    unit_mm: float
    """Millimetres in the file's unit of length."""
    unit_known: bool
    intent: int
    qform_code: int
    sform_code: int
    quaternion: tuple[float, float, float]
    offset: tuple[float, float, float]
    rows: tuple[tuple[float, float, float, float], ...]
    """The three rows of the sform."""

    @property
    def data_bytes(self) -> int:
        """Bytes of voxel data, as the header claims."""
        return voxel_count(self.shape) * self.type.size

    @property
    def scaled(self) -> bool:
        """Whether voxels are to be scaled: a slope of 0 or one that is not finite means that they are not."""
        return (
            math.isfinite(self.slope)
            and self.slope != 0.0
            and math.isfinite(self.intercept)
            and (self.slope, self.intercept) != (1.0, 0.0)
        )


def looks_like_nifti(head: bytes) -> bool:
    """Tell whether the first bytes are those of a NIfTI or Analyze header."""
    return len(head) >= 348 and (_order(head, 348) is not None or _order(head, 540) is not None)


def _order(head: bytes, size: int) -> Literal["<", ">"] | None:
    if head[:4] == size.to_bytes(4, "little"):
        return "<"
    return ">" if head[:4] == size.to_bytes(4, "big") else None


def parse_header(head: bytes) -> NiftiHeader:
    """Read a header from the first bytes of a file.

    Raises
    ------
    InvalidInput
        ``corrupt_file``, ``unsupported_format`` or ``unknown_format``.
    """
    if len(head) >= 540 and (order := _order(head, 540)) is not None:
        return _parse_nifti2(head, order)
    if len(head) >= 348 and (order := _order(head, 348)) is not None:
        return _parse_nifti1(head, order)
    raise corrupt(f"The NIfTI header is cut off after {len(head)} bytes.")


def _parse_nifti1(head: bytes, order: Literal["<", ">"]) -> NiftiHeader:
    magic = head[344:348]
    if magic == b"ni1\0":
        raise unsupported(
            "The file is the header of a NIfTI pair (.hdr and .img).",
            "Convert the pair to a single .nii or .nii.gz file.",
        )
    if magic != b"n+1\0":
        raise unsupported(
            "The file looks like an Analyze 7.5 header, which does not say left from right.",
            "Convert header and image to a single .nii or .nii.gz file.",
        )
    dim = struct.unpack_from(order + "8h", head, 40)
    intent, datatype = struct.unpack_from(order + "2h", head, 68)
    pixdim = struct.unpack_from(order + "8f", head, 76)
    offset, slope, intercept = struct.unpack_from(order + "3f", head, 108)
    qform, sform = struct.unpack_from(order + "2h", head, 252)
    numbers = struct.unpack_from(order + "18f", head, 256)
    return _build(1, order, dim, datatype, pixdim, offset, slope, intercept, head[123], intent, qform, sform, numbers)


def _parse_nifti2(head: bytes, order: Literal["<", ">"]) -> NiftiHeader:
    magic = head[4:12]
    if magic[:4] == b"ni2\0":
        raise unsupported(
            "The file is the header of a NIfTI-2 pair (.hdr and .img).",
            "Convert the pair to a single .nii or .nii.gz file.",
        )
    if magic[:4] != b"n+2\0":
        raise corrupt("The file begins like a NIfTI-2 file and lacks the mark of one.")
    if magic[4:] != b"\r\n\x1a\n":
        raise corrupt("The NIfTI-2 file was changed by a transfer in text mode.", "Transfer it again in binary mode.")
    (datatype,) = struct.unpack_from(order + "h", head, 12)
    dim = struct.unpack_from(order + "8q", head, 16)
    pixdim = struct.unpack_from(order + "8d", head, 104)
    (offset,) = struct.unpack_from(order + "q", head, 168)
    slope, intercept = struct.unpack_from(order + "2d", head, 176)
    qform, sform = struct.unpack_from(order + "2i", head, 344)
    numbers = struct.unpack_from(order + "18d", head, 352)
    units, intent = struct.unpack_from(order + "2i", head, 500)
    return _build(2, order, dim, datatype, pixdim, offset, slope, intercept, units, intent, qform, sform, numbers)


def _build(
    version: Literal[1, 2],
    order: Literal["<", ">"],
    dim: tuple[int, ...],
    datatype: int,
    pixdim: tuple[float, ...],
    offset: float,
    slope: float,
    intercept: float,
    units: int,
    intent: int,
    qform_code: int,
    sform_code: int,
    numbers: tuple[float, ...],
) -> NiftiHeader:
    if not 1 <= dim[0] <= 7:
        raise corrupt(f"The NIfTI header claims {dim[0]} dimensions; a file has 1 to 7.")
    sizes = list(dim[1 : dim[0] + 1])
    # A further axis of length 0 is how some programs write that it is not there.
    sizes[3:] = [max(n, 1) if n == 0 else n for n in sizes[3:]]
    if min(sizes) < 1:
        raise corrupt(f"The NIfTI header claims the size {' × '.join(map(str, sizes))}.")
    sizes += [1] * (3 - len(sizes))
    while len(sizes) > 3 and sizes[-1] == 1:
        sizes.pop()
    if datatype in _UNREAD_TYPES:
        raise unsupported(
            f"The NIfTI file holds {_UNREAD_TYPES[datatype]}.", "Convert it to 16-bit integers or floats."
        )
    if datatype not in TYPES:
        raise corrupt(f"The NIfTI header names data type {datatype}, which does not exist.")
    least = 352 if version == 1 else 544
    if not math.isfinite(offset) or not 0 <= offset <= MAX_DATA_OFFSET or offset != int(offset):
        raise corrupt(f"The NIfTI header claims that its data begin at byte {offset:g}.")
    if 0 < offset < least - 4:
        raise corrupt(f"The NIfTI header claims that its data begin at byte {offset:g}, inside the header.")
    unit = units & 0x07
    return NiftiHeader(
        version=version,
        byte_order=order,
        shape=tuple(sizes),
        type=TYPES[datatype],
        pixdim=pixdim,
        data_offset=int(offset) or least,
        slope=slope,
        intercept=intercept,
        unit_mm=_UNIT_MM.get(unit, 1.0),
        unit_known=unit in (1, 2, 3),
        intent=intent,
        qform_code=qform_code,
        sform_code=sform_code,
        quaternion=(numbers[0], numbers[1], numbers[2]),
        offset=(numbers[3], numbers[4], numbers[5]),
        rows=tuple((numbers[k], numbers[k + 1], numbers[k + 2], numbers[k + 3]) for k in (6, 10, 14)),
    )


def recognise(head: bytes, size: int, *, gzipped: bool = False) -> FileFormat:
    """Tell what the NIfTI header at the start of `head` says.

    Parameters
    ----------
    head
        The first bytes, unpacked if the file is gzipped.
    size
        Bytes of the file as it is.
    gzipped
        Whether it is gzipped.
    """
    header = parse_header(head)
    check_data_fits("NIfTI", header.data_offset + header.data_bytes, size, deflated=gzipped)
    spacing = [v * header.unit_mm for v in header.pixdim[1:4]]
    details: Details = {
        "shape": list(header.shape),
        "spacing": finite_spacing(spacing),
        "dtype": header.type.name if header.type.storage == "real" else header.type.storage,
    }
    return FileFormat(
        kind=AssetKind.VOLUME,
        format=f"nifti{header.version}",
        media_type="application/gzip" if gzipped else "application/x-nifti",
        extension=".nii.gz" if gzipped else ".nii",
        details=details,
    )

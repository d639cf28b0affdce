"""NIfTI-1 and NIfTI-2, plain and gzipped.

Orientation
-----------
The sform is used where its code is set, else the qform. Where neither is set the header has only a spacing: then the
volume is taken as nibabel and FSL take it (x grows to the left, the centre is the origin), and a warning says that
left and right are not known. A sheared sform is kept exactly.
"""

from __future__ import annotations

import contextlib
import gzip
import math
import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final, cast

import numpy as np

from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats import gzip_head
from shapery_contracts.formats.nifti import HEADER_BYTES, TYPES, NiftiHeader, parse_header
from shapery_geometry.volume import FloatArray, Volume, check_affine
from shapery_geometry.volume_io.source import Array, VolumeHeader, native, scaled, take_component
from shapery_geometry.volume_io.streams import ByteSource, Inflater, check_end, read_exactly, skip

_CODES: Final = {t.name: code for code, t in TYPES.items() if t.storage == "real"}


class NiftiSource:
    """An open NIfTI file."""

    def __init__(self, stream: BinaryIO, *, gzipped: bool) -> None:
        self._stream = stream
        self._gzipped = gzipped
        stream.seek(0)
        head = stream.read(1 << 16 if gzipped else HEADER_BYTES)
        self._nifti = parse_header(gzip_head(head, HEADER_BYTES) if gzipped else head)
        affine, warnings = affine_of(self._nifti)
        shape = self._nifti.shape
        x, y, z = np.sqrt((affine[:3, :3] ** 2).sum(axis=0)).tolist()
        self.header = VolumeHeader(
            shape=(shape[0], shape[1], shape[2]),
            spacing=(x, y, z),
            dtype=self._nifti.type.name,
            affine=affine,
            format=f"nifti{self._nifti.version}",
            warnings=tuple(warnings),
            frames=math.prod(shape[3:]),
            storage=self._nifti.type.storage,
        )

    @property
    def _frame_bytes(self) -> int:
        return math.prod(self.header.shape) * self._nifti.type.size

    def bytes_needed(self, frame: int) -> int:
        """Return how many bytes must be read or decompressed for `frame`."""
        return self._frame_bytes * (frame + 1 if self._gzipped else 1)

    def load(self, frame: int, component: str | None) -> Array:
        """Return the voxels (I, J, K) of `frame`."""
        nifti = self._nifti
        begin = nifti.data_offset + frame * self._frame_bytes
        source: ByteSource
        if self._gzipped:
            self._stream.seek(0)
            source = Inflater(self._stream)
            skip(source, begin)
        else:
            self._stream.seek(begin)
            source = self._stream
        raw = read_exactly(source, self._frame_bytes)
        if self._gzipped and frame == self.header.frames - 1:
            check_end(source)
        i, j, k = self.header.shape
        dtype = np.dtype(nifti.type.name).newbyteorder(nifti.byte_order)
        if nifti.type.storage in ("rgb", "rgba"):
            colours = raw.reshape(k, j, i, nifti.type.size)
            return np.ascontiguousarray(take_component(colours, nifti.type.storage, component).T)
        values = native(raw.view(dtype).reshape(k, j, i))
        if nifti.scaled and nifti.type.storage == "complex":
            values = values * nifti.slope + nifti.intercept
        values = take_component(values, nifti.type.storage, component)
        if nifti.scaled and nifti.type.storage == "real":
            values = scaled(values, nifti.slope, nifti.intercept)
        return np.ascontiguousarray(values.T)


def affine_of(header: NiftiHeader) -> tuple[FloatArray, list[str]]:
    """Return the affine to RAS mm and what is doubtful about it.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` if no orientation in the header can be used.
    """
    warnings: list[str] = []
    if header.unit_known and header.unit_mm != 1.0:
        warnings.append(f"The file's unit of length is {header.unit_mm:g} mm; all lengths were converted to mm.")
    sform = _sform(header) if header.sform_code > 0 else None
    qform = _qform(header) if header.qform_code > 0 else None
    usable: list[FloatArray] = []
    refusal: InvalidInput | None = None
    for matrix in (sform, qform):
        if matrix is not None:
            try:
                usable.append(check_affine(matrix))
            except InvalidInput as error:
                refusal = refusal or error
                warnings.append(f"One of the file's two orientations cannot be used. {error.message}")
    if refusal is not None and not usable:
        raise refusal
    if len(usable) == 2:
        corners = np.array(list(np.ndindex(2, 2, 2))) * (np.array(header.shape[:3]) - 1)
        moved = corners @ (usable[0] - usable[1])[:3, :3].T + (usable[0] - usable[1])[:3, 3]
        distance = float(np.sqrt((moved**2).sum(axis=1)).max())
        if distance > 0.1 * float(np.sqrt((usable[0][:3, :3] ** 2).sum(axis=0)).min()):
            warnings.append(
                f"The file's two orientations (sform and qform) differ by up to {distance:.2f} mm; the sform is used."
            )
    if usable:
        return usable[0], warnings
    warnings.append(
        "The file does not say how the volume lies (qform and sform code are 0): only its spacing is known, and left "
        "and right may be swapped."
    )
    spacing = np.abs(header.pixdim[1:4]) * header.unit_mm
    base = np.diag([-spacing[0], spacing[1], spacing[2], 1.0])
    base[:3, 3] = -base[:3, :3] @ ((np.array(header.shape[:3]) - 1) / 2)
    return check_affine(base), warnings


def _sform(header: NiftiHeader) -> FloatArray:
    matrix = np.eye(4)
    with np.errstate(all="ignore"):
        matrix[:3] = np.array(header.rows, dtype=np.float64) * header.unit_mm
    return matrix


def _qform(header: NiftiHeader) -> FloatArray:
    """Return the rotation of the quaternion (a, b, c, d) with a ≥ 0, method 2 of the NIfTI-1 standard."""
    b, c, d = header.quaternion
    matrix = np.full((4, 4), np.nan)
    matrix[3] = (0.0, 0.0, 0.0, 1.0)
    square = b * b + c * c + d * d
    if not math.isfinite(square) or square > 1.0 + 1e-3:
        return matrix
    if square > 1.0 - 1e-7:
        # A rotation by 180°, up to rounding.
        norm = math.sqrt(square)
        a, b, c, d = 0.0, b / norm, c / norm, d / norm
    else:
        a = math.sqrt(1.0 - square)
    rotation = np.array(
        [
            [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c],
        ]
    )
    spacing = np.abs(header.pixdim[1:4]) * header.unit_mm
    if header.pixdim[0] < 0:
        spacing[2] = -spacing[2]
    matrix[:3, :3] = rotation * spacing
    matrix[:3, 3] = np.array(header.offset) * header.unit_mm
    return matrix


def write_nifti(volume: Volume, path: Path | str, *, description: str = "Shapery") -> None:
    """Write a volume as a NIfTI file, gzipped where the name ends in ``.gz``.

    The same volume gives the same bytes. Labels keep their integer type (bool becomes uint8), float16 becomes float32.
    The affine goes into the sform, and into the qform where a quaternion can hold it: a sheared one cannot. NIfTI-1
    holds affines as float32; NIfTI-2 is written only where an axis has more than 32767 voxels.

    Parameters
    ----------
    volume
        What to write.
    path
        Ends in ``.nii`` or ``.nii.gz``.
    description
        Text in the header, at most 79 bytes of ASCII.

    Raises
    ------
    ValueError
        If `path` has another ending.
    """
    path = Path(path)
    if not path.name.endswith((".nii", ".nii.gz")):
        raise ValueError(f"a NIfTI file ends in .nii or .nii.gz, not {path.name!r}")
    data = volume.data
    if data.dtype == np.bool_:
        data = data.view(np.uint8)
    elif data.dtype == np.float16:
        data = data.astype(np.float32)
    if data.dtype.name not in _CODES:
        raise InvalidInput("invalid_volume", f"NIfTI has no type for {data.dtype}.", "Convert it to float32 or int16.")
    little = data.dtype.newbyteorder("<")
    with _opened(path) as stream:
        stream.write(_header_bytes(volume, data.dtype, description.encode("ascii", "replace")[:79]))
        for k in range(volume.shape[2]):
            stream.write(data[:, :, k].astype(little, copy=False).tobytes(order="F"))


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    """Open a file that appears under its name only when it is complete."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with contextlib.ExitStack() as stack:
            stream = stack.enter_context(partial.open("wb"))
            if path.name.endswith(".gz"):
                # Neither name nor time go into the gzip header: equal volumes give equal files.
                packed = gzip.GzipFile(filename="", mode="wb", compresslevel=6, fileobj=stream, mtime=0)
                yield cast("BinaryIO", stack.enter_context(packed))
            else:
                yield stream
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def _header_bytes(volume: Volume, dtype: np.dtype[np.generic], description: bytes) -> bytes:
    """Return the header and the four bytes that say that no extension follows."""
    affine = volume.affine
    quaternion, qfac = _quaternion(affine)
    qform_code = 0 if quaternion is None else 2
    dim = (3, *volume.shape, 1, 1, 1, 1)
    pixdim = (qfac, *volume.spacing, 1.0, 1.0, 1.0, 1.0)
    numbers = (*(quaternion or (0.0, 0.0, 0.0)), *affine[:3, 3].tolist(), *affine[:3].ravel().tolist())
    code, bits = _CODES[dtype.name], dtype.itemsize * 8
    if max(volume.shape) > 32767:
        wide = bytearray(544)
        struct.pack_into("<i8s2h8q", wide, 0, 540, b"n+2\0\r\n\x1a\n", code, bits, *dim)
        struct.pack_into("<8d", wide, 104, *pixdim)
        struct.pack_into("<q2d", wide, 168, 544, 1.0, 0.0)
        struct.pack_into("<80s", wide, 240, description)
        struct.pack_into("<2i18d", wide, 344, qform_code, 2, *numbers)
        struct.pack_into("<i", wide, 500, 2)
        return bytes(wide)
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<b", head, 38, ord("r"))
    struct.pack_into("<8h", head, 40, *dim)
    struct.pack_into("<2h", head, 70, code, bits)
    struct.pack_into("<8f", head, 76, *pixdim)
    struct.pack_into("<3f", head, 108, 352.0, 1.0, 0.0)
    struct.pack_into("<b", head, 123, 2)
    struct.pack_into("<80s", head, 148, description)
    struct.pack_into("<2h18f", head, 252, qform_code, 2, *numbers)
    struct.pack_into("<4s", head, 344, b"n+1\0")
    return bytes(head)


def _quaternion(affine: FloatArray) -> tuple[tuple[float, float, float] | None, float]:
    """Return (b, c, d) of the rotation in `affine` and its handedness; None where it is sheared."""
    axes = affine[:3, :3] / np.sqrt((affine[:3, :3] ** 2).sum(axis=0))
    qfac = 1.0 if np.linalg.det(axes) > 0 else -1.0
    # Rounded to float32 the axes of a rotation are orthogonal to about 1e-6.
    if not np.allclose(axes.T @ axes, np.eye(3), rtol=0.0, atol=1e-5):
        return None, qfac
    axes[:, 2] *= qfac
    # The largest eigenvector of this symmetric matrix is the quaternion (Bar-Itzhack 2000); it is stable at 180°.
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = axes
    symmetric = np.array(
        [
            [xx - yy - zz, yx + xy, zx + xz, zy - yz],
            [yx + xy, yy - xx - zz, zy + yz, xz - zx],
            [zx + xz, zy + yz, zz - xx - yy, yx - xy],
            [zy - yz, xz - zx, yx - xy, xx + yy + zz],
        ]
    )
    b, c, d, a = np.linalg.eigh(symmetric)[1][:, -1]
    sign = -1.0 if a < 0 else 1.0
    return (float(b * sign), float(c * sign), float(d * sign)), qfac

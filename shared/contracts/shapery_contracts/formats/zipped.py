"""What zip archives hold: a mesh sequence (npz, or a file per frame), a DICOM series, or a header with its data."""

from __future__ import annotations

import ast
import math
import posixpath
import re
from dataclasses import dataclass
from typing import BinaryIO, Final

from shapery_contracts.archives import ArchiveEntry, ArchiveLimits, SafeArchive, open_archive
from shapery_contracts.errors import InvalidInput, UserError
from shapery_contracts.formats import dicom, meshes, metaimage, nifti, nrrd
from shapery_contracts.formats.model import AssetKind, FileFormat, corrupt, unsupported

_SAMPLES: Final = 16
_SAMPLE_BYTES: Final = 1 << 16
_NPY_HEADER: Final = 4096
MESH_SUFFIXES: Final = (".obj", ".ply", ".stl", ".off", ".glb")
_LIKELY: Final = (*MESH_SUFFIXES, ".dcm", ".ima", ".mhd", ".nhdr", "")


@dataclass(frozen=True, slots=True)
class NpyHeader:
    """What the header of one array in an npz file says."""

    dtype: str
    """NumPy's spelling with its byte order: ``<f4``."""
    fortran_order: bool
    shape: tuple[int, ...]
    data_offset: int

    @property
    def data_bytes(self) -> int:
        """Bytes of the array."""
        return math.prod(self.shape) * int(self.dtype[2:])


def parse_npy_header(head: bytes, name: str) -> NpyHeader:
    """Read the header of the array `name` from its first bytes.

    Raises
    ------
    InvalidInput
        ``corrupt_file``, or ``unsupported_format`` for arrays of anything but numbers.
    """
    if not head.startswith(b"\x93NUMPY") or len(head) < 12 or head[6] not in (1, 2, 3):
        raise corrupt(f"Entry {name!r} of the npz file is no array.")
    start = 10 if head[6] == 1 else 12
    end = start + int.from_bytes(head[8:start], "little")
    if end > len(head):
        raise corrupt(f"The header of the array {name!r} in the npz file is cut off.")
    try:
        header = ast.literal_eval(head[start:end].decode("latin-1").strip())
        dtype, fortran, shape = header["descr"], header["fortran_order"], header["shape"]
    except (ValueError, SyntaxError, TypeError, KeyError, MemoryError, RecursionError) as error:
        raise corrupt(f"The header of the array {name!r} in the npz file is damaged.") from error
    if not isinstance(dtype, str) or not re.fullmatch(r"[<>|=][bifu][1248]", dtype):
        raise unsupported(f"The array {name!r} in the npz file holds no plain numbers.", "Save it as float32 or int32.")
    if not isinstance(shape, tuple) or not all(type(n) is int and 0 <= n < 1 << 48 for n in shape):
        raise corrupt(f"The header of the array {name!r} in the npz file has no valid shape.")
    return NpyHeader(dtype, bool(fortran), shape, end)


def recognise(stream: BinaryIO, limits: ArchiveLimits | None = None) -> FileFormat:
    """Tell what the zip archive in `stream` holds.

    Only the directory and the beginnings of a few entries are read.

    Raises
    ------
    InvalidInput
        ``corrupt_file``, ``unsafe_archive``, ``unsupported_format``, ``unknown_format`` or ``empty_content``.
    LimitExceeded
        ``too_large``.
    """
    archive = open_archive(stream, limits)
    entries = archive.entries
    if not entries:
        raise InvalidInput("empty_content", "The zip archive holds no files.")
    if all(entry.name.endswith(".npy") for entry in entries):
        return _npz(archive)
    found = _sample(archive)
    formats = {f.format for f in found.values()}
    if "dicom" in formats:
        if len(formats) > 1:
            raise unsupported(
                "The zip archive holds DICOM files together with other data.", "Send one archive for each volume."
            )
        details = dict(next(iter(found.values())).details)
        details.pop("shape", None)
        return FileFormat(
            kind=AssetKind.VOLUME,
            format="dicom-zip",
            media_type="application/zip",
            extension=".zip",
            details={**details, "files": len(entries)},
        )
    volumes = [f for f in found.values() if f.kind is AssetKind.VOLUME]
    if len(volumes) == 1 and len(found) == 1:
        return volumes[0]
    if volumes:
        raise unsupported("The zip archive holds several volumes.", "Send them one by one.")
    if found:
        named = sum(entry.name.lower().endswith(MESH_SUFFIXES) for entry in entries)
        return FileFormat(
            kind=AssetKind.SEQUENCE,
            format="mesh-zip",
            media_type="application/zip",
            extension=".zip",
            details={"files": len(entries), "frames": max(named, len(found))},
        )
    raise InvalidInput(
        "unknown_format",
        f"None of the {len(entries)} files in the zip archive is a mesh, a DICOM slice, or a header with its data.",
        "Send a DICOM series, or the meshes of one sequence.",
    )


def _sample(archive: SafeArchive) -> dict[str, FileFormat]:
    """Recognise the beginnings of a few entries, those first whose names promise something.

    The names only choose where to look; what is found there is told from the content.
    """
    entries = sorted(
        archive.entries, key=lambda e: posixpath.splitext(e.name)[1].lower() not in _LIKELY and "." in e.name
    )
    chosen = entries if len(entries) <= _SAMPLES else [*entries[: _SAMPLES // 2], *entries[-_SAMPLES // 2 :]]
    found: dict[str, FileFormat] = {}
    refusal: UserError | None = None
    for entry in chosen:
        if entry.size == 0:
            continue
        head = archive.read(entry.name, _SAMPLE_BYTES)
        try:
            recognised = _entry(archive, entry, head)
        except UserError as error:
            # One slice that is no image, or one damaged mesh, does not decide what the archive is.
            refusal = refusal or error
            continue
        if recognised is not None:
            found[entry.name] = recognised
    if not found and refusal is not None:
        raise refusal
    return found


def _entry(archive: SafeArchive, entry: ArchiveEntry, head: bytes) -> FileFormat | None:
    if dicom.looks_like_dicom(head):
        return dicom.recognise(head, entry.size)
    if nifti.looks_like_nifti(head) or head.startswith(b"\x1f\x8b"):
        raise unsupported(
            f"The zip archive holds the packed volume {entry.name!r}.", "Send that file itself, without the archive."
        )
    if head.startswith(nrrd.MAGIC):
        nrrd_header = nrrd.parse_header(head)
        if not nrrd_header.data_file:
            raise unsupported(f"The zip archive holds the NRRD file {entry.name!r}.", "Send that file itself.")
        return nrrd.recognise(head, entry.size, detached=_companion(archive, entry, nrrd_header.data_file))
    if metaimage.looks_like_metaimage(head):
        header = metaimage.parse_header(head)
        metaimage.check_data_file(header)
        if not header.data_file:
            raise unsupported(f"The zip archive holds the MetaImage file {entry.name!r}.", "Send that file itself.")
        return metaimage.recognise(head, entry.size, detached=_companion(archive, entry, header.data_file))
    return meshes.recognise(head, entry.size)


def _companion(archive: SafeArchive, header: ArchiveEntry, data_file: str) -> int:
    """Return the size of the data file that a header names, which stands in the header's folder."""
    name = companion_name(header.name, data_file)
    for entry in archive.entries:
        if entry.name == name:
            return entry.size
    raise corrupt(f"The header {header.name!r} names the data file {data_file[:80]!r}, which is not in the archive.")


def companion_name(header: str, data_file: str) -> str:
    """Return the path of the data file that the header at path `header` names.

    Raises
    ------
    InvalidInput
        ``unsafe_archive`` if the name leads out of the header's folder.
    """
    name = data_file.replace("\\", "/").removeprefix("./")
    if not name or name.startswith("/") or ".." in name.split("/") or ":" in name or "\0" in name:
        raise InvalidInput(
            "unsafe_archive",
            f"The header {header!r} names the data file {data_file[:80]!r}, which does not lie beside it.",
            "Name the data file without a folder.",
        )
    return posixpath.join(posixpath.dirname(header), name)


def _npz(archive: SafeArchive) -> FileFormat:
    sizes = {entry.name: entry.size for entry in archive.entries}
    for needed in ("vertices.npy", "faces.npy"):
        if needed not in sizes:
            names = ", ".join(sorted(name.removesuffix(".npy") for name in sizes)[:8])
            raise unsupported(
                f"The npz file has no array {needed.removesuffix('.npy')!r}; it has {names}.",
                "A sequence has `vertices` of shape (frames, n, 3) and `faces` of shape (m, 3).",
            )
    vertices, faces = (
        parse_npy_header(archive.read(name, _NPY_HEADER), name) for name in ("vertices.npy", "faces.npy")
    )
    for name, header in (("vertices.npy", vertices), ("faces.npy", faces)):
        if header.data_offset + header.data_bytes != sizes[name]:
            raise corrupt(
                f"The array {name.removesuffix('.npy')!r} of the npz file should take {header.data_bytes} bytes, "
                f"and has {sizes[name] - header.data_offset}."
            )
    if len(vertices.shape) == 2 and vertices.shape[1:] == (3,):
        raise unsupported(
            f"The npz file holds a single mesh with vertices of shape {vertices.shape}, not a sequence.",
            "Send the mesh as OBJ, PLY, STL, OFF or GLB.",
        )
    if len(vertices.shape) != 3 or vertices.shape[2] != 3 or vertices.dtype[1] != "f":
        raise unsupported(
            f"The array `vertices` of the npz file has shape {vertices.shape} and type {vertices.dtype}.",
            "A sequence has floats of shape (frames, n, 3) there.",
        )
    if len(faces.shape) != 2 or faces.shape[1] != 3 or faces.dtype[1] not in "iu":
        raise unsupported(
            f"The array `faces` of the npz file has shape {faces.shape} and type {faces.dtype}.",
            "A sequence has integers of shape (m, 3) there.",
        )
    return FileFormat(
        kind=AssetKind.SEQUENCE,
        format="npz",
        media_type="application/x-npz",
        extension=".npz",
        details={"frames": vertices.shape[0], "vertices": vertices.shape[1], "faces": faces.shape[0]},
    )


def is_zip(head: bytes) -> bool:
    """Tell whether the first bytes are those of a zip archive, an empty one included."""
    return head.startswith((b"PK\x03\x04", b"PK\x05\x06"))

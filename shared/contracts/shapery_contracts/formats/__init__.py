"""Which kind of thing a file is, told from its content and never from its name.

Readers in `shapery_geometry` and the gateway's uploads ask the same function, so that what was accepted on upload is
what is read later. Recognition needs no numerics and reads a bounded part of the file: its first 64 KiB (an NRRD
header of up to 1 MiB), and of a zip archive the directory and the beginnings of a few entries.
"""

from __future__ import annotations

import re
import zlib
from typing import BinaryIO, Final

from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats import dicom, meshes, metaimage, nifti, nrrd, zipped
from shapery_contracts.formats.model import AssetKind, Details, FileFormat, corrupt, unsupported

__all__ = ["AssetKind", "Details", "FileFormat", "sniff"]

WINDOW: Final = 1 << 16
"""Bytes at the start of a file that decide."""

_OTHERS: Final = (
    (rb"\x89PNG\r\n\x1a\n", "a PNG picture"),
    (rb"\xff\xd8\xff", "a JPEG picture"),
    (rb"GIF8[79]a", "a GIF picture"),
    (rb"II\*\0|MM\0\*", "a TIFF picture"),
    (rb"BM.{4}\0\0\0\0", "a BMP picture"),
    (rb"%PDF-", "a PDF document"),
    (rb"7z\xbc\xaf\x27\x1c", "a 7-Zip archive"),
    (rb"Rar!\x1a\x07", "a RAR archive"),
    (rb"BZh[1-9]", "a bzip2 file"),
    (rb"\xfd7zXZ\0", "an xz file"),
    (rb"\x28\xb5\x2f\xfd", "a Zstandard file"),
    (rb".{257}ustar", "a tar archive"),
    (rb"\x89HDF\r\n\x1a\n", "an HDF5 file (MINC 2 volumes are such files)"),
    (rb"CDF[\x01\x02]", "a NetCDF file (MINC 1 volumes are such files)"),
    (rb"\0\0\0\x01\0\0..\0\0..\0\0..\0\0..\0\0\0[\0\x01\x03\x04]", "a FreeSurfer MGH volume"),
    (rb"# vtk DataFile", "a legacy VTK file"),
    (rb"\s*(<\?xml[^>]*>\s*)?<VTKFile", "a VTK XML file"),
    (rb"\s*(<\?xml[^>]*>\s*)?<COLLADA", "a COLLADA scene"),
    (rb"Kaydara FBX Binary", "an FBX scene"),
    (rb"; FBX", "an FBX scene"),
    (rb"ISO-10303-21", "a STEP file"),
    (rb"\$MeshFormat", "a Gmsh mesh"),
    (rb"MeshVersionFormatted", "a MEDIT mesh"),
    (rb"\x93NUMPY", "a single NumPy array"),
    (rb"DRACO", "a Draco mesh"),
    (rb"BLENDER", "a Blender scene"),
    (rb"#VRML|#X3D", "a VRML or X3D scene"),
)
_VOLUMES: Final = "Volumes are read as NIfTI, NRRD, MetaImage or DICOM; meshes as OBJ, PLY, STL, OFF or GLB."
_SEQUENCES: Final = "Sequences are read as npz, or as a zip of meshes."


def sniff(stream: BinaryIO, size: int) -> FileFormat:
    """Tell what the `size` bytes of a seekable `stream` are.

    Reads a bounded number of bytes, whatever the file claims.

    Raises
    ------
    InvalidInput
        ``unknown_format``, ``unsupported_format``, ``empty_content``, ``unsafe_archive`` or ``corrupt_file``.
    LimitExceeded
        ``too_large`` for archives with more entries or bytes than any upload may have.
    """
    stream.seek(0)
    head = stream.read(min(size, WINDOW))
    if not head:
        raise InvalidInput("empty_content", "The file is empty.")
    if head.startswith(b"SMC1"):
        return FileFormat(
            kind=AssetKind.MOTION, format="smc", media_type="application/x-shapery-motion", extension=".smc"
        )
    if head.startswith(b"\x1f\x8b"):
        return _gzipped(head, size)
    if zipped.is_zip(head):
        return zipped.recognise(stream)
    if nifti.looks_like_nifti(head):
        return nifti.recognise(head, size)
    if head.startswith(nrrd.MAGIC):
        if size > len(head) and not re.search(rb"\r?\n\r?\n", head):
            head += stream.read(min(size, nrrd.MAX_HEADER) - len(head))
        return nrrd.recognise(head, size)
    if dicom.looks_like_dicom(head):
        return dicom.recognise(head, size)
    if metaimage.looks_like_metaimage(head):
        return metaimage.recognise(head, size)
    if (mesh := meshes.recognise(head, size)) is not None:
        return mesh
    raise _unknown(head)


def gzip_head(head: bytes, limit: int) -> bytes:
    """Unpack at most `limit` bytes from the beginning of a gzip file.

    Raises
    ------
    InvalidInput
        ``corrupt_file``.
    """
    try:
        return zlib.decompressobj(16 + zlib.MAX_WBITS).decompress(head, limit)
    except zlib.error as error:
        raise corrupt(f"The gzip file is damaged ({error}).") from error


def _gzipped(head: bytes, size: int) -> FileFormat:
    inner = gzip_head(head, 1024)
    if len(inner) < 1024 and size <= len(head) and not _gzip_ends(head):
        raise corrupt(f"The gzip file is cut off: of what is in it {len(inner)} bytes can be unpacked.")
    if nifti.looks_like_nifti(inner):
        return nifti.recognise(inner, size, gzipped=True)
    if not inner:
        raise InvalidInput("empty_content", "The gzip file holds nothing.")
    if inner.startswith(nrrd.MAGIC) or metaimage.looks_like_metaimage(inner) or dicom.looks_like_dicom(inner):
        raise unsupported("Of gzipped files only NIfTI is read.", "Unpack the file and send what was in it.")
    if len(inner) < 348 and inner[:2] in (b"\x5c\x01", b"\x01\x5c", b"\x1c\x02"):
        raise corrupt(f"The NIfTI header in the gzip file is cut off after {len(inner)} bytes.")
    raise InvalidInput(
        "unknown_format",
        f"The file is gzipped, and what is in it {_named(inner) or 'is of no known format'}.",
        "Unpack the file and send what was in it.",
    )


def _gzip_ends(head: bytes) -> bool:
    """Tell whether the first stream in a gzip file, known to be short, is complete."""
    stream = zlib.decompressobj(16 + zlib.MAX_WBITS)
    stream.decompress(head, 2048)
    return stream.eof


def _named(head: bytes) -> str:
    for pattern, name in _OTHERS:
        if re.match(pattern, head, re.DOTALL):
            return f"is {name}"
    return ""


def _unknown(head: bytes) -> InvalidInput:
    if re.match(rb"\s*\{", head) and re.search(rb'"asset"\s*:\s*\{[^}]*"version"', head):
        return unsupported("The file is a glTF scene in JSON, whose data stand elsewhere.", "Send it as a .glb file.")
    if name := _named(head):
        return unsupported(f"The file {name}, which is not read here.", f"{_VOLUMES} {_SEQUENCES}")
    return InvalidInput("unknown_format", "The file is of no format that is known here.", f"{_VOLUMES} {_SEQUENCES}")

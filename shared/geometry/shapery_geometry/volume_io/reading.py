"""The one door to all readers: a file or a folder in, a volume out."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from shapery_contracts.archives import ArchiveLimits, SafeArchive, open_archive
from shapery_contracts.errors import InvalidInput, LimitExceeded
from shapery_contracts.formats import AssetKind, dicom, metaimage, nrrd, sniff, zipped
from shapery_contracts.formats.model import corrupt, unsupported
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io.dicom import DicomSource, FileList
from shapery_geometry.volume_io.metaimage import MetaImageSource
from shapery_geometry.volume_io.nifti import NiftiSource
from shapery_geometry.volume_io.nrrd import NrrdSource
from shapery_geometry.volume_io.source import ReadLimits, VolumeHeader, VolumeSource, load_volume

_PEEK = 1 << 16
_MARKS = (b"\x5c\x01\0\0", b"\0\0\x01\x5c", b"\x1c\x02\0\0", b"\0\0\x02\x1c", b"\x1f\x8b", b"PK\x03\x04", b"NRRD000")


def read_volume(
    path: Path | str,
    *,
    frame: int | None = None,
    component: str | None = None,
    series: str | None = None,
    limits: ReadLimits | None = None,
) -> Volume:
    """Read one scalar volume.

    Parameters
    ----------
    path
        A file (NIfTI, NRRD, MetaImage, DICOM, or a zip of a DICOM series or of a header with its data), or a folder
        with a DICOM series, with a header and its data, or with one volume. Formats are told from the content.
    frame
        Which volume to take from a file with several (time points, channels, vector components), from 0. Such a file
        is refused without it.
    component
        Which number to take from complex or colour voxels, see `COMPONENTS`. Such a file is refused without it.
    series
        The series instance UID to take where there are DICOM files of several. They are refused without it.
    limits
        By default `ReadLimits()`.

    Returns
    -------
    The volume, C-contiguous in native byte order: the file's own integer type where nothing is to be scaled, else
    float32 or float64. Its ``warnings`` name what is doubtful: an unknown orientation, voxels that are not finite.

    Raises
    ------
    FileNotFoundError
        If there is nothing at `path`.
    InvalidInput
        ``unknown_format``, ``unsupported_format``, ``corrupt_file``, ``empty_content``, ``unsafe_archive``,
        ``invalid_volume``, ``irregular_series`` or ``mixed_series``.
    LimitExceeded
        ``too_large``.
    """
    limits = limits or ReadLimits()
    with _opened(Path(path), series, limits) as source:
        return load_volume(source, frame=frame, component=component, limits=limits)


def read_volume_header(
    path: Path | str, *, series: str | None = None, limits: ReadLimits | None = None
) -> VolumeHeader:
    """Read what a file says of its volume, without loading a voxel.

    Files with several volumes, or with voxels that are not plain numbers, are described by ``frames`` and
    ``components``. Parameters and errors are those of `read_volume`; the size is not checked.
    """
    with _opened(Path(path), series, limits or ReadLimits()) as source:
        return source.header


@contextlib.contextmanager
def _opened(path: Path, series: str | None, limits: ReadLimits) -> Iterator[VolumeSource]:
    with contextlib.ExitStack() as stack:
        if path.is_dir():
            yield _open_folder(path, series, limits, stack)
        else:
            yield _open_file(path, series, limits, stack)


def _open_file(path: Path, series: str | None, limits: ReadLimits, stack: contextlib.ExitStack) -> VolumeSource:
    stream: BinaryIO = stack.enter_context(path.open("rb"))
    size = path.stat().st_size
    if (data := _companion(path, stream, size)) is not None:
        return _open_pair(path, data, stack)
    found = sniff(stream, size)
    if found.kind is not AssetKind.VOLUME:
        raise InvalidInput(
            "wrong_input_kind", f"The file holds a {found.kind} ({found.format}), not a volume.", "Send a volume."
        )
    if found.format in ("nifti1", "nifti2"):
        return NiftiSource(stream, gzipped=found.extension == ".nii.gz")
    if found.format == "dicom":
        return DicomSource(FileList.of_paths([path]), series=series, limits=limits)
    if found.extension == ".zip":
        archive = open_archive(stream, ArchiveLimits(entries=limits.files, total_bytes=2 * limits.bytes))
        if found.format == "dicom-zip":
            return DicomSource(FileList.of_archive(archive), series=series, limits=limits)
        return _open_packed_pair(archive, limits, stack)
    return NrrdSource(stream) if found.format == "nrrd" else MetaImageSource(stream)


def _companion(path: Path, stream: BinaryIO, size: int) -> Path | None:
    """Return the data file beside a detached header; None if `path` is no such header.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` if it is one, and the data file is missing or too short.
    """
    data = _named_data(path, stream)
    if data is None:
        return None
    if not data.is_file():
        raise corrupt(
            f"The header {path.name!r} names the data file {data.name!r}, which does not lie beside it.",
            "Send both together.",
        )
    stream.seek(0)
    head = stream.read(nrrd.MAX_HEADER)
    recognise = nrrd.recognise if head.startswith(nrrd.MAGIC) else metaimage.recognise
    recognise(head, size, detached=data.stat().st_size)
    return data


def _named_data(path: Path, stream: BinaryIO) -> Path | None:
    """Return the path of the data file that a detached header names; None if `path` is no such header."""
    head = stream.read(_PEEK)
    if head.startswith(nrrd.MAGIC):
        head += stream.read(nrrd.MAX_HEADER - len(head))
    name = _data_name(head)
    return path.parent / zipped.companion_name(path.name, name) if name else None


def _data_name(head: bytes) -> str:
    """Return the data file that a detached header names; empty if `head` begins no such header."""
    if head.startswith(nrrd.MAGIC):
        return nrrd.parse_header(head).data_file
    if metaimage.looks_like_metaimage(head):
        header = metaimage.parse_header(head)
        metaimage.check_data_file(header)
        return header.data_file
    return ""


def _open_pair(header: Path, data: Path, stack: contextlib.ExitStack) -> VolumeSource:
    head = stack.enter_context(header.open("rb"))
    body = stack.enter_context(data.open("rb"))
    is_nrrd = head.read(len(nrrd.MAGIC)) == nrrd.MAGIC
    return NrrdSource(head, body) if is_nrrd else MetaImageSource(head, body)


def _open_packed_pair(archive: SafeArchive, limits: ReadLimits, stack: contextlib.ExitStack) -> VolumeSource:
    """Unpack a header and the data file that it names, and nothing else of the archive."""
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="shapery-")))
    sizes = {entry.name: entry.size for entry in archive.entries}
    for name, size in sizes.items():
        head = archive.read(name, min(size, _PEEK))
        if not (head.startswith(nrrd.MAGIC) or metaimage.looks_like_metaimage(head)):
            continue
        data = _data_name(head)
        if not data:
            continue
        companion = zipped.companion_name(name, data)
        if companion not in sizes:
            raise corrupt(f"The header {name!r} names the data file {data[:80]!r}, which is not in the archive.")
        needed = size + sizes[companion]
        if needed > limits.bytes:
            raise LimitExceeded(
                "too_large", f"The volume unpacks to {needed} bytes; at most {limits.bytes} are allowed."
            )
        header = folder / "header"
        header.write_bytes(archive.read(name))
        with archive.open(companion) as source, (folder / "data").open("wb") as target:
            shutil.copyfileobj(source, target)
        return _open_pair(header, folder / "data", stack)
    raise corrupt("The archive holds no header with its data.")


def _open_folder(folder: Path, series: str | None, limits: ReadLimits, stack: contextlib.ExitStack) -> VolumeSource:
    files = _files(folder, limits)
    if not files:
        raise InvalidInput("empty_content", "The folder holds no files.")
    if len(files) == 1:
        return _open_file(files[0], series, limits, stack)
    heads = {path: _peek(path) for path in files}
    slices = [path for path, head in heads.items() if dicom.looks_like_dicom(head)]
    volumes = [path for path, head in heads.items() if head.startswith(_MARKS) or metaimage.looks_like_metaimage(head)]
    if slices and volumes:
        raise unsupported(
            f"The folder holds DICOM files together with {volumes[0].name!r}.", "Give the path of one volume."
        )
    if slices:
        others = [str(path.relative_to(folder)) for path in files if path not in set(slices)]
        return DicomSource(FileList.of_paths(slices, folder), series=series, limits=limits, left_out=others)
    # A data file may look like a volume of its own: packed with gzip, it does.
    owned = {_data_of(path) for path in volumes if not heads[path].startswith((b"\x1f\x8b", b"PK"))}
    volumes = [path for path in volumes if path not in owned]
    if len(volumes) == 1:
        return _open_file(volumes[0], series, limits, stack)
    if volumes:
        names = ", ".join(path.name for path in volumes[:5])
        raise unsupported(f"The folder holds {len(volumes)} volumes ({names}).", "Give the path of one of them.")
    raise InvalidInput(
        "unknown_format",
        f"None of the {len(files)} files in the folder is a volume or a DICOM slice.",
        "Send a volume.",
    )


def _data_of(path: Path) -> Path | None:
    with path.open("rb") as stream:
        return _named_data(path, stream)


def _files(folder: Path, limits: ReadLimits) -> list[Path]:
    """Return the regular files below `folder` in the order of their names, without hidden ones."""
    found = []
    for parent, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith(".") and name != "__MACOSX")
        for name in sorted(names):
            path = Path(parent, name)
            if not name.startswith(".") and path.is_file():
                found.append(path)
            if len(found) > limits.files:
                raise LimitExceeded("too_large", f"The folder holds more than {limits.files} files.")
    return found


def _peek(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(512)

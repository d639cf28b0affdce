"""DICOM: a series of single slices as a list of files or a zip, or one multi-frame file.

Files that are no images (reports, directories, segmentations) are left out with a warning; a damaged file is not.
Values are rescaled as each slice says; they stay integers where slope and intercept allow it.
"""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np

from shapery_contracts.archives import SafeArchive
from shapery_contracts.errors import InvalidInput, LimitExceeded, UserError
from shapery_contracts.formats import dicom as recognition
from shapery_contracts.formats.model import corrupt, unsupported
from shapery_geometry.volume_io.dicom_pixels import (
    BY_GDCM,
    DEFLATED,
    PLAIN,
    check_deflated,
    check_syntax,
    decode,
    foreign_faults,
    lenient_pydicom,
)
from shapery_geometry.volume_io.dicom_slices import DicomSlice, DicomStack, Vector, choose_series, stack_slices
from shapery_geometry.volume_io.source import Array, ReadLimits, VolumeHeader, check_size, take_component

HEADER_LIMIT: Final = 256 << 20
"""Bytes before the pixels; an enhanced file with thousands of frames has some tens of megabytes of them."""
DEFLATED_LIMIT: Final = 1 << 30
"""Bytes that a deflated file may unpack to, which `pydicom` does in memory and in one go."""
_TAGS: Final = [
    "SOPClassUID",
    "SOPInstanceUID",
    "Modality",
    "SeriesDescription",
    "SeriesInstanceUID",
    "InstanceNumber",
    "AcquisitionNumber",
    "AcquisitionTime",
    "ContentTime",
    "TemporalPositionIdentifier",
    "TriggerTime",
    "EchoNumbers",
    "EchoTime",
    "DiffusionBValue",
    "ImagePositionPatient",
    "ImageOrientationPatient",
    "PixelSpacing",
    "RescaleSlope",
    "RescaleIntercept",
    "Rows",
    "Columns",
    "NumberOfFrames",
    "SamplesPerPixel",
    "PhotometricInterpretation",
    "BitsAllocated",
    "BitsStored",
    "PixelRepresentation",
    "SharedFunctionalGroupsSequence",
    "PerFrameFunctionalGroupsSequence",
]


@dataclass(frozen=True, slots=True)
class FileList:
    """Files by name, and how to open each."""

    names: tuple[str, ...]
    openers: tuple[Callable[[], BinaryIO], ...]
    header_openers: tuple[Callable[[], BinaryIO], ...]
    """Open each for reading from its beginning, without unpacking what is not read."""
    sizes: tuple[int, ...]

    @classmethod
    def of_paths(cls, paths: Sequence[Path], root: Path | None = None) -> FileList:
        """Return the files at `paths`, named relative to `root`."""
        openers = tuple(partial(_open_path, path) for path in paths)
        return cls(
            names=tuple(path.name if root is None else path.relative_to(root).as_posix() for path in paths),
            openers=openers,
            header_openers=openers,
            sizes=tuple(path.stat().st_size for path in paths),
        )

    @classmethod
    def of_archive(cls, archive: SafeArchive) -> FileList:
        """Return the entries of `archive`; each is unpacked in memory when it is opened."""
        return cls(
            names=tuple(entry.name for entry in archive.entries),
            openers=tuple(partial(_open_entry, archive, entry.name) for entry in archive.entries),
            header_openers=tuple(partial(_Unpacking, archive, entry.name) for entry in archive.entries),
            sizes=tuple(entry.size for entry in archive.entries),
        )


class _Clamped(io.BufferedReader):
    """A file that is never asked for more than it has: a false length in a header would allocate that many bytes."""

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))
        self._end = self.seek(0, io.SEEK_END)
        self.seek(0)

    def read(self, size: int | None = -1, /) -> bytes:
        left = max(self._end - self.tell(), 0)
        return super().read(left if size is None or size < 0 else min(size, left))


class _Unpacking(io.BytesIO):
    """The beginning of an archive's entry, unpacked as far as it is read."""

    def __init__(self, archive: SafeArchive, name: str) -> None:
        super().__init__()
        self._name = name
        self._source = archive.open(name)
        self._unpacked = 0

    def read(self, size: int | None = -1, /) -> bytes:
        end = HEADER_LIMIT + 1 if size is None or size < 0 else min(self.tell() + size, HEADER_LIMIT + 1)
        while self._unpacked < end:
            data = self._source.read(min(end - self._unpacked, 1 << 16))
            if not data:
                break
            here = self.tell()
            self.seek(self._unpacked)
            self._unpacked += self.write(data)
            self.seek(here)
        if self._unpacked > HEADER_LIMIT:
            raise LimitExceeded(
                "too_large", f"The header of {self._name} is longer than {HEADER_LIMIT} bytes, the most that is read."
            )
        return super().read(size)

    def close(self) -> None:
        self._source.close()
        super().close()


def _open_path(path: Path) -> BinaryIO:
    return _Clamped(path)


def _open_entry(archive: SafeArchive, name: str) -> BinaryIO:
    return io.BytesIO(archive.read(name))


@dataclass(frozen=True, slots=True)
class _Pixels:
    """What one file says of all its pixels."""

    syntax: str
    samples: int
    photometric: str
    allocated: int
    stored: int
    signed: bool
    bytes_per_frame: int


@dataclass(frozen=True, slots=True)
class _Scan:
    """What the headers of all files say."""

    slices: list[DicomSlice]
    pixels: dict[int, _Pixels]
    left_out: list[str]


class DicomSource:
    """The headers of a DICOM series, checked and ordered."""

    def __init__(
        self, files: FileList, *, series: str | None, limits: ReadLimits, left_out: Sequence[str] = ()
    ) -> None:
        if len(files.names) > limits.files:
            raise LimitExceeded(
                "too_large", f"There are {len(files.names)} DICOM files; at most {limits.files} are allowed."
            )
        scan = _scan(files, limits)
        chosen = choose_series(scan.slices, series)
        # Refuse too large a volume before its slices are compared.
        check_size((chosen[0].columns, chosen[0].rows, 2), limits)
        self._files = files
        self._stack: DicomStack = stack_slices(chosen)
        self._pixels = {item.file: scan.pixels[item.file] for item in chosen}
        notes = list(self._stack.warnings)
        others = [*scan.left_out, *left_out]
        if others:
            shown = ", ".join(others[:5]) + (f" and {len(others) - 5} more" if len(others) > 5 else "")
            notes.append(
                f"{len(others)} file{'s' if len(others) > 1 else ''} that hold no DICOM image were left out: {shown}."
            )
        if len(chosen) < len(scan.slices):
            notes.append(f"{len(scan.slices) - len(chosen)} slices of other series were left out.")
        kinds = list(self._pixels.values())
        for kind in kinds:
            check_syntax(kind.syntax, self._files.names[0])
        if any(kind.photometric == "MONOCHROME1" for kind in kinds):
            notes.append("Low values are meant to be shown bright (MONOCHROME1); they were taken as they are stored.")
        self._storage = _storage(kinds)
        self.header = self._header(notes)

    def _header(self, notes: list[str]) -> VolumeHeader:
        first = self._stack.volumes[0][0]
        affine = self._stack.affine
        x, y, z = np.sqrt((affine[:3, :3] ** 2).sum(axis=0)).tolist()
        kind = self._pixels[first.file]
        return VolumeHeader(
            shape=(first.columns, first.rows, len(self._stack.volumes[0])),
            spacing=(x, y, z),
            dtype=f"{'int' if kind.signed else 'uint'}{kind.allocated}",
            affine=affine,
            format="dicom",
            warnings=tuple(notes),
            frames=len(self._stack.volumes),
            storage=self._storage,
        )

    def bytes_needed(self, frame: int) -> int:
        """Return how many bytes of pixels must be decoded for `frame`."""
        return sum(self._pixels[item.file].bytes_per_frame for item in self._stack.volumes[frame])

    def load(self, frame: int, component: str | None) -> Array:
        """Return the voxels (columns, rows, slices) of `frame`, rescaled."""
        volume = self._stack.volumes[frame]
        wanted = sorted((item.file, item.frame, index) for index, item in enumerate(volume))
        out: Array | None = None
        for file, group in itertools.groupby(wanted, key=lambda entry: entry[0]):
            entries = list(group)
            name = self._files.names[file]
            arrays = decode(self._files.openers[file], self._pixels[file].syntax, [e[1] for e in entries], name)
            done = 0
            for (_, _, index), array in zip(entries, arrays, strict=False):
                item = volume[index]
                values = take_component(array, self._storage, component)
                if values.shape != (item.rows, item.columns):
                    raise corrupt(f"The pixels of {item.name} have the size {values.shape}, its header says otherwise.")
                if out is None:
                    out = np.empty((len(volume), item.rows, item.columns), dtype=self._result_type(values, volume))
                _rescale_into(out[index], values, item)
                done += 1
            if done != len(entries):
                raise corrupt(f"{name} has {done} frames of pixels where {len(entries)} are needed.")
        assert out is not None
        return np.ascontiguousarray(out.T)

    def _result_type(self, values: Array, volume: Sequence[DicomSlice]) -> np.dtype[Any]:
        """Return the narrowest type that holds the rescaled values of all slices."""
        if values.dtype.kind == "f" or self._storage != "real":
            return values.dtype
        offsets = {item.intercept for item in volume}
        if any(item.slope != 1.0 for item in volume) or any(o != int(o) or abs(o) > 2**30 for o in offsets):
            return np.dtype(np.float64 if values.dtype.itemsize > 2 else np.float32)
        if offsets == {0.0}:
            return values.dtype
        kinds = [self._pixels[item.file] for item in volume]
        low = min(-(1 << (k.stored - 1)) if k.signed else 0 for k in kinds) + int(min(offsets))
        high = max((1 << (k.stored - int(k.signed))) - 1 for k in kinds) + int(max(offsets))
        for candidate in (np.int16, np.int32):
            if np.iinfo(candidate).min <= low and high <= np.iinfo(candidate).max:
                return np.dtype(candidate)
        return np.dtype(np.int64)


def _rescale_into(out: Array, values: Array, item: DicomSlice) -> None:
    if item.slope == 1.0 and item.intercept == 0.0:
        out[...] = values
    elif out.dtype.kind == "f":
        out[...] = values.astype(np.float64) * item.slope + item.intercept
    else:
        out[...] = values.astype(np.int64) + int(item.intercept)


def _storage(kinds: Sequence[_Pixels]) -> str:
    colour = {kind.samples for kind in kinds}
    if len(colour) > 1:
        raise unsupported("The series holds grey and coloured slices.", "Send the grey ones alone.")
    if any(kind.photometric == "PALETTE COLOR" for kind in kinds):
        raise unsupported("The pixels are indices into a colour palette, not intensities.", "Send the original series.")
    if colour == {1}:
        return "real"
    if colour != {3} or any(kind.syntax in BY_GDCM for kind in kinds):
        raise unsupported("The pixels are compressed colours.", "Send the original grey series.")
    return "rgb"


def _scan(files: FileList, limits: ReadLimits) -> _Scan:
    """Read all headers.

    Raises
    ------
    InvalidInput
        If a file is damaged, or none holds an image.
    """
    scan = _Scan([], {}, [])
    refusal: UserError | None = None
    for index, (name, opener, size) in enumerate(zip(files.names, files.header_openers, files.sizes, strict=True)):
        if size > limits.bytes:
            raise LimitExceeded("too_large", f"{name} has {size} bytes; at most {limits.bytes} are allowed.")
        with opener() as stream:
            head = stream.read(1 << 16)
            if not recognition.looks_like_dicom(head):
                scan.left_out.append(name)
                continue
            try:
                recognition.recognise(head, size)
            except UserError as error:
                if error.code != "unsupported_format":
                    raise InvalidInput(error.code, f"{name}: {error.message}", error.hint) from error
                refusal = refusal or error
                scan.left_out.append(name)
                continue
            if recognition.transfer_syntax(head) == DEFLATED:
                check_deflated(stream, min(limits.bytes, DEFLATED_LIMIT), name)
            stream.seek(0)
            with foreign_faults(name), lenient_pydicom():
                _read_headers(stream, index, name, size, scan)
    if not scan.slices:
        raise refusal or InvalidInput("unknown_format", "None of the files is a DICOM image.")
    return scan


def _read_headers(stream: BinaryIO, index: int, name: str, size: int, scan: _Scan) -> None:
    import pydicom

    dataset = pydicom.dcmread(stream, stop_before_pixels=True, specific_tags=list(_TAGS))
    pixels = _pixels_of(dataset, name)
    groups = dataset.get("PerFrameFunctionalGroupsSequence")
    frames = int(dataset.get("NumberOfFrames") or 1)
    claimed = pixels.bytes_per_frame * frames
    if pixels.syntax in PLAIN and claimed > size:
        raise corrupt(f"{name} should hold {claimed} bytes of pixels, and has {size} bytes; it is truncated.")
    if pixels.syntax in PLAIN and size > claimed + HEADER_LIMIT:
        raise corrupt(f"{name} should hold {claimed} bytes of pixels, and has {size} bytes.")
    scan.pixels[index] = pixels
    if not groups:
        if frames > 1:
            raise unsupported(
                f"{name} holds {frames} frames and does not say where each lies.",
                "Export the series as single slices, or as an enhanced multi-frame file.",
            )
        scan.slices.append(_slice_of(dataset, None, None, index, 0, name))
        return
    if len(groups) != frames:
        raise corrupt(f"{name} claims {frames} frames and describes {len(groups)}.")
    shared = dataset.get("SharedFunctionalGroupsSequence")
    for number, group in enumerate(groups):
        scan.slices.append(_slice_of(dataset, group, shared[0] if shared else None, index, number, name))


def _pixels_of(dataset: Any, name: str) -> _Pixels:
    allocated = int(dataset.get("BitsAllocated") or 0)
    rows, columns = int(dataset.get("Rows") or 0), int(dataset.get("Columns") or 0)
    samples = int(dataset.get("SamplesPerPixel") or 1)
    if rows < 1 or columns < 1 or allocated not in (1, 8, 16, 32, 64):
        raise corrupt(f"{name} says that it holds {columns} × {rows} pixels of {allocated} bits.")
    return _Pixels(
        syntax=str(dataset.file_meta.TransferSyntaxUID),
        samples=samples,
        photometric=str(dataset.get("PhotometricInterpretation") or ""),
        allocated=allocated,
        stored=max(1, min(allocated, int(dataset.get("BitsStored") or allocated))),
        signed=int(dataset.get("PixelRepresentation") or 0) == 1,
        bytes_per_frame=rows * columns * samples * allocated // 8,
    )


def _slice_of(dataset: Any, group: Any, shared: Any, index: int, frame: int, name: str) -> DicomSlice:
    """Return one slice; for a multi-frame file from its functional groups, the frame's own before the shared ones."""

    def macro(sequence: str, keyword: str) -> Any:
        for place in (group, shared):
            if place is not None and (items := place.get(sequence)) and items[0].get(keyword) is not None:
                return items[0].get(keyword)
        # Only single slices say it outside the groups.
        return dataset.get(keyword) if group is None else None

    orientation = _numbers(macro("PlaneOrientationSequence", "ImageOrientationPatient"), 6)
    spacing = _numbers(macro("PixelMeasuresSequence", "PixelSpacing"), 2)
    if spacing is not None and min(spacing) <= 0:
        raise corrupt(f"{name} has the pixel spacing {spacing[0]:g} × {spacing[1]:g} mm.")
    position = _numbers(macro("PlanePositionSequence", "ImagePositionPatient"), 3)
    slope = _number(macro("PixelValueTransformationSequence", "RescaleSlope"), 1.0)
    modality = str(dataset.get("Modality") or "")
    return DicomSlice(
        file=index,
        name=name if group is None else f"{name} frame {frame}",
        frame=frame,
        series=str(dataset.get("SeriesInstanceUID") or ""),
        description=f"{modality} {dataset.get('SeriesDescription') or ''}".strip(),
        rows=int(dataset.Rows),
        columns=int(dataset.Columns),
        position=None if position is None else (position[0], position[1], position[2]),
        row_direction=_direction(orientation, 0),
        column_direction=_direction(orientation, 3),
        spacing=None if spacing is None else (spacing[0], spacing[1]),
        # A slope of 0 would erase the image; it is how some programs write that there is none.
        slope=slope or 1.0,
        intercept=_number(macro("PixelValueTransformationSequence", "RescaleIntercept"), 0.0),
        moment=_moment(dataset, macro, frame),
        uid=f"{dataset.get('SOPInstanceUID') or index} {frame}",
    )


def _moment(dataset: Any, macro: Callable[[str, str], Any], frame: int) -> tuple[float, ...]:
    return tuple(
        _number(value, 0.0)
        for value in (
            macro("FrameContentSequence", "TemporalPositionIndex"),
            dataset.get("TemporalPositionIdentifier"),
            dataset.get("TriggerTime"),
            dataset.get("EchoNumbers"),
            macro("MREchoSequence", "EffectiveEchoTime"),
            dataset.get("EchoTime"),
            macro("MRDiffusionSequence", "DiffusionBValue"),
            dataset.get("AcquisitionNumber"),
            dataset.get("AcquisitionTime"),
            dataset.get("ContentTime"),
            dataset.get("InstanceNumber"),
            frame,
        )
    )


def _number(value: Any, default: float) -> float:
    """Return a single finite number, or `default` where there is none."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return default
    return number if math.isfinite(number) else default


def _numbers(value: Any, count: int) -> tuple[float, ...] | None:
    """Return `count` finite numbers, or None where there are none."""
    try:
        numbers = tuple(float(v) for v in value)
    except (TypeError, ValueError):
        return None
    return numbers if len(numbers) == count and all(map(math.isfinite, numbers)) else None


def _direction(orientation: tuple[float, ...] | None, start: int) -> Vector | None:
    if orientation is None:
        return None
    x, y, z = orientation[start : start + 3]
    length = math.sqrt(x * x + y * y + z * z)
    # Direction cosines are rounded to a few decimals; anything far from unit length is no direction.
    return (x / length, y / length, z / length) if abs(length - 1.0) < 0.05 else None

"""Stored pixel values of DICOM files, native and compressed."""

from __future__ import annotations

import contextlib
import tempfile
import warnings
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy.typing as npt

from shapery_contracts.errors import InvalidInput, LimitExceeded, UserError
from shapery_contracts.formats.model import corrupt, unsupported

Array = npt.NDArray[Any]

PLAIN: Final = frozenset(
    {
        "1.2.840.10008.1.2",  # Implicit VR Little Endian
        "1.2.840.10008.1.2.1",  # Explicit VR Little Endian
        "1.2.840.10008.1.2.2",  # Explicit VR Big Endian
    }
)
"""Transfer syntaxes under which the file is at least as long as its pixels."""
DEFLATED: Final = "1.2.840.10008.1.2.1.99"
_RLE: Final = "1.2.840.10008.1.2.5"
BY_GDCM: Final = frozenset(
    {
        "1.2.840.10008.1.2.4.50",  # JPEG Baseline, 8 bit
        "1.2.840.10008.1.2.4.51",  # JPEG Extended, 12 bit
        "1.2.840.10008.1.2.4.57",  # JPEG Lossless
        "1.2.840.10008.1.2.4.70",  # JPEG Lossless, first-order prediction
        "1.2.840.10008.1.2.4.80",  # JPEG-LS Lossless
        "1.2.840.10008.1.2.4.81",  # JPEG-LS Near-lossless
        "1.2.840.10008.1.2.4.90",  # JPEG 2000 Lossless
        "1.2.840.10008.1.2.4.91",  # JPEG 2000
    }
)
_GDCM_TAGS: Final = (
    "SOPClassUID",
    "SOPInstanceUID",
    "SamplesPerPixel",
    "PhotometricInterpretation",
    "PlanarConfiguration",
    "Rows",
    "Columns",
    "BitsAllocated",
    "BitsStored",
    "HighBit",
    "PixelRepresentation",
)


@contextlib.contextmanager
def foreign_faults(what: str) -> Iterator[None]:
    """Turn whatever a library raises on foreign bytes into ``corrupt_file``.

    The libraries document no set of errors for damaged files: `AttributeError`, `struct.error`, `IndexError` and many
    more were seen. Our own errors, lack of memory, failures of the disk, and what can only be a defect of a program
    pass.
    """
    try:
        yield
    except (UserError, MemoryError, NameError, ImportError, AssertionError):
        raise
    except OSError as error:
        if error.errno is not None:
            raise
        raise corrupt(f"{what} is damaged ({error}).") from error
    except Exception as error:
        text = str(error).splitlines()[0][:160] if str(error) else type(error).__name__
        raise corrupt(f"{what} is damaged ({text}).") from error


@contextlib.contextmanager
def lenient_pydicom() -> Iterator[None]:
    """Keep `pydicom` from warning of values that break the standard's rules.

    They are common, those that matter are checked here, and the warnings would carry them into logs.
    """
    from pydicom import config

    before = config.settings.reading_validation_mode
    config.settings.reading_validation_mode = config.IGNORE
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        config.settings.reading_validation_mode = before


def check_syntax(syntax: str, name: str) -> None:
    """Refuse what no decoder here reads.

    Raises
    ------
    InvalidInput
        ``unsupported_format``, with the encoding's name.
    """
    if syntax in PLAIN or syntax in BY_GDCM or syntax in (DEFLATED, _RLE):
        return
    from pydicom.uid import UID

    raise unsupported(
        f"The pixels of {name} are compressed as {UID(syntax).name}, which is not read here.",
        "Convert the series to an uncompressed transfer syntax (Explicit VR Little Endian).",
    )


def check_deflated(stream: BinaryIO, limit: int, name: str) -> None:
    """Refuse a deflated file that unpacks to more than `limit` bytes; `pydicom` would unpack it in one go.

    The deflated part begins somewhere behind the meta information, so the whole is tried from each place where that
    may end: the group length says where.
    """
    stream.seek(132)
    head = stream.read(12)
    if head[:8] != b"\x02\x00\x00\x00UL\x04\x00":
        raise corrupt(f"The meta information of {name} does not say how long it is.")
    stream.seek(144 + int.from_bytes(head[8:12], "little"))
    inflater = zlib.decompressobj(-zlib.MAX_WBITS)
    total = 0
    data = b""
    while not inflater.eof:
        data = inflater.unconsumed_tail or stream.read(1 << 16)
        if not data:
            break
        try:
            total += len(inflater.decompress(data, 1 << 20))
        except zlib.error as error:
            raise corrupt(f"{name} is damaged ({error}).") from error
        if total > limit:
            raise LimitExceeded("too_large", f"{name} unpacks to more than {limit} bytes, the most that is allowed.")
    stream.seek(0)


def decode(opened: Callable[[], BinaryIO], syntax: str, frames: Sequence[int], name: str) -> Iterator[Array]:
    """Yield the stored values (rows, columns) or (rows, columns, 3) of `frames` of one file, unscaled.

    Parameters
    ----------
    opened
        Opens the file.
    syntax
        UID of its transfer syntax.
    frames
        Which frames, from 0, in rising order.
    name
        The file's name, for errors.
    """
    check_syntax(syntax, name)
    with foreign_faults(name), lenient_pydicom(), opened() as stream:
        if syntax in BY_GDCM:
            yield from _by_gdcm(stream, frames, name)
        else:
            yield from _by_pydicom(stream, frames)


def _by_pydicom(stream: BinaryIO, frames: Sequence[int]) -> Iterator[Array]:
    import pydicom
    from pydicom.pixels.utils import iter_pixels

    dataset = pydicom.dcmread(stream)
    allocated = int(dataset.BitsAllocated)
    stored = int(dataset.get("BitsStored", allocated))
    signed = int(dataset.get("PixelRepresentation", 0)) == 1
    for array in iter_pixels(dataset, indices=list(frames)):
        yield _stored_bits(array, allocated, stored, signed=signed)


def _stored_bits(array: Array, allocated: int, stored: int, *, signed: bool) -> Array:
    """Return the values of the stored bits alone: some programs keep overlays in the bits above them."""
    if array.dtype.kind not in "iu" or not 1 < stored < allocated or array.dtype.itemsize * 8 != allocated:
        return array
    if not signed:
        masked: Array = array & array.dtype.type((1 << stored) - 1)
        return masked
    shift = allocated - stored
    extended: Array = (array << shift) >> shift
    return extended


def _by_gdcm(stream: BinaryIO, frames: Sequence[int], name: str) -> Iterator[Array]:
    """Decode through ITK, each frame as a file of its own that holds nothing but the pixels.

    So neither the order of frames nor a rescaling is left to ITK.
    """
    import pydicom
    import SimpleITK
    from pydicom.encaps import encapsulate, generate_frames
    from pydicom.uid import generate_uid

    dataset = pydicom.dcmread(stream)
    total = int(dataset.get("NumberOfFrames") or 1)
    wanted = set(frames)
    with tempfile.TemporaryDirectory(prefix="shapery-") as folder:
        path = str(Path(folder) / "frame.dcm")
        for index, fragment in enumerate(generate_frames(dataset.PixelData, number_of_frames=total)):
            if index not in wanted:
                continue
            single = pydicom.Dataset()
            for tag in _GDCM_TAGS:
                if tag in dataset:
                    setattr(single, tag, getattr(dataset, tag))
            # A class without functional groups, so that ITK looks for none.
            single.SOPClassUID = "1.2.840.10008.5.1.4.1.1.7"
            single.SOPInstanceUID = generate_uid()
            single.file_meta = pydicom.dataset.FileMetaDataset()
            single.file_meta.TransferSyntaxUID = dataset.file_meta.TransferSyntaxUID
            single.file_meta.MediaStorageSOPClassUID = single.SOPClassUID
            single.file_meta.MediaStorageSOPInstanceUID = single.SOPInstanceUID
            single.PixelData = encapsulate([fragment])
            single["PixelData"].is_undefined_length = True
            single.save_as(path, enforce_file_format=True)
            yield _read_by_itk(SimpleITK, path, (int(dataset.Rows), int(dataset.Columns)), name)


def _read_by_itk(itk: Any, path: str, shape: tuple[int, int], name: str) -> Array:
    try:
        image = itk.ReadImage(path, imageIO="GDCMImageIO")
    except RuntimeError as error:
        raise corrupt(f"The compressed pixels of {name} cannot be decoded.") from error
    array: Array = itk.GetArrayFromImage(image)
    size = tuple(array.shape[-2:])
    if size != shape:
        raise InvalidInput(
            "corrupt_file", f"The compressed pixels of {name} have the size {size}, its header says {shape}."
        )
    return array.reshape(shape)

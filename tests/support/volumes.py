"""Volumes of our own for tests: an asymmetric phantom in every orientation, and DICOM series of any irregularity."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pydicom
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian, MRImageStorage, generate_uid

from shapery_geometry.volume import Volume

SPACING = np.array([0.8, 1.1, 2.5])


def oblique_rotation() -> np.ndarray:
    """A rotation by less than 45° about each axis, so that the nearest world axes are the array's own."""
    a, b, c = 0.2, -0.15, 0.3
    rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    ry = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    rz = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return rz @ ry @ rx


def phantom() -> Volume:
    """Every voxel has a value of its own, every axis a length and a spacing of its own, and the affine is oblique."""
    data = np.arange(7 * 5 * 6, dtype=np.int16).reshape(7, 5, 6)
    affine = np.eye(4)
    affine[:3, :3] = oblique_rotation() * SPACING
    affine[:3, 3] = (-31.25, 17.5, 4.75)
    return Volume(data, affine)


ORIENTATIONS = list(itertools.product(itertools.permutations(range(3)), itertools.product((False, True), repeat=3)))
"""All 48 orders and directions of three axes."""


def stored_as(volume: Volume, axes: Sequence[int], flips: Sequence[bool]) -> Volume:
    """The same volume stored with its axes swapped and reversed: written out plainly, not with the code under test."""
    data = np.transpose(volume.data, axes)
    affine = np.array(volume.affine)
    affine[:3, :3] = volume.affine[:3, list(axes)]
    for axis, flip in enumerate(flips):
        if flip:
            affine[:3, 3] += affine[:3, axis] * (data.shape[axis] - 1)
            affine[:3, axis] *= -1
            data = np.flip(data, axis)
    return Volume(np.ascontiguousarray(data), affine)


def all_orientations(volume: Volume) -> Iterator[Volume]:
    """The volume stored in each of the 48 ways."""
    for axes, flips in ORIENTATIONS:
        yield stored_as(volume, axes, flips)


def dicom_slice(
    volume: Volume,
    k: int,
    *,
    series: str,
    instance: int | None = None,
    pixels: np.ndarray | None = None,
    **changes: Any,
) -> FileDataset:
    """Slice `k` of a volume as an MR image; `changes` replaces elements by keyword, None removes one."""
    to_lps = np.diag([-1.0, -1.0, 1.0])
    axes = to_lps @ volume.affine[:3, :3]
    spacing = np.sqrt((axes**2).sum(axis=0))
    position = to_lps @ volume.to_world((0, 0, k))
    data = volume.data[:, :, k].T if pixels is None else pixels
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = MRImageStorage
    meta.MediaStorageSOPInstanceUID = generate_uid()
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    dataset = FileDataset("slice.dcm", {}, file_meta=meta, preamble=b"\0" * 128)
    dataset.SOPClassUID = MRImageStorage
    dataset.SOPInstanceUID = meta.MediaStorageSOPInstanceUID
    dataset.Modality = "MR"
    dataset.SeriesDescription = "phantom"
    dataset.SeriesInstanceUID = series
    dataset.InstanceNumber = k + 1 if instance is None else instance
    dataset.ImagePositionPatient = [f"{v:.9g}" for v in position]
    dataset.ImageOrientationPatient = [f"{v:.9g}" for v in (*(axes[:, 0] / spacing[0]), *(axes[:, 1] / spacing[1]))]
    dataset.PixelSpacing = [f"{spacing[1]:.9g}", f"{spacing[0]:.9g}"]
    dataset.Rows, dataset.Columns = data.shape[:2]
    dataset.SamplesPerPixel = 1
    dataset.PhotometricInterpretation = "MONOCHROME2"
    dataset.BitsAllocated = dataset.BitsStored = 8 * data.dtype.itemsize
    dataset.HighBit = dataset.BitsStored - 1
    dataset.PixelRepresentation = int(data.dtype.kind == "i")
    dataset.PixelData = np.ascontiguousarray(data).tobytes()
    for keyword, value in changes.items():
        if value is None:
            delattr(dataset, keyword)
        else:
            setattr(dataset, keyword, value)
    return dataset


def write_dicom(dataset: pydicom.Dataset, path: Path) -> Path:
    """Write one file."""
    dataset.save_as(path, enforce_file_format=True)
    return path


def write_series(
    folder: Path, volume: Volume, *, order: Sequence[int] | None = None, series: str | None = None, **changes: Any
) -> list[Path]:
    """Write a volume as a series, one file per slice.

    The n-th file, by name and by instance number, holds slice ``order[n]``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    uid = series or generate_uid()
    return [
        write_dicom(
            dicom_slice(volume, k, series=uid, instance=number + 1, **changes), folder / f"image-{number:04d}.dcm"
        )
        for number, k in enumerate(range(volume.shape[2]) if order is None else order)
    ]


def write_multiframe(
    path: Path, volume: Volume, *, order: Sequence[int] | None = None, series: str | None = None, **changes: Any
) -> Path:
    """Write a volume as one enhanced multi-frame file whose n-th frame is slice ``order[n]``."""
    order = list(range(volume.shape[2])) if order is None else list(order)
    single = dicom_slice(volume, 0, series=series or generate_uid())
    dataset = FileDataset(str(path), {}, file_meta=single.file_meta, preamble=b"\0" * 128)
    dataset.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.4.1"
    outside = ("ImagePositionPatient", "ImageOrientationPatient", "PixelSpacing", "PixelData")
    for element in single:
        if element.keyword not in outside:
            dataset.add(element)
    dataset.SOPClassUID = "1.2.840.10008.5.1.4.1.1.4.1"
    dataset.NumberOfFrames = len(order)
    shared = pydicom.Dataset()
    orientation = pydicom.Dataset()
    orientation.ImageOrientationPatient = single.ImageOrientationPatient
    shared.PlaneOrientationSequence = [orientation]
    measures = pydicom.Dataset()
    measures.PixelSpacing = single.PixelSpacing
    shared.PixelMeasuresSequence = [measures]
    dataset.SharedFunctionalGroupsSequence = [shared]
    groups = []
    for k in order:
        place = pydicom.Dataset()
        place.ImagePositionPatient = dicom_slice(volume, k, series="1.2").ImagePositionPatient
        group = pydicom.Dataset()
        group.PlanePositionSequence = [place]
        groups.append(group)
    dataset.PerFrameFunctionalGroupsSequence = groups
    dataset.PixelData = b"".join(np.ascontiguousarray(volume.data[:, :, k].T).tobytes() for k in order)
    for keyword, value in changes.items():
        setattr(dataset, keyword, value)
    return write_dicom(dataset, path)

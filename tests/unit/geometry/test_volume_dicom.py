"""DICOM: order by place, reports of irregular series, choices, and pixels."""

from __future__ import annotations

import re
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pydicom
import pytest
import SimpleITK
from pydicom.encaps import encapsulate
from pydicom.uid import (
    DeflatedExplicitVRLittleEndian,
    ExplicitVRBigEndian,
    HTJ2KLossless,
    ImplicitVRLittleEndian,
    JPEG2000Lossless,
    RLELossless,
    generate_uid,
)

from shapery_contracts.errors import InvalidInput, LimitExceeded, UserError
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import ReadLimits, read_volume, read_volume_header
from tests.support.volumes import dicom_slice, phantom, write_dicom, write_multiframe, write_series

DEPTH = phantom().shape[2]


def refusal(path: Path, **options: Any) -> UserError:
    with pytest.raises(UserError) as caught:
        read_volume(path, **options)
    return caught.value


def same_as_phantom(volume: Volume) -> None:
    canonical, _ = volume.canonical()
    np.testing.assert_array_equal(canonical.data, phantom().data)
    np.testing.assert_allclose(canonical.affine, phantom().affine, rtol=0, atol=1e-6)


class TestOrder:
    @pytest.mark.parametrize("seed", range(4))
    def test_names_and_instance_numbers_decide_nothing(self, tmp_path: Path, seed: int) -> None:
        order = np.random.default_rng(seed).permutation(DEPTH).tolist()
        write_series(tmp_path, phantom(), order=order)
        same_as_phantom(read_volume(tmp_path))

    def test_reversed_names_give_the_same_volume(self, tmp_path: Path) -> None:
        write_series(tmp_path / "up", phantom())
        write_series(tmp_path / "down", phantom(), order=range(DEPTH)[::-1])
        up, down = read_volume(tmp_path / "up"), read_volume(tmp_path / "down")
        np.testing.assert_array_equal(up.data, down.data)
        np.testing.assert_array_equal(up.affine, down.affine)

    def test_itk_sees_the_same_volume_at_the_same_place(self, tmp_path: Path) -> None:
        # ITK's reader of series is another implementation of the same standard.
        files = write_series(tmp_path, phantom())
        image = SimpleITK.ReadImage([str(path) for path in files])
        volume = read_volume(tmp_path)
        np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(image).T, volume.data)
        corner = image.TransformIndexToPhysicalPoint([6, 4, 5])
        np.testing.assert_allclose(volume.to_world([6, 4, 5]), np.array(corner) * (-1, -1, 1), atol=1e-5)

    def test_slices_in_folders_below_are_found(self, tmp_path: Path) -> None:
        files = write_series(tmp_path, phantom())
        for number, path in enumerate(files):
            below = tmp_path / f"part{number % 2}"
            below.mkdir(exist_ok=True)
            path.rename(below / path.name)
        same_as_phantom(read_volume(tmp_path))

    def test_what_is_no_image_is_left_out_and_named(self, tmp_path: Path) -> None:
        write_series(tmp_path, phantom())
        (tmp_path / "README.txt").write_text("exported yesterday")
        report = dicom_slice(phantom(), 0, series="1.2.3")
        report.SOPClassUID = report.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.88.11"
        for keyword in ("PixelData", "Rows", "Columns"):
            delattr(report, keyword)
        write_dicom(report, tmp_path / "report.dcm")
        volume = read_volume(tmp_path)
        same_as_phantom(volume)
        assert len(volume.warnings) == 1
        assert "2 files" in volume.warnings[0]
        assert "README.txt" in volume.warnings[0]
        assert "report.dcm" in volume.warnings[0]

    def test_a_tilted_gantry_gives_a_sheared_volume(self, tmp_path: Path) -> None:
        affine = np.array([[0.8, 0, 0, -3], [0, 0.9, 0.6, 4], [0, 0, 2.0, 5], [0, 0, 0, 1]])
        tilted = Volume(phantom().data, affine)
        write_series(tmp_path, tilted)
        volume = read_volume(tmp_path)
        canonical, _ = volume.canonical()
        np.testing.assert_allclose(canonical.affine, affine, rtol=0, atol=1e-6)
        np.testing.assert_array_equal(canonical.data, tilted.data)
        assert f"{np.degrees(np.arctan(0.3)):.1f}°" in volume.warnings[0]

    def test_positions_rounded_to_a_tenth_are_accepted_with_a_warning(self, tmp_path: Path) -> None:
        affine = np.diag([1.0, 1.0, 0.75, 1.0])
        deep = Volume(np.arange(3 * 4 * 20, dtype=np.int16).reshape(3, 4, 20), affine)
        for k in range(20):
            place = [0, 0, f"{k * 0.75:.1f}"]
            write_dicom(dicom_slice(deep, k, series="1.2.3", ImagePositionPatient=place), tmp_path / f"{k}.dcm")
        volume = read_volume(tmp_path)
        assert volume.spacing[2] == pytest.approx(0.75, abs=0.005)
        assert "varies between 0.700 and 0.800 mm" in volume.warnings[0]


class TestIrregular:
    def test_a_gap_is_reported_with_files_and_distances(self, tmp_path: Path) -> None:
        files = write_series(tmp_path, phantom())
        files[3].unlink()
        error = refusal(tmp_path)
        assert error.code == "irregular_series"
        assert "2.500 mm apart" in error.message
        assert "5.000 mm between image-0002.dcm" in error.message
        assert "image-0004.dcm" in error.message
        assert "1 slice is missing" in error.message

    @pytest.mark.parametrize("missing", [1, DEPTH - 2])
    @pytest.mark.parametrize("count", [4, 5, 40])
    def test_a_gap_beside_the_last_slice_is_noticed(self, tmp_path: Path, missing: int, count: int) -> None:
        deep = Volume(np.arange(2 * 2 * count, dtype=np.int16).reshape(2, 2, count), np.diag([1.0, 1, 3, 1]))
        files = write_series(tmp_path, deep)
        files[1 if missing == 1 else count - 2].unlink()
        assert refusal(tmp_path).code == "irregular_series"

    def test_the_first_or_last_slice_is_not_missed(self, tmp_path: Path) -> None:
        files = write_series(tmp_path, phantom())
        files[0].unlink()
        np.testing.assert_array_equal(read_volume(tmp_path).canonical()[0].data, phantom().data[:, :, 1:])

    def test_a_drifting_distance_is_reported(self, tmp_path: Path) -> None:
        deep = Volume(np.zeros((3, 4, 30), np.int16), np.eye(4))
        for k in range(30):
            place = [0, 0, k + 0.005 * k * k]
            write_dicom(dicom_slice(deep, k, series="1.2.3", ImagePositionPatient=place), tmp_path / f"{k}.dcm")
        error = refusal(tmp_path)
        assert error.code == "irregular_series"
        assert "1.0" in error.message

    def test_a_doubled_position_is_reported_with_both_files(self, tmp_path: Path) -> None:
        files = write_series(tmp_path, phantom())
        other = pydicom.dcmread(files[2])
        other.SOPInstanceUID = generate_uid()
        write_dicom(other, tmp_path / "copy.dcm")
        error = refusal(tmp_path)
        assert error.code == "irregular_series"
        assert "copy.dcm" in error.message
        assert "image-0002.dcm" in error.message

    def test_the_same_file_twice_everywhere_is_no_second_time_point(self, tmp_path: Path) -> None:
        write_series(tmp_path, phantom())
        for path in list(tmp_path.iterdir()):
            (tmp_path / f"again-{path.name}").write_bytes(path.read_bytes())
        error = refusal(tmp_path)
        assert error.code == "irregular_series"
        assert "one slice twice" in error.message

    def test_a_localizer_in_the_series_is_named(self, tmp_path: Path) -> None:
        write_series(tmp_path, phantom(), series="1.2.3")
        localizer = dicom_slice(phantom(), 0, series="1.2.3", ImageOrientationPatient=[0, 1, 0, 0, 0, -1])
        write_dicom(localizer, tmp_path / "scout.dcm")
        error = refusal(tmp_path)
        assert error.code == "irregular_series"
        assert "2 different orientations" in error.message
        assert "scout.dcm" in error.message

    @pytest.mark.parametrize(
        ("changes", "part"),
        [
            ({"PixelSpacing": [9, 9]}, "2 different pixel spacings"),
            ({"ImagePositionPatient": None}, "1 of 6 slices do not say where they lie"),
            ({"ImageOrientationPatient": None}, "do not say where they lie"),
            ({"ImageOrientationPatient": [0, 0, 0, 0, 0, 0]}, "do not say where they lie"),
            ({"PixelSpacing": None}, "no pixel spacing"),
            ({"pixels": np.zeros((9, 9), np.int16)}, "2 different sizes"),
            ({"ImageOrientationPatient": [1, 0, 0, 0.02, 0.9998, 0]}, "orientations"),
        ],
    )
    def test_one_odd_slice_is_reported(self, tmp_path: Path, changes: dict[str, Any], part: str) -> None:
        plain = Volume(phantom().data, np.diag([1.0, 1, 2, 1]))
        write_series(tmp_path, plain, series="1.2.3")
        write_dicom(dicom_slice(plain, 2, series="1.2.3", **changes), tmp_path / "image-0002.dcm")
        error = refusal(tmp_path)
        assert error.code == "irregular_series"
        assert part in error.message
        assert "image-0002.dcm" in error.message

    def test_a_slice_beside_the_stack_is_reported(self, tmp_path: Path) -> None:
        plain = Volume(phantom().data, np.diag([1.0, 1, 2, 1]))
        write_series(tmp_path, plain, series="1.2.3")
        moved = dicom_slice(plain, 2, series="1.2.3", ImagePositionPatient=[3, 0, 4])
        write_dicom(moved, tmp_path / "image-0002.dcm")
        error = refusal(tmp_path)
        assert error.code == "irregular_series"
        assert "image-0002.dcm" in error.message
        assert "beside its neighbours" in error.message

    def test_skewed_rows_and_columns_are_refused(self, tmp_path: Path) -> None:
        write_series(tmp_path, phantom(), ImageOrientationPatient=[1, 0, 0, 0.1, 0.995, 0])
        assert "right angles" in refusal(tmp_path).message


class TestSeries:
    def test_several_are_listed_and_one_can_be_chosen(self, tmp_path: Path) -> None:
        write_series(tmp_path / "a", phantom(), series="1.2.3.1")
        write_series(tmp_path / "b", phantom().with_data(-phantom().data), series="1.2.3.2", SeriesDescription="after")
        error = refusal(tmp_path)
        assert error.code == "mixed_series"
        for part in ("2 series", "MR phantom: 6 slices of 7×5, series 1.2.3.1", "MR after", "1.2.3.2"):
            assert part in error.message
        np.testing.assert_array_equal(read_volume(tmp_path, series="1.2.3.2").canonical()[0].data, -phantom().data)
        assert read_volume(tmp_path, series="1.2.3.1").warnings == ("6 slices of other series were left out.",)
        assert refusal(tmp_path, series="9.9").code == "mixed_series"

    def test_a_series_of_the_other_is_not_needed_to_be_sound(self, tmp_path: Path) -> None:
        write_series(tmp_path, phantom(), series="1.2.3.1")
        write_dicom(dicom_slice(phantom(), 0, series="1.2.3.2", PixelSpacing=None), tmp_path / "z.dcm")
        same_as_phantom(read_volume(tmp_path, series="1.2.3.1"))

    def test_time_points_are_frames(self, tmp_path: Path) -> None:
        for time in range(3):
            later = phantom().with_data(phantom().data + np.int16(1000 * time))
            write_series(tmp_path / f"{2 - time}", later, series="1.2.3", TemporalPositionIdentifier=time + 1)
        assert "3 volumes" in refusal(tmp_path).message
        assert read_volume_header(tmp_path).frames == 3
        for time in range(3):
            volume = read_volume(tmp_path, frame=time)
            np.testing.assert_array_equal(volume.canonical()[0].data, phantom().data + 1000 * time)


class TestMultiframe:
    def test_frames_are_ordered_by_place(self, tmp_path: Path) -> None:
        path = write_multiframe(tmp_path / "v.dcm", phantom(), order=[5, 0, 3, 1, 4, 2])
        same_as_phantom(read_volume(path))

    def test_a_gap_names_the_frames(self, tmp_path: Path) -> None:
        path = write_multiframe(tmp_path / "v.dcm", phantom(), order=[0, 1, 3, 4, 5])
        error = refusal(path)
        assert error.code == "irregular_series"
        assert "v.dcm frame 1" in error.message

    def test_counts_that_contradict_each_other_are_refused(self, tmp_path: Path) -> None:
        path = write_multiframe(tmp_path / "v.dcm", phantom(), NumberOfFrames=7)
        assert refusal(path).code == "corrupt_file"
        path = write_multiframe(tmp_path / "w.dcm", phantom(), NumberOfFrames=10**9)
        assert refusal(path).code == "corrupt_file"

    def test_frames_without_places_are_refused(self, tmp_path: Path) -> None:
        path = write_multiframe(tmp_path / "v.dcm", phantom())
        dataset = pydicom.dcmread(path)
        del dataset.PerFrameFunctionalGroupsSequence
        write_dicom(dataset, path)
        error = refusal(path)
        assert error.code == "unsupported_format"
        assert "6 frames" in error.message


class TestValues:
    @pytest.mark.parametrize(
        ("changes", "dtype", "expected"),
        [
            ({}, np.int16, phantom().data),
            ({"RescaleSlope": 1, "RescaleIntercept": -1024}, np.int32, phantom().data.astype(np.int32) - 1024),
            ({"RescaleSlope": 0.5, "RescaleIntercept": 3}, np.float32, phantom().data * 0.5 + 3),
            ({"RescaleSlope": 1, "RescaleIntercept": 0.5}, np.float32, phantom().data + 0.5),
            ({"RescaleSlope": 0, "RescaleIntercept": 0}, np.int16, phantom().data),
            (
                {"RescaleSlope": 1, "RescaleIntercept": -1024, "BitsStored": 12, "HighBit": 11},
                np.int16,
                phantom().data - 1024,
            ),
        ],
    )
    def test_rescaling(self, tmp_path: Path, changes: dict[str, Any], dtype: type, expected: np.ndarray) -> None:
        write_series(tmp_path, phantom(), **changes)
        canonical, _ = read_volume(tmp_path).canonical()
        assert canonical.data.dtype == dtype
        np.testing.assert_array_equal(canonical.data, expected)

    def test_each_slice_has_a_slope_of_its_own(self, tmp_path: Path) -> None:
        for k in range(DEPTH):
            one = dicom_slice(phantom(), k, series="1.2.3", RescaleSlope=k + 1, RescaleIntercept=-k)
            write_dicom(one, tmp_path / f"{k}.dcm")
        canonical, _ = read_volume(tmp_path).canonical()
        np.testing.assert_array_equal(canonical.data, phantom().data * (np.arange(DEPTH) + 1.0) - np.arange(DEPTH))

    def test_bits_above_the_stored_ones_are_left_out(self, tmp_path: Path) -> None:
        for signed in (0, 1):
            folder = tmp_path / str(signed)
            values = (phantom().data - (100 if signed else 0)).astype(np.int16)
            overlaid = phantom().with_data(((values & 0x0FFF) | 0x7000).astype(np.int16))
            write_series(folder, overlaid, BitsStored=12, HighBit=11, PixelRepresentation=signed)
            canonical, _ = read_volume(folder).canonical()
            np.testing.assert_array_equal(canonical.data, values)

    def test_inverted_grey_is_reported(self, tmp_path: Path) -> None:
        write_series(tmp_path, phantom(), PhotometricInterpretation="MONOCHROME1")
        volume = read_volume(tmp_path)
        assert "MONOCHROME1" in volume.warnings[0]
        same_as_phantom(volume)

    def test_colours_need_a_component(self, tmp_path: Path) -> None:
        colours = np.random.default_rng(0).integers(0, 256, (*phantom().shape, 3), dtype=np.uint8)
        uid = generate_uid()
        for k in range(DEPTH):
            pixels = np.ascontiguousarray(colours[:, :, k].transpose(1, 0, 2))
            changes = {"SamplesPerPixel": 3, "PhotometricInterpretation": "RGB", "PlanarConfiguration": 0}
            write_dicom(dicom_slice(phantom(), k, series=uid, pixels=pixels, **changes), tmp_path / f"{k}.dcm")
        assert "colours (RGB)" in refusal(tmp_path).message
        canonical, _ = read_volume(tmp_path, component="blue").canonical()
        np.testing.assert_array_equal(canonical.data, colours[..., 2])

    def test_a_palette_is_refused(self, tmp_path: Path) -> None:
        write_series(tmp_path, phantom(), PhotometricInterpretation="PALETTE COLOR")
        assert "palette" in refusal(tmp_path).message


def transcoded(folder: Path, syntax: str, volume: Volume) -> None:
    """Write a series under another uncompressed transfer syntax."""
    folder.mkdir(exist_ok=True)
    for k in range(volume.shape[2]):
        dataset = dicom_slice(volume, k, series="1.2.3")
        dataset.file_meta.TransferSyntaxUID = syntax
        little = syntax != ExplicitVRBigEndian
        if not little:
            dataset.PixelData = volume.data[:, :, k].T.astype(">i2").tobytes()
        pydicom.dcmwrite(
            folder / f"{k}.dcm",
            dataset,
            implicit_vr=syntax == ImplicitVRLittleEndian,
            little_endian=little,
            enforce_file_format=True,
        )


class TestTransferSyntaxes:
    @pytest.mark.parametrize("syntax", [ImplicitVRLittleEndian, ExplicitVRBigEndian, DeflatedExplicitVRLittleEndian])
    def test_uncompressed(self, tmp_path: Path, syntax: str) -> None:
        transcoded(tmp_path, syntax, phantom())
        same_as_phantom(read_volume(tmp_path))

    def test_explicit_files_that_declare_themselves_implicit(self, tmp_path: Path) -> None:
        for path in write_series(tmp_path, phantom()):
            raw = path.read_bytes()
            assert raw.count(b"1.2.840.10008.1.2.1\0") == 1
            path.write_bytes(raw.replace(b"1.2.840.10008.1.2.1\0", b"1.2.840.10008.1.2\0\0\0"))
        same_as_phantom(read_volume(tmp_path))

    def test_run_lengths(self, tmp_path: Path) -> None:
        for k in range(DEPTH):
            dataset = dicom_slice(phantom(), k, series="1.2.3")
            dataset.compress(RLELossless, encoding_plugin="pydicom")
            write_dicom(dataset, tmp_path / f"{k}.dcm")
        same_as_phantom(read_volume(tmp_path))

    def test_jpeg_2000_single_and_multi_frame(self, tmp_path: Path) -> None:
        volume = Volume(np.random.default_rng(0).integers(0, 4000, (24, 20, 5), dtype=np.uint16), phantom().affine)
        frames = [self.jpeg_2000(tmp_path, np.ascontiguousarray(volume.data[:, :, k].T)) for k in range(5)]
        for k, frame in enumerate(frames):
            dataset = dicom_slice(volume, k, series="1.2.3", RescaleSlope=2, RescaleIntercept=1)
            dataset.file_meta.TransferSyntaxUID = JPEG2000Lossless
            dataset.PixelData = encapsulate([frame])
            (tmp_path / "series").mkdir(exist_ok=True)
            write_dicom(dataset, tmp_path / "series" / f"{k}.dcm")
        np.testing.assert_array_equal(read_volume(tmp_path / "series").canonical()[0].data, volume.data * 2.0 + 1)
        order = [4, 1, 3, 0, 2]
        path = write_multiframe(tmp_path / "v.dcm", volume, order=order)
        dataset = pydicom.dcmread(path)
        dataset.file_meta.TransferSyntaxUID = JPEG2000Lossless
        dataset.PixelData = encapsulate([frames[k] for k in order])
        write_dicom(dataset, path)
        again = read_volume(path)
        assert again.data.dtype == np.uint16
        np.testing.assert_array_equal(again.canonical()[0].data, volume.data)

    @staticmethod
    def jpeg_2000(folder: Path, pixels: np.ndarray) -> bytes:
        """One frame compressed by ITK, taken out of the file it writes."""
        image = SimpleITK.GetImageFromArray(pixels)
        writer = SimpleITK.ImageFileWriter()
        writer.SetImageIO("GDCMImageIO")
        writer.SetFileName(str(folder / "one.dcm"))
        writer.UseCompressionOn()
        writer.SetCompressor("JPEG2000")
        writer.Execute(image)
        dataset = pydicom.dcmread(folder / "one.dcm")
        assert dataset.file_meta.TransferSyntaxUID == JPEG2000Lossless
        (folder / "one.dcm").unlink()
        return next(pydicom.encaps.generate_frames(dataset.PixelData, number_of_frames=1))

    def test_damaged_compression_is_refused(self, tmp_path: Path) -> None:
        for k in range(DEPTH):
            dataset = dicom_slice(phantom(), k, series="1.2.3")
            dataset.file_meta.TransferSyntaxUID = JPEG2000Lossless
            dataset.PixelData = encapsulate([b"\xff\x4f\xff\x51" + bytes(60)])
            write_dicom(dataset, tmp_path / f"{k}.dcm")
        assert refusal(tmp_path).code == "corrupt_file"

    def test_what_cannot_be_decoded_is_refused_by_name(self, tmp_path: Path) -> None:
        for k in range(DEPTH):
            dataset = dicom_slice(phantom(), k, series="1.2.3")
            dataset.file_meta.TransferSyntaxUID = HTJ2KLossless
            dataset.PixelData = encapsulate([bytes(64)])
            write_dicom(dataset, tmp_path / f"{k}.dcm")
        error = refusal(tmp_path)
        assert error.code == "unsupported_format"
        assert "High-Throughput JPEG 2000" in error.message

    def test_a_deflated_bomb_is_stopped(self, tmp_path: Path) -> None:
        transcoded(tmp_path, DeflatedExplicitVRLittleEndian, Volume(np.zeros((512, 512, 2), np.int16), np.eye(4)))
        packed = next(tmp_path.iterdir()).stat().st_size
        error = refusal(tmp_path, limits=ReadLimits(bytes=200_000))
        assert packed < 200_000
        assert isinstance(error, LimitExceeded)
        assert error.code == "too_large"


def test_of_a_zip_nothing_is_unpacked_but_headers_and_the_chosen_slices(tmp_path: Path) -> None:
    zeros = bytes(40 << 20)
    with zipfile.ZipFile(tmp_path / "v.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for path in write_series(tmp_path / "s", phantom(), series="1.2.3"):
            archive.write(path, path.name)
        archive.writestr("movie.avi", zeros)
        # Its pixels stand at the beginning, and much follows them.
        other = (tmp_path / "s" / "image-0000.dcm").read_bytes().replace(b"1.2.3\0", b"1.2.4\0")
        archive.writestr("z.dcm", other + zeros)
    tracemalloc.start()
    try:
        volume = read_volume(tmp_path / "v.zip", series="1.2.3")
        assert tracemalloc.get_traced_memory()[1] < 10 << 20
    finally:
        tracemalloc.stop()
    same_as_phantom(volume)
    assert any("movie.avi" in warning for warning in volume.warnings)


def test_a_header_in_a_zip_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shapery_geometry.volume_io.dicom.HEADER_LIMIT", 1 << 20)
    with zipfile.ZipFile(tmp_path / "v.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for k in range(DEPTH):
            swollen = dicom_slice(phantom(), k, series="1.2.3")
            swollen.add_new(0x00090010, "LO", "PRIVATE")
            swollen.add_new(0x00091010, "OB", bytes(2 << 20))
            archive.write(write_dicom(swollen, tmp_path / "s.dcm"), f"{k}.dcm")
    error = refusal(tmp_path / "v.zip")
    assert error.code == "too_large"
    assert "0.dcm" in error.message


class TestDamage:
    def test_a_truncated_slice_is_named(self, tmp_path: Path) -> None:
        files = write_series(tmp_path, phantom())
        raw = files[4].read_bytes()
        for kept in (len(raw) - 10, len(raw) // 2, 200):
            files[4].write_bytes(raw[:kept])
            error = refusal(tmp_path)
            assert error.code == "corrupt_file"
            assert "image-0004.dcm" in error.message

    def test_a_damaged_slice_in_a_zip_is_named(self, tmp_path: Path) -> None:
        files = write_series(tmp_path / "s", phantom())
        files[4].write_bytes(files[4].read_bytes()[:-10])
        with zipfile.ZipFile(tmp_path / "v.zip", "w") as archive:
            for path in files:
                archive.write(path, path.name)
        assert "image-0004.dcm" in refusal(tmp_path / "v.zip").message

    def test_no_word_of_the_patient_gets_into_messages_or_headers(self, tmp_path: Path) -> None:
        write_series(tmp_path, phantom(), PatientName="Doe^Jane", PatientID="12345")
        header = read_volume_header(tmp_path)
        next(iter(sorted(tmp_path.iterdir()))).rename(tmp_path / "x.txt")
        (tmp_path / "image-0003.dcm").unlink()
        text = f"{header} {refusal(tmp_path)}"
        assert not re.search("Doe|Jane|12345", text)


def test_the_real_series_and_its_zip_agree_with_itk(shared_data: Path, tmp_path: Path) -> None:
    folder = shared_data / "volumes" / "dicom_t1_decubitus"
    volume = read_volume(folder)
    names = SimpleITK.ImageSeriesReader.GetGDCMSeriesFileNames(str(folder))
    image = SimpleITK.ReadImage(names)
    expected = SimpleITK.GetArrayFromImage(image).T
    assert volume.shape == (256, 256, 35)
    np.testing.assert_array_equal(volume.data, expected)
    for index in ([0, 0, 0], [255, 0, 34], [10, 200, 3]):
        point = np.array(image.TransformIndexToPhysicalPoint(index)) * (-1, -1, 1)
        np.testing.assert_allclose(volume.to_world(index), point, atol=1e-4)
    with zipfile.ZipFile(tmp_path / "series.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for number, path in enumerate(sorted(folder.iterdir(), key=lambda p: p.name[::-1])):
            archive.write(path, f"export/{number}")
    packed = read_volume(tmp_path / "series.zip")
    np.testing.assert_array_equal(packed.data, volume.data)
    np.testing.assert_array_equal(packed.affine, volume.affine)


def test_limits_hold_before_a_pixel_is_read(tmp_path: Path) -> None:
    write_series(tmp_path, phantom(), Rows=60000, Columns=60000)
    with pytest.raises(InvalidInput, match="truncated"):
        read_volume(tmp_path)

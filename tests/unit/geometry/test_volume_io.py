"""Reading and writing of volumes: one frame inside, whatever the format and the order of the axes."""

from __future__ import annotations

import bz2
import gzip
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import nibabel as nib
import nrrd
import numpy as np
import pytest
import SimpleITK

from shapery_contracts.errors import InvalidInput, LimitExceeded, UserError
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import ReadLimits, read_volume, read_volume_header, write_nifti
from tests.support.volumes import (
    ORIENTATIONS,
    all_orientations,
    dicom_slice,
    phantom,
    stored_as,
    write_dicom,
    write_multiframe,
    write_series,
)

LPS = np.diag([-1.0, -1.0, 1.0])


def write_with_nibabel(volume: Volume, path: Path, *, kind: type = nib.Nifti1Image, form: str = "both") -> Path:
    image = kind(volume.data, volume.affine)
    image.set_sform(volume.affine, 0 if form == "qform" else 1)
    image.set_qform(volume.affine, 0 if form == "sform" else 1)
    nib.save(image, path)
    return path


def write_with_itk(volume: Volume, path: Path, *, compressed: bool = False) -> Path:
    image = SimpleITK.GetImageFromArray(np.ascontiguousarray(volume.data.T))
    axes = LPS @ volume.affine[:3, :3]
    image.SetSpacing(volume.spacing)
    image.SetDirection((axes / np.array(volume.spacing)).ravel().tolist())
    image.SetOrigin((LPS @ volume.affine[:3, 3]).tolist())
    SimpleITK.WriteImage(image, str(path), useCompression=compressed)
    return path


def write_with_pynrrd(
    volume: Volume,
    path: Path,
    *,
    space: str = "left-posterior-superior",
    encoding: str = "gzip",
    detached: bool = False,
) -> Path:
    signs = {"l": np.array([-1.0, 1, 1]), "r": np.array([1.0, 1, 1])}[space[0]]
    if "posterior" in space:
        signs = signs * (1, -1, 1)
    header = {
        "space": space,
        "space directions": (volume.affine[:3, :3] * signs[:, None]).T,
        "space origin": volume.affine[:3, 3] * signs,
        "kinds": ["domain"] * 3,
        "encoding": encoding,
    }
    nrrd.write(str(path), volume.data, header, detached_header=detached)
    return path


def zipped(folder: Path, path: Path) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.iterdir()):
            archive.write(file, f"export/{file.name}")
    return path


def ours(suffix: str) -> Callable[[Volume, Path], Path]:
    def write(volume: Volume, folder: Path) -> Path:
        write_nifti(volume, folder / f"v{suffix}")
        return folder / f"v{suffix}"

    return write


def series(volume: Volume, folder: Path) -> Path:
    # The order of names and instance numbers has nothing to do with the order of places.
    write_series(folder / "series", volume, order=np.random.default_rng(1).permutation(volume.shape[2]).tolist())
    return folder / "series"


def pair(volume: Volume, folder: Path, extension: str) -> Path:
    inner = folder / "pair"
    inner.mkdir()
    write: Callable[..., Path] = write_with_itk if extension == ".mhd" else write_with_pynrrd
    options = {} if extension == ".mhd" else {"detached": True}
    write(volume, inner / f"v{extension}", **options)
    assert len(list(inner.iterdir())) == 2
    return inner


WRITERS: dict[str, Callable[[Volume, Path], Path]] = {
    "our nii": ours(".nii"),
    "our nii.gz": ours(".nii.gz"),
    "nibabel nifti1": lambda v, d: write_with_nibabel(v, d / "v.nii.gz"),
    "nibabel nifti1 qform": lambda v, d: write_with_nibabel(v, d / "v.nii", form="qform"),
    "nibabel nifti1 sform": lambda v, d: write_with_nibabel(v, d / "v.nii", form="sform"),
    "nibabel nifti2": lambda v, d: write_with_nibabel(v, d / "v.nii", kind=nib.Nifti2Image),
    "itk nii": lambda v, d: write_with_itk(v, d / "v.nii"),
    "mha": lambda v, d: write_with_itk(v, d / "v.mha"),
    "mha compressed": lambda v, d: write_with_itk(v, d / "v.mha", compressed=True),
    "mhd and raw in a folder": lambda v, d: pair(v, d, ".mhd"),
    "mhd and raw in a zip": lambda v, d: zipped(pair(v, d, ".mhd"), d / "v.zip"),
    "mhd beside its raw": lambda v, d: pair(v, d, ".mhd") / "v.mhd",
    "nrrd lps": lambda v, d: write_with_pynrrd(v, d / "v.nrrd"),
    "nrrd ras raw": lambda v, d: write_with_pynrrd(v, d / "v.nrrd", space="right-anterior-superior", encoding="raw"),
    "nrrd las bzip2": lambda v, d: write_with_pynrrd(v, d / "v.nrrd", space="left-anterior-superior", encoding="bzip2"),
    "nrrd text": lambda v, d: write_with_pynrrd(v, d / "v.nrrd", encoding="ASCII"),
    "nrrd detached in a folder": lambda v, d: pair(v, d, ".nhdr"),
    "nrrd detached in a zip": lambda v, d: zipped(pair(v, d, ".nhdr"), d / "v.zip"),
    "itk nrrd": lambda v, d: write_with_itk(v, d / "v.nrrd"),
    "dicom series": series,
    "dicom zip": lambda v, d: zipped(series(v, d), d / "v.zip"),
    "dicom multi-frame": lambda v, d: write_multiframe(d / "v.dcm", v, order=[3, 1, 0, 2, *range(4, v.shape[2])]),
}


@pytest.mark.parametrize("name", WRITERS)
def test_the_phantom_comes_back_from_all_48_orientations(name: str, tmp_path: Path) -> None:
    expected = phantom()
    for number, stored in enumerate(all_orientations(expected)):
        folder = tmp_path / str(number)
        folder.mkdir()
        volume = read_volume(WRITERS[name](stored, folder))
        canonical, reorientation = volume.canonical()
        np.testing.assert_array_equal(canonical.data, expected.data)
        # Of the quaternion's four numbers three are stored, in float32: an error of 1e-7 turns a corner by 1e-5 mm.
        np.testing.assert_allclose(canonical.affine, expected.affine, rtol=0, atol=5e-5)
        assert volume.data.dtype == np.int16
        assert volume.data.flags.c_contiguous
        assert volume.warnings == ()
        if not name.startswith("dicom"):
            # Slices are ordered by place; every other format keeps the order of its file.
            np.testing.assert_array_equal(volume.data, stored.data)
            assert volume.same_grid(stored)
        result = reorientation.undo(canonical)
        assert volume.same_grid(result, tolerance=0.0)
        np.testing.assert_array_equal(result.data, volume.data)


def test_a_result_on_the_input_grid_has_the_affine_that_other_programs_read(tmp_path: Path) -> None:
    for axes, flips in ORIENTATIONS[::5]:
        stored = stored_as(phantom(), axes, flips)
        path = write_with_nibabel(stored, tmp_path / "in.nii.gz")
        volume = read_volume(path)
        canonical, reorientation = volume.canonical()
        labels = reorientation.undo(canonical.with_data((canonical.data > 50).astype(np.uint8)))
        write_nifti(labels, tmp_path / "labels.nii.gz")
        before, after = nib.load(path), nib.load(tmp_path / "labels.nii.gz")
        np.testing.assert_array_equal(np.asarray(after.dataobj), np.asarray(before.dataobj) > 50)
        assert after.affine.tobytes() == before.affine.tobytes()
        assert after.get_data_dtype() == np.uint8


class TestWriteNifti:
    def test_other_programs_read_what_is_written(self, tmp_path: Path) -> None:
        for dtype in ("uint8", "int16", "uint16", "int32", "float32", "float64", "int64"):
            volume = Volume(phantom().data.astype(dtype), phantom().affine)
            write_nifti(volume, tmp_path / "v.nii.gz")
            image = nib.load(tmp_path / "v.nii.gz")
            assert image.get_data_dtype() == dtype
            np.testing.assert_array_equal(np.asarray(image.dataobj), volume.data)
            np.testing.assert_allclose(image.get_sform(), volume.affine, rtol=1e-6)
            np.testing.assert_allclose(image.get_qform(), volume.affine, rtol=0, atol=1e-5)
            itk = SimpleITK.ReadImage(str(tmp_path / "v.nii.gz"))
            np.testing.assert_allclose(itk.GetSpacing(), volume.spacing, rtol=1e-5)
            np.testing.assert_allclose(itk.GetOrigin(), LPS @ volume.affine[:3, 3], rtol=1e-5)

    def test_the_same_volume_gives_the_same_bytes(self, tmp_path: Path) -> None:
        write_nifti(phantom(), tmp_path / "a.nii.gz")
        write_nifti(phantom(), tmp_path / "another name.nii.gz")
        assert (tmp_path / "a.nii.gz").read_bytes() == (tmp_path / "another name.nii.gz").read_bytes()
        assert sorted(p.name for p in tmp_path.iterdir()) == ["a.nii.gz", "another name.nii.gz"]

    def test_a_sheared_affine_goes_into_the_sform_alone(self, tmp_path: Path) -> None:
        affine = np.array([[0.5, 0, 0, 1], [0, 0.5, 0, 2], [0, 0.25, 2, 3], [0, 0, 0, 1]])
        write_nifti(Volume(phantom().data, affine), tmp_path / "v.nii")
        assert nib.load(tmp_path / "v.nii").header["qform_code"] == 0
        np.testing.assert_array_equal(read_volume(tmp_path / "v.nii").affine, affine)

    def test_bool_and_half_precision_become_what_every_program_reads(self, tmp_path: Path) -> None:
        write_nifti(Volume(phantom().data > 50, np.eye(4)), tmp_path / "b.nii")
        assert read_volume(tmp_path / "b.nii").data.dtype == np.uint8
        write_nifti(Volume(phantom().data.astype(np.float16), np.eye(4)), tmp_path / "h.nii")
        assert read_volume(tmp_path / "h.nii").data.dtype == np.float32

    def test_axes_too_long_for_nifti1_are_written_as_nifti2(self, tmp_path: Path) -> None:
        volume = Volume(np.arange(2 * 2 * 40000, dtype=np.int32).reshape(2, 2, 40000), phantom().affine)
        write_nifti(volume, tmp_path / "v.nii.gz")
        assert read_volume_header(tmp_path / "v.nii.gz").format == "nifti2"
        again = read_volume(tmp_path / "v.nii.gz")
        np.testing.assert_array_equal(again.data, volume.data)
        np.testing.assert_array_equal(again.affine, volume.affine)
        np.testing.assert_array_equal(nib.load(tmp_path / "v.nii.gz").affine, volume.affine)

    def test_a_failure_leaves_nothing_behind(self, tmp_path: Path) -> None:
        with pytest.raises(ValueError, match=r"\.nii or \.nii\.gz"):
            write_nifti(phantom(), tmp_path / "v.img")
        with pytest.raises(InvalidInput, match="NIfTI has no type"):
            write_nifti(Volume(phantom().data.astype(np.longdouble), np.eye(4)), tmp_path / "v.nii")
        assert list(tmp_path.iterdir()) == []


class TestNiftiHeaders:
    """Fields that real files get wrong, each written into a sound file."""

    @pytest.fixture
    def edited(self, tmp_path: Path) -> Callable[..., Path]:
        def edit(*changes: tuple[int, str, tuple[float, ...]], data: np.ndarray | None = None) -> Path:
            volume = phantom() if data is None else Volume(data, phantom().affine)
            raw = bytearray(write_with_nibabel(volume, tmp_path / "sound.nii").read_bytes())
            for offset, layout, values in changes:
                struct.pack_into("<" + layout, raw, offset, *values)
            path = tmp_path / "edited.nii"
            path.write_bytes(raw)
            return path

        return edit

    @pytest.mark.parametrize("slope", [(np.nan, np.nan), (0.0, 7.0), (1.0, 0.0), (np.inf, 0.0), (2.0, np.nan)])
    def test_a_slope_that_means_nothing_leaves_the_integers(self, edited: Callable[..., Path], slope: tuple) -> None:
        volume = read_volume(edited((112, "2f", slope)))
        np.testing.assert_array_equal(volume.data, phantom().data)
        assert volume.data.dtype == np.int16

    def test_a_slope_scales_to_floats(self, edited: Callable[..., Path]) -> None:
        volume = read_volume(edited((112, "2f", (0.5, -3.0))))
        assert volume.data.dtype == np.float32
        np.testing.assert_array_equal(volume.data, phantom().data * 0.5 - 3)

    def test_wide_integers_are_scaled_in_double_precision(self, edited: Callable[..., Path]) -> None:
        data = phantom().data.astype(np.int32) + 2**30
        volume = read_volume(edited((112, "2f", (2.0, 1.0)), data=data))
        assert volume.data.dtype == np.float64
        np.testing.assert_array_equal(volume.data, data * 2.0 + 1)

    def test_without_sform_the_qform_holds(self, edited: Callable[..., Path]) -> None:
        volume = read_volume(edited((254, "h", (0,)), (280, "12f", (9.0,) * 12)))
        np.testing.assert_allclose(volume.affine, phantom().affine, rtol=0, atol=1e-5)
        assert volume.warnings == ()

    def test_with_qform_code_0_the_sform_holds(self, edited: Callable[..., Path]) -> None:
        volume = read_volume(edited((252, "h", (0,)), (256, "6f", (0.5,) * 6)))
        np.testing.assert_allclose(volume.affine, phantom().affine, rtol=1e-6)
        assert volume.warnings == ()

    def test_with_both_codes_0_only_the_spacing_is_known_and_a_warning_says_so(
        self, edited: Callable[..., Path]
    ) -> None:
        path = edited((252, "2h", (0, 0)))
        volume = read_volume(path)
        assert volume.spacing == pytest.approx(phantom().spacing, rel=1e-6)
        np.testing.assert_allclose(volume.affine, nib.load(path).affine, rtol=1e-6)
        assert "only its spacing is known" in volume.warnings[0]

    def test_two_orientations_that_differ_are_reported_with_the_distance(self, edited: Callable[..., Path]) -> None:
        volume = read_volume(edited((268, "3f", (0.0, 0.0, 0.0))))
        np.testing.assert_allclose(volume.affine, phantom().affine, rtol=1e-6)
        assert "differ by up to" in volume.warnings[0]

    def test_a_flat_sform_gives_way_to_the_qform(self, edited: Callable[..., Path]) -> None:
        volume = read_volume(edited((280, "12f", (0.0,) * 12)))
        np.testing.assert_allclose(volume.affine, phantom().affine, rtol=0, atol=1e-5)
        assert "cannot be used" in volume.warnings[0]

    def test_a_flat_sform_alone_is_refused(self, edited: Callable[..., Path]) -> None:
        with pytest.raises(InvalidInput, match="spacing 0, 0, 0 mm") as caught:
            read_volume(edited((252, "h", (0,)), (280, "12f", (0.0,) * 12)))
        assert caught.value.code == "invalid_volume"

    @pytest.mark.parametrize(("unit", "factor"), [(1, 1000.0), (2, 1.0), (3, 0.001), (0, 1.0), (10, 1.0)])
    def test_lengths_become_millimetres(self, edited: Callable[..., Path], unit: int, factor: float) -> None:
        volume = read_volume(edited((123, "b", (unit,))))
        np.testing.assert_allclose(volume.affine[:3], phantom().affine[:3] * factor, rtol=1e-6)
        assert any("converted to mm" in w for w in volume.warnings) == (factor != 1.0)

    def test_a_half_turn_in_the_quaternion(self, tmp_path: Path) -> None:
        # There a = 0, where the plain formula for the quaternion divides by zero and rounding can make a² negative.
        for diagonal in ([1, -1, -1], [-1, 1, -1], [-1, -1, 1]):
            volume = Volume(phantom().data, np.diag([*(np.array(diagonal) * (0.7, 1.3, 2.1)), 1.0]))
            path = write_with_nibabel(volume, tmp_path / "v.nii", form="qform")
            np.testing.assert_allclose(read_volume(path).affine, volume.affine, rtol=0, atol=1e-6)
            write_nifti(volume, tmp_path / "w.nii")
            np.testing.assert_allclose(nib.load(tmp_path / "w.nii").get_qform(), volume.affine, rtol=0, atol=1e-6)

    def test_big_endian(self, tmp_path: Path) -> None:
        for kind in (nib.Nifti1Image, nib.Nifti2Image):
            header = kind.header_class(endianness=">")
            header.set_data_dtype(np.int16)
            image = kind(phantom().data, phantom().affine, header)
            nib.save(image, tmp_path / "v.nii")
            assert (tmp_path / "v.nii").read_bytes()[0] == 0
            volume = read_volume(tmp_path / "v.nii")
            np.testing.assert_array_equal(volume.data, phantom().data)
            assert volume.data.dtype == np.int16
            assert volume.data.dtype.isnative

    @pytest.mark.parametrize(
        ("change", "part"),
        [
            ((40, "h", (0,)), "0 dimensions"),
            ((40, "h", (9,)), "9 dimensions"),
            ((42, "h", (-7,)), "-7 × 5 × 6"),
            ((42, "h", (0,)), "0 × 5 × 6"),
            ((70, "h", (77,)), "data type 77"),
            ((108, "f", (np.nan,)), "nan"),
            ((108, "f", (1e30,)), "1e+30"),
            ((108, "f", (100.0,)), "inside the header"),
            ((44, "h", (30000,)), "asks for"),
        ],
    )
    def test_headers_that_contradict_themselves(self, edited: Callable[..., Path], change: tuple, part: str) -> None:
        with pytest.raises(InvalidInput) as caught:
            read_volume(edited(change))
        assert caught.value.code == "corrupt_file"
        assert part in str(caught.value)

    def test_pairs_and_analyze_are_named(self, edited: Callable[..., Path]) -> None:
        for mark, name in ((b"ni1\0", "NIfTI pair"), (b"\0\0\0\0", "Analyze 7.5")):
            with pytest.raises(InvalidInput, match=name) as caught:
                read_volume(edited((344, "4s", (mark,))))
            assert caught.value.code == "unsupported_format"


class TestChoices:
    def test_a_frame_is_chosen_from_four_dimensions(self, tmp_path: Path) -> None:
        data = np.arange(4 * 3 * 2 * 5, dtype=np.int16).reshape(4, 3, 2, 5)
        for name in ("v.nii", "v.nii.gz"):
            nib.save(nib.Nifti1Image(data, np.eye(4)), tmp_path / name)
            with pytest.raises(InvalidInput, match=r"5 volumes.*frame=0 … frame=4") as caught:
                read_volume(tmp_path / name)
            assert caught.value.code == "invalid_volume"
            for frame in range(5):
                np.testing.assert_array_equal(read_volume(tmp_path / name, frame=frame).data, data[..., frame])
            with pytest.raises(InvalidInput, match="no frame 5"):
                read_volume(tmp_path / name, frame=5)
            header = read_volume_header(tmp_path / name)
            assert (header.shape, header.frames) == ((4, 3, 2), 5)

    def test_a_fourth_axis_of_one_is_no_choice(self, tmp_path: Path) -> None:
        nib.save(nib.Nifti1Image(phantom().data[..., None], np.eye(4)), tmp_path / "v.nii")
        np.testing.assert_array_equal(read_volume(tmp_path / "v.nii").data, phantom().data)

    def test_vectors_in_the_fifth_dimension_are_frames(self, tmp_path: Path) -> None:
        data = np.arange(4 * 3 * 2 * 3, dtype=np.float32).reshape(4, 3, 2, 1, 3)
        image = nib.Nifti1Image(data, np.eye(4))
        image.header.set_intent("vector")
        nib.save(image, tmp_path / "v.nii")
        np.testing.assert_array_equal(read_volume(tmp_path / "v.nii", frame=2).data, data[..., 0, 2])

    def test_complex_numbers(self, tmp_path: Path) -> None:
        data = (phantom().data + 1j * phantom().data[::-1]).astype(np.complex64)
        nib.save(nib.Nifti1Image(data, np.eye(4)), tmp_path / "v.nii")
        with pytest.raises(InvalidInput, match=r"complex numbers.*magnitude, phase, real, imaginary"):
            read_volume(tmp_path / "v.nii")
        for component, expected in (
            ("magnitude", np.abs(data)),
            ("phase", np.angle(data)),
            ("real", data.real),
            ("imaginary", data.imag),
        ):
            np.testing.assert_array_equal(read_volume(tmp_path / "v.nii", component=component).data, expected)
        with pytest.raises(InvalidInput, match="no component 'red'"):
            read_volume(tmp_path / "v.nii", component="red")
        assert read_volume_header(tmp_path / "v.nii").components == ("magnitude", "phase", "real", "imaginary")

    def test_colours_in_nifti_metaimage_and_nrrd(self, tmp_path: Path) -> None:
        colours = np.random.default_rng(0).integers(0, 256, (4, 3, 2, 3), dtype=np.uint8)
        packed = np.ascontiguousarray(colours).view([("R", "u1"), ("G", "u1"), ("B", "u1")])[..., 0]
        nib.save(nib.Nifti1Image(packed, np.eye(4)), tmp_path / "v.nii")
        image = SimpleITK.GetImageFromArray(np.ascontiguousarray(colours.transpose(2, 1, 0, 3)), isVector=True)
        SimpleITK.WriteImage(image, str(tmp_path / "v.mha"))
        header = {"kinds": ["RGB-color", "domain", "domain", "domain"], "space": "left-posterior-superior"}
        header["space directions"] = np.vstack([[np.nan] * 3, np.eye(3)])  # type: ignore[assignment]
        nrrd.write(str(tmp_path / "v.nrrd"), np.moveaxis(colours, -1, 0), header)
        grey = colours.astype(np.float32) @ np.array([0.299, 0.587, 0.114], np.float32)
        for path in (tmp_path / "v.nii", tmp_path / "v.mha", tmp_path / "v.nrrd"):
            with pytest.raises(InvalidInput, match=r"colours \(RGB\)"):
                read_volume(path)
            np.testing.assert_array_equal(read_volume(path, component="green").data, colours[..., 1])
            np.testing.assert_allclose(read_volume(path, component="luminance").data, grey, rtol=1e-6)

    def test_channels_of_metaimage_and_lists_of_nrrd_are_frames(self, tmp_path: Path) -> None:
        data = np.random.default_rng(0).random((4, 3, 2, 5), dtype=np.float32)
        image = SimpleITK.GetImageFromArray(np.ascontiguousarray(data.transpose(2, 1, 0, 3)), isVector=True)
        SimpleITK.WriteImage(image, str(tmp_path / "v.mha"))
        np.testing.assert_array_equal(read_volume(tmp_path / "v.mha", frame=3).data, data[..., 3])
        for axis in (0, 3):
            # The list may be the fastest axis or the slowest.
            kinds = ["domain"] * 3
            kinds.insert(axis, "list")
            directions = np.insert(np.eye(3), axis, np.nan, axis=0)
            header = {"kinds": kinds, "space": "right-anterior-superior", "space directions": directions}
            nrrd.write(str(tmp_path / "v.nrrd"), np.moveaxis(data, -1, axis), header)
            np.testing.assert_array_equal(read_volume(tmp_path / "v.nrrd", frame=3).data, data[..., 3])

    def test_plain_numbers_have_no_components(self, tmp_path: Path) -> None:
        write_nifti(phantom(), tmp_path / "v.nii")
        with pytest.raises(InvalidInput, match="no component 'phase'"):
            read_volume(tmp_path / "v.nii", component="phase")


class TestSpacesAndUnits:
    @staticmethod
    def nrrd_with(path: Path, fields: str, data: np.ndarray | None = None) -> Path:
        data = phantom().data if data is None else data
        sizes = " ".join(map(str, data.shape))
        head = f"NRRD0005\ntype: short\ndimension: {data.ndim}\nsizes: {sizes}\nendian: little\n{fields}"
        path.write_bytes(head.encode() + b"\n\n" + np.asfortranarray(data).tobytes(order="F"))
        return path

    def test_without_a_space_it_is_taken_as_ras_with_a_warning(self, tmp_path: Path) -> None:
        volume = read_volume(self.nrrd_with(tmp_path / "v.nrrd", "encoding: raw\nspacings: 0.5 1 2"))
        np.testing.assert_array_equal(volume.affine, np.diag([0.5, 1, 2, 1]))
        np.testing.assert_array_equal(volume.data, phantom().data)
        assert "taken as RAS" in volume.warnings[0]

    def test_without_any_spacing_it_is_a_millimetre_with_a_warning(self, tmp_path: Path) -> None:
        volume = read_volume(self.nrrd_with(tmp_path / "v.nrrd", "encoding: raw"))
        assert volume.spacing == (1, 1, 1)
        assert sum("taken as 1 mm" in w for w in volume.warnings) == 3

    def test_units_are_converted(self, tmp_path: Path) -> None:
        fields = (
            "encoding: raw\nspace: left-posterior-superior\nspace directions: (100,0,0) (0,200,0) (0,0,300)\n"
            'space origin: (1000,2000,3000)\nspace units: "um" "um" "um"'
        )
        volume = read_volume(self.nrrd_with(tmp_path / "v.nrrd", fields))
        np.testing.assert_allclose(
            volume.affine, [[-0.1, 0, 0, -1], [0, -0.2, 0, -2], [0, 0, 0.3, 3], [0, 0, 0, 1]], rtol=1e-12, atol=1e-15
        )
        assert "converted to mm" in volume.warnings[0]

    def test_hexadecimal_skips_and_byte_order(self, tmp_path: Path) -> None:
        data = phantom().data
        big = data.astype(">i2").tobytes(order="F")
        head = b"NRRD0004\ntype: int16\ndimension: 3\nsizes: 7 5 6\nspacings: 1 1 1\nendian: big\n"
        for fields, body in (
            (b"encoding: hex", big.hex("\n", 20).encode()),
            (b"encoding: raw\nbyte skip: 3", b"xyz" + big),
            (b"encoding: raw\nline skip: 2", b"a\nb\n" + big),
            (b"encoding: raw\nbyte skip: -1", b"anything" + big),
            (b"encoding: gzip", gzip.compress(big)),
            (b"encoding: bz2", bz2.compress(big)),
        ):
            (tmp_path / "v.nrrd").write_bytes(head + fields + b"\n\n" + body)
            np.testing.assert_array_equal(read_volume(tmp_path / "v.nrrd").data, data)

    def test_metaimage_without_orientation_is_lps_with_a_warning(self, tmp_path: Path) -> None:
        head = "NDims = 3\nDimSize = 7 5 6\nElementType = MET_SHORT\nElementSpacing = 1 2 3\nElementDataFile = LOCAL\n"
        (tmp_path / "v.mha").write_bytes(head.encode() + phantom().data.tobytes(order="F"))
        volume = read_volume(tmp_path / "v.mha")
        np.testing.assert_array_equal(volume.affine, np.diag([-1, -2, 3, 1]))
        np.testing.assert_array_equal(volume.data, phantom().data)
        assert "as ITK does" in volume.warnings[0]

    def test_metaimage_header_size_and_byte_order(self, tmp_path: Path) -> None:
        head = (
            "ObjectType = Image\nNDims = 3\nDimSize = 7 5 6\nBinaryDataByteOrderMSB = True\nHeaderSize = {}\n"
            "TransformMatrix = 1 0 0 0 1 0 0 0 1\nElementType = MET_SHORT\nElementDataFile = v.raw\n"
        )
        (tmp_path / "v.raw").write_bytes(b"12345" + phantom().data.astype(">i2").tobytes(order="F"))
        for skipped in (5, -1):
            (tmp_path / "v.mhd").write_text(head.format(skipped))
            np.testing.assert_array_equal(read_volume(tmp_path / "v.mhd").data, phantom().data)


class TestFoldersAndPairs:
    def test_a_header_without_its_data_is_refused_by_name(self, tmp_path: Path) -> None:
        folder = pair(phantom(), tmp_path, ".mhd")
        (folder / "v.raw").unlink()
        for path in (folder, folder / "v.mhd"):
            with pytest.raises(InvalidInput, match=r"v\.raw"):
                read_volume(path)

    @pytest.mark.parametrize("name", ["../secret.raw", "/etc/passwd", "C:\\x.raw", "..\\secret.raw"])
    def test_a_header_that_names_a_file_elsewhere_is_refused(self, tmp_path: Path, name: str) -> None:
        (tmp_path / "secret.raw").write_bytes(bytes(1000))
        folder = pair(phantom(), tmp_path, ".mhd")
        text = (folder / "v.mhd").read_text().replace("v.raw", name)
        (folder / "v.mhd").write_text(text)
        with pytest.raises(InvalidInput) as caught:
            read_volume(folder / "v.mhd")
        assert caught.value.code == "unsafe_archive"

    def test_short_data_are_refused_with_both_sizes(self, tmp_path: Path) -> None:
        folder = pair(phantom(), tmp_path, ".mhd")
        (folder / "v.raw").write_bytes(bytes(419))
        with pytest.raises(InvalidInput, match="420 bytes of data, and the file has 419"):
            read_volume(folder)

    def test_one_volume_among_other_files_is_found(self, tmp_path: Path) -> None:
        write_nifti(phantom(), tmp_path / "scan.nii.gz")
        (tmp_path / "README.txt").write_text("notes")
        np.testing.assert_array_equal(read_volume(tmp_path).data, phantom().data)

    def test_folders_of_nothing_or_of_several_volumes_are_refused(self, tmp_path: Path) -> None:
        with pytest.raises(InvalidInput, match="no files") as caught:
            read_volume(tmp_path)
        assert caught.value.code == "empty_content"
        (tmp_path / "a.txt").write_text("a")
        (tmp_path / "b.txt").write_text("b")
        with pytest.raises(InvalidInput, match="None of the 2 files"):
            read_volume(tmp_path)
        write_nifti(phantom(), tmp_path / "one.nii")
        write_nifti(phantom(), tmp_path / "two.nii")
        with pytest.raises(InvalidInput, match=r"one\.nii, two\.nii"):
            read_volume(tmp_path)

    def test_a_missing_path_is_the_usual_error(self, tmp_path: Path) -> None:
        with pytest.raises(FileNotFoundError):
            read_volume(tmp_path / "nothing.nii")

    def test_names_decide_nothing(self, tmp_path: Path) -> None:
        for name, target in (
            ("our nii.gz", "x.dcm"),
            ("mha", "x.obj"),
            ("nrrd lps", "x"),
            ("dicom multi-frame", "x.nii"),
        ):
            folder = tmp_path / name
            folder.mkdir()
            path = WRITERS[name](phantom(), folder).rename(tmp_path / target)
            np.testing.assert_array_equal(read_volume(path).canonical()[0].data, phantom().data)


class TestNotFinite:
    def test_they_stay_and_are_reported(self, tmp_path: Path) -> None:
        data = phantom().data.astype(np.float32)
        data[0, 0, :3] = (np.nan, np.inf, -np.inf)
        write_nifti(Volume(data, phantom().affine), tmp_path / "v.nii")
        volume = read_volume(tmp_path / "v.nii")
        np.testing.assert_array_equal(volume.data, data)
        assert volume.warnings == ("3 of 210 voxels (1.43%) are not finite (NaN or infinite).",)
        assert volume.statistics().maximum == 209

    def test_a_volume_of_nothing_else_is_refused(self, tmp_path: Path) -> None:
        write_nifti(Volume(np.full((2, 3, 4), np.nan, np.float32), np.eye(4)), tmp_path / "v.nii")
        with pytest.raises(InvalidInput, match="None of the 24 voxels"):
            read_volume(tmp_path / "v.nii")


class TestFlatImages:
    def test_single_slices_are_refused(self, tmp_path: Path) -> None:
        nib.save(nib.Nifti1Image(np.zeros((8, 9, 1), np.uint8), np.eye(4)), tmp_path / "v.nii")
        nib.save(nib.Nifti1Image(np.zeros((8, 9), np.uint8), np.eye(4)), tmp_path / "w.nii")
        nrrd.write(str(tmp_path / "v.nrrd"), np.zeros((8, 9), np.uint8))
        SimpleITK.WriteImage(SimpleITK.GetImageFromArray(np.zeros((8, 9), np.uint8)), str(tmp_path / "v.mha"))
        write_dicom(dicom_slice(phantom(), 0, series="1.2.3"), tmp_path / "v.dcm")
        for name in ("v.nii", "w.nii", "v.nrrd", "v.mha", "v.dcm"):
            with pytest.raises(InvalidInput, match="flat image") as caught:
                read_volume(tmp_path / name)
            assert caught.value.code == "invalid_volume"


class TestLimits:
    def test_voxels_and_bytes_are_bounded_before_loading(self, tmp_path: Path) -> None:
        for name, write in WRITERS.items():
            folder = tmp_path / name.replace(" ", "_")
            folder.mkdir()
            path = write(phantom(), folder)
            with pytest.raises(LimitExceeded, match=r"210 voxels; at most 209") as caught:
                read_volume(path, limits=ReadLimits(voxels=209))
            assert caught.value.code == "too_large"
            read_volume(path, limits=ReadLimits(voxels=210))
            with pytest.raises(LimitExceeded, match="bytes"):
                read_volume(path, limits=ReadLimits(bytes=100))

    def test_files_are_bounded(self, tmp_path: Path) -> None:
        path = series(phantom(), tmp_path)
        with pytest.raises(LimitExceeded, match="more than 5 files"):
            read_volume(path, limits=ReadLimits(files=5))
        with pytest.raises(LimitExceeded, match="6 entries; at most 5"):
            read_volume(zipped(path, tmp_path / "v.zip"), limits=ReadLimits(files=5))

    def test_frames_before_the_chosen_one_count_where_they_are_unpacked(self, tmp_path: Path) -> None:
        data = np.zeros((10, 10, 10, 4), np.uint8)
        data[0, 0, 0] = (1, 2, 3, 4)
        nib.save(nib.Nifti1Image(data, np.eye(4)), tmp_path / "v.nii.gz")
        nib.save(nib.Nifti1Image(data, np.eye(4)), tmp_path / "v.nii")
        limits = ReadLimits(bytes=2000)
        assert read_volume(tmp_path / "v.nii.gz", frame=1, limits=limits).data[0, 0, 0] == 2
        assert read_volume(tmp_path / "v.nii", frame=3, limits=limits).data[0, 0, 0] == 4
        with pytest.raises(LimitExceeded):
            read_volume(tmp_path / "v.nii.gz", frame=2, limits=limits)


SINGLE_FILES = [n for n in WRITERS if n not in ("dicom series", "mhd beside its raw") and "folder" not in n]


class TestDamage:
    @pytest.mark.parametrize("name", SINGLE_FILES)
    def test_truncation_anywhere_is_refused(self, name: str, tmp_path: Path) -> None:
        path = WRITERS[name](phantom(), tmp_path)
        whole = path.read_bytes()
        for kept in sorted({0, 1, 3, 100, *np.linspace(1, len(whole) - 9, 15).astype(int).tolist()}):
            path.write_bytes(whole[:kept])
            with pytest.raises(UserError) as caught:
                read_volume(path)
            assert caught.value.code in ("corrupt_file", "unknown_format", "empty_content")

    @pytest.mark.parametrize("name", ["our nii.gz", "nrrd lps", "nrrd las bzip2", "mha compressed", "dicom zip"])
    def test_a_changed_byte_in_compressed_data_is_noticed(self, name: str, tmp_path: Path) -> None:
        path = WRITERS[name](phantom(), tmp_path)
        whole = bytearray(path.read_bytes())
        place = len(whole) - 30 if name != "dicom zip" else 400
        whole[place] ^= 0x55
        path.write_bytes(whole)
        with pytest.raises(InvalidInput) as caught:
            read_volume(path)
        assert caught.value.code == "corrupt_file"

"""Real volumes: each is read as other programs read it, or refused with a sentence that says what it is."""

from __future__ import annotations

from pathlib import Path

import nibabel as nib
import numpy as np
import pytest
import SimpleITK

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume, read_volume_header, write_nifti

pytestmark = pytest.mark.data

REFUSED = {
    "V1.nii.gz": ("invalid_volume", "3 volumes (time points, channels or vector components)"),
    "broken_truncated.nii.gz": ("corrupt_file", "break off before their end"),
    "complex.nii.gz": ("invalid_volume", "complex numbers"),
    "ct_perfusion.nii.gz": ("invalid_volume", "colours (RGB)"),
    "pcasl.nii.gz": ("invalid_volume", "10 volumes"),
    "phase_with_nan.nii": ("invalid_volume", "2 volumes"),
}
READ = {
    "FLAIR.nrrd": (124, 160, 140),
    "MR_Gd.nii.gz": (176, 188, 144),
    "enh.dcm": (64, 64, 6),
    "lesion.nii.gz": (124, 160, 140),
    "low_res.nii.gz": (7, 5, 3),
    "mha.mha": (64, 64, 37),
    "shear.nii.gz": (306, 422, 54),
}


@pytest.fixture
def variants(shared_data: Path) -> Path:
    return shared_data / "volumes" / "variants"


def as_itk_reads(path: Path) -> Volume:
    image = SimpleITK.ReadImage(str(path))
    affine = np.eye(4)
    affine[:3, :3] = np.array(image.GetDirection()).reshape(3, 3) * image.GetSpacing()
    affine[:3, 3] = image.GetOrigin()
    return Volume(SimpleITK.GetArrayFromImage(image).T, np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine)


def test_every_variant_is_read_or_refused(variants: Path) -> None:
    assert {path.name for path in variants.iterdir()} == set(REFUSED) | set(READ)
    for name, (code, part) in REFUSED.items():
        with pytest.raises(InvalidInput) as caught:
            read_volume(variants / name)
        assert caught.value.code == code
        assert part in caught.value.message
        assert caught.value.hint
    for name, shape in READ.items():
        volume = read_volume(variants / name)
        assert volume.shape == shape
        assert read_volume_header(variants / name).shape == shape
        assert volume.statistics().non_finite == 0


@pytest.mark.parametrize("name", ["MR_Gd", "lesion", "low_res", "shear"])
def test_nifti_as_nibabel_reads_it(variants: Path, name: str) -> None:
    image = nib.load(variants / f"{name}.nii.gz")
    volume = read_volume(variants / f"{name}.nii.gz")
    np.testing.assert_array_equal(volume.affine, image.affine)
    np.testing.assert_allclose(volume.data, image.get_fdata(), rtol=1e-6)


def test_the_sheared_affine_is_kept_and_its_qform_reported(variants: Path) -> None:
    volume = read_volume(variants / "shear.nii.gz")
    axes = volume.affine[:3, :3] / volume.spacing
    assert abs(axes[:, 1] @ axes[:, 2]) > 0.3
    assert "differ by up to" in volume.warnings[0]


@pytest.mark.parametrize("name", ["variants/FLAIR.nrrd", "variants/mha.mha", "vessel_aorta_ct_vmtk/aorta.mha"])
def test_nrrd_and_metaimage_as_itk_reads_them(shared_data: Path, name: str) -> None:
    expected = as_itk_reads(shared_data / "volumes" / name)
    volume = read_volume(shared_data / "volumes" / name)
    np.testing.assert_array_equal(volume.data, expected.data)
    np.testing.assert_allclose(volume.affine, expected.affine, rtol=0, atol=1e-9)


def test_the_enhanced_file_as_itk_reads_it(variants: Path) -> None:
    expected = as_itk_reads(variants / "enh.dcm")
    volume = read_volume(variants / "enh.dcm")
    np.testing.assert_array_equal(volume.data, expected.data)
    np.testing.assert_allclose(volume.affine, expected.affine, rtol=0, atol=1e-4)


def test_the_same_lesion_in_two_formats_lies_at_the_same_place(variants: Path) -> None:
    assert read_volume(variants / "FLAIR.nrrd").same_grid(read_volume(variants / "lesion.nii.gz"))


def test_choices_give_what_nibabel_gives(variants: Path) -> None:
    for name in ("V1.nii.gz", "pcasl.nii.gz", "phase_with_nan.nii"):
        data = nib.load(variants / name).get_fdata()
        for frame in (0, data.shape[3] - 1):
            np.testing.assert_allclose(read_volume(variants / name, frame=frame).data, data[..., frame], rtol=1e-6)
    data = np.asarray(nib.load(variants / "complex.nii.gz").dataobj)
    np.testing.assert_array_equal(read_volume(variants / "complex.nii.gz", component="magnitude").data, np.abs(data))
    colours = np.asarray(nib.load(variants / "ct_perfusion.nii.gz").dataobj)
    np.testing.assert_array_equal(read_volume(variants / "ct_perfusion.nii.gz", component="red").data, colours["R"])


def test_nan_and_a_missing_orientation_are_reported(variants: Path) -> None:
    volume = read_volume(variants / "phase_with_nan.nii", frame=0)
    figures = volume.statistics()
    assert figures.non_finite > 0
    assert np.isfinite([figures.minimum, figures.maximum]).all()
    assert "only its spacing is known" in volume.warnings[0]
    assert f"{figures.non_finite} of {volume.data.size} voxels" in volume.warnings[1]


def test_tumor_cases_as_nibabel_reads_them_and_back(shared_data: Path, tmp_path: Path) -> None:
    cases = sorted((shared_data / "volumes").glob("tumor_brats*"))
    assert len(cases) == 11
    for case in cases[::4]:
        image = nib.load(case / "t1c.nii.gz")
        volume = read_volume(case / "t1c.nii.gz")
        assert volume.data.dtype == image.get_data_dtype()
        np.testing.assert_array_equal(volume.data, np.asarray(image.dataobj))
        np.testing.assert_array_equal(volume.affine, image.affine)
        assert volume.same_grid(read_volume(case / "seg.nii.gz"))
        canonical, reorientation = volume.canonical()
        assert nib.aff2axcodes(canonical.affine) == ("R", "A", "S")
        labels = reorientation.undo(canonical.with_data((canonical.data > 100).astype(np.uint8)))
        write_nifti(labels, tmp_path / "labels.nii.gz")
        again = nib.load(tmp_path / "labels.nii.gz")
        np.testing.assert_array_equal(again.affine, image.affine)
        np.testing.assert_array_equal(np.asarray(again.dataobj), np.asarray(image.dataobj) > 100)

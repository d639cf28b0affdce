"""Rigid co-registration: known transforms are recovered, aligned volumes are left alone, two heads are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_contracts.segmentation import Alignment
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume
from shapery_segmentation import _registration_kernels as kernels
from shapery_segmentation.phantoms import HeadPhantom, head_phantom
from shapery_segmentation.registration import Registration, align, register, rigid, rotation_degrees

pytestmark = pytest.mark.slow

PLACES = np.random.default_rng(1).uniform(-60, 60, (200, 3))


@pytest.fixture(scope="module")
def thick() -> HeadPhantom:
    """A head in slices of 3 mm."""
    return head_phantom(np.random.default_rng(110), (108, 128, 54), (1.5, 1.5, 3.0), noise=0.04)


def moved(volume: Volume, transform: np.ndarray) -> Volume:
    return Volume(volume.data, np.linalg.inv(transform) @ volume.affine)


def errors(found: Registration, transform: np.ndarray) -> np.ndarray:
    """Distances in mm between where places are brought and where they belong."""
    rest = found.transform @ np.linalg.inv(transform)
    return np.linalg.norm(PLACES @ rest[:3, :3].T + rest[:3, 3] - PLACES, axis=1)


def test_a_rigid_transform_turns_about_its_centre() -> None:
    centre = np.array([10.0, -20.0, 30.0])
    transform = rigid((0.0, 0.0, 90.0), (1.0, 2.0, 3.0), centre)
    np.testing.assert_allclose(transform[:3, :3] @ centre + transform[:3, 3], centre + np.array([1, 2, 3]))
    np.testing.assert_allclose(transform[:3, :3] @ [1, 0, 0], [0, 1, 0], atol=1e-12)
    assert rotation_degrees(transform) == pytest.approx(90.0)
    assert rotation_degrees(rigid((5.0, -8.0, 15.0), (0, 0, 0), centre)) == pytest.approx(17.9, abs=0.5)


def test_a_volume_that_lies_right_is_left_as_it_is(head: HeadPhantom) -> None:
    found = register(head.pre, head.post, rng=np.random.default_rng(0))
    assert not found.moved
    np.testing.assert_array_equal(found.transform, np.eye(4))
    assert found.apply(head.pre) is head.pre
    assert found.likeness > 0.5


@pytest.mark.parametrize(
    ("degrees", "shift"),
    [((0, 0, 0), (4, -3, 2)), ((5, -8, 15), (4, -6, 3)), ((0, 0, 0), (0, 120, -80))],
    ids=["shifted", "turned by 18°", "in another frame"],
)
def test_known_transforms_are_recovered_within_half_a_voxel(
    head: HeadPhantom, degrees: tuple[float, float, float], shift: tuple[float, float, float]
) -> None:
    transform = rigid(degrees, shift, np.zeros(3))
    found = register(moved(head.pre, transform), head.post, rng=np.random.default_rng(0))
    assert found.moved
    assert found.agreement > found.agreement_before
    assert errors(found, transform).mean() < 0.5 * min(head.post.spacing)


def test_known_transforms_are_recovered_in_thick_slices(thick: HeadPhantom) -> None:
    transform = rigid((4.0, 6.0, -15.0), (5.0, 3.0, -6.0), np.zeros(3))
    found = register(moved(thick.pre, transform), thick.post, rng=np.random.default_rng(0))
    assert errors(found, transform).mean() < 0.5 * min(thick.post.spacing)


def test_the_same_generator_gives_the_same_transform(thick: HeadPhantom) -> None:
    away = moved(thick.pre, rigid((0, 0, 6.0), (3, 0, 0), np.zeros(3)))
    one, two = (register(away, thick.post, rng=np.random.default_rng(4)) for _ in range(2))
    np.testing.assert_array_equal(one.transform, two.transform)


@pytest.mark.data
def test_two_patients_are_refused(shared_data: Path) -> None:
    folders = sorted(shared_data.glob("volumes/tumor_brats18_*"))
    if len(folders) < 2:
        pytest.skip("there are not two real cases")
    post, pre = read_volume(folders[0] / "t1c.nii.gz"), read_volume(folders[1] / "t1.nii.gz")
    told: list[Alignment] = []
    with pytest.raises(InvalidInput) as caught:
        align(pre, post, "pre", True, told, [], rng=np.random.default_rng(0))
    assert caught.value.code == "different_subjects"
    assert caught.value.hint
    own = read_volume(folders[0] / "t1.nii.gz")
    _, certainty = align(own, post, "pre", True, told, [], rng=np.random.default_rng(0))
    assert certainty == 1.0


@pytest.mark.data
def test_a_known_transform_of_a_real_case_is_undone(shared_data: Path) -> None:
    folder = shared_data / "volumes/tumor_brats18_tcia01_231_1"
    if not folder.is_dir():
        pytest.skip("the real case is not there")
    post, pre = read_volume(folder / "t1c.nii.gz"), read_volume(folder / "t1.nii.gz")
    centre = post.to_world((np.array(post.shape) - 1) / 2)
    transform = rigid((5.0, -8.0, 15.0), (4.0, -6.0, 3.0), centre)
    found = register(moved(pre, transform), post, rng=np.random.default_rng(0))
    rest = found.transform @ np.linalg.inv(transform)
    away = np.linalg.norm((PLACES + centre) @ rest[:3, :3].T + rest[:3, 3] - PLACES - centre, axis=1)
    assert away.mean() < 0.5


def test_mutual_information_is_that_of_the_joint_histogram() -> None:
    rng = np.random.default_rng(5)
    data = rng.uniform(0.0, 9.0, (7, 8, 6)).astype(np.float32)
    points = rng.uniform(-2.0, 9.0, (4000, 3))
    fixed = rng.integers(0, 16, len(points))
    joint = np.empty((16, 16))
    count = kernels.joint_histogram(data, np.eye(3), np.zeros(3), points, fixed, 1.0, 8.0, joint)

    inside = ((points >= -0.5) & (points <= np.array(data.shape) - 0.5)).all(axis=1)
    values = ndimage.map_coordinates(data.astype(np.float64), points[inside].T, order=1, mode="nearest")
    at = np.clip((values - 1.0) / 7.0, 0.0, 1.0) * 14
    expected = np.zeros((16, 16))
    np.add.at(expected, (fixed[inside], at.astype(int)), 1.0 - at % 1.0)
    np.add.at(expected, (fixed[inside], at.astype(int) + 1), at % 1.0)
    assert count == inside.sum()
    np.testing.assert_allclose(joint, expected, atol=1e-9)

    p = expected / count
    independent = np.outer(p.sum(axis=1), p.sum(axis=0))
    seen = p > 0
    assert kernels.mutual_information(joint, count) == pytest.approx(
        (p[seen] * np.log(p[seen] / independent[seen])).sum()
    )

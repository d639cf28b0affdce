"""Generated vessels."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_geometry.volume import Volume
from shapery_segmentation.labels import MICROHEMORRHAGE, OBJECT, VESSEL
from shapery_segmentation.phantoms import phantom_of_label, tube_phantom, vessel_tree_phantom

SMALL = (64, 64, 64)


def test_the_same_seed_gives_the_same_tree() -> None:
    first, again, other = (vessel_tree_phantom(np.random.default_rng(s), SMALL) for s in (1, 1, 2))
    np.testing.assert_array_equal(first.volume.data, again.volume.data)
    np.testing.assert_array_equal(first.truth.data, again.truth.data)
    assert (first.truth.data != other.truth.data).any()


def test_branches_obey_murrays_law_and_end_where_they_should() -> None:
    tree = vessel_tree_phantom(np.random.default_rng(3), least_radius=1.5)
    children: dict[int, list[float]] = {}
    for number, branch in enumerate(tree.branches):
        assert branch.parent < number
        assert (np.diff(branch.radii) <= 0).all()
        children.setdefault(branch.parent, []).append(float(branch.radii[0]))
        if branch.parent >= 0:
            np.testing.assert_array_equal(branch.points[0], tree.branches[branch.parent].points[-1])
    assert min(float(branch.radii.min()) for branch in tree.branches) >= 1.5
    whole = [(parent, radii) for parent, radii in children.items() if len(radii) == 2]
    assert whole
    for parent, radii in whole:
        assert sum(r**3 for r in radii) == pytest.approx(tree.branches[parent].radii[-1] ** 3)


@pytest.mark.parametrize("polarity", ["bright", "dark"])
def test_partial_volume_and_contrast(polarity: str) -> None:
    tube = tube_phantom(np.random.default_rng(1), (48, 48, 48), radius=3.0, polarity=polarity, snr=np.inf)  # type: ignore[arg-type]
    values = tube.volume.data
    vessel = 200.0 if polarity == "bright" else 35.0
    assert {float(values.min()), float(values.max())} == {min(vessel, 100.0), max(vessel, 100.0)}
    share = (values.astype(np.float64) - 100.0) / (vessel - 100.0)
    # The share of every voxel, added up, is the volume that was drawn.
    length = float(np.linalg.norm(tube.centerline[-1] - tube.centerline[0]))
    assert share.sum() == pytest.approx(np.pi * 9.0 * length + 36.0 * np.pi, rel=5e-3)
    np.testing.assert_array_equal(tube.truth.data == VESSEL, share >= 0.5)


def test_noise_and_bias_are_what_was_asked_for() -> None:
    rng = np.random.default_rng
    plain = tube_phantom(rng(4), SMALL, snr=np.inf)
    noisy = tube_phantom(rng(4), SMALL, snr=8.0)
    assert (noisy.volume.data - plain.volume.data).std() == pytest.approx(100.0 / 8.0, rel=0.02)
    biased = tube_phantom(rng(4), SMALL, snr=np.inf, bias=0.4)
    ratio = biased.volume.data / plain.volume.data
    assert float(ratio.min()) == pytest.approx(0.8, abs=1e-3)
    assert float(ratio.max()) == pytest.approx(1.2, abs=1e-3)
    assert np.abs(np.diff(ratio, axis=0)).max() < 0.03


def test_tumor_and_bleedings_touch_no_vessel() -> None:
    tree = vessel_tree_phantom(np.random.default_rng(5), tumor_radius=8.0, microhemorrhages=2)
    truth = tree.truth.data
    for label in (OBJECT, MICROHEMORRHAGE):
        index = np.argwhere(truth == label)
        assert len(index)
        beside = np.clip(index[:, None] + np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]), 0, 95)
        assert not (truth[tuple(beside.reshape(-1, 3).T)] == VESSEL).any()
    with pytest.raises(ValueError, match="no room"):
        vessel_tree_phantom(np.random.default_rng(5), tumor_radius=60.0)


def test_a_label_becomes_a_volume() -> None:
    mask = np.zeros((24, 24, 24), dtype=np.uint16)
    mask[8:16, 8:16, 4:20] = 7
    phantom = phantom_of_label(np.random.default_rng(6), Volume(mask, np.eye(4)), snr=20.0)
    np.testing.assert_array_equal(phantom.truth.data == VESSEL, mask > 0)
    assert phantom.volume.data[mask > 0].mean() > 170.0
    assert len(phantom.centerline) == 0

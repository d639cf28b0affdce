"""Vessels from volumes: phantoms with known truth."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from shapery_contracts.errors import InvalidInput
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mask_metrics import dice, intersection_over_union
from shapery_geometry.volume import Volume
from shapery_segmentation.labels import MICROHEMORRHAGE, OBJECT, VESSEL
from shapery_segmentation.microhemorrhage import find_microhemorrhages
from shapery_segmentation.phantoms.vessels import VesselPhantom, tube_phantom, vessel_tree_phantom
from shapery_segmentation.vessels import Vessels, segment_vessels

pytestmark = pytest.mark.slow

FloatArray = NDArray[np.float64]


@pytest.fixture(scope="module")
def tree() -> VesselPhantom:
    """Dark veins beside a tumor, with bleedings, noise and bias."""
    return vessel_tree_phantom(
        np.random.default_rng(3), polarity="dark", bias=0.4, tumor_radius=9.0, microhemorrhages=3
    )


@pytest.fixture(scope="module")
def found(tree: VesselPhantom) -> Vessels:
    return segment_vessels(tree.volume, around=tree.truth.data == OBJECT)


def _near(points: FloatArray, line: FloatArray, within: float) -> float:
    """Return the share of points within so many mm of a line's points."""
    return float(np.mean(cKDTree(line).query(points)[0] < within))


def _check(found: Vessels, truth: VesselPhantom, iou: float) -> None:
    assert intersection_over_union(found.mask, truth.truth.data == VESSEL) >= iou
    for tree in found.trees:
        surface = tree.surface
        assert surface.closed
        assert surface.manifold
        assert surface.oriented
        assert surface.volume > 0
        assert len(self_intersections(surface)) == 0
    drawn = truth.centerline[truth.volume.contains(truth.centerline)]
    middle = np.concatenate([branch.points for branch in found.branches])
    # Within a voxel; at forks, where a middle is a matter of definition, within two.
    for line, other in ((drawn, middle), (middle, truth.centerline)):
        assert _near(line, other, max(truth.volume.spacing)) >= 0.95
        assert _near(line, other, 2.0 * max(truth.volume.spacing)) >= 0.98


def test_a_tree_beside_a_tumor(tree: VesselPhantom, found: Vessels) -> None:
    assert found.polarity == "dark"
    assert len(found.trees) == 1
    assert found.warnings == ()
    _check(found, tree, 0.94)
    (one,) = found.trees
    assert one.surface.genus == 0
    drawn = sum(float(np.linalg.norm(np.diff(b.points, axis=0), axis=1).sum()) for b in tree.branches)
    # Of the drawn length a radius or more at every end, and what lies outside the volume, can't be seen.
    assert 0.88 * drawn < one.length_mm < 1.02 * drawn
    forks = sum(sum(b.parent == n for b in tree.branches) == 2 for n in range(len(tree.branches)))
    assert one.forks == forks
    low, high = one.radius_range_mm
    assert low == pytest.approx(1.5, abs=0.3)
    assert high == pytest.approx(4.5, abs=0.4)


def test_every_branch_is_reached(tree: VesselPhantom, found: Vessels) -> None:
    for branch in tree.branches:
        index = np.rint(tree.volume.to_index(branch.points[-1])).astype(int)
        assert found.mask[tuple(index)]


def test_bleedings_around_it(tree: VesselPhantom, found: Vessels) -> None:
    truth = tree.truth.data
    result = find_microhemorrhages(tree.volume, vessels=found.mask, tumor=truth == OBJECT, polarity=found.polarity)
    assert dice(result.mask, truth == MICROHEMORRHAGE) >= 0.9
    assert len(result.clusters) == 3
    assert not (result.mask & found.mask).any()
    assert result.threshold is not None
    # Between tissue and the bleedings' own value.
    assert 2.5 < result.threshold < 100.0


def test_nothing_bleeds_where_nothing_was_drawn() -> None:
    phantom = tube_phantom(np.random.default_rng(1), (40, 40, 40), radius=2.5, bias=0.4)
    result = find_microhemorrhages(phantom.volume, vessels=phantom.truth.data == VESSEL, polarity="bright")
    assert result.clusters == ()
    assert not result.mask.any()
    assert result.threshold is None


@pytest.mark.parametrize("polarity", ["bright", "dark"])
@pytest.mark.parametrize("radius", [2.0, 4.0])
def test_a_tube_has_its_radius_and_length(polarity: str, radius: float) -> None:
    phantom = tube_phantom(np.random.default_rng(2), (48, 48, 48), radius=radius, polarity=polarity, bias=0.4)  # type: ignore[arg-type]
    found = segment_vessels(phantom.volume)
    assert found.polarity == polarity
    _check(found, phantom, 0.92 if radius < 3 else 0.95)
    (tree,) = found.trees
    assert tree.surface.euler_characteristic == 2
    points = tree.surface.vertices
    axis = phantom.centerline[-1] - phantom.centerline[0]
    length = float(np.linalg.norm(axis))
    along = (points - phantom.centerline[0]) @ axis / length
    across = np.linalg.norm(points - phantom.centerline[0] - along[:, None] * axis / length, axis=1)
    # A twentieth of a voxel: over hundreds of vertices the noise averages out.
    middle = (along > 6) & (along < length - 6)
    assert across[middle].mean() == pytest.approx(radius, abs=0.05)
    assert tree.mean_radius_mm == pytest.approx(radius, rel=0.06)
    # The tube's ends are half balls; the middle ends about where these begin.
    assert tree.length_mm == pytest.approx(length, abs=radius + 1.0)


def test_voxels_in_any_order_give_the_same(tree: VesselPhantom, found: Vessels) -> None:
    volume = tree.volume
    turned = np.ascontiguousarray(volume.data.transpose(2, 0, 1)[::-1])
    affine = volume.affine[:, [2, 0, 1, 3]].copy()
    affine[:3, 3] += affine[:3, 0] * (turned.shape[0] - 1)
    affine[:3, 0] *= -1
    region = np.ascontiguousarray((tree.truth.data == OBJECT).transpose(2, 0, 1)[::-1])
    again = segment_vessels(Volume(turned, affine), around=region)
    np.testing.assert_array_equal(again.mask, found.mask.transpose(2, 0, 1)[::-1])
    np.testing.assert_array_equal(again.trees[0].surface.vertices, found.trees[0].surface.vertices)


def test_oblique_and_anisotropic_voxels_give_the_same_in_mm() -> None:
    affine = np.diag([0.8, 0.8, 1.4, 1.0])
    affine[:3, 3] = (10.0, -20.0, 5.0)
    oblique = affine.copy()
    turn = Rotation.from_euler("xyz", [10, 20, 30], degrees=True).as_matrix()
    oblique[:3, :3] = turn @ affine[:3, :3]
    lengths = []
    for matrix in (affine, oblique):
        phantom = tube_phantom(np.random.default_rng(5), (60, 60, 36), matrix, radius=3.0, bend=3.0)
        found = segment_vessels(phantom.volume)
        _check(found, phantom, 0.94)
        lengths.append(found.trees[0].length_mm)
    assert lengths[0] == pytest.approx(lengths[1], rel=0.03)


def test_seeds_that_are_given_are_followed_alone() -> None:
    first = tube_phantom(np.random.default_rng(6), (40, 64, 40), radius=2.5)
    both = np.concatenate((first.volume.data, first.volume.data), axis=0)
    volume = Volume(both, first.volume.affine)
    seed = first.volume.to_world((21.0, 31.0, 21.0))
    assert len(segment_vessels(volume).trees) == 2
    found = segment_vessels(volume, [seed])
    assert len(found.trees) == 1
    assert found.mask[:40].any()
    assert not found.mask[40:].any()
    with pytest.raises(InvalidInput, match="outside the volume"):
        segment_vessels(volume, [(500.0, 0.0, 0.0)])
    with pytest.raises(InvalidInput, match="No vessel was reached"):
        segment_vessels(volume, [(0.0, 0.0, 0.0)], polarity="bright")


def test_noise_alone_has_no_vessels() -> None:
    noise = np.random.default_rng(7).normal(100.0, 10.0, (40, 40, 40)).astype(np.float32)
    found = segment_vessels(Volume(noise, np.eye(4)))
    assert found.trees == ()
    assert not found.mask.any()
    assert "No vessels were found" in found.warnings[-1]


def test_bad_input_is_told() -> None:
    flat = Volume(np.full((20, 20, 20), 3, dtype=np.int16), np.eye(4))
    with pytest.raises(InvalidInput) as caught:
        segment_vessels(flat)
    assert caught.value.code == "invalid_volume"
    with pytest.raises(InvalidInput) as caught:
        segment_vessels(flat, around=np.ones((3, 3, 3), dtype=bool))
    assert caught.value.code == "grid_mismatch"
    with pytest.raises(InvalidInput) as caught:
        find_microhemorrhages(flat, vessels=np.zeros(flat.shape, dtype=bool))
    assert caught.value.code == "invalid_params"

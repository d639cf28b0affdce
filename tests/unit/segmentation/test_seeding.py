"""Octree, symmetry plane, evidence and candidates."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_segmentation.blocks import block_mean, spread
from shapery_segmentation.brain import Brain, find_brain
from shapery_segmentation.calibration import Calibration, calibrate
from shapery_segmentation.phantoms import HeadPhantom
from shapery_segmentation.seeding import _octree_kernels as octree_kernels
from shapery_segmentation.seeding.candidates import find_candidates
from shapery_segmentation.seeding.evidence import evidence
from shapery_segmentation.seeding.octree import search_octree
from shapery_segmentation.seeding.points import candidates_from_points, check_points
from shapery_segmentation.seeding.symmetry import SymmetryPlane, find_symmetry

SHAPE = (96, 96, 80)
INDEX = np.stack(np.meshgrid(*map(np.arange, SHAPE), indexing="ij"), axis=-1)
BRAIN = (((INDEX - np.array([47.5, 47.5, 39.5])) / np.array([44, 46, 38])) ** 2).sum(axis=-1) < 1
MIDDLE = SymmetryPlane(np.array([1.0, 0.0, 0.0]), 47.5, 1.0)


def ball(centre: tuple[int, int, int], radius: float) -> np.ndarray:
    return np.linalg.norm(INDEX - np.array(centre), axis=-1) <= radius


def field_with(*objects: np.ndarray, level: float = 6.0, seed: int = 0) -> np.ndarray:
    field = np.random.default_rng(seed).normal(0, 1, SHAPE).astype(np.float32)
    for item in objects:
        field[item] += level
    return np.where(BRAIN, field, 0).astype(np.float32)


def test_two_normals_are_recovered_from_their_histogram() -> None:
    rng = np.random.default_rng(1)
    values = np.concatenate((rng.normal(0, 1, 30_000), rng.normal(6, 1.5, 10_000)))
    bottom, width = -6.0, 0.25
    counts = np.histogram(values, bins=octree_kernels.BINS, range=(bottom, bottom + width * octree_kernels.BINS))[0]
    result = np.zeros(7)
    octree_kernels.two_normals(counts.astype(float), bottom, width, 2.0, result)
    np.testing.assert_allclose(result[:6], [0.75, 0.0, 1.0, 0.25, 6.0, 1.5], atol=0.05)
    assert result[6] > 0.1
    counts = np.histogram(values[:30_000], bins=octree_kernels.BINS, range=(-6, 18))[0]
    octree_kernels.two_normals(counts.astype(float), bottom, width, 2.0, result)
    assert result[6] < 0.01


@pytest.mark.parametrize("radius", [18, 9, 5])
def test_octree_finds_objects_of_all_sizes_and_their_peak(radius: int) -> None:
    item = ball((30, 50, 40), radius)
    found = search_octree(field_with(item), BRAIN, 1.0, 2.0)
    peak = found.on_grid(SHAPE)
    assert (peak[item] > 0).mean() > 0.8
    assert np.median(peak[item & (peak > 0)]) == pytest.approx(6.0, abs=1.0)
    # Not more than the cells around it.
    assert (peak[BRAIN & ~ball((30, 50, 40), radius + 30)] == 0).all()


def test_octree_finds_nothing_in_noise() -> None:
    found = search_octree(field_with(), BRAIN, 1.0, 2.0)
    assert found.levels == (0, 0, 0)
    assert not found.peak.any()


def test_symmetry_plane_of_tilted_heads(tilted_head: HeadPhantom, head: HeadPhantom) -> None:
    for phantom, degrees, shift in (
        (tilted_head, (4.0, -7.0, 14.0), (3.0, -4.0, 2.0)),
        (head, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    ):
        brain = find_brain(phantom.pre, phantom.post)
        calibration = calibrate(brain, phantom.post, phantom.pre)
        plane = find_symmetry(calibration.before, brain.mask, brain.grid.spacing)
        # The head's own x axis, turned about x, y and z in turn.
        b, c = np.deg2rad(degrees[1:])
        expected = np.array([np.cos(b) * np.cos(c), np.cos(b) * np.sin(c), -np.sin(b)])
        assert np.rad2deg(np.arccos(min(1.0, abs(float(plane.normal @ expected))))) < 3.0
        # Distance of the head's centre from the plane found.
        centre = (np.array(shift) - brain.grid.affine[:3, 3]) @ np.eye(3)
        assert abs(float(plane.normal @ centre) - plane.distance) < 2.5


def test_reflection_is_an_involution_and_keeps_the_plane() -> None:
    normal = np.array([0.9, 0.3, -0.1])
    plane = SymmetryPlane(normal / np.linalg.norm(normal), 31.0, 1.0)
    matrix, offset = plane.reflection(1.3)
    points = np.random.default_rng(0).uniform(0, 60, (50, 3))
    mirrored = points @ matrix.T + offset
    np.testing.assert_allclose(mirrored @ matrix.T + offset, points, atol=1e-9)
    middle = (points + mirrored) / 2 * 1.3
    np.testing.assert_allclose(middle @ plane.normal, 31.0, atol=1e-9)


def weight_of(field: np.ndarray, before: np.ndarray | None = None) -> np.ndarray:
    reference = np.zeros(SHAPE, np.float32) if before is None else before.astype(np.float32)
    return evidence(field, reference, BRAIN, MIDDLE, 1.0)


def test_evidence_wants_one_sided_deep_tissue() -> None:
    one, other = ball((25, 48, 40), 7), ball((70, 48, 40), 7)
    alone = weight_of(field_with(one))
    assert alone[one].mean() > 0.6
    assert alone[other].mean() < 0.05
    # A pair, as plexus and sinuses are.
    assert weight_of(field_with(one, other))[one].mean() < 0.1
    # Dark before contrast: fluid or flowing blood.
    assert weight_of(field_with(one), np.where(one, -4.0, 0.0))[one].mean() < 0.15
    # Along the brain's edge.
    rim = BRAIN & ~(((INDEX - np.array([47.5, 47.5, 39.5])) / np.array([41, 43, 35])) ** 2).sum(axis=-1).__lt__(1)
    half = rim & (INDEX[..., 0] < 40)
    assert weight_of(field_with(half))[half].mean() < 0.25


def test_evidence_bears_halves_that_differ_by_a_few_millimetres() -> None:
    pair = weight_of(field_with(ball((25, 48, 40), 6), ball((72, 51, 42), 6)))
    assert pair[ball((25, 48, 40), 6)].mean() < 0.25


def shell(centre: tuple[int, int, int], outer: float, inner: float) -> np.ndarray:
    return ball(centre, outer) & ~ball(centre, inner)


@pytest.mark.parametrize("item", [ball((48, 48, 40), 8), shell((46, 55, 38), 14, 10)], ids=["solid", "rim"])
def test_evidence_knows_the_own_mirror_image_of_what_lies_across_the_middle(item: np.ndarray) -> None:
    assert weight_of(field_with(item))[item].mean() > 0.6


def test_evidence_finds_none_in_veins_of_the_middle_and_in_pairs_beside_it() -> None:
    along = np.abs(INDEX[..., 1] - 48) < 20
    vein = (np.linalg.norm(INDEX[..., ::2] - np.array([48, 40]), axis=-1) <= 4) & along
    assert weight_of(field_with(vein))[vein].mean() < 0.1
    pair = ball((36, 48, 40), 7), ball((59, 48, 40), 7)
    assert weight_of(field_with(*pair))[pair[0] | pair[1]].mean() < 0.1
    # Enhancing meninges enclose the brain: nothing within them is more than a vein for that.
    deep = (((INDEX - np.array([47.5, 47.5, 39.5])) / np.array([40, 42, 34])) ** 2).sum(axis=-1) < 1
    meninges = BRAIN & ~deep
    assert weight_of(field_with(meninges, vein))[vein].mean() < 0.1


def test_blocks_are_averaged_and_spread_back() -> None:
    values = np.arange(5 * 4 * 3, dtype=np.float32).reshape(5, 4, 3)
    mean = block_mean(values, 2)
    assert mean.shape == (3, 2, 2)
    assert mean[0, 0, 0] == values[:2, :2, :2].mean()
    assert mean[2, 1, 1] == values[4, 2:, 2].mean()
    back = spread(mean, 2, values.shape)
    assert back.shape == values.shape
    assert back[4, 3, 2] == mean[2, 1, 1]
    np.testing.assert_array_equal(block_mean(values, 1), values)


def test_the_tumor_is_the_first_candidate(head: HeadPhantom, tilted_head: HeadPhantom) -> None:
    for phantom in (head, tilted_head):
        brain = find_brain(phantom.pre, phantom.post)
        search = find_candidates(calibrate(brain, phantom.post, phantom.pre), brain.mask, brain.grid.spacing)
        rim = brain.grid.sample(phantom.truth) == 1
        first = search.candidates[0]
        assert rim[first.voxels].mean() > 0.7
        order = [candidate.evidence_mm3 for candidate in search.candidates]
        assert order == sorted(order, reverse=True)
        # The octree alone holds it too.
        peak = search.octree.on_grid(brain.grid.shape)
        assert (peak[rim & brain.mask] > 0).mean() > 0.8
        assert (peak[brain.mask] == 0).any()


@pytest.fixture(scope="module")
def found(head: HeadPhantom) -> tuple[Brain, Calibration, np.ndarray]:
    brain = find_brain(head.pre, head.post)
    return brain, calibrate(brain, head.post, head.pre), np.ones(brain.grid.shape, np.float32)


def test_a_point_in_the_necrosis_leads_to_the_rim(
    head: HeadPhantom, found: tuple[Brain, Calibration, np.ndarray]
) -> None:
    brain, calibration, weight = found
    warnings: list[str] = []
    (candidate,) = candidates_from_points([head.tumors[0].center], brain, calibration, weight, warnings)
    rim = brain.grid.sample(head.truth) == 1
    assert candidate.seeded_by == "user"
    assert rim[candidate.voxels].mean() > 0.7
    assert not warnings


def test_points_outside_and_points_at_nothing(head: HeadPhantom, found: tuple[Brain, Calibration, np.ndarray]) -> None:
    brain, calibration, weight = found
    with pytest.raises(InvalidInput, match=r"\(500, 0, 0\) lies outside") as caught:
        check_points([(0, 0, 0), (500, 0, 0)], head.post)
    assert caught.value.code == "invalid_params"
    with pytest.raises(InvalidInput, match="outside"):
        check_points([(0, float("nan"), 0)], head.post)
    quiet = Calibration(np.zeros_like(calibration.field), calibration.before, 1.0, 0.0, 1.0, True)
    with pytest.raises(InvalidInput, match="None of the 1 seeds") as caught:
        candidates_from_points([(0, 0, 0)], brain, quiet, weight, [])
    assert caught.value.code == "no_object_found"
    warnings: list[str] = []
    far = head.post.to_world((2, 2, 2))
    both = candidates_from_points([head.tumors[0].center, far], brain, calibration, weight, warnings)
    assert len(both) == 1
    assert len(warnings) == 1
    assert "Nothing enhances within 25 mm" in warnings[0]

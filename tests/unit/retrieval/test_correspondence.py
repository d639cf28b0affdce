"""Samples laid on each other: left stays left, mirrored bodies find themselves, and parts follow their samples."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_retrieval import _matching_kernels as kernels
from shapery_retrieval._correspondence_kernels import _misfit
from shapery_retrieval.correspondence import SampledSurface, between_parts, lay, surface_of
from shapery_retrieval.describe import Description, describe
from shapery_retrieval.matching import match
from shapery_retrieval.search import region_of

from .conftest import egg


def body(bent: float = 0.0) -> TriangleMesh:
    """A body that is alike on both sides of x = 0: two arms, a head and a tail, bent sideways."""
    ball = icosphere(subdivisions=3)
    p = ball.vertices
    places = np.array([[0.9, 0.3, 0.3], [-0.9, 0.3, 0.3], [0.0, 0.3, 0.95], [0.0, -0.9, -0.4]])
    places /= np.linalg.norm(places, axis=1, keepdims=True)
    lengths = np.array([1.2, 1.2, 0.8, 1.6])
    radius = 1 + np.exp(-12 * ((p[:, None] - places) ** 2).sum(axis=2)) @ lengths
    p = p * radius[:, None] * [1.0, 0.8, 1.3]
    turn = bent * p[:, 2]
    x, z = p[:, 0], p[:, 2]
    p = np.stack((x * np.cos(turn) + z * np.sin(turn), p[:, 1], z * np.cos(turn) - x * np.sin(turn)), axis=1)
    return ball.with_vertices(p)


def mirrored(mesh: TriangleMesh) -> TriangleMesh:
    return mesh.with_vertices(mesh.vertices * [-1, 1, 1]).flipped()


def landed(query: Description, other: Description) -> np.ndarray:
    """(s, 3) where, in the other's frame, most of each sample of the query is laid."""
    plan = lay(surface_of(query.arg), surface_of(other.arg))
    there = other.normalised.mesh.vertices[other.decomposition.samples.vertices]
    return np.asarray(there[np.argmax(plan, axis=1)])


def at(description: Description) -> np.ndarray:
    return np.asarray(description.normalised.mesh.vertices[description.decomposition.samples.vertices])


@pytest.fixture(scope="module")
def upright() -> Description:
    return describe(body())


@pytest.fixture(scope="module")
def leaning() -> Description:
    return describe(body(0.25))


def test_a_mirror_changes_the_sign_of_sides_and_nothing_else(described_egg: Description) -> None:
    turned = describe(mirrored(egg()))
    # both are sampled anew: each sample is compared with the nearest one of the other
    apart = np.linalg.norm((at(turned) * [-1, 1, 1])[:, None] - at(described_egg), axis=2)
    near, partner = apart.min(axis=1) < 1e-6, apart.argmin(axis=1)
    assert near.mean() > 0.9
    for name, sign in (("patch_sides", -1), ("patch_features", 1)):
        there = turned.arg.whole[name][near].astype(float)
        here = described_egg.arg.whole[name][partner[near]].astype(float)
        assert np.corrcoef(there.ravel(), sign * here.ravel())[0, 1] > 0.98


def test_a_ball_has_no_sides() -> None:
    assert np.abs(describe(icosphere(subdivisions=3)).arg.whole["patch_sides"]).max() < 0.1


def test_left_stays_left_in_another_pose(upright: Description, leaning: Description) -> None:
    arms = np.abs(at(upright)[:, 0]) > 0.3
    found = landed(leaning, upright)
    own = body().vertices
    # the body's vertices are numbered alike in both poses
    moved = (body(0.25).vertices - leaning.normalised.centre) * leaning.normalised.scale
    nearest = np.argmin(np.linalg.norm(at(leaning)[:, None] - moved, axis=2), axis=1)
    truth = (own[nearest] - upright.normalised.centre) * upright.normalised.scale
    sideways = np.abs(truth[:, 0]) > 0.15
    assert arms.any()
    assert sideways.sum() > 20
    assert (np.sign(found[sideways, 0]) == np.sign(truth[sideways, 0])).mean() > 0.97
    assert np.linalg.norm(found - truth, axis=1).mean() < 0.12


def test_a_mirrored_body_is_laid_on_its_original(described_egg: Description) -> None:
    turned = describe(mirrored(egg()))
    found = landed(turned, described_egg)
    assert np.linalg.norm(found - at(turned) * [-1, 1, 1], axis=1).mean() < 0.1


def test_levels_agree_and_keep_the_areas(upright: Description, leaning: Description) -> None:
    found = match(upright.arg, leaning.arg)
    first, second = found.levels[1].transport, found.levels[2].transport
    above, beside = upright.arg.levels[2].parents, leaning.arg.levels[2].parents
    summed = np.zeros_like(first)
    np.add.at(summed, (above[:, None], beside[None]), second)
    np.testing.assert_allclose(summed, first, atol=1e-6)
    assert first.sum() == pytest.approx(1, abs=1e-4)
    np.testing.assert_allclose(first.sum(axis=1), upright.arg.levels[1].masses, atol=0.02)
    surface = surface_of(upright.arg)
    for level, (parts, count) in zip(upright.arg.levels[1:], surface.parts, strict=True):
        np.testing.assert_allclose(np.bincount(parts, surface.masses, count), level.masses, atol=1e-4)


def test_parts_laid_on_another_pose_keep_their_borders(upright: Description, leaning: Description) -> None:
    own = upright.decomposition.levels[-1][upright.cells_on(body())]
    found = match(upright.arg, leaning.arg)
    cells = leaning.cells_on(body(0.25))
    laid = found.overlaid[cells]
    # the body's vertices are numbered alike in both poses
    kept = (own == laid).mean()
    partner = np.array([j for _, j, _ in found.levels[-1].pairs()])
    matched = (partner[own] == leaning.decomposition.levels[-1][cells]).mean()
    assert kept > 0.65
    assert kept > matched + 0.05
    itself = match(upright.arg, upright.arg).overlaid
    assert (itself == upright.decomposition.levels[-1]).mean() > 0.98


def test_parts_of_a_region_lie_on_it_and_nowhere_else(upright: Description) -> None:
    levels = upright.arg.levels
    chosen = int(np.argmax(levels[1].masses))
    shares = [np.ones(1), (np.arange(levels[1].parts) == chosen) * 1.0, (levels[2].parents == chosen) * 1.0]
    laid = match(region_of(upright.arg, shares), upright.arg, partial=True).overlaid
    inside = upright.decomposition.levels[1] == chosen
    areas = upright.decomposition.samples.areas
    assert areas[inside & (laid >= 0)].sum() > 0.95 * areas[inside].sum()
    # samples beside a border take some of what lies on it
    assert areas[~inside & (laid >= 0)].sum() < 0.15 * areas[~inside].sum()
    assert set(laid.tolist()) <= {-1, *range(int((levels[2].parents == chosen).sum()))}


def test_a_plan_turned_over_is_the_plan_backwards(upright: Description, leaning: Description) -> None:
    here, there = surface_of(upright.arg), surface_of(leaning.arg)
    np.testing.assert_allclose(lay(here, there), lay(there, here).T, atol=1e-6)


def test_places_as_good_as_others_do_not_hang_on_rounding(
    described_egg: Description, described_torus: Description
) -> None:
    # all along a torus places are alike: which one was the largest once differed from one direction to the other
    here, there = surface_of(described_egg.arg), surface_of(described_torus.arg)
    np.testing.assert_allclose(lay(here, there), lay(there, here).T, atol=1e-6)


def test_a_sample_fits_where_those_around_it_keep_their_distances() -> None:
    rng = np.random.default_rng(1)
    points, others = rng.uniform(size=(9, 3)), rng.uniform(size=(7, 3))
    own, there = (np.linalg.norm(p[:, None] - p, axis=2).astype(np.float32) for p in (points, others))
    near = np.argsort(own, axis=1)[:, :6].astype(np.int32)
    places = rng.integers(0, 7, 9).astype(np.int32)
    found = _misfit(near, own, places, there)
    for i, j in np.ndindex(9, 7):
        assert found[i, j] == pytest.approx(np.mean((own[i, near[i]] - there[places[near[i]], j]) ** 2), rel=1e-4)


def test_a_region_keeps_its_samples(described_egg: Description) -> None:
    arg = described_egg.arg
    kept = np.arange(arg.levels[2].parts) % 2 == 0
    region = region_of(arg, [np.ones(1), np.arange(16) < 8, kept.astype(float)])
    whole, part = surface_of(arg), surface_of(region)
    inside = kept[whole.parts[1][0]]
    assert len(part.masses) == inside.sum()
    np.testing.assert_array_equal(part.known, whole.known[inside])
    np.testing.assert_array_equal(part.sides, whole.sides[inside])
    first = np.flatnonzero(inside)[:10]
    # distances among the first samples that are left are those of the whole
    full = described_egg.decomposition.samples.distances
    share = full[np.ix_(first, first)] / full.max()
    np.testing.assert_allclose(part.unit / arg.whole["patch_reach"][0] * part.distances[:10, :10], share, atol=0.003)
    np.testing.assert_array_equal(part.parts[1][0], (np.cumsum(kept) - 1)[whole.parts[1][0][inside]])
    above = whole.parts[0][0][inside]
    np.testing.assert_array_equal(part.parts[0][0], np.where(above < 8, above, -1))
    assert [count for _, count in part.parts] == [8, kept.sum()]
    # what lies in no part of a level is carried between none
    first, second = between_parts(np.full((len(above), len(whole.masses)), 1e-4, np.float32), part, whole)
    assert first.shape == (8, 16)
    assert first.sum() == pytest.approx(1e-4 * (above < 8).sum() * len(whole.masses), rel=1e-4)
    assert second.sum() == pytest.approx(1e-4 * len(above) * len(whole.masses), rel=1e-4)


def test_one_sample_is_laid_on_one() -> None:
    one, none = np.ones(1, np.float32), np.zeros(1, np.float32)
    part = np.zeros(1, np.int64), 1
    one = SampledSurface(
        one,
        np.zeros((1, 22), np.float32),
        np.zeros((1, 10), np.float32),
        none,
        np.zeros((1, 1), np.uint8),
        np.float32(1),
        np.zeros((1, 1), np.int32),
        one,
        (part, part),
    )
    np.testing.assert_allclose(lay(one, one), 1)


def test_settled_plans_meet_both_margins() -> None:
    rng = np.random.default_rng(0)
    masses, others = (rng.dirichlet(np.ones(k)).astype(np.float32) for k in (7, 5))
    cost = rng.uniform(size=(7, 5)).astype(np.float32)
    plan, back = np.empty((7, 5), np.float32), np.empty((5, 7), np.float32)
    kernels.settle(cost, masses, others, np.float32(0.3), 200, False, plan)
    kernels.settle(np.ascontiguousarray(cost.T), others, masses, np.float32(0.3), 200, False, back)
    np.testing.assert_allclose(plan.sum(axis=1), masses, atol=1e-4)
    np.testing.assert_allclose(plan.sum(axis=0), others, atol=1e-4)
    np.testing.assert_allclose(plan, back.T, atol=1e-6)
    # what costs least is preferred as much as entropy lets it: exp(−c/ε) times a factor by row and by column
    ratio = np.log(plan) + cost / 0.3
    np.testing.assert_allclose(ratio - ratio[:1] - ratio[:, :1] + ratio[0, 0], 0, atol=0.02)

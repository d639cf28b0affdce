"""Matching of graphs: against brute force on small ones, symmetry, identity, correspondence."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_contracts.errors import InvalidInput
from shapery_retrieval import _matching_kernels as kernels
from shapery_retrieval.arg import Arg
from shapery_retrieval.describe import Description, build_arg
from shapery_retrieval.matching import match
from shapery_retrieval.search import region_of

from .conftest import torus


def transport(
    x: tuple, y: tuple, *, alpha: float, epsilon: float, relaxed: bool = False, rounds: int = 60
) -> tuple[float, np.ndarray]:
    plan = np.zeros((len(x[0]), len(y[0])), dtype=np.float32)
    nodes = ((x[1][:, None] - y[1][None]) ** 2).sum(axis=2)
    a, e = np.float32(alpha), np.float32(epsilon)
    cost = kernels.transport(nodes, x[0], x[2], y[0], y[2], a, e, e, 3, rounds, relaxed, plan)
    return cost, plan


def graph(k: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Equal masses, features far apart, distances of points in the plane."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(k, 2))
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    features = 2 * rng.normal(size=(k, 3))
    return np.full(k, 1 / k, np.float32), features.astype(np.float32), (distances / distances.mean()).astype(np.float32)


def brute_force(x: tuple, y: tuple, alpha: float) -> tuple[float, tuple[int, ...]]:
    """The best one-to-one matching of two graphs of equal size by trying all."""
    k = len(x[0])
    nodes = ((x[1][:, None] - y[1][None]) ** 2).sum(axis=2)

    def cost(order: tuple[int, ...]) -> float:
        chosen = list(order)
        structure = ((x[2] - y[2][np.ix_(chosen, chosen)]) ** 2).sum() / k**2
        return (1 - alpha) * nodes[np.arange(k), chosen].mean() + alpha * structure

    return min((cost(order), order) for order in itertools.permutations(range(k)))


@pytest.mark.parametrize("seed", range(12))
def test_small_graphs_are_matched_as_brute_force_matches_them(seed: int) -> None:
    x = graph(5, seed)
    rng = np.random.default_rng(100 + seed)
    order = rng.permutation(5)
    noise = 0.1 * rng.normal(size=(5, 3)).astype(np.float32)
    y = (x[0], x[1][order] + noise, np.ascontiguousarray(x[2][np.ix_(order, order)]))
    best, mapping = brute_force(x, y, 0.5)
    cost, plan = transport(x, y, alpha=0.5, epsilon=0.05)
    assert tuple(np.argmax(plan, axis=1).tolist()) == mapping
    assert cost == pytest.approx(best, abs=0.02)


@given(st.integers(0, 500), st.integers(2, 9), st.integers(2, 9))
@settings(max_examples=40, deadline=None)
def test_plans_keep_their_margins_and_swap_with_the_graphs(seed: int, k: int, l: int) -> None:  # noqa: E741
    x, y = graph(k, seed), graph(l, seed + 1)
    # nearly exclusive choices balance slowly
    there, plan = transport(x, y, alpha=0.5, epsilon=4.0, rounds=1000)
    back, other = transport(y, x, alpha=0.5, epsilon=4.0, rounds=1000)
    assert there == pytest.approx(back, rel=1e-4)
    np.testing.assert_allclose(plan, other.T, atol=1e-5)
    assert plan.sum() == pytest.approx(1, abs=1e-4)
    np.testing.assert_allclose(plan.sum(axis=1), x[0], atol=0.02)
    assert (plan >= 0).all()


def test_relaxed_plans_meet_the_first_margin_alone() -> None:
    x, y = graph(3, 1), graph(8, 2)
    _, plan = transport(x, y, alpha=0.3, epsilon=0.1, relaxed=True)
    np.testing.assert_allclose(plan.sum(axis=1), x[0], atol=1e-5)
    assert plan.sum(axis=0).max() > 0.2


def test_far_features_leave_no_column_undefined() -> None:
    x = graph(6, 3)
    y = (x[0], x[1] + np.float32(300), x[2])
    cost, plan = transport(x, y, alpha=0.5, epsilon=0.01)
    assert np.isfinite(plan).all()
    assert np.isfinite(cost)


def test_a_shape_matches_itself_and_others_less(described_egg: Description, described_torus: Description) -> None:
    itself = match(described_egg.arg, described_egg.arg)
    assert itself.score == pytest.approx(1, abs=1e-5)
    assert [level.score for level in itself.levels] == pytest.approx([1, 1, 1], abs=1e-5)
    # parts that are much alike share their area
    assert sum(weight for i, j, weight in itself.levels[1].pairs() if i == j) > 0.6
    other = match(described_egg.arg, described_torus.arg)
    back = match(described_torus.arg, described_egg.arg)
    assert 0 <= other.score < 0.8
    assert other.score == pytest.approx(back.score, abs=1e-4)
    np.testing.assert_allclose(other.levels[2].transport, back.levels[2].transport.T, atol=1e-4)


def test_genus_one_matches_genus_one_best(described_egg: Description, described_torus: Description) -> None:
    slimmer = build_arg(torus(thickness=0.33))
    assert match(slimmer, described_torus.arg).score > match(slimmer, described_egg.arg).score + 0.1


def test_a_region_matches_the_whole_it_is_of(described_egg: Description, described_torus: Description) -> None:
    arg = described_egg.arg
    half = np.arange(arg.levels[2].parts) % 2 == 0
    region = region_of(arg, [np.ones(1), np.arange(16) < 8, half.astype(float)])
    assert region.levels[1].parts == 8
    assert region.levels[2].parts == half.sum()
    assert region.levels[2].masses.sum() == pytest.approx(1, abs=1e-5)
    found = match(region, arg, partial=True)
    assert found.score > 0.9
    assert found.score > match(region, described_torus.arg, partial=True).score
    assert found.best_level in {1, 2}
    # the parts of the region meet the very parts that they are
    where = np.flatnonzero(half)
    pairs = found.levels[1].pairs()
    weights = sum(weight for i, j, weight in pairs if where[i] == j)
    assert weights > 0.5 * sum(weight for _, _, weight in pairs)


def test_versions_do_not_mix(described_egg: Description) -> None:
    arg = described_egg.arg
    with pytest.raises(InvalidInput, match="different index versions"):
        match(arg, replace(arg, index_version=arg.index_version + 1))


def test_levels_of_different_sizes_match() -> None:
    small = build_arg(torus(12, 8))
    assert isinstance(small, Arg)
    assert match(small, small).score == pytest.approx(1, abs=1e-5)

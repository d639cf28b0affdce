"""Decomposition: normalized cuts against brute force, modes, sibling modes that merge, nested levels."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_geometry.mesh import icosphere
from shapery_retrieval.decompose import decompose, normalized_cut, split_further
from shapery_retrieval.describe import Description
from shapery_retrieval.normalise import normalise
from shapery_retrieval.signals import compute_signals

from .conftest import cylinder


def ncut(weights: np.ndarray, second: np.ndarray) -> float:
    cut = weights[second][:, ~second].sum()
    return cut / weights[second].sum() + cut / weights[~second].sum()


@given(st.integers(0, 10_000))
@settings(max_examples=30, deadline=None)
def test_the_cost_of_a_cut_is_what_it_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    weights = rng.random((7, 7))
    weights = weights + weights.T
    second, cost = normalized_cut(weights)
    assert not second[0]
    assert second.any()
    assert cost == pytest.approx(ncut(weights, second))


def test_two_clusters_are_cut_where_brute_force_cuts_them() -> None:
    rng = np.random.default_rng(0)
    points = np.concatenate((rng.normal(size=(4, 2)), rng.normal(size=(5, 2)) + 4))
    weights = np.exp(-((points[:, None] - points[None]) ** 2).sum(axis=2) / 8)
    found, cost = normalized_cut(weights)
    best = min(
        ncut(weights, np.array((False, *choice)))
        for choice in itertools.product((False, True), repeat=8)
        if any(choice)
    )
    assert cost == pytest.approx(best)
    assert found.tolist() == [False] * 4 + [True] * 5


def test_levels_are_nested_and_parts_hang_together(described_egg: Description) -> None:
    decomposition = described_egg.decomposition
    for above, below in itertools.pairwise(decomposition.levels):
        for part in range(below.max() + 1):
            assert len(np.unique(above[below == part])) == 1
    # heavy parts are cut rather than light ones, so none is left that is much heavier than the mean
    mass = np.bincount(decomposition.levels[1], weights=decomposition.samples.areas)
    assert mass.max() < 4 / len(mass)


def test_cuts_that_cost_least_come_first_even_of_light_parts() -> None:
    weights = np.full((10, 10), 0.01)
    for some in (slice(0, 6), slice(6, 8), slice(8, 10)):
        weights[some, some] = 1.0
    labels = split_further(np.zeros(10, dtype=np.int64), weights, np.full(10, 0.1), 3)
    assert len(set(labels[:6])) == len(set(labels[6:8])) == len(set(labels[8:])) == 1
    assert len(set(labels)) == 3
    # where cuts are alike, the heavier part is cut
    halves = np.repeat([0, 1], 4)
    even = split_further(halves, np.ones((8, 8)), np.array([0.05] * 4 + [0.2] * 4), 3)
    assert len(set(even[:4])) == 1
    assert len(set(even[4:])) == 2


def test_a_graph_that_cannot_be_cut_further_stays() -> None:
    labels = split_further(np.zeros(3, dtype=np.int64), np.ones((3, 3)), np.ones(3), 16)
    assert sorted(labels.tolist()) == [0, 1, 2]


def test_sibling_modes_on_a_cylinder_merge() -> None:
    """Fig. 4.1: the side of a cylinder has many modes of one feature; the second stage makes one component of them."""
    normalised = normalise(cylinder())
    found = decompose(compute_signals(normalised))
    points = normalised.mesh.vertices[found.samples.vertices]
    height = np.ptp(normalised.mesh.vertices[:, 2])
    middle = np.abs(points[:, 2]) < 0.2 * height
    modes = np.unique(found.modes[middle])
    assert len(modes) > 1
    assert len(np.unique(found.components[middle])) == 1
    assert len(np.unique(found.components)) < len(np.unique(found.modes))


def test_a_sphere_has_no_parts_of_its_own() -> None:
    found = decompose(compute_signals(normalise(icosphere(subdivisions=3))))
    assert len(np.unique(found.components)) == 1


def test_windows_grow_while_their_modes_are_stable(described_egg: Description) -> None:
    found = described_egg.decomposition
    smallest = float(np.median(np.sort(found.samples.distances, axis=1)[:, 8]))
    assert found.windows.min() >= smallest
    assert found.windows.max() <= 3.0 * smallest * (1 + 1e-9)
    # on a smooth body they do
    assert found.windows.max() > 1.4 * smallest

"""Which points of two surfaces correspond, and with them which parts.

Parts move with the pose, and a part alone cannot be told from its like on the other side. So it is the samples of two
surfaces that are laid on each other, and a part corresponds to those parts that its samples come to lie in.

Where all that is known is alike on both sides, `shapery_retrieval.sides` tells them apart.

References
----------
F. Mémoli, Gromov–Wasserstein distances and the metric approach to object matching, Foundations of Computational
Mathematics 11, 2011, doi:10.1007/s10208-011-9093-5.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_retrieval import _matching_kernels as kernels
from shapery_retrieval.arg import Arg
from shapery_retrieval.patches import patches_of
from shapery_retrieval.sides import SIDES

KNOWN = (*range(7), *range(14, 29))
"""Features of patches by which samples are laid on each other: the means, and how the surface lies around."""
KNOWN_WEIGHT = 1 / 8
COARSE = 40
"""So many samples, the first and most spread ones, are laid on each other by all their distances."""
ALPHA, WARM, EPSILON = np.float32(0.9), np.float32(0.07), np.float32(0.01)
"""Share of the distances in the cost, which are what a pose keeps; entropy at first and at last."""
OUTER, ROUNDS = 2, 6
SIDE_WEIGHT = np.float32(0.4)
MIRRORED = 0.5
"""A body is taken for mirrored where this brings its cost below this share. Of poses none came below 0.65; a mirrored
copy comes to about 0.02."""
FINE_EPSILON = np.float32(0.01)
"""Entropy of the plan of all samples, which is found from their distances to the coarse ones."""

Array = NDArray[np.float64]
Array32 = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class SampledSurface:
    """The samples of a surface, or of a region of one, laid out to be compared.

    Attributes
    ----------
    masses : (s,) float32
        Share of the surface of each.
    features : (s, 22) float32
        Standardised and weighted, so that squared distance is the cost of laying two on each other.
    sides : (s, 10) float32
        Weighted likewise.
    distances : (s, c) float32
        Geodesic distance from each to the first ones, over the mean.
    parts
        For each level below the root the (s,) part of each; −1 where a region does not hold it.
    """

    masses: Array32
    features: Array32
    sides: Array32
    distances: Array32
    parts: tuple[NDArray[np.int64], ...]


def surface_of(arg: Arg) -> SampledSurface:
    """Lay out the samples that a graph holds."""
    finest = arg.whole["patch_parts"].astype(np.int64)
    s = len(finest)
    # near a border patches count less, but all of a part is its samples together
    counted = arg.whole["patch_masses"].astype(np.float64)
    masses = counted / np.bincount(finest, counted)[finest] * arg.levels[-1].masses[finest]
    features = patches_of(arg).features[:, KNOWN] * np.float32(np.sqrt(KNOWN_WEIGHT))
    by_side = arg.whole["patch_sides"].astype(np.float32) * np.sqrt(SIDE_WEIGHT / len(SIDES) / 2)
    unit = np.float32(arg.whole["patch_reach"][0] / 255)
    bare = np.append(arg.whole["patch_distances"], np.uint8(0))
    distances = bare[_places(s)[:, : min(COARSE, s)]] * unit
    parts = [finest]
    for level in arg.levels[:1:-1]:
        parts.insert(0, np.where(parts[0] < 0, -1, level.parents[parts[0]]).astype(np.int64))
    return SampledSurface((masses / masses.sum()).astype(np.float32), features, by_side, distances, tuple(parts))


def region_samples(whole: Mapping[str, NDArray[Any]], numbers: NDArray[np.int32]) -> dict[str, NDArray[Any]]:
    """Return the arrays of a graph with those samples alone that lie in a region; what is not of samples stays.

    Parameters
    ----------
    whole
        As the graph has them.
    numbers
        What each of its finest parts is called in the region; −1 where it is not of it.
    """
    chosen = np.flatnonzero(numbers[whole["patch_parts"]] >= 0)
    of_each = ("patch_masses", "patch_features", "patch_sides")
    pairs = _places(len(whole["patch_parts"]))[np.ix_(chosen, chosen)][np.triu_indices(len(chosen), 1)]
    return {
        **whole,
        **{name: whole[name][chosen] for name in of_each},
        "patch_parts": numbers[whole["patch_parts"][chosen]].astype(np.uint8),
        "patch_distances": whole["patch_distances"][pairs],
    }


def lay(query: SampledSurface, other: SampledSurface, *, relaxed: bool = False) -> Array:
    """(s, t) plan that lays the samples of one surface on those of another; in sum 1.

    Parameters
    ----------
    query, other
        Two surfaces.
    relaxed
        Whether the query may be a part of the other: then parts of the other may stay bare.

    Notes
    -----
    A few samples are laid by fused Gromov–Wasserstein transport, the others by their distances to these. Left is laid
    on left, unless right on left costs far less: a body with two like sides may lean to either, a mirrored one is its
    original.
    """
    few, there_few = query.distances.shape[1], other.distances.shape[1]
    nodes = _squared(query, other)
    # |a + b|² is |a − b|² and four times a·b
    turn = 4 * query.sides @ other.sides.T
    cost, plan = _coarse(query, other, nodes, relaxed)
    turned_cost, turned = _coarse(query, other, nodes[:few, :there_few] + turn[:few, :there_few], relaxed)
    if turned_cost < MIRRORED * cost:
        nodes, plan = nodes + turn, turned
    here, there = query.distances, other.distances
    laid = (here @ plan) @ there.T
    laid *= -2
    laid += (here**2 @ plan.sum(axis=1))[:, None]
    laid += there**2 @ plan.sum(axis=0)
    laid *= ALPHA
    nodes *= 1 - ALPHA
    laid += nodes
    result = np.empty_like(laid)
    kernels.settle(laid, query.masses, other.masses, FINE_EPSILON, ROUNDS, relaxed, result)
    return np.asarray(result, dtype=np.float64)


def between_parts(plan: Array, query: NDArray[np.int64], other: NDArray[np.int64], k: int, l: int) -> Array:  # noqa: E741
    """(k, l) sum of a plan of samples over the parts that they lie in, as far as they lie in any."""
    rows, columns = np.zeros((k + 1, plan.shape[0])), np.zeros((l + 1, plan.shape[1]))
    rows[query, np.arange(len(query))] = 1.0
    columns[other, np.arange(len(other))] = 1.0
    return np.asarray(rows[:k] @ plan @ columns[:l].T)


def _coarse(query: SampledSurface, other: SampledSurface, nodes: Array32, relaxed: bool) -> tuple[float, Array32]:
    k, l = query.distances.shape[1], other.distances.shape[1]  # noqa: E741
    plan = np.empty((k, l), dtype=np.float32)
    cost = kernels.transport(
        np.ascontiguousarray(nodes[:k, :l]), _gathered(query), query.distances[:k], _gathered(other),
        other.distances[:l], ALPHA, WARM, EPSILON, OUTER, ROUNDS, relaxed, plan,
    )  # fmt: skip
    return float(cost), plan


def _gathered(surface: SampledSurface) -> Array32:
    """(c,) share of the surface that is nearest to each of the first samples."""
    nearest = np.argmin(surface.distances, axis=1)
    return np.asarray(np.bincount(nearest, surface.masses, surface.distances.shape[1]), dtype=np.float32)


def _squared(query: SampledSurface, other: SampledSurface) -> Array32:
    """(s, t) squared distances by features and sides."""
    own, others = (np.concatenate((each.features, each.sides), axis=1) for each in (query, other))
    squares = own @ others.T
    squares *= -2
    squares += (own**2).sum(axis=1)[:, None]
    squares += (others**2).sum(axis=1)
    return np.asarray(np.maximum(squares, np.float32(0), out=squares))


@lru_cache(maxsize=64)
def _places(s: int) -> NDArray[np.intp]:
    """(s, s) where the distance of each pair of samples is kept; that to itself follows the last one."""
    upper = np.triu_indices(s, 1)
    places = np.full((s, s), len(upper[0]), dtype=np.intp)
    places[upper] = np.arange(len(upper[0]))
    return np.minimum(places, places.T)

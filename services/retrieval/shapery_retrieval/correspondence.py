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
from shapery_retrieval.patches import BLOCKS
from shapery_retrieval.sides import SIDES
from shapery_retrieval.vocabulary import vocabulary

KNOWN = (*range(7), *range(14, 29))
"""Features of patches by which samples are laid on each other: the means, and how the surface lies around."""
KNOWN_WEIGHT = 1 / 8
COARSE = 40
"""So many samples, the first and most spread ones, are laid on each other by all their distances."""
ALPHA, WARM, EPSILON = np.float32(0.9), np.float32(0.07), np.float32(0.01)
"""Share of the distances in the cost, which are what a pose keeps; entropy at first and at last."""
OUTER, ROUNDS = 2, 4
SIDE_WEIGHT = np.float32(0.4)
MIRRORED = 0.5
"""A body is taken for mirrored where this brings its cost below this share. Of poses none came below 0.65; a mirrored
copy comes to about 0.02."""
FINE_EPSILON = np.float32(0.01)
"""Entropy of the plan of all samples, which is found from their distances to the coarse ones."""

Array32 = NDArray[np.float32]

_MIRROR = np.array([1] * len(KNOWN) + [-1] * len(SIDES), dtype=np.float32)


@dataclass(frozen=True, eq=False)
class SampledSurface:
    """The samples of a surface, or of a region of one, laid out to be compared.

    Attributes
    ----------
    masses : (s,) float32
        Share of the surface of each.
    features : (s, 32) float32
        Standardised and weighted, so that squared distance is the cost of laying two on each other. The last ten are
        the sides.
    squares : (s,) float32
        Their squared lengths.
    distances : (s, c) float32
        Geodesic distance from each to the first ones, over the mean.
    gathered : (c,) float32
        Share of the surface that is nearest to each of the first ones.
    parts
        For each level below the root a (k, s) float32 matrix: 1 where a part holds a sample. A region may hold a sample
        on one level alone.
    """

    masses: Array32
    features: Array32
    squares: Array32
    distances: Array32
    gathered: Array32
    parts: tuple[Array32, ...]


def surface_of(arg: Arg) -> SampledSurface:
    """Lay out the samples that a graph holds."""
    finest = arg.whole["patch_parts"].astype(np.int64)
    s = len(finest)
    # near a border patches count less, but all of a part is its samples together
    counted = arg.whole["patch_masses"].astype(np.float64)
    masses = counted / np.bincount(finest, counted)[finest] * arg.levels[-1].masses[finest]
    masses /= masses.sum()
    features = np.empty((s, len(KNOWN) + len(SIDES)), np.float32)
    features[:, : len(KNOWN)] = arg.whole["patch_features"][:, KNOWN]
    features[:, len(KNOWN) :] = arg.whole["patch_sides"]
    mean, factor = _standards()
    features -= mean
    features *= factor
    bare = np.append(arg.whole["patch_distances"], np.uint8(0))
    distances = bare[_places(s, COARSE)] * np.float32(arg.whole["patch_reach"][0] / 255)
    gathered = np.bincount(np.argmin(distances, axis=1), masses, distances.shape[1])
    numbers = finest
    parts: list[Array32] = []
    for level in arg.levels[:0:-1]:
        held = np.zeros((level.parts + 1, s), np.float32)
        held[numbers, np.arange(s)] = 1.0
        parts.insert(0, held[:-1])
        # −1, of no part, stays −1: it is the row that is cut off
        numbers = np.append(level.parents, -1)[numbers]
    return SampledSurface(
        masses.astype(np.float32),
        features,
        np.einsum("sf,sf->s", features, features),
        distances,
        gathered.astype(np.float32),
        tuple(parts),
    )


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
    pairs = _places(len(whole["patch_parts"]), len(whole["patch_parts"]))[np.ix_(chosen, chosen)][
        np.triu_indices(len(chosen), 1)
    ]
    return {
        **whole,
        **{name: whole[name][chosen] for name in of_each},
        "patch_parts": numbers[whole["patch_parts"][chosen]].astype(np.uint8),
        "patch_distances": whole["patch_distances"][pairs],
    }


def lay(query: SampledSurface, other: SampledSurface, *, relaxed: bool = False) -> Array32:
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
    on left, unless single samples look more alike mirrored, and all of them together cost far less: a body with two
    like sides may lean to either, a mirrored one is its original.
    """
    own, few, there_few = query.features, len(query.gathered), len(other.gathered)
    alike = _squared(query, own, few, other, there_few)
    cost, plan = _coarse(query, other, alike, relaxed)
    turned = _squared(query, own * _MIRROR, few, other, there_few)
    gain = query.gathered @ (alike.min(axis=1) - turned.min(axis=1))
    gain += other.gathered @ (alike.min(axis=0) - turned.min(axis=0))
    if gain > 0:
        turned_cost, turned_plan = _coarse(query, other, turned, relaxed)
        if turned_cost < MIRRORED * cost:
            own, plan = own * _MIRROR, turned_plan
    # features and the distances to the coarse samples, which the plan carries over, in one product
    here, there = query.distances, other.distances
    left = np.concatenate((own * (ALPHA - 1), (here @ plan) * -ALPHA), axis=1)
    laid = left @ np.concatenate((other.features, there), axis=1).T
    laid *= 2
    laid += ((1 - ALPHA) * query.squares + ALPHA * (here**2 @ plan.sum(axis=1)))[:, None]
    laid += (1 - ALPHA) * other.squares + ALPHA * (there**2 @ plan.sum(axis=0))
    result = np.empty(laid.shape, dtype=np.float32)
    kernels.settle(laid, query.masses, other.masses, FINE_EPSILON, ROUNDS, relaxed, result)
    return result


def _squared(query: SampledSurface, own: Array32, k: int, other: SampledSurface, l: int) -> Array32:  # noqa: E741
    """(k, l) squared distances of the first samples by features and sides."""
    result = own[:k] @ other.features[:l].T
    result *= -2
    result += query.squares[:k, None]
    result += other.squares[:l]
    return np.asarray(result)


def _coarse(query: SampledSurface, other: SampledSurface, nodes: Array32, relaxed: bool) -> tuple[float, Array32]:
    k, l = len(query.gathered), len(other.gathered)  # noqa: E741
    plan = np.empty((k, l), dtype=np.float32)
    cost = kernels.transport(
        nodes, query.gathered, query.distances[:k], other.gathered, other.distances[:l],
        ALPHA, WARM, EPSILON, OUTER, ROUNDS, relaxed, plan,
    )  # fmt: skip
    return float(cost), plan


@lru_cache(maxsize=1)
def _standards() -> tuple[Array32, Array32]:
    """(32,) mean and (32,) factor of each feature of a sample."""
    words = vocabulary()
    scale = np.empty(len(words.patch_mean))
    for weight, columns in BLOCKS:
        scale[list(columns)] = np.sqrt(KNOWN_WEIGHT * weight / len(columns))
    known, side = list(KNOWN), np.full(len(SIDES), np.sqrt(SIDE_WEIGHT / len(SIDES) / 2))
    mean = np.concatenate((words.patch_mean[known], np.zeros(len(SIDES))))
    factor = np.concatenate(((scale / words.patch_spread)[known], side))
    return mean.astype(np.float32), factor.astype(np.float32)


@lru_cache(maxsize=64)
def _places(s: int, few: int) -> NDArray[np.intp]:
    """(s, few) where the distance of each sample to the first ones is kept; that to itself follows the last one."""
    upper = np.triu_indices(s, 1)
    places = np.full((s, s), len(upper[0]), dtype=np.intp)
    places[upper] = np.arange(len(upper[0]))
    return np.ascontiguousarray(np.minimum(places, places.T)[:, :few])

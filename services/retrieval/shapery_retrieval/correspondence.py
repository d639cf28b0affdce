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

from shapery_retrieval import _correspondence_kernels as kernels
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
MIRRORED = np.float32(0.5)
"""A body is taken for mirrored where this brings its cost below this share. Of poses none came below 0.65; a mirrored
copy comes to about 0.02."""
FINE_EPSILON = np.float32(0.01)
"""Entropy of the plan of all samples by their distances to the coarse ones."""
AROUND, NEAR_ALPHA, NEAR_EPSILON = 24, np.float32(0.96), np.float32(0.012)
"""By so many nearest samples each finds its place at last. A pose keeps short distances better than long ones, and near
its place what is known of a sample says less than where those around it lie."""
RELAXED_AROUND, RELAXED_ALPHA, RELAXED_EPSILON = 12, ALPHA, FINE_EPSILON
"""The same for a part, which has fewer samples."""
NEAR_ROUNDS = 12
"""Areas are kept more closely at last: they, too, tell how far along a limb a sample lies."""
BARE = np.float32(0.1)

Array32 = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class SampledSurface:
    """The samples of a surface, or of a region of one, laid out to be compared.

    Attributes
    ----------
    masses : (s,) float32
        Share of the surface of each.
    known : (s, 22) float32
        Features, standardised and weighted, so that squared distance is the cost of laying two on each other.
    sides : (s, 10) float32
        What changes its sign in a mirror, weighted likewise.
    squares : (s,) float32
        Squared lengths of both together.
    distances : (s, s) uint8
        Geodesic distances between them, in units.
    unit
        Of the distances, over the mean distance.
    around : (s, a) int32
        The nearest to each, itself among them.
    gathered : (c,) float32
        Share of the surface that is nearest to each of the first ones.
    parts
        For each level below the root the (s,) numbers of the parts that hold the samples, and how many parts there are.
        A region may hold a sample on one level alone: on the other it is of part −1.
    """

    masses: Array32
    known: Array32
    sides: Array32
    squares: Array32
    distances: NDArray[np.uint8]
    unit: np.float32
    around: NDArray[np.int32]
    gathered: Array32
    parts: tuple[tuple[NDArray[np.int64], int], ...]


def surface_of(arg: Arg) -> SampledSurface:
    """Lay out the samples that a graph holds."""
    finest = arg.whole["patch_parts"].astype(np.int64)
    s = len(finest)
    # near a border patches count less, but all of a part is its samples together
    counted = arg.whole["patch_masses"].astype(np.float64)
    masses = counted / np.bincount(finest, counted)[finest] * arg.levels[-1].masses[finest]
    masses /= masses.sum()
    mean, factor, side = _standards()
    known = (arg.whole["patch_features"][:, KNOWN] - mean) * factor
    sides = arg.whole["patch_sides"] * side
    bare = np.append(arg.whole["patch_distances"], np.uint8(0))
    distances = bare[_places(s)]
    coarse = min(s, COARSE)
    gathered = np.bincount(np.argmin(distances[:, :coarse], axis=1), masses, coarse)
    numbers = finest
    parts: list[tuple[NDArray[np.int64], int]] = []
    for level in arg.levels[:0:-1]:
        parts.insert(0, (numbers, level.parts))
        # −1, of no part, stays −1
        numbers = np.append(level.parents, -1)[numbers].astype(np.int64)
    return SampledSurface(
        masses.astype(np.float32),
        known,
        sides,
        np.einsum("sf,sf->s", known, known) + np.einsum("sf,sf->s", sides, sides),
        distances,
        np.float32(arg.whole["patch_reach"][0] / 255),
        np.argsort(distances, axis=1, kind="stable")[:, :AROUND].astype(np.int32),
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
    pairs = _places(len(whole["patch_parts"]))[np.ix_(chosen, chosen)][np.triu_indices(len(chosen), 1)]
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
    A few samples are laid by fused Gromov–Wasserstein transport, the others by their distances to these, and all once
    more by the distances to the samples around them, which lie where they were laid the most. Left is laid
    on left, unless single samples look more alike mirrored, and all of them together cost far less: a body with two
    like sides may lean to either, a mirrored one is its original.
    """
    plan = np.empty((len(query.masses), len(other.masses)), dtype=np.float32)
    near = (RELAXED_AROUND, RELAXED_ALPHA, RELAXED_EPSILON) if relaxed else (AROUND, NEAR_ALPHA, NEAR_EPSILON)
    kernels.lay(
        query.masses, query.known, query.sides, query.squares,
        query.distances, query.unit, query.around, query.gathered,
        other.masses, other.known, other.sides, other.squares,
        other.distances, other.unit, other.around, other.gathered,
        ALPHA, WARM, EPSILON, OUTER, ROUNDS, FINE_EPSILON, *near, NEAR_ROUNDS, MIRRORED, relaxed, plan,
    )  # fmt: skip
    return plan


def between_parts(plan: Array32, query: SampledSurface, other: SampledSurface) -> list[NDArray[np.float64]]:
    """Return for each level below the root the (k, l) shares that a plan of samples carries from part to part."""
    return [
        kernels.gathered_by_parts(plan, *here, *there) for here, there in zip(query.parts, other.parts, strict=True)
    ]


def overlaid(plan: Array32, query: SampledSurface, other: SampledSurface) -> NDArray[np.int64]:
    """(t,) the part of the query's finest level that lies on each sample of another surface; −1 where none does.

    Nothing lies where a plan that may leave samples bare brings less than `BARE` of what it brings on average to where
    it brings anything.
    """
    numbers, count = query.parts[-1]
    return np.asarray(kernels.overlaid(plan, numbers, count, other.masses, BARE))


@lru_cache(maxsize=1)
def _standards() -> tuple[Array32, Array32, np.float32]:
    """(22,) mean and (22,) factor of each feature of a sample, and the factor of its sides."""
    words = vocabulary()
    scale = np.empty(len(words.patch_mean))
    for weight, columns in BLOCKS:
        scale[list(columns)] = np.sqrt(KNOWN_WEIGHT * weight / len(columns))
    known = list(KNOWN)
    factor = (scale / words.patch_spread)[known]
    side = np.sqrt(SIDE_WEIGHT / len(SIDES) / 2)
    return words.patch_mean[known].astype(np.float32), factor.astype(np.float32), np.float32(side)


@lru_cache(maxsize=64)
def _places(s: int) -> NDArray[np.intp]:
    """(s, s) where the distance between two samples is kept; that to itself follows the last one."""
    upper = np.triu_indices(s, 1)
    places = np.full((s, s), len(upper[0]), dtype=np.intp)
    places[upper] = np.arange(len(upper[0]))
    return np.minimum(places, places.T)

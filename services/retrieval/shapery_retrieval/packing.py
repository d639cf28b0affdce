"""Graphs laid out side by side, as matching and ranking read them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_retrieval import _matching_kernels as kernels
from shapery_retrieval.arg import Arg
from shapery_retrieval.nodes import columns_of
from shapery_retrieval.vocabulary import vocabulary

BLOCKS: tuple[tuple[float, tuple[str, ...]], ...] = (
    (1.0, ("heat.mean", "heat.dev")),
    (1.0, ("wave.mean", "wave.dev")),
    (1.0, ("thickness.mean", "thickness.dev")),
    (1.5, ("mean_curvature.mean", "mean_curvature.dev")),
    (1.5, ("gaussian_curvature.mean", "gaussian_curvature.dev")),
    (1.0, ("geodesic.whole", "geodesic.mean")),
)
"""Features that count alike whatever their number: weights and columns of `shapery_retrieval.nodes`."""
Blocks = tuple[tuple[float, tuple[str, ...]], ...]

ALPHA = np.float32(0.5)
"""Share of the distances between parts in the cost; the rest is the parts' features."""
EPSILON = np.float32(0.07)
OUTER, ROUNDS = 1, 6
AT_ONCE = 64
"""So many graphs are compared at once, which the processor's caches hold."""

Array32 = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class PackedLevel:
    """One level of n graphs, padded with parts of no mass.

    Attributes
    ----------
    masses : (n, k)
    features : (n, d, k)
        Standardised and weighted, so that squared distance is the cost of putting two parts together.
    squares : (n, k)
        Their squared lengths.
    distances : (n, k, k)
    own : (n,)
        Cost of each graph with itself.
    parts : (n,) int64
        How many parts of each are real.
    """

    masses: Array32
    features: Array32
    squares: Array32
    distances: Array32
    own: Array32
    parts: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.masses)

    def taken(self, places: NDArray[np.int64]) -> PackedLevel:
        """Return some of the graphs, in the order of `places`."""
        return PackedLevel(
            self.masses[places], self.features[places], self.squares[places], self.distances[places],
            self.own[places], self.parts[places],
        )  # fmt: skip

    def node_costs(self, other: PackedLevel, index: int, chosen: NDArray[np.int64]) -> Array32:
        """(c, k, l) squared distances between the features of the parts of one graph and those of the chosen ones."""
        own = np.ascontiguousarray(self.features[index].T)
        return _squared(own @ other.features[chosen], self.squares[index][None], other.squares[chosen])

    def costs(self, other: PackedLevel, index: int, chosen: NDArray[np.int64], *, relaxed: bool = False) -> Array32:
        """(c,) cost of the graph at `index` against the chosen ones of `other`."""
        found = [
            kernels.transport_many(
                self.node_costs(other, index, some), self.masses[index], self.distances[index],
                other.masses, other.distances, some, ALPHA, EPSILON, OUTER, ROUNDS, relaxed,
            )
            for some in np.split(chosen, range(AT_ONCE, len(chosen), AT_ONCE))
        ]  # fmt: skip
        return np.concatenate(found)

    def with_own(self) -> PackedLevel:
        """Return the same graphs with what each costs with itself."""
        own = np.empty(len(self), np.float32)
        for begin in range(0, len(self), AT_ONCE):
            some = slice(begin, begin + AT_ONCE)
            features, squares = self.features[some], self.squares[some]
            nodes = _squared(features.transpose(0, 2, 1) @ features, squares, squares)
            own[some] = kernels.transport_to_self(
                nodes, self.masses[some], self.distances[some], ALPHA, EPSILON, OUTER, ROUNDS
            )
        return replace(self, own=own)

    def divergences(self, other: PackedLevel, index: int, chosen: NDArray[np.int64]) -> Array32:
        """(c,) costs less the mean of what both cost with themselves: never negative, zero for the graph itself."""
        costs = self.costs(other, index, chosen)
        return np.asarray(np.maximum(costs - (self.own[index] + other.own[chosen]) / 2, np.float32(0)))


def pack_level(args: Sequence[Arg], level: int, blocks: Blocks = BLOCKS) -> PackedLevel:
    """Lay out one level of several graphs."""
    words = vocabulary()
    columns = [columns_of(names) for _, names in blocks]
    total = sum(weight for weight, _ in blocks)
    scale = np.concatenate(
        [
            np.full(len(c), np.sqrt(weight / total / len(c) / 2)) / words.node_spread[c]
            for (weight, _), c in zip(blocks, columns, strict=True)
        ]
    )
    order = np.concatenate(columns)
    n, k = len(args), max((arg.levels[level].parts for arg in args), default=1)
    masses, features = np.zeros((n, k), np.float32), np.zeros((n, k, len(order)), np.float32)
    distances = np.zeros((n, k, k), np.float32)
    for i, arg in enumerate(args):
        node = arg.levels[level]
        p = node.parts
        masses[i, :p] = node.masses / node.masses.sum()
        features[i, :p] = (node.features[:, order].astype(np.float64) - words.node_mean[order]) * scale
        distances[i, :p, :p] = node.distances
    squares = np.einsum("nkd,nkd->nk", features, features)
    features = np.ascontiguousarray(features.transpose(0, 2, 1))
    parts = np.array([arg.levels[level].parts for arg in args])
    return PackedLevel(masses, features, squares, distances, np.zeros(n, np.float32), parts).with_own()


def _squared(products: Array32, left: Array32, right: Array32) -> Array32:
    """(c, k, l) squared distances from inner products and squared lengths; the products are overwritten."""
    products *= np.float32(-2.0)
    products += left[:, :, None]
    products += right[:, None, :]
    return np.asarray(np.maximum(products, np.float32(0.0), out=products))


def pack_levels(args: Sequence[Arg]) -> tuple[PackedLevel, ...]:
    """Lay out the levels below the root of several graphs.

    Raises
    ------
    InvalidInput
        ``conflict`` where they are of different index versions or levels.
    """
    if not args:
        raise ValueError("there is nothing to lay out")
    if len({(arg.index_version, len(arg.levels)) for arg in args}) > 1:
        raise InvalidInput("conflict", "Graphs of different index versions cannot be compared.", "Index them again.")
    return tuple(pack_level(args, level) for level in range(1, len(args[0].levels)))


def joined(graphs: Sequence[tuple[PackedLevel, ...]]) -> tuple[PackedLevel, ...]:
    """Lay graphs side by side that were laid out one by one."""
    result = []
    for levels in zip(*graphs, strict=True):
        n, k, d = len(levels), max(level.masses.shape[1] for level in levels), levels[0].features.shape[1]
        masses, squares = np.zeros((n, k), np.float32), np.zeros((n, k), np.float32)
        features, distances = np.zeros((n, d, k), np.float32), np.zeros((n, k, k), np.float32)
        for i, level in enumerate(levels):
            p = level.masses.shape[1]
            masses[i, :p], squares[i, :p] = level.masses[0], level.squares[0]
            features[i, :, :p], distances[i, :p, :p] = level.features[0], level.distances[0]
        own = np.concatenate([level.own for level in levels])
        result.append(
            PackedLevel(masses, features, squares, distances, own, np.concatenate([level.parts for level in levels]))
        )
    return tuple(result)


def level_distances(
    query: Sequence[PackedLevel], index: int, bank: Sequence[PackedLevel], chosen: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(c, m) divergences from the chosen graphs on each of the m levels below the root."""
    return np.stack(
        [own.divergences(others, index, chosen) for own, others in zip(query, bank, strict=True)], axis=1
    ).astype(np.float64)


def part_distances(
    query: Sequence[PackedLevel], index: int, bank: Sequence[PackedLevel], chosen: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(c,) divergences from the chosen graphs, summed over the levels below the root."""
    return np.asarray(level_distances(query, index, bank, chosen).sum(axis=1))


def whole_arrays(args: Sequence[Arg]) -> dict[str, Array32]:
    """Return (n, d) arrays of the descriptors at the roots by name, as they are compared by Euclidean distance.

    Shares are under a root; those of the views are weighted by rarity besides, and of unit length.
    """
    words = vocabulary()
    views = np.zeros((len(args), len(words.views)), np.float32)
    for row, arg in zip(views, args, strict=True):
        row[arg.whole["view_words"]] = arg.whole["view_weights"].astype(np.float32)
    views = np.sqrt(views) * np.maximum(words.view_rarity, 0.0)
    views /= np.maximum(np.linalg.norm(views, axis=1, keepdims=True), 1e-12)
    whole = {name: np.stack([arg.whole[name] for arg in args]) for name in ("covariance", "quantiles")}
    whole["wave_words"] = np.sqrt(np.stack([arg.whole["wave_words"] for arg in args]))
    whole["views"] = views
    return whole

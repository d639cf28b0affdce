"""Matching of two graphs: a score, and which parts correspond (section 4.6).

On every level a fused Gromov–Wasserstein transport carries the area of one shape's parts to the other's, so that parts
alike in features meet and distances between parts are kept. Its cost, less what both shapes cost with themselves, is
the distance. Which parts correspond is found by their samples; see `shapery_retrieval.correspondence`.

References
----------
T. Vayer, L. Chapel, R. Flamary, R. Tavenard, N. Courty, Fused Gromov–Wasserstein distance for structured objects,
Algorithms 13(9), 2020, doi:10.3390/a13090212.
J. Feydy et al., Interpolating between optimal transport and MMD using Sinkhorn divergences, AISTATS 2019 (for taking
off the cost with oneself).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_retrieval.arg import Arg
from shapery_retrieval.correspondence import SampledSurface, between_parts, lay, overlaid, surface_of
from shapery_retrieval.packing import level_distances
from shapery_retrieval.vector import PackedGraphs, cue_distances, pack
from shapery_retrieval.vocabulary import vocabulary

UNLIKE = 0.35
"""Divergence at which a level's score has fallen to 1/e; about the mean between unrelated generated shapes."""


@dataclass(frozen=True, eq=False)
class LevelMatch:
    """How two shapes match on one level.

    Attributes
    ----------
    level
        Its number; 0 is the root.
    score
        In [0, 1]; 1 for a shape with itself.
    transport : (k, l) float64
        How much of the query's area is laid from each of its parts on each part of the other; in sum 1. On all levels
        it is the same laying of the samples, so that parents and children agree.
    """

    level: int
    score: float
    transport: NDArray[np.float64]

    def pairs(self) -> list[tuple[int, int, float]]:
        """Return for each part of the query the part that most of it is carried to, and how much."""
        best = np.argmax(self.transport, axis=1)
        carried = self.transport[np.arange(len(best)), best]
        return list(zip(range(len(best)), best.tolist(), carried.tolist(), strict=True))


@dataclass(frozen=True, eq=False)
class Match:
    """How two shapes match.

    Attributes
    ----------
    score
        In [0, 1]. Global: the sum over the levels, over their number; symmetric, and 1 for a shape with itself.
        Partial: the best level's.
    levels
        From the root, or for a partial match from the level below it, to the finest.
    best_level
        The level of the highest score below the root.
    overlaid : (t,) int64
        For each sample of the other shape the part of the query's finest level that lies on it, or −1. The other's own
        parts end elsewhere, for borders move with the pose; so laid, the query's parts keep their borders.
    """

    score: float
    levels: tuple[LevelMatch, ...]
    best_level: int
    overlaid: NDArray[np.int64]


def match(query: Arg, other: Arg, *, partial: bool = False) -> Match:
    """Match two graphs.

    Parameters
    ----------
    query, other
        Of one index version.
    partial
        Whether the query may be a part of the other shape: then parts of the other need no partner, the whole-shape
        descriptors say nothing, and the score is not symmetric.

    Raises
    ------
    InvalidInput
        ``conflict`` for graphs of different index versions.
    """
    both = pack((query, other))
    return match_packed(both, 0, both, np.array([1]), surface_of(query), [surface_of(other)], partial=partial)[0]


def match_packed(
    query: PackedGraphs,
    index: int,
    bank: PackedGraphs,
    places: NDArray[np.int64],
    own_surface: SampledSurface,
    surfaces: Sequence[SampledSurface],
    *,
    partial: bool = False,
    apart: NDArray[np.float64] | None = None,
) -> list[Match]:
    """Match a graph with others that are laid out already, as are their samples; see `match`.

    With `apart` the (c, m) divergences on each level are known, but for rows of NaN.
    """
    if partial:
        costs = []
        for own, others in zip(query.levels, bank.levels, strict=True):
            itself = own.costs(own, index, np.array([index]), relaxed=True)[0]
            costs.append(np.maximum(own.costs(others, index, places, relaxed=True) - itself, 0.0))
        apart = np.stack(costs, axis=1).astype(np.float64)
    elif apart is None:
        apart = level_distances(query.levels, index, bank.levels, places)
    elif (unknown := np.flatnonzero(np.isnan(apart[:, 0]))).size:
        apart = apart.copy()
        apart[unknown] = level_distances(query.levels, index, bank.levels, places[unknown])
    below = np.exp(-apart / UNLIKE)
    roots = None if partial else _root_scores(query, index, bank, places)
    matches = []
    for row, surface in enumerate(surfaces):
        plan = lay(own_surface, surface, relaxed=partial)
        best = int(np.argmax(below[row])) + 1
        levels = [] if roots is None else [LevelMatch(0, float(roots[row]), np.ones((1, 1)))]
        for number, carried in enumerate(between_parts(plan, own_surface, surface), start=1):
            levels.append(LevelMatch(number, float(below[row, number - 1]), carried))
        score = float(below[row, best - 1]) if partial else sum(level.score for level in levels) / len(levels)
        matches.append(Match(score, tuple(levels), best, overlaid(plan, own_surface, surface)))
    return matches


def _root_scores(query: PackedGraphs, index: int, bank: PackedGraphs, places: NDArray[np.int64]) -> NDArray[np.float64]:
    own, others = query.vectors[index], bank.vectors[places]
    unlike = vocabulary().unlike
    scores = [np.exp(-cue_distances(own, others, cue) / unlike[cue]) for cue in unlike]
    return np.asarray(np.mean(scores, axis=0))

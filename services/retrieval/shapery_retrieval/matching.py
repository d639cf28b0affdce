"""Matching of two graphs: a score, and which parts correspond (section 4.6).

On every level a fused Gromov–Wasserstein transport carries the area of one shape's parts to the other's, so that parts
alike in features meet and distances between parts are kept. The plan is the correspondence; its cost, less what both
shapes cost with themselves, is the distance.

References
----------
T. Vayer, L. Chapel, R. Flamary, R. Tavenard, N. Courty, Fused Gromov–Wasserstein distance for structured objects,
Algorithms 13(9), 2020, doi:10.3390/a13090212.
J. Feydy et al., Interpolating between optimal transport and MMD using Sinkhorn divergences, AISTATS 2019 (for taking
off the cost with oneself).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_retrieval import _matching_kernels as kernels
from shapery_retrieval.arg import Arg
from shapery_retrieval.packing import ALPHA, EPSILON, OUTER, ROUNDS, PackedGraphs, PackedLevel, pack

UNLIKE = 0.35
"""Divergence at which a level's score has fallen to 1/e; about the mean between unrelated generated shapes."""
WHOLE_UNLIKE = {"covariance": 6.0, "scale_invariant": 3.0, "quantiles": 0.35, "wave_words": 0.5, "views": 1.0}
"""The same for each descriptor at the root."""


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
        How much of the query's area the matching carries from each of its parts to each part of the other; in sum 1.
    """

    level: int
    score: float
    transport: NDArray[np.float64]

    def pairs(self) -> list[tuple[int, int, float]]:
        """Return for each part of the query the part that most of it is carried to, and how much."""
        best = np.argmax(self.transport, axis=1)
        return [(i, int(j), float(self.transport[i, j])) for i, j in enumerate(best)]


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
    """

    score: float
    levels: tuple[LevelMatch, ...]
    best_level: int


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
    levels = [] if partial else [LevelMatch(0, _root_score(both), np.ones((1, 1)))]
    for number, level in enumerate(both.levels, start=1):
        k, l = query.levels[number].parts, other.levels[number].parts  # noqa: E741
        levels.append(_match_level(level, number, k, l, partial))
    below = [level for level in levels if level.level > 0]
    best = max(below, key=lambda level: level.score)
    score = best.score if partial else sum(level.score for level in levels) / len(levels)
    return Match(score, tuple(levels), best.level)


def transport_plan(
    query: PackedLevel, index: int, other: PackedLevel, place: int, *, relaxed: bool = False
) -> tuple[float, NDArray[np.float64]]:
    """Return the cost of putting one graph's level on another's, and the plan."""
    plan = np.zeros((query.masses.shape[1], other.masses.shape[1]), dtype=np.float32)
    cost = kernels.transport(
        query.masses[index], query.features[index], query.squares[index], query.distances[index],
        other.masses[place], other.features[place], other.squares[place], other.distances[place],
        ALPHA, EPSILON, OUTER, ROUNDS, relaxed, plan,
    )  # fmt: skip
    return float(cost), plan.astype(np.float64)


def _match_level(level: PackedLevel, number: int, k: int, l: int, partial: bool) -> LevelMatch:  # noqa: E741
    cost, plan = transport_plan(level, 0, level, 1, relaxed=partial)
    own = transport_plan(level, 0, level, 0, relaxed=True)[0] if partial else float(level.own.sum()) / 2
    return LevelMatch(number, float(np.exp(-max(cost - own, 0.0) / UNLIKE)), plan[:k, :l])


def _root_score(both: PackedGraphs) -> float:
    distances = [
        float(np.linalg.norm(values[0] - values[1]))
        if name != "quantiles"
        else float(np.abs(values[0] - values[1]).mean())
        for name, values in sorted(both.whole.items())
    ]
    scores = [np.exp(-d / WHOLE_UNLIKE[name]) for d, name in zip(distances, sorted(both.whole), strict=True)]
    return float(np.mean(scores))

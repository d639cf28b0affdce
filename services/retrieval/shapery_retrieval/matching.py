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

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from shapery_retrieval import _matching_kernels as kernels
from shapery_retrieval.arg import Arg
from shapery_retrieval.packing import ALPHA, EPSILON, OUTER, ROUNDS, PackedLevel
from shapery_retrieval.vector import PackedGraphs, cue_distances, pack
from shapery_retrieval.vocabulary import vocabulary

UNLIKE = 0.35
"""Divergence at which a level's score has fallen to 1/e; about the mean between unrelated generated shapes."""

SHARP_EPSILON, SHARP_OUTER, SHARP_ROUNDS = np.float32(0.01), 8, 30


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
    return match_packed(both, 0, both, 1, partial=partial)


def match_packed(
    query: PackedGraphs,
    index: int,
    bank: PackedGraphs,
    place: int,
    *,
    partial: bool = False,
    plans: Literal["all", "best"] = "all",
) -> Match:
    """Match two graphs that are laid out already; see `match`.

    With `plans` ``best`` the plan of the best level alone is sharp, which is what costs most.
    """
    levels = []
    if not partial:
        levels.append(LevelMatch(0, _root_score(query, index, bank, place), np.ones((1, 1))))
    for number, (own, others) in enumerate(zip(query.levels, bank.levels, strict=True), start=1):
        cost, plan = transport_plan(own, index, others, place, relaxed=partial)
        if partial:
            itself = transport_plan(own, index, own, index, relaxed=True)[0]
        else:
            itself = float(own.own[index] + others.own[place]) / 2
        score = float(np.exp(-max(cost - itself, 0.0) / UNLIKE))
        levels.append(LevelMatch(number, score, plan[: own.parts[index], : others.parts[place]]))
    best = max((level for level in levels if level.level > 0), key=lambda level: level.score)
    score = best.score if partial else sum(level.score for level in levels) / len(levels)
    sharp = [
        replace(level, transport=_sharp(query, index, bank, place, level.level, relaxed=partial))
        if level.level > 0 and (plans == "all" or level is best)
        else level
        for level in levels
    ]
    return Match(score, tuple(sharp), best.level)


def _sharp(
    query: PackedGraphs, index: int, bank: PackedGraphs, place: int, level: int, *, relaxed: bool
) -> NDArray[np.float64]:
    own, others = query.levels[level - 1], bank.levels[level - 1]
    plan = transport_plan(own, index, others, place, relaxed=relaxed, sharp=True)[1]
    return plan[: own.parts[index], : others.parts[place]]


def transport_plan(
    query: PackedLevel, index: int, other: PackedLevel, place: int, *, relaxed: bool = False, sharp: bool = False
) -> tuple[float, NDArray[np.float64]]:
    """Return the cost of putting one graph's level on another's, and the plan.

    Scores take few soft steps, which is what ranks best and fastest. Correspondences are `sharp`: more steps with less
    entropy, so that a part is carried to one other.
    """
    plan = np.zeros((query.masses.shape[1], other.masses.shape[1]), dtype=np.float32)
    cost = kernels.transport(
        query.masses[index], query.features[index], query.squares[index], query.distances[index],
        other.masses[place], other.features[place], other.squares[place], other.distances[place],
        ALPHA, SHARP_EPSILON if sharp else EPSILON, SHARP_OUTER if sharp else OUTER,
        SHARP_ROUNDS if sharp else ROUNDS, relaxed, plan,
    )  # fmt: skip
    return float(cost), plan.astype(np.float64)


def _root_score(query: PackedGraphs, index: int, bank: PackedGraphs, place: int) -> float:
    own, other = query.vectors[index], bank.vectors[place : place + 1]
    unlike = vocabulary().unlike
    return float(np.mean([np.exp(-cue_distances(own, other, cue)[0] / unlike[cue]) for cue in unlike]))

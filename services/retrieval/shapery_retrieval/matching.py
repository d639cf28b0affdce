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
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from shapery_retrieval import _matching_kernels as kernels
from shapery_retrieval.arg import Arg
from shapery_retrieval.packing import EPSILON, PackedLevel
from shapery_retrieval.vector import PackedGraphs, cue_distances, pack
from shapery_retrieval.vocabulary import vocabulary

UNLIKE = 0.35
"""Divergence at which a level's score has fallen to 1/e; about the mean between unrelated generated shapes."""

SHARP_ALPHA, SHARP_WARM, SHARP_EPSILON = np.float32(0.8), EPSILON, np.float32(0.01)
SHARP_OUTER, SHARP_ROUNDS = 8, 30
"""For correspondences distances between parts count more than features: in another pose they are kept."""


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
        Empty on levels whose plan was not asked for.
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
    return match_packed(both, 0, both, np.array([1]), partial=partial)[0]


def match_packed(
    query: PackedGraphs,
    index: int,
    bank: PackedGraphs,
    places: NDArray[np.int64],
    *,
    partial: bool = False,
    plans: Literal["all", "best"] = "all",
) -> list[Match]:
    """Match a graph with others that are laid out already; see `match`.

    With `plans` ``best`` the plan of the best level alone is worked out, which is what costs most; the others' are
    empty.
    """
    scores = []
    for own, others in zip(query.levels, bank.levels, strict=True):
        if partial:
            itself = own.costs(own, index, np.array([index]), relaxed=True)[0]
            apart = np.maximum(own.costs(others, index, places, relaxed=True) - itself, 0.0)
        else:
            apart = own.divergences(others, index, places)
        scores.append(np.exp(-apart.astype(np.float64) / UNLIKE))
    below = np.stack(scores, axis=1)
    roots = None if partial else _root_scores(query, index, bank, places)
    matches = []
    for row, place in enumerate(places.tolist()):
        best = int(np.argmax(below[row])) + 1
        levels = [] if roots is None else [LevelMatch(0, float(roots[row]), np.ones((1, 1)))]
        for number, (own, others) in enumerate(zip(query.levels, bank.levels, strict=True), start=1):
            if plans == "all" or number == best:
                plan = sharp_plan(own, index, others, place, relaxed=partial)
            else:
                plan = np.zeros((0, 0))
            levels.append(LevelMatch(number, float(below[row, number - 1]), plan))
        score = float(below[row, best - 1]) if partial else sum(level.score for level in levels) / len(levels)
        matches.append(Match(score, tuple(levels), best))
    return matches


def sharp_plan(
    query: PackedLevel, index: int, other: PackedLevel, place: int, *, relaxed: bool = False
) -> NDArray[np.float64]:
    """(k, l) plan that puts one graph's level on another's.

    Scores take few soft steps, which is what ranks best and fastest. Correspondences take more steps with less entropy,
    so that a part is carried to one other.
    """
    plan = np.zeros((query.masses.shape[1], other.masses.shape[1]), dtype=np.float32)
    kernels.transport(
        query.node_costs(other, index, np.array([place]))[0], query.masses[index], query.distances[index],
        other.masses[place], other.distances[place],
        SHARP_ALPHA, SHARP_WARM, SHARP_EPSILON, SHARP_OUTER, SHARP_ROUNDS, relaxed, plan,
    )  # fmt: skip
    return plan[: query.parts[index], : other.parts[place]].astype(np.float64)


def _root_scores(query: PackedGraphs, index: int, bank: PackedGraphs, places: NDArray[np.int64]) -> NDArray[np.float64]:
    own, others = query.vectors[index], bank.vectors[places]
    unlike = vocabulary().unlike
    scores = [np.exp(-cue_distances(own, others, cue) / unlike[cue]) for cue in unlike]
    return np.asarray(np.mean(scores, axis=0))

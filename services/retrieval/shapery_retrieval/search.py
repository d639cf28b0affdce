"""Query by example: the shapes of a bank that resemble a shape, or of which a region is a part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_retrieval.arg import Arg
from shapery_retrieval.matching import UNLIKE, Match, match_packed
from shapery_retrieval.packing import PackedGraphs, pack
from shapery_retrieval.ranking import (
    GROUPS,
    WHOLE_CUES,
    affinity,
    contrast,
    diffuse,
    gate,
    local_scale,
    part_distances,
    voted,
    whole_distances,
)

MATCHED = 64
"""So many shapes, the best by the descriptors of the whole, are matched part by part."""

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Hit:
    """One shape that was found: its name, its score in [0, 1], and how its parts correspond to the query's."""

    shape_id: str
    score: float
    match: Match


@dataclass(frozen=True, eq=False)
class Answer:
    """What a search found.

    Attributes
    ----------
    hits
        Best first.
    cues
        How much each group of cues counted; in sum 1.
    compared
        How many shapes were compared by their graphs.
    """

    hits: tuple[Hit, ...]
    cues: Mapping[str, float]
    compared: int


class Searcher:
    """A bank laid out in memory, with what is known of its neighbourhoods; it answers one query after another.

    Parameters
    ----------
    args
        Graphs of one index version, by the names of their shapes.
    """

    def __init__(self, args: Mapping[str, Arg]) -> None:
        self.ids: list[str] = sorted(args)
        self._version = args[self.ids[0]].index_version if args else None
        self._graphs: PackedGraphs | None = pack([args[name] for name in self.ids]) if args else None
        self._scales: dict[str, Array] | None = None
        self._near: NDArray[np.int64] | None = None
        self._part_scales = np.full(len(self.ids), np.nan)

    def __len__(self) -> int:
        return len(self.ids)

    def search(
        self, query: Arg, *, limit: int = 20, exclude: str | None = None, partial: bool = False, rerank: bool = False
    ) -> Answer:
        """Find the shapes that resemble a query.

        Parameters
        ----------
        query
            Of the bank's index version.
        limit
            How many at most.
        exclude
            A shape to leave out, usually the query itself.
        partial
            Whether the query may be a part of what is looked for.
        rerank
            Whether the order of the best follows how they resemble each other, too.
        """
        if self._graphs is None:
            return Answer((), {group: 1 / len(GROUPS) for group in GROUPS}, 0)
        if query.index_version != self._version:
            raise InvalidInput("conflict", "The query and the bank are of different index versions.", "Index it again.")
        allowed = np.array([name != exclude for name in self.ids])
        packed = pack([query])
        if partial:
            scores, weights, compared = self._partial_scores(packed, allowed), {"parts": 1.0}, int(allowed.sum())
        else:
            scores, weights, compared = self._scores(packed, 0, allowed)
        order = np.flatnonzero(allowed)[np.argsort(-scores[allowed], kind="stable")]
        if rerank and not partial:
            order, scores = self._reranked(scores, order)
        hits = [
            Hit(self.ids[i], float(scores[i]), match_packed(packed, 0, self._graphs, i, partial=partial))
            for i in order[:limit].tolist()
        ]
        return Answer(tuple(hits), weights, compared)

    def _scores(
        self, query: PackedGraphs, index: int, allowed: NDArray[np.bool_]
    ) -> tuple[Array, dict[str, float], int]:
        assert self._graphs is not None
        scales, _ = self._neighbourhoods()
        found: dict[str, Array] = {}
        for cue, distances in whole_distances(query, index, self._graphs).items():
            found[cue] = affinity(distances, local_scale(distances[allowed]), scales[cue])
        groups = {group: voted(group, found) for group in GROUPS if group != "parts"}
        first = np.where(allowed, sum(groups.values()), -1.0)
        chosen = np.argsort(-first, kind="stable")[: min(MATCHED, int(allowed.sum()))]
        distances = part_distances(query, index, self._graphs, chosen)
        parts = np.zeros(len(self.ids))
        parts[chosen] = affinity(distances, local_scale(distances), self._part_scales_of(chosen))
        groups = {"parts": parts, **groups}
        weights = gate({g: contrast(values[allowed]) for g, values in groups.items()})
        scores = sum(float(weights[g]) * groups[g] for g in groups)
        return np.asarray(scores), {g: float(w) for g, w in weights.items()}, len(chosen)

    def _neighbourhoods(self) -> tuple[dict[str, Array], NDArray[np.int64]]:
        """Local scales by each descriptor of the whole, and for each shape the ones nearest by all of these."""
        if self._scales is None or self._near is None:
            assert self._graphs is not None
            n = len(self.ids)
            rows = {cue: np.empty((n, n), dtype=np.float32) for cue in WHOLE_CUES}
            for i in range(n):
                for cue, distances in whole_distances(self._graphs, i, self._graphs).items():
                    rows[cue][i] = distances
                    rows[cue][i, i] = np.inf
            self._scales = {
                cue: np.array([local_scale(row.astype(np.float64)) for row in found]) for cue, found in rows.items()
            }
            fused = np.zeros((n, n), dtype=np.float32)
            for group, cues in GROUPS.items():
                for cue, weight in cues.items() if group != "parts" else ():
                    scale = self._scales[cue].astype(np.float32)
                    fused += np.float32(weight) * np.exp(-(rows[cue] ** 2) / np.outer(scale, scale))
            np.fill_diagonal(fused, -1.0)
            self._near = np.argsort(-fused, axis=1, kind="stable")[:, : min(MATCHED, n - 1)]
        return self._scales, self._near

    def _part_scales_of(self, chosen: NDArray[np.int64]) -> Array:
        """Local scales by the parts of some shapes; computed when first asked for."""
        assert self._graphs is not None
        _, near = self._neighbourhoods()
        for i in chosen[np.isnan(self._part_scales[chosen])].tolist():
            self._part_scales[i] = local_scale(part_distances(self._graphs, i, self._graphs, near[i]))
        return np.asarray(self._part_scales[chosen])

    def _partial_scores(self, query: PackedGraphs, allowed: NDArray[np.bool_]) -> Array:
        """Return e to the relaxed cost on the best level; all shapes are matched, because no vector tells of parts."""
        assert self._graphs is not None
        chosen = np.flatnonzero(allowed)
        best = np.full(len(chosen), np.inf)
        for own, others in zip(query.levels, self._graphs.levels, strict=True):
            itself = float(own.costs(own, 0, np.array([0]), relaxed=True)[0])
            best = np.minimum(best, np.maximum(own.costs(others, 0, chosen, relaxed=True) - itself, 0.0))
        scores = np.full(len(self.ids), -1.0)
        scores[chosen] = np.exp(-best / UNLIKE)
        return scores

    def _reranked(self, scores: Array, order: NDArray[np.int64]) -> tuple[NDArray[np.int64], Array]:
        """Let similarity flow between the best, as far as they were matched."""
        assert self._graphs is not None
        pool = order[:MATCHED]
        m = len(pool)
        square = np.eye(m + 1)
        square[0, 1:] = square[1:, 0] = scores[pool]
        everyone = np.ones(len(self.ids), dtype=bool)
        for row, i in enumerate(pool.tolist(), start=1):
            allowed = everyone.copy()
            allowed[i] = False
            square[row, 1:] = self._scores(self._graphs, i, allowed)[0][pool]
            square[row, row] = 1.0
        flowed = diffuse(square)[0, 1:]
        result = scores * 1e-3
        result[pool] = flowed
        return np.concatenate((pool[np.argsort(-flowed, kind="stable")], order[MATCHED:])), result


def score_matrix(args: Sequence[Arg], *, rerank: bool = False) -> Array:
    """(n, n) scores of every shape against every other, higher is more alike; 1 on the diagonal.

    Each row is a pure query: local scales and contrasts are those of the bank without the row's shape. With `rerank`
    similarity then flows over the whole bank.
    """
    graphs = pack(args)
    n = len(args)
    everyone = np.arange(n)
    distances = {cue: np.zeros((n, n)) for cue in (*WHOLE_CUES, "parts")}
    for i in range(n):
        for cue, row in whole_distances(graphs, i, graphs).items():
            distances[cue][i] = row
        later = everyone[i + 1 :]
        distances["parts"][i, later] = part_distances(graphs, i, graphs, later)
        distances["parts"][later, i] = distances["parts"][i, later]
    scores = np.eye(n)
    for i in range(n):
        others = np.flatnonzero(everyone != i)
        if len(others):
            scores[i, others] = fused_scores(
                {cue: d[i, others] for cue, d in distances.items()},
                {cue: d[np.ix_(others, others)] for cue, d in distances.items()},
            )
    return diffuse(scores) if rerank else scores


def fused_scores(query: Mapping[str, Array], bank: Mapping[str, Array]) -> Array:
    """(m,) scores of a query from its (m,) distances by each cue and the bank's own (m, m) ones."""
    found = {}
    for cue, distances in query.items():
        square = bank[cue].copy()
        np.fill_diagonal(square, np.inf)
        scales = np.array([local_scale(row) for row in square])
        found[cue] = affinity(distances, local_scale(distances), scales)
    groups = {group: voted(group, found) for group in GROUPS}
    weights = gate({group: contrast(values) for group, values in groups.items()})
    return np.asarray(sum(float(weights[group]) * groups[group] for group in groups))


def parts_in(arg: Arg, shares: Sequence[Array]) -> list[NDArray[np.int64]]:
    """Return for each level the numbers of the parts of which at least half lies in a region, or of the fullest one.

    Parameters
    ----------
    arg
        Of the whole shape.
    shares
        For each level the (k,) share of each part's area that lies in the region.
    """
    numbers = [np.arange(arg.levels[0].parts)]
    for level, share in zip(arg.levels[1:], shares[1:], strict=True):
        inside = np.flatnonzero(share >= 0.5)
        numbers.append(inside if len(inside) else np.array([np.argmax(share * level.masses)]))
    return numbers


def region_of(arg: Arg, shares: Sequence[Array]) -> Arg:
    """Return the graph of a region, whose parts on each level are those of `parts_in`, in their order.

    Parameters
    ----------
    arg, shares
        As for `parts_in`.
    """
    levels = list(arg.levels[:1])
    for level, share, keep in zip(arg.levels[1:], shares[1:], parts_in(arg, shares)[1:], strict=True):
        masses = level.masses[keep] * np.maximum(share[keep], 0.5)
        levels.append(
            replace(
                level,
                masses=(masses / masses.sum()).astype(np.float32),
                features=level.features[keep],
                distances=level.distances[np.ix_(keep, keep)],
                adjacency=level.adjacency[np.ix_(keep, keep)],
                parents=level.parents[keep],
            )
        )
    return replace(arg, levels=tuple(levels))

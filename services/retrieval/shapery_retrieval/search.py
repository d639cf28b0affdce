"""Query by example: the shapes of a bank that resemble a shape, or of which a region is a part."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_contracts.retrieval import INDEX_VERSION, VECTOR_DIMENSION
from shapery_geometry.threads import one_blas_thread
from shapery_retrieval.arg import Arg
from shapery_retrieval.correspondence import SampledSurface, region_samples, surface_of
from shapery_retrieval.matching import Match, match_packed
from shapery_retrieval.packing import PackedLevel, level_distances, pack_levels, part_distances, whole_arrays
from shapery_retrieval.patches import Patches, nearest_patches, patches_of
from shapery_retrieval.ranking import GROUPS, affinity, diffuse, gate, local_scale, local_scales, voted
from shapery_retrieval.vector import SEGMENTS, PackedGraphs, Vectors, cue_distances, neighbour_scales, pack, vectors_of

BLOCK, MOST_MATCHED = 48, 288
"""Shapes are matched part by part in blocks of so many, the most promising first, until a block brings nothing among
the best any more; and not more than so many."""
RERANKED = 64
"""So many of the best take part in re-ranking."""
SURFACES_KEPT = 1024
"""Of so many shapes a searcher keeps the samples, about 45 kB each, for the next query."""

Array = NDArray[np.float64]
Lay = Callable[[NDArray[np.int64]], tuple[PackedLevel, ...]]
"""Lays out the levels of the shapes at some places of a bank."""
LayPatches = Callable[[NDArray[np.int64]], list[Patches]]
"""Gives the patches of the shapes at some places of a bank."""
LaySurfaces = Callable[[NDArray[np.int64]], list[SampledSurface]]
"""Gives the samples of the shapes at some places of a bank."""


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
    """A bank, or the part of one that lies near a query, with what is known of its neighbourhoods.

    Parameters
    ----------
    ids
        Names of the shapes, in ascending order.
    vectors : (n, 256) float32
        Their vectors, or others where it searches with parts alone, which are not compared by them.
    lay, lay_patches, lay_surfaces
        Give the graphs of shapes, their patches, or their samples, when they are matched.
    version
        Index version of all of them.
    scales
        Where the local scales by each cue are kept, or are already; they depend on the vectors alone.
    """

    def __init__(
        self,
        ids: Sequence[str],
        vectors: Vectors,
        lay: Lay,
        lay_patches: LayPatches,
        lay_surfaces: LaySurfaces,
        version: int = INDEX_VERSION,
        scales: dict[str, Array] | None = None,
    ) -> None:
        self.ids = list(ids)
        self._vectors = vectors
        self._lay = lay
        self._lay_patches = lay_patches
        self._lay_surfaces = lay_surfaces
        self._version = version
        self._scales = {} if scales is None else scales

    @classmethod
    def of(cls, args: Mapping[str, Arg]) -> Searcher:
        """Return a searcher over graphs of one index version by the names of their shapes."""
        ids = sorted(args)
        if not ids:
            return cls([], np.empty((0, VECTOR_DIMENSION), np.float32), lambda _: (), lambda _: [], lambda _: [])
        graphs = pack([args[name] for name in ids])
        surface_at = lru_cache(SURFACES_KEPT)(lambda place: surface_of(args[ids[place]]))
        return cls(
            ids,
            graphs.vectors,
            lambda places: tuple(level.taken(places) for level in graphs.levels),
            lambda places: [patches_of(args[ids[place]]) for place in places.tolist()],
            lambda places: [surface_at(place) for place in places.tolist()],
            args[ids[0]].index_version,
        )

    def __len__(self) -> int:
        return len(self.ids)

    @one_blas_thread()
    def search(
        self,
        query: Arg,
        *,
        limit: int = 20,
        exclude: str | None = None,
        partial: bool = False,
        rerank: bool = False,
        exhaustive: bool = False,
        hypotheses: Sequence[Patches] = (),
        vector: Array | None = None,
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
        exhaustive
            Whether all shapes are matched part by part, and not the promising ones alone.
        hypotheses
            For a partial query its patches, for each size that it may have in a whole; by default those of its graph.
        vector
            The query's, where it is known.
        """
        if not self.ids:
            return Answer((), {group: 1 / len(GROUPS) for group in GROUPS}, 0)
        if query.index_version != self._version:
            raise InvalidInput("conflict", "The query and the bank are of different index versions.", "Index it again.")
        allowed = np.array([name != exclude for name in self.ids])
        levels = pack_levels([query])
        if partial:
            known = np.zeros((1, VECTOR_DIMENSION), np.float32)  # a part is not compared by what it is as a whole
        elif vector is None:
            known = vectors_of(levels, whole_arrays([query]))
        else:
            known = vector.astype(np.float32)[None]
        packed = PackedGraphs(levels, known)
        weights: Mapping[str, float] = {"parts": 1.0}
        apart = np.full((len(self.ids), len(levels)), np.nan)
        if partial:
            scores = self._partial_scores(hypotheses or [patches_of(query)], allowed)
            compared = int(allowed.sum())
        else:
            wanted = max(limit, RERANKED) if rerank else limit
            scores, weights, compared = self._scores(packed, allowed, wanted, apart, exhaustive=exhaustive)
        order = np.flatnonzero(allowed)[np.argsort(-scores[allowed], kind="stable")]
        if rerank and not partial:
            order, scores = self._reranked(scores, order)
        best = order[:limit]
        found = PackedGraphs(self._lay(best), self._vectors[best])
        own, surfaces = surface_of(query), self._lay_surfaces(best)
        matches = match_packed(
            packed, 0, found, np.arange(len(best)), own, surfaces, partial=partial, apart=apart[best]
        )
        hits = [Hit(self.ids[i], float(scores[i]), match) for i, match in zip(best.tolist(), matches, strict=True)]
        return Answer(tuple(hits), weights, compared)

    def _scores(
        self, query: PackedGraphs, allowed: NDArray[np.bool_], wanted: int, apart: Array, *, exhaustive: bool = False
    ) -> tuple[Array, dict[str, float], int]:
        """Scores of all, the groups' weights, and how many shapes were matched part by part.

        What is not matched keeps the score that its vector promises. The divergences of those that are, level by level,
        are written into `apart`.
        """
        if not self._scales:
            self._scales |= {cue: neighbour_scales(self._vectors, cue) for cue in SEGMENTS}
        distances = {cue: cue_distances(query.vectors[0], self._vectors, cue) for cue in SEGMENTS}
        found = {cue: affinity(d, local_scale(d[allowed]), self._scales[cue]) for cue, d in distances.items()}
        groups = {group: voted(group, found) for group in GROUPS}
        scale = local_scale(distances["parts"][allowed])
        scores, weights = _fused(groups, allowed)
        promising = np.argsort(-scores, kind="stable")[: int(allowed.sum())]
        size, most = (len(promising), len(promising)) if exhaustive else (BLOCK, MOST_MATCHED)
        done = 0
        divergences = distances["parts"].copy()
        while done < min(most, len(promising)):
            block = promising[done : done + size]
            done += len(block)
            apart[block] = level_distances(query.levels, 0, self._lay(block), np.arange(len(block)))
            divergences[block] = apart[block].sum(axis=1)
            # what vectors promise of the others is put on the level of what was found
            known, others = promising[:done], promising[done:]
            level = np.median(divergences[known] / np.maximum(distances["parts"][known], 1e-3))
            divergences[others] = level * distances["parts"][others]
            groups["parts"] = affinity(divergences, scale, self._scales["parts"])
            scores, weights = _fused(groups, allowed)
            best = promising[np.argpartition(-scores[promising], min(wanted, len(promising)) - 1)[:wanted]]
            if done >= 2 * wanted and not np.isin(best, promising[done - len(block) :]).any():
                break
        return scores, weights, done

    def _partial_scores(self, hypotheses: Sequence[Patches], allowed: NDArray[np.bool_]) -> Array:
        """Return what share of the query finds a patch of its kind in each shape, over all hypotheses of its size.

        All shapes are looked at. A patch votes for shapes that have one nearer to it than most shapes have: its
        distances are taken by its own local scale.
        """
        chosen = np.flatnonzero(allowed)
        others = self._lay_patches(chosen)
        votes = np.zeros(len(chosen))
        for patches in hypotheses:
            apart = nearest_patches(patches, others)
            scales = np.array([local_scale(row) for row in apart])
            votes += patches.masses @ np.exp(-((apart / scales[:, None]) ** 2)) / len(hypotheses)
        scores = np.full(len(self.ids), -1.0)
        scores[chosen] = votes
        return scores

    def _reranked(self, scores: Array, order: NDArray[np.int64]) -> tuple[NDArray[np.int64], Array]:
        """Let similarity flow between the best, as far as they were matched."""
        pool = order[:RERANKED]
        m = len(pool)
        square = np.eye(m + 1)
        square[0, 1:] = square[1:, 0] = scores[pool]
        everyone = np.ones(len(self.ids), dtype=bool)
        graphs = PackedGraphs(self._lay(pool), self._vectors[pool])
        for row, i in enumerate(pool.tolist()):
            allowed = everyone.copy()
            allowed[i] = False
            one = PackedGraphs(
                tuple(level.taken(np.array([row])) for level in graphs.levels), graphs.vectors[row : row + 1]
            )
            square[row + 1, 1:] = self._scores(one, allowed, m, np.empty((len(self.ids), len(graphs.levels))))[0][pool]
            square[row + 1, row + 1] = 1.0
        flowed = diffuse(square)[0, 1:]
        result = scores * 1e-3
        result[pool] = flowed
        return np.concatenate((pool[np.argsort(-flowed, kind="stable")], order[RERANKED:])), result


def _fused(groups: Mapping[str, Array], allowed: NDArray[np.bool_]) -> tuple[Array, dict[str, float]]:
    """Weigh the groups by how clearly each sets shapes apart; shapes that are not allowed get −1."""
    weights = gate({group: values[allowed] for group, values in groups.items()})
    scores = sum(weights[group] * values for group, values in groups.items())
    return np.where(allowed, scores, -1.0), weights


@one_blas_thread()
def score_matrix(args: Sequence[Arg], *, rerank: bool = False) -> Array:
    """(n, n) scores of every shape against every other, higher is more alike; 1 on the diagonal.

    Each row is a pure query: local scales and contrasts are those of the bank without the row's shape. With `rerank`
    similarity then flows over the whole bank.
    """
    graphs = pack(args)
    n = len(args)
    everyone = np.arange(n)
    found: dict[str, Array] = {}
    for cue in SEGMENTS:
        apart = cue_distances(graphs.vectors, graphs.vectors, cue)
        scales = local_scales(apart, without=everyone)
        own = local_scales(apart)[:, None]
        if cue == "parts":
            for i in everyone[:-1].tolist():
                later = everyone[i + 1 :]
                apart[i, later] = apart[later, i] = part_distances(graphs.levels, i, graphs.levels, later)
        found[cue] = affinity(apart, own, scales)
    groups = {group: voted(group, found) for group in GROUPS}
    scores = np.eye(n)
    for i in everyone.tolist():
        scores[i] = _fused({group: values[i] for group, values in groups.items()}, everyone != i)[0]
        scores[i, i] = 1.0
    return diffuse(scores) if rerank else scores


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

    A part's parent is −1 where the region does not hold it.

    Parameters
    ----------
    arg, shares
        As for `parts_in`.
    """
    levels, above = list(arg.levels[:1]), np.zeros(1, dtype=np.int32)
    for level, share, keep in zip(arg.levels[1:], shares[1:], parts_in(arg, shares)[1:], strict=True):
        masses = level.masses[keep] * np.maximum(share[keep], 0.5)
        levels.append(
            replace(
                level,
                masses=(masses / masses.sum()).astype(np.float32),
                features=level.features[keep],
                distances=level.distances[np.ix_(keep, keep)],
                adjacency=level.adjacency[np.ix_(keep, keep)],
                parents=above[level.parents[keep]],
            )
        )
        above = np.full(level.parts, -1, dtype=np.int32)
        above[keep] = np.arange(len(keep))
    return replace(arg, levels=tuple(levels), whole=region_samples(arg.whole, above))

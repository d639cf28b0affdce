"""What it costs a search by a part, in a large bank, that it looks only at the shapes nearest by their vectors.

The bank is that of `benchmarks.retrieval.growth`; the patches of a shape are those of the real one that it was made
from, each moved by noise of a share of the spread. No shape is left out, for here it is not asked what is alike but
what an exhaustive search would find.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.retrieval.growth import CHUNK, NOISE, Grown
from shapery_geometry.threads import one_blas_thread
from shapery_retrieval.arg import Arg
from shapery_retrieval.job import PARTIAL_CANDIDATES
from shapery_retrieval.patches import Patches, nearest_patches, patches_of
from shapery_retrieval.ranking import local_scale
from shapery_retrieval.vector import vector_of

BEST = 20
Query = tuple[Arg, list[Patches]]


@one_blas_thread()
def kept_of_exhaustive(args: Sequence[Arg], queries: Sequence[Query], size: int) -> dict[str, Any]:
    """Search with parts among all shapes and among the nearest by vector.

    Parameters
    ----------
    args
        Real graphs that the bank is grown from.
    queries
        Graphs of parts, and what they may be of a whole.
    size
        Of the bank.

    Returns
    -------
    ``size``, ``candidates``; ``kept``, the share of the exhaustive twenty best among the twenty best found; ``first``,
    how often the best is the same; ``rank``, the median rank by vector of the exhaustive twenty best.
    """
    bank = Grown(args, size)
    real = [patches_of(arg) for arg in args]
    spread = np.concatenate([patches.features for patches in real]).std(axis=0)
    apart = [[np.empty((len(h.masses), size), np.float32) for h in hypotheses] for _, hypotheses in queries]
    for number in range(-(-size // CHUNK)):
        rng = np.random.default_rng([14, number])
        begin, end = number * CHUNK, min((number + 1) * CHUNK, size)
        moved = []
        for start in bank.starts(number)[: end - begin].tolist():
            features = real[start].features
            noise = NOISE * spread * rng.standard_normal(features.shape, np.float32)
            moved.append(Patches(real[start].masses, features + noise))
        for (_, hypotheses), rows in zip(queries, apart, strict=True):
            for patches, row in zip(hypotheses, rows, strict=True):
                row[:, begin:end] = nearest_patches(patches, moved)
    vectors = bank.vectors(0, size)
    kept, first, ranks = [], [], []
    for (arg, hypotheses), rows in zip(queries, apart, strict=True):
        near = np.argsort(np.linalg.norm(vectors - vector_of(arg).astype(np.float32), axis=1), kind="stable")
        rank = np.empty(size, dtype=np.int64)
        rank[near] = np.arange(size)
        best = _best(hypotheses, rows, np.arange(size))
        found = _best(hypotheses, rows, near[:PARTIAL_CANDIDATES])
        kept.append(len(np.intersect1d(best, found)) / BEST)
        first.append(best[0] == found[0])
        ranks.append(np.median(rank[best]))
        print(kept[-1], first[-1], ranks[-1], flush=True)
    return {
        "size": size,
        "candidates": PARTIAL_CANDIDATES,
        "kept": float(np.mean(kept)),
        "first": float(np.mean(first)),
        "rank": float(np.median(ranks)),
    }


def _best(hypotheses: Sequence[Patches], rows: Sequence[np.ndarray], places: np.ndarray) -> np.ndarray:
    """Return the best of some shapes, as `shapery_retrieval.search.Searcher` ranks them for a part."""
    votes = np.zeros(len(places))
    for patches, row in zip(hypotheses, rows, strict=True):
        some = row[:, places].astype(np.float64)
        scales = np.array([local_scale(distances) for distances in some])
        votes += patches.masses @ np.exp(-((some / scales[:, None]) ** 2))
    return places[np.argsort(-votes, kind="stable")[:BEST]]

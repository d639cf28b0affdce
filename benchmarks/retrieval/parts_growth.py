"""What it costs a search by a part, in a large bank, that it looks only at the shapes nearest by the vectors of parts.

The bank is that of `benchmarks.retrieval.growth`; the patches of a shape are those of the real one that it was made
from, each moved by noise of a share of the spread. No shape is left out, for here it is not asked what is alike but
what an exhaustive search would find.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.retrieval.growth import CHUNK, NOISE, Grown
from shapery_contracts.retrieval import VECTOR_DIMENSION
from shapery_geometry.threads import one_blas_thread
from shapery_retrieval.arg import Arg
from shapery_retrieval.coverage import asked_of, covered_by
from shapery_retrieval.job import PARTIAL_CANDIDATES
from shapery_retrieval.patches import Patches, nearest_patches, patches_of
from shapery_retrieval.ranking import local_scale
from shapery_retrieval.vector import vector_of

BEST = 20
BY_WHOLE = 4000
"""So many nearest by the vectors of wholes are looked at for comparison."""
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
    ``size``; for ``by_parts`` and ``by_whole``, by which vectors candidates are found, ``candidates``; ``kept``, the
    share of the exhaustive twenty best among the twenty best found; ``first``, how often the best is the same; and
    ``rank``, the median rank by vector of the exhaustive twenty best; ``cpu_seconds`` of comparing a part with its
    candidates by all patches.
    """
    bank = Grown(args, size)
    real = [patches_of(arg) for arg in args]
    spread = np.concatenate([patches.features for patches in real]).std(axis=0)
    apart = [[np.empty((len(h.masses), size), np.float32) for h in hypotheses] for _, hypotheses in queries]
    covered = np.empty((size, VECTOR_DIMENSION), np.float32)
    for number in range(-(-size // CHUNK)):
        rng = np.random.default_rng([14, number])
        begin, end = number * CHUNK, min((number + 1) * CHUNK, size)
        moved = []
        for start in bank.starts(number)[: end - begin].tolist():
            features = real[start].features
            noise = NOISE * spread * rng.standard_normal(features.shape, np.float32)
            moved.append(Patches(real[start].masses, features + noise))
        covered[begin:end] = covered_by(moved)
        for (_, hypotheses), rows in zip(queries, apart, strict=True):
            for patches, row in zip(hypotheses, rows, strict=True):
                row[:, begin:end] = nearest_patches(patches, moved)
    whole = bank.vectors(0, size)
    figures: dict[str, list[tuple[float, float, float]]] = {"by_parts": [], "by_whole": []}
    for (arg, hypotheses), rows in zip(queries, apart, strict=True):
        best = _best(hypotheses, rows, np.arange(size))
        for by, vectors, asked, most in (
            ("by_parts", covered, asked_of(hypotheses), PARTIAL_CANDIDATES),
            ("by_whole", whole, vector_of(arg), BY_WHOLE),
        ):
            near = np.argsort(np.linalg.norm(vectors - asked.astype(np.float32), axis=1), kind="stable")
            rank = np.empty(size, dtype=np.int64)
            rank[near] = np.arange(size)
            found = _best(hypotheses, rows, near[:most])
            kept = len(np.intersect1d(best, found)) / BEST
            figures[by].append((kept, best[0] == found[0], float(np.median(rank[best]))))
            print(by, figures[by][-1], flush=True)
    compared = [real[start] for start in bank.starts(0)[:PARTIAL_CANDIDATES].tolist()]
    began = time.process_time()
    for _, hypotheses in queries:
        for patches in hypotheses:
            nearest_patches(patches, compared)
    seconds = (time.process_time() - began) / len(queries)
    counts = {"by_parts": PARTIAL_CANDIDATES, "by_whole": BY_WHOLE}
    told = {
        by: {
            "candidates": counts[by],
            "kept": float(np.mean([row[0] for row in found])),
            "first": float(np.mean([row[1] for row in found])),
            "rank": float(np.median([row[2] for row in found])),
        }
        for by, found in figures.items()
    }
    return {"size": size, "cpu_seconds": seconds, **told}


def _best(hypotheses: Sequence[Patches], rows: Sequence[np.ndarray], places: np.ndarray) -> np.ndarray:
    """Return the best of some shapes, as `shapery_retrieval.search.Searcher` ranks them for a part."""
    votes = np.zeros(len(places))
    for patches, row in zip(hypotheses, rows, strict=True):
        some = row[:, places].astype(np.float64)
        scales = np.array([local_scale(distances) for distances in some])
        votes += patches.masses @ np.exp(-((some / scales[:, None]) ** 2))
    return places[np.argsort(-votes, kind="stable")[:BEST]]

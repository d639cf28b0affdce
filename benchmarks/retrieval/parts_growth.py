"""What it costs a search by a part, in a large bank, that it looks only at the shapes nearest by the vectors of parts.

The bank is that of `benchmarks.retrieval.growth`; the patches of a shape are those of the real one that it was made
from, each moved by noise of a share of the spread. No shape is left out, for here it is not asked what is alike but
what an exhaustive search would find.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from benchmarks.retrieval.growth import CHUNK, NOISE, Grown
from shapery_geometry.threads import one_blas_thread
from shapery_retrieval.arg import Arg
from shapery_retrieval.coverage import asked_of, covered_by
from shapery_retrieval.job import PARTIAL_CANDIDATES
from shapery_retrieval.patches import Patches, nearest_patches, patches_of
from shapery_retrieval.ranking import local_scale
from shapery_retrieval.vector import vector_of
from shapery_retrieval.vocabulary import vocabulary

BEST = 20
_COUNTS = {"by_parts": PARTIAL_CANDIDATES, "by_whole": 4000}
"""So many nearest by either vector are looked at."""
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
    moving = Moving(bank, [patches_of(arg) for arg in args], size)
    figures: dict[str, list[list[float]]] = {"by_parts": [], "by_whole": []}
    for arg, hypotheses in queries:
        found = _found(bank, moving, arg, hypotheses)
        print(found, flush=True)
        for by, row in found.items():
            figures[by].append(row)
    compared = moving.patches(0)[:PARTIAL_CANDIDATES]
    began = time.process_time()
    for _, hypotheses in queries:
        for patches in hypotheses:
            nearest_patches(patches, compared)
    seconds = (time.process_time() - began) / len(queries)
    told = {
        by: {
            "candidates": _COUNTS[by],
            "kept": float(np.mean([row[0] for row in rows])),
            "first": float(np.mean([row[1] for row in rows])),
            "rank": float(np.median([row[2] for row in rows])),
        }
        for by, rows in figures.items()
    }
    return {"size": size, "cpu_seconds": seconds, **told}


class Moving:
    """Patches of the shapes of a grown bank, and the vectors of parts made of them."""

    def __init__(self, bank: Grown, real: Sequence[Patches], size: int) -> None:
        self._bank = bank
        self._real = real
        self._spread = np.concatenate([patches.features for patches in real]).std(axis=0)
        self.size = size

    def patches(self, number: int) -> list[Patches]:
        """Return those of a thousand shapes."""
        rng = np.random.default_rng([14, number])
        moved = []
        for start in self._bank.starts(number)[: self.size - number * CHUNK].tolist():
            features = self._real[start].features
            noise = NOISE * self._spread * rng.standard_normal(features.shape, np.float32)
            moved.append(Patches(self._real[start].masses, features + noise))
        return moved

    @cached_property
    def covered(self) -> np.ndarray:
        """(n, 256) float32, from a file where they were worked out before."""
        words = hashlib.sha256(vocabulary().patch_words.tobytes() + vocabulary().patch_reach.tobytes()).hexdigest()
        path = self._bank.folder / f"covered-{self.size}-{words[:16]}.npy"
        if not path.exists():
            chunks = [covered_by(self.patches(number)) for number in range(-(-self.size // CHUNK))]
            part = path.with_suffix(".part.npy")
            np.save(part, np.concatenate(chunks).astype(np.float32))
            part.replace(path)
        return np.asarray(np.load(path))


def _found(bank: Grown, moving: Moving, arg: Arg, hypotheses: Sequence[Patches]) -> dict[str, list[float]]:
    """Return what of the exhaustive twenty best is kept, whether the best is, and the median rank of the twenty."""
    asked = {"by_parts": asked_of(hypotheses), "by_whole": vector_of(arg)}
    vectors = {"by_parts": moving.covered, "by_whole": bank.vectors(0, moving.size)}
    known = hashlib.sha256(json.dumps([_COUNTS, *(values.tolist() for values in asked.values())]).encode()).hexdigest()
    path = bank.folder / f"part-{moving.size}-{known[:16]}.json"
    if path.exists():
        stored: dict[str, list[float]] = json.loads(path.read_text())
        return stored
    rows = [np.empty((len(patches.masses), moving.size), np.float32) for patches in hypotheses]
    for number in range(-(-moving.size // CHUNK)):
        moved = moving.patches(number)
        for patches, row in zip(hypotheses, rows, strict=True):
            row[:, number * CHUNK : number * CHUNK + len(moved)] = nearest_patches(patches, moved)
    best = _best(hypotheses, rows, np.arange(moving.size))
    result = {}
    for by, most in _COUNTS.items():
        near = np.argsort(np.linalg.norm(vectors[by] - asked[by].astype(np.float32), axis=1), kind="stable")
        rank = np.empty(moving.size, dtype=np.int64)
        rank[near] = np.arange(moving.size)
        found = _best(hypotheses, rows, near[:most])
        kept = len(np.intersect1d(best, found)) / BEST
        result[by] = [kept, float(best[0] == found[0]), float(np.median(rank[best]))]
    path.write_text(json.dumps(result))
    return result


def _best(hypotheses: Sequence[Patches], rows: Sequence[np.ndarray], places: np.ndarray) -> np.ndarray:
    """Return the best of some shapes, as `shapery_retrieval.search.Searcher` ranks them for a part."""
    votes = np.zeros(len(places))
    for patches, row in zip(hypotheses, rows, strict=True):
        some = row[:, places].astype(np.float64)
        scales = np.array([local_scale(distances) for distances in some])
        votes += patches.masses @ np.exp(-((some / scales[:, None]) ** 2))
    return places[np.argsort(-votes, kind="stable")[:BEST]]

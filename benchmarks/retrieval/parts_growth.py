"""What it costs a search by a part, in a bank of any size, that it looks only at the shapes nearest by vector.

The bank is that of `benchmarks.retrieval.growth`; the patches of a shape are those of the real one that it was made
from, each moved by noise of a share of the spread. No shape is left out, for here it is not asked what is alike but
what an exhaustive search would find.
"""

from __future__ import annotations

import hashlib
import json
import os
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
from shapery_retrieval.vocabulary import vocabulary

BEST = 20
Query = tuple[Arg, list[Patches]]


@one_blas_thread()
def kept_of_exhaustive(args: Sequence[Arg], queries: Sequence[Query], sizes: Sequence[int]) -> list[dict[str, Any]]:
    """Search with parts among all shapes and among the nearest by the vectors of parts.

    Parameters
    ----------
    args
        Real graphs that the bank is grown from.
    queries
        Graphs of parts, and what they may be of a whole.
    sizes
        Of banks, each the first shapes of the largest, in ascending order.

    Returns
    -------
    For each size ``size``; ``kept``, the share of the exhaustive twenty best among the twenty best found; ``first``,
    how often the best is the same; ``rank``, the median rank by vector of the exhaustive twenty best; ``scan``,
    processor seconds of finding candidates by a scan of all vectors, and ``compare`` those of comparing a part with the
    candidates by all patches.
    """
    bank = Grown(args, sizes[-1])
    moving = Moving(bank, [patches_of(arg) for arg in args], sizes[-1])
    figures = []
    for _, hypotheses in queries:
        figures.append(_found(bank, moving, hypotheses, sizes))
        print(figures[-1], flush=True)
    compared = moving.patches(0)[:PARTIAL_CANDIDATES]
    began = time.process_time()
    for _, hypotheses in queries:
        for patches in hypotheses:
            nearest_patches(patches, compared)
    compare = (time.process_time() - began) / len(queries)
    rows = []
    for size, found in zip(sizes, np.array(figures).transpose(1, 2, 0), strict=True):
        began = time.process_time()
        for _, hypotheses in queries:
            np.linalg.norm(moving.covered[:size] - asked_of(hypotheses).astype(np.float32), axis=1)
        scan = (time.process_time() - began) / len(queries)
        rows.append(
            {
                "size": size,
                "kept": float(found[0].mean()),
                "first": float(found[1].mean()),
                "rank": float(np.median(found[2])),
                "scan": scan,
                "compare": compare * min(size, PARTIAL_CANDIDATES) / len(compared),
            }
        )
    return rows


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
            part = path.with_suffix(f".{os.getpid()}.npy")
            np.save(part, np.concatenate(chunks).astype(np.float32))
            part.replace(path)
        return np.asarray(np.load(path))


def _found(bank: Grown, moving: Moving, hypotheses: Sequence[Patches], sizes: Sequence[int]) -> list[list[float]]:
    """Return for each size what of the exhaustive twenty best is kept, whether the best is, and their median rank."""
    asked = asked_of(hypotheses).astype(np.float32)
    known = hashlib.sha256(json.dumps([PARTIAL_CANDIDATES, *sizes]).encode() + asked.tobytes()).hexdigest()
    path = bank.folder / f"part-{known[:16]}.json"
    if path.exists():
        stored: list[list[float]] = json.loads(path.read_text())
        return stored
    rows = [np.empty((len(patches.masses), moving.size), np.float32) for patches in hypotheses]
    for number in range(-(-moving.size // CHUNK)):
        moved = moving.patches(number)
        for patches, row in zip(hypotheses, rows, strict=True):
            row[:, number * CHUNK : number * CHUNK + len(moved)] = nearest_patches(patches, moved)
    apart = np.linalg.norm(moving.covered - asked, axis=1)
    result = []
    for size in sizes:
        best = _best(hypotheses, rows, np.arange(size))
        near = np.argsort(apart[:size], kind="stable")
        rank = np.empty(size, dtype=np.int64)
        rank[near] = np.arange(size)
        found = _best(hypotheses, rows, np.sort(near[:PARTIAL_CANDIDATES]))
        kept = len(np.intersect1d(best, found)) / len(best)
        result.append([kept, float(best[0] == found[0]), float(np.median(rank[best]))])
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

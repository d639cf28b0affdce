"""What it costs a search by a part, in a bank of any size, that it looks only at the shapes nearest by vector.

Every shape of the bank is joined of halves of two real ones: the patches nearest to one of the samples, on the surface,
until they make up a half, each moved by noise of a share of the spread. So parts recur in many wholes, more or less of
them, and no two wholes are alike: of copies of a few shapes the best would all be copies of one, whose order is noise.
No shape is left out, for here it is not asked what is alike but what an exhaustive search would find.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any
from uuid import UUID

import numpy as np

from benchmarks.retrieval.features import CACHE
from benchmarks.retrieval.growth import CHUNK, NOISE
from shapery_geometry.threads import one_blas_thread
from shapery_retrieval.arg import Arg
from shapery_retrieval.correspondence import surface_of
from shapery_retrieval.coverage import asked_of, covered_by
from shapery_retrieval.job import PARTIAL_CANDIDATES
from shapery_retrieval.patches import Patches, nearest_patches, patches_of
from shapery_retrieval.ranking import local_scale
from shapery_retrieval.vocabulary import vocabulary
from shapery_worker.bank import VectorTable

BEST = 20
TOGETHER = 5
"""So many queries are compared with the bank in one go; their distances take some 120 MB each in the largest."""
KEYS = ("among", "kept", "score", "first", "rank")
Query = tuple[Arg, list[Patches]]


@one_blas_thread()
def kept_of_exhaustive(args: Sequence[Arg], queries: Mapping[str, Query], sizes: Sequence[int]) -> list[dict[str, Any]]:
    """Search with parts among all shapes and among the nearest by the vectors of parts.

    Parameters
    ----------
    args
        Real graphs, of whose halves the bank is joined.
    queries
        By name graphs of parts, and what they may be of a whole.
    sizes
        Of banks, each the first shapes of the largest, in ascending order.

    Returns
    -------
    For each size ``size``; ``among``, the share of the exhaustive twenty best that is looked at; ``kept``, that of them
    which is among the twenty best found, where local scales are those of what is looked at; ``score``, the sum of what
    an exhaustive search gives the twenty found, over that of its own; ``first``, how often the best is the same;
    ``rank``, the median rank by vector of the exhaustive twenty best; ``scan``, processor seconds of finding candidates
    by a scan of all vectors, and ``compare`` those of comparing a part with the candidates by all patches. ``queries``
    holds the former five for each query.
    """
    joined = Joined(args, sizes[-1])
    hypotheses = [patches for _, patches in queries.values()]
    figures = np.concatenate(
        [_found(joined, hypotheses[at : at + TOGETHER], sizes) for at in range(0, len(hypotheses), TOGETHER)]
    )
    compared = joined.patches(0)[:PARTIAL_CANDIDATES]
    began = time.process_time()
    for several in hypotheses:
        for patches in several:
            nearest_patches(patches, compared)
    compare = (time.process_time() - began) / len(queries)
    rows = []
    scans = scanned(joined, hypotheses, sizes)
    for size, scan, found in zip(sizes, scans, figures.transpose(1, 0, 2), strict=True):
        rows.append(
            {
                "size": size,
                **dict(zip(KEYS, [*found[:, :-1].mean(axis=0).tolist(), float(np.median(found[:, -1]))], strict=True)),
                "scan": scan,
                "compare": compare * min(size, PARTIAL_CANDIDATES) / len(compared),
                "queries": {
                    name: dict(zip(KEYS, row, strict=True)) for name, row in zip(queries, found.tolist(), strict=True)
                },
            }
        )
    return rows


def scanned(joined: Joined, queries: Sequence[Sequence[Patches]], sizes: Sequence[int]) -> list[float]:
    """Return for each size the mean processor seconds of finding candidates, as a worker finds them in memory."""
    table = VectorTable()
    seconds = []
    for begin, end in pairwise((0, *sizes)):
        for place in range(begin, end):
            table.put(UUID(int=place), joined.covered[place].tobytes())
        began = time.process_time()
        for several in queries:
            table.nearest(asked_of(several), PARTIAL_CANDIDATES, None)
        seconds.append((time.process_time() - began) / len(queries))
    return seconds


class Joined:
    """Patches of shapes that are joined of halves of real ones, and the vectors of parts made of them.

    Parameters
    ----------
    args
        Real graphs.
    size
        How many shapes there are.
    """

    def __init__(self, args: Sequence[Arg], size: int) -> None:
        self._real = [patches_of(arg) for arg in args]
        self._near = [np.argsort(surface_of(arg).distances, axis=1, kind="stable") for arg in args]
        self._spread = np.concatenate([patches.features for patches in self._real]).std(axis=0)
        self._digest = hashlib.sha256(b"".join(arg.to_bytes() for arg in args))
        self.size = size

    def patches(self, number: int) -> list[Patches]:
        """Return those of a thousand shapes."""
        rng = np.random.default_rng([15, number])
        joined = []
        for two in rng.integers(len(self._real), size=(CHUNK, 2)).tolist():
            halves = [self._half(start, rng) for start in two]
            masses, features = (np.concatenate(arrays) for arrays in zip(*halves, strict=True))
            noise = NOISE * self._spread * rng.standard_normal(features.shape, np.float32)
            joined.append(Patches(masses / masses.sum(), features + noise))
        return joined[: self.size - number * CHUNK]

    def _half(self, start: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        patches, near = self._real[start], self._near[start]
        order = near[rng.integers(len(near))]
        inside = order[np.cumsum(patches.masses[order]) - patches.masses[order] < 0.5]
        return patches.masses[inside], patches.features[inside]

    @cached_property
    def covered(self) -> np.ndarray:
        """(n, 256) float32, from a file where they were worked out before."""
        digest = self._digest.copy()
        digest.update(vocabulary().patch_words.tobytes() + vocabulary().patch_reach.tobytes())
        path: Path = CACHE / f"joined-{digest.hexdigest()[:16]}-{self.size}.npy"
        if not path.exists():
            chunks = [covered_by(self.patches(number)) for number in range(-(-self.size // CHUNK))]
            part = path.with_suffix(f".{os.getpid()}.npy")
            np.save(part, np.concatenate(chunks).astype(np.float32))
            part.replace(path)
        return np.asarray(np.load(path))


def _found(joined: Joined, queries: Sequence[Sequence[Patches]], sizes: Sequence[int]) -> np.ndarray:
    """(q, sizes, 5) figures of some queries, as `KEYS` names them."""
    rows = [[np.empty((len(one.masses), joined.size), np.float32) for one in several] for several in queries]
    for number in range(-(-joined.size // CHUNK)):
        some = joined.patches(number)
        for several, its_rows in zip(queries, rows, strict=True):
            for patches, row in zip(several, its_rows, strict=True):
                row[:, number * CHUNK : number * CHUNK + len(some)] = nearest_patches(patches, some)
    figures = []
    for several, its_rows in zip(queries, rows, strict=True):
        apart = np.linalg.norm(joined.covered - asked_of(several).astype(np.float32), axis=1)
        figures.append([_kept(several, its_rows, apart[:size]) for size in sizes])
        print(json.dumps(figures[-1]), flush=True)
    return np.array(figures)


def _kept(several: Sequence[Patches], rows: Sequence[np.ndarray], apart: np.ndarray) -> list[float]:
    """Return the figures of one query in the bank of the first shapes, whose vectors are so far from the query's."""
    size = len(apart)
    votes = _votes(several, rows, np.arange(size))
    best = np.argsort(-votes, kind="stable")[:BEST]
    near = np.argsort(apart, kind="stable")
    rank = np.empty(size, dtype=np.int64)
    rank[near] = np.arange(size)
    looked_at = np.sort(near[:PARTIAL_CANDIDATES])
    found = looked_at[np.argsort(-_votes(several, rows, looked_at), kind="stable")[:BEST]]
    return [
        float(np.isin(best, looked_at).mean()),
        float(np.isin(best, found).mean()),
        float(votes[found].sum() / votes[best].sum()),
        float(best[0] == found[0]),
        float(np.median(rank[best])),
    ]


def _votes(several: Sequence[Patches], rows: Sequence[np.ndarray], places: np.ndarray) -> np.ndarray:
    """Return the scores of some shapes, as `shapery_retrieval.search.Searcher` gives them for a part."""
    votes = np.zeros(len(places))
    for patches, row in zip(several, rows, strict=True):
        for mass, distances in zip(patches.masses, row, strict=True):
            some = distances[places].astype(np.float64)
            votes += mass * np.exp(-((some / local_scale(some)) ** 2))
    return votes

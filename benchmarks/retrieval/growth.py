"""How the cost of a query grows with the bank, and how much of the exhaustive answer the fast one keeps.

Banks are filled with graphs between real ones: each is a real graph whose descriptors are moved towards one of its
twelve nearest by up to three fifths of the way, and by noise of a share of the spread in the bank; its parts drift and
scatter. A million is a hundred thousand of these with vectors scattered around theirs.
"""

from __future__ import annotations

import hashlib
import json
import os
import resource
import time
from collections.abc import Sequence
from typing import Any
from uuid import UUID

import numpy as np
from numpy.typing import NDArray

from benchmarks.retrieval.features import CACHE
from shapery_contracts.retrieval import VECTOR_DIMENSION
from shapery_geometry.threads import one_blas_thread
from shapery_retrieval.arg import Arg
from shapery_retrieval.correspondence import SampledSurface, surface_of
from shapery_retrieval.job import CANDIDATES
from shapery_retrieval.packing import PackedLevel, pack_levels, part_distances, whole_arrays
from shapery_retrieval.ranking import RANK
from shapery_retrieval.search import Searcher
from shapery_retrieval.vector import SEGMENTS, cue_distances, vectors_of
from shapery_worker.bank import VectorTable

NOISE = 0.05
WAY = 0.6
CHUNK = 1000
MOST_GRAPHS = 100_000
NAMES = ("masses", "features", "squares", "distances", "own", "parts")
QUERIES = 10
NEAREST = 200
"""So many nearest by each cue are looked at by the exhaustive search besides those that its graphs find."""

Array = NDArray[np.float64]


class Grown:
    """Graphs between those of `args`, made a thousand at a time and kept in files."""

    def __init__(self, args: Sequence[Arg], size: int) -> None:
        self._args = args
        self._real = pack_levels(args), whole_arrays(args)
        vectors = vectors_of(*self._real)
        self._near = np.argsort(cue_distances(vectors, vectors, "covariance"), axis=1)[:, 1:13]
        self._spread = NOISE * vectors.std(axis=0)
        digest = hashlib.sha256(b"".join(arg.to_bytes() for arg in args))
        digest.update(vectors.tobytes())
        self.folder = CACHE / f"grown-{digest.hexdigest()[:16]}"
        self.folder.mkdir(parents=True, exist_ok=True)
        self._size = size
        count = min(size, MOST_GRAPHS)
        chunks = [self._chunk(number) for number in range(-(-count // CHUNK))]
        self.levels = tuple(
            PackedLevel(*(np.concatenate([chunk[k][name] for chunk, _ in chunks])[:count] for name in NAMES))
            for k in range(len(self._real[0]))
        )
        self._vectors = np.concatenate([vectors for _, vectors in chunks])[:count]

    def vectors(self, begin: int, end: int) -> NDArray[np.float32]:
        """Return the vectors of the shapes from one number to another."""
        places = np.arange(begin, end)
        found = self._vectors[places % len(self._vectors)]
        if end <= len(self._vectors):
            return found
        noise = np.random.default_rng([12, begin]).standard_normal(found.shape, np.float32) * self._spread
        noise[places < len(self._vectors)] = 0.0
        return np.asarray(found + noise, dtype=np.float32)

    def lay(self, places: NDArray[np.int64]) -> tuple[PackedLevel, ...]:
        """Lay out the graphs of some shapes."""
        return tuple(level.taken(places % len(self._vectors)) for level in self.levels)

    def lay_surfaces(self, places: NDArray[np.int64]) -> list[SampledSurface]:
        """Lay out the samples of the real graphs that some shapes were made from."""
        within = places % len(self._vectors)
        return [surface_of(self._args[self.starts(k // CHUNK)[k % CHUNK]]) for k in within.tolist()]

    def starts(self, number: int) -> NDArray[np.int64]:
        """Return which real graph each of a thousand was made from."""
        return np.random.default_rng([13, number]).integers(len(self._args), size=CHUNK)

    def _chunk(self, number: int) -> tuple[list[dict[str, Any]], NDArray[np.float32]]:
        path = self.folder / f"{number}.npz"
        if not path.exists():
            levels, vectors = self._between(self.starts(number), np.random.default_rng([11, number]))
            arrays = {f"{name}{k}": getattr(level, name) for k, level in enumerate(levels) for name in NAMES}
            part = path.with_suffix(f".{os.getpid()}.npz")
            np.savez(part, vectors=vectors, **arrays)
            part.replace(path)
        with np.load(path, allow_pickle=False) as stored:
            found = [{name: stored[f"{name}{k}"] for name in NAMES} for k in range(len(self._real[0]))]
            return found, stored["vectors"]

    @one_blas_thread()
    def _between(
        self, start: NDArray[np.int64], rng: np.random.Generator
    ) -> tuple[list[PackedLevel], NDArray[np.float32]]:
        levels, whole = self._real
        count = len(start)
        end = self._near[start, rng.integers(self._near.shape[1], size=count)]
        way = rng.uniform(0, WAY, count)[:, None]
        moved = {}
        for name, values in whole.items():
            noise = NOISE * values.std(axis=0) * rng.normal(size=(count, values.shape[1]))
            moved[name] = ((1 - way) * values[start] + way * values[end] + noise).astype(np.float32)
        found = []
        for level in levels:
            real = level.masses[start, None, :] > 0
            spread = level.features.std(axis=(0, 2))[None, :, None]
            drift = rng.normal(size=(count, spread.shape[1], 1))
            scatter = rng.normal(size=(count, spread.shape[1], level.masses.shape[1]))
            features = (level.features[start] + NOISE * spread * (drift + scatter) * real).astype(np.float32)
            squares = np.einsum("ndk,ndk->nk", features, features)
            stretch = np.exp(NOISE * rng.normal(size=(count, 1, 1))).astype(np.float32)
            bare = PackedLevel(
                level.masses[start], features, squares, level.distances[start] * stretch,
                np.zeros(count, np.float32), level.parts[start],
            )  # fmt: skip
            found.append(bare.with_own())
        return found, vectors_of(found, moved)


def growth(args: Sequence[Arg], sizes: Sequence[int], queries: int = QUERIES) -> list[dict[str, Any]]:
    """Return for banks of growing size what a query costs, by stage, and how much of the exhaustive answer it keeps.

    Beyond `MOST_GRAPHS` the costs alone are measured.
    """
    asked = args[:: max(1, len(args) // queries)][:queries]
    known = [vectors_of(pack_levels([query]), whole_arrays([query]))[0] for query in asked]
    bank, rows = Grown(args, max(sizes)), []
    for size in sizes:
        path = bank.folder / f"row-{size}-{queries}.json"
        if not path.exists():
            row = _measured(bank, size, asked, known)
            path.write_text(json.dumps(row))
        rows.append(json.loads(path.read_text()))
        print(rows[-1], flush=True)
    return rows


def _measured(bank: Grown, size: int, asked: Sequence[Arg], known: Sequence[NDArray[np.float32]]) -> dict[str, Any]:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    table = VectorTable()
    for begin in range(0, size, CHUNK):
        for place, vector in enumerate(bank.vectors(begin, min(begin + CHUNK, size)), start=begin):
            table.put(UUID(int=place), vector.tobytes())
    seconds = {"vector": 0.0, "candidates": 0.0, "match": 0.0}
    totals, found, compared = [], [], 0
    for query in (*asked[:2], *asked):
        at = [time.process_time()]
        vector = vectors_of(pack_levels([query]), whole_arrays([query]))[0].astype(np.float64)
        at.append(time.process_time())
        near = table.nearest(vector, CANDIDATES, None)
        at.append(time.process_time())
        near = sorted(near)
        places = np.array([UUID(candidate.shape_id).int for candidate in near])
        vectors = np.frombuffer(b"".join(candidate.vector for candidate in near), dtype="<f4")
        answer = _over(bank, places, vectors.reshape(-1, VECTOR_DIMENSION)).search(query, vector=vector)
        at.append(time.process_time())
        totals.append(at[-1] - at[0])
        found.append({int(hit.shape_id) for hit in answer.hits})
        compared += answer.compared
        for name, spent in zip(seconds, np.diff(at), strict=True):
            seconds[name] += float(spent)
    count = len(totals)
    row = {
        "size": size,
        **{name: value / count for name, value in seconds.items()},
        "query": float(np.mean(totals)),
        "compared": compared / count,
        "agreement": None,
        "vector_megabytes": table.size / 2**20,
        "peak_megabytes": (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 2**10,
    }
    if size <= MOST_GRAPHS:
        best = exhaustive(bank, size, asked, known)
        row["agreement"] = float(np.mean([len(a & b) / len(b) for a, b in zip(found[2:], best, strict=True)]))
    return row


@one_blas_thread()
def exhaustive(bank: Grown, size: int, asked: Sequence[Arg], known: Sequence[NDArray[np.float32]]) -> list[set[int]]:
    """Return the twenty best of searches in which every shape is matched part by part, on scales of the whole bank.

    Local scales, of which each takes a look at the whole bank, are worked out for whatever is near by some cue.
    """
    vectors = bank.vectors(0, size)
    everyone = np.arange(size)
    chosen, divergences = [], []
    for query, vector in zip(asked, known, strict=True):
        levels = pack_levels([query])
        apart = np.concatenate(
            [part_distances(levels, 0, bank.lay(some), np.arange(len(some))) for some in _blocks(everyone)]
        )
        by_cue = [apart, *(cue_distances(vector, vectors, cue) for cue in SEGMENTS)]
        most = min(NEAREST, size)
        chosen.append(np.unique(np.concatenate([np.argpartition(d, most - 1)[:most] for d in by_cue])))
        divergences.append(apart)
    union = np.unique(np.concatenate(chosen))
    rank = min(RANK, max(1, size // 2))
    scales = {}
    for cue in SEGMENTS:
        rows = []
        for some in _blocks(union):
            apart = cue_distances(vectors[some], vectors, cue)
            apart[np.arange(len(some)), some] = np.inf
            rows.append(np.partition(apart, rank - 1, axis=1)[:, rank - 1])
        scales[cue] = np.maximum(np.concatenate(rows), 1e-3)
    found = []
    for query, vector, places in zip(asked, known, chosen, strict=True):
        own = np.searchsorted(union, places)
        searcher = _over(bank, places, vectors[places], {cue: values[own] for cue, values in scales.items()})
        answer = searcher.search(query, exhaustive=True, vector=vector.astype(np.float64))
        found.append({int(hit.shape_id) for hit in answer.hits})
    return found


def _blocks(places: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    return np.split(places, range(200, len(places), 200))


def _over(
    bank: Grown, places: NDArray[np.int64], vectors: NDArray[np.float32], scales: dict[str, Array] | None = None
) -> Searcher:
    """Return a searcher over some graphs of a bank, named by their places."""
    names = [f"{place:07d}" for place in places.tolist()]
    return Searcher(
        names,
        vectors,
        lambda chosen: bank.lay(places[chosen]),
        lambda _: [],
        lambda chosen: bank.lay_surfaces(places[chosen]),
        scales=scales,
    )


def row_of(row: dict[str, Any]) -> str:
    """Return the figures of one size as a row of a Markdown table."""
    costs = " | ".join(f"{1000 * row[stage]:.1f}" for stage in ("vector", "candidates", "match", "query"))
    kept = "–" if row["agreement"] is None else f"{row['agreement']:.3f}"
    return f"| {row['size']:,} | {costs} | {row['compared']:.0f} | {kept} | {row['vector_megabytes']:.0f} |"

"""How the cost of a query grows with the bank, and how much of the exhaustive answer the fast one keeps.

Banks are filled with graphs between real ones: each is a real graph whose descriptors are moved towards one of its
twelve nearest by up to three fifths of the way, and by noise of a share of the spread in the bank; its parts drift and
scatter.
"""

from __future__ import annotations

import hashlib
import time
import tracemalloc
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from uuid import UUID

import numpy as np
from numpy.typing import NDArray

from benchmarks.retrieval.features import CACHE, Features
from shapery_contracts.retrieval import VECTOR_DIMENSION
from shapery_retrieval.arg import Arg
from shapery_retrieval.job import CANDIDATES
from shapery_retrieval.packing import PackedLevel, pack_levels, whole_arrays
from shapery_retrieval.search import Searcher
from shapery_retrieval.vector import PackedGraphs, cue_distances, vectors_of
from shapery_worker.bank import VectorTable

NOISE = 0.05
WAY = 0.6
CHUNK = 1000
NAMES = ("masses", "features", "squares", "distances", "own", "parts")
QUERIES = 20


def grown(args: Sequence[Arg], size: int) -> PackedGraphs:
    """Return so many graphs between those of `args`; a thousand of them are computed once and kept in a file."""
    levels, whole = pack_levels(args), whole_arrays(args)
    vectors = vectors_of(levels, whole)
    near = np.argsort(cue_distances(vectors, vectors, "covariance"), axis=1)[:, 1:13]
    folder = CACHE / f"grown-{hashlib.sha256(b''.join(arg.to_bytes() for arg in args)).hexdigest()[:16]}"
    folder.mkdir(parents=True, exist_ok=True)
    chunks = []
    for number in range(-(-size // CHUNK)):
        path = folder / f"{number}.npz"
        if not path.exists():
            _save(path, _between(levels, whole, near, CHUNK, np.random.default_rng([11, number])))
        chunks.append(_load(path, len(levels)))
    joined = tuple(
        PackedLevel(*(np.concatenate([getattr(chunk.levels[k], name) for chunk in chunks])[:size] for name in NAMES))
        for k in range(len(levels))
    )
    return PackedGraphs(joined, np.concatenate([chunk.vectors for chunk in chunks])[:size])


def _save(path: Path, graphs: PackedGraphs) -> None:
    arrays = {f"{name}{k}": getattr(level, name) for k, level in enumerate(graphs.levels) for name in NAMES}
    part = path.with_suffix(".part.npz")
    np.savez(part, vectors=graphs.vectors, **arrays)
    part.replace(path)


def _load(path: Path, levels: int) -> PackedGraphs:
    with np.load(path, allow_pickle=False) as stored:
        found = tuple(PackedLevel(*(stored[f"{name}{k}"] for name in NAMES)) for k in range(levels))
        return PackedGraphs(found, stored["vectors"])


def _between(
    levels: Sequence[PackedLevel],
    whole: dict[str, NDArray[np.float32]],
    near: NDArray[np.int64],
    count: int,
    rng: np.random.Generator,
) -> PackedGraphs:
    start = rng.integers(len(near), size=count)
    end = near[start, rng.integers(near.shape[1], size=count)]
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
        distances = level.distances[start] * stretch
        bare = PackedLevel(
            level.masses[start], features, squares, distances, np.zeros(count, np.float32), level.parts[start]
        )
        own = np.array([bare.costs(bare, i, np.array([i]))[0] for i in range(count)], dtype=np.float32)
        found.append(PackedLevel(bare.masses, features, squares, distances, own, bare.parts))
    return PackedGraphs(tuple(found), vectors_of(found, moved))


def growth(features: Sequence[Features], sizes: Sequence[int], queries: int = QUERIES) -> list[dict[str, Any]]:
    """Return for banks of growing size what a query costs, by stage, and how much of the exhaustive answer it keeps."""
    args = [item.arg for item in features]
    asked = args[:: max(1, len(args) // queries)][:queries]
    bank = grown(args, max(sizes))
    rows = []
    for size in sizes:
        table = VectorTable()
        for place, vector in enumerate(bank.vectors[:size]):
            table.put(UUID(int=place), vector.tobytes())
        whole = _over(bank, np.arange(size))
        seconds = {"vector": 0.0, "candidates": 0.0, "match": 0.0}
        kept, compared = [], 0
        for query in asked:
            start = time.process_time()
            levels = pack_levels([query])
            vector = vectors_of(levels, whole_arrays([query]))[0].astype(np.float64)
            seconds["vector"] += time.process_time() - start
            start = time.process_time()
            near = table.nearest(vector, CANDIDATES, None)
            seconds["candidates"] += time.process_time() - start
            places = np.sort([UUID(candidate.shape_id).int for candidate in near])
            start = time.process_time()
            answer = _over(bank, places).search(query, vector=vector)
            seconds["match"] += time.process_time() - start
            compared += answer.compared
            best = whole.search(query, exhaustive=True)
            kept.append(
                len({hit.shape_id for hit in answer.hits} & {hit.shape_id for hit in best.hits}) / len(best.hits)
            )
        rows.append(
            {
                "size": size,
                **{name: value / len(asked) for name, value in seconds.items()},
                "query": sum(seconds.values()) / len(asked),
                "compared": compared / len(asked),
                "agreement": float(np.mean(kept)),
                "vector_megabytes": table.size / 2**20,
            }
        )
        print(rows[-1], flush=True)
    return rows


def candidate_growth(features: Sequence[Features], size: int) -> dict[str, Any]:
    """Return the cost of the first stage alone in a bank of vectors around real ones."""
    rng = np.random.default_rng(1)
    real = vectors_of(pack_levels([f.arg for f in features]), whole_arrays([f.arg for f in features]))
    spread = 0.3 * real.std(axis=0)
    tracemalloc.start()
    table = VectorTable()
    for place in range(size):
        vector = real[place % len(real)] + (rng.standard_normal(VECTOR_DIMENSION) * spread).astype(np.float32)
        table.put(UUID(int=place), vector.tobytes())
    megabytes = tracemalloc.get_traced_memory()[0] / 2**20
    tracemalloc.stop()
    start = time.process_time()
    for query in real[:5]:
        table.nearest(query.astype(np.float64), CANDIDATES, None)
    return {"size": size, "candidates": (time.process_time() - start) / 5, "megabytes": megabytes}


def _over(bank: PackedGraphs, places: NDArray[np.int64]) -> Searcher:
    """Return a searcher over some graphs of a bank, named by their places."""
    return Searcher(
        [f"{place:07d}" for place in places.tolist()],
        bank.vectors[places],
        lambda chosen: tuple(level.taken(places[chosen]) for level in bank.levels),
    )

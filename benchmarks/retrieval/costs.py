"""What indexing and a query cost, and how that grows with the bank."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.retrieval.features import Features
from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval.arg import Arg
from shapery_retrieval.decompose import decompose
from shapery_retrieval.nodes import build_levels
from shapery_retrieval.normalise import normalise
from shapery_retrieval.search import Searcher
from shapery_retrieval.signals import compute_signals
from shapery_retrieval.vector import vector_of
from shapery_retrieval.whole import whole_descriptors


def index_profile(meshes: Sequence[TriangleMesh]) -> dict[str, float]:
    """Return the mean CPU seconds of each stage of indexing a mesh."""
    total = dict.fromkeys(("normalise", "signals", "decompose", "describe parts", "views and whole"), 0.0)
    for mesh in meshes:
        at = [time.process_time()]
        normalised = normalise(mesh)
        at.append(time.process_time())
        signals = compute_signals(normalised)
        at.append(time.process_time())
        decomposition = decompose(signals)
        at.append(time.process_time())
        build_levels(signals, decomposition, normalised.mesh.edges)
        at.append(time.process_time())
        whole_descriptors(normalised.mesh, signals)
        at.append(time.process_time())
        for name, seconds in zip(total, np.diff(at), strict=True):
            total[name] += float(seconds) / len(meshes)
    return total


def query_cost(features: Sequence[Features], queries: int = 40) -> dict[str, float]:
    """Return the CPU seconds of laying out a bank, of its first query, and of one query after that."""
    args = {f"{place:04d}": item.arg for place, item in enumerate(features)}
    start = time.process_time()
    searcher = Searcher(args)
    built = time.process_time()
    chosen = list(args)[:: max(1, len(args) // queries)]
    for name in chosen:
        searcher.search(args[name], exclude=name)
    warm = time.process_time()
    for name in chosen:
        searcher.search(args[name], exclude=name)
    return {
        "lay_out": built - start,
        "first_queries": (warm - built) / len(chosen),
        "query": (time.process_time() - warm) / len(chosen),
    }


def perturbed(arg: Arg, rng: np.random.Generator) -> Arg:
    """Return a graph much like another: every descriptor moved by a few percent."""
    whole = {
        name: values
        if values.dtype.kind != "f" or name == "view_weights"
        else (values * (1 + 0.05 * rng.normal(size=values.shape))).astype(values.dtype)
        for name, values in arg.whole.items()
    }
    return replace(arg, whole=whole)


def growth(features: Sequence[Features], sizes: Sequence[int], candidates: int = 400) -> list[dict[str, Any]]:
    """Return, for banks of real graphs perturbed to fill them, the cost of finding candidates and of comparing them."""
    rng = np.random.default_rng(0)
    args = [item.arg for item in features]
    real = np.stack([vector_of(arg) for arg in args]).astype(np.float32)
    spread = real.std(axis=0) * 0.1
    rows = []
    for size in sizes:
        vectors = real[rng.integers(len(real), size=size)]
        vectors += (rng.normal(size=vectors.shape) * spread).astype(np.float32)
        squares = np.einsum("ij,ij->i", vectors, vectors)
        start = time.process_time()
        for query in real[:10]:
            # |v|² − 2 v·q orders as the distance does
            near = squares - 2 * (vectors @ query)
            np.argpartition(near, min(candidates, size - 1))[:candidates]
        scan = (time.process_time() - start) / 10
        count = min(candidates, size)
        bank = {f"{i:06d}": perturbed(args[i % len(args)], rng) for i in range(count)}
        start = time.process_time()
        searcher = Searcher(bank)
        searcher.search(args[0])
        compare = time.process_time() - start
        rows.append({"size": size, "scan": scan, "compare_cold": compare, "vector_megabytes": vectors.nbytes / 2**20})
    return rows

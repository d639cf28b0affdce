"""What indexing and a query cost."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from benchmarks.retrieval.features import Features
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.threads import one_blas_thread
from shapery_retrieval.decompose import decompose
from shapery_retrieval.nodes import build_levels
from shapery_retrieval.normalise import normalise
from shapery_retrieval.patches import LocalSurface
from shapery_retrieval.search import Searcher
from shapery_retrieval.sides import sample_arrays
from shapery_retrieval.signals import compute_signals
from shapery_retrieval.whole import whole_descriptors


@one_blas_thread()
def index_profile(meshes: Sequence[TriangleMesh]) -> dict[str, float]:
    """Return the mean CPU seconds of each stage of indexing a mesh."""
    stages = ("normalise", "signals", "decompose", "describe parts", "views and whole", "patches", "sides")
    total = dict.fromkeys(stages, 0.0)
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
        LocalSurface(normalised, signals, decomposition.samples).described(1.0)
        at.append(time.process_time())
        sample_arrays(normalised.mesh, signals, decomposition.samples)
        at.append(time.process_time())
        for name, seconds in zip(total, np.diff(at), strict=True):
            total[name] += float(seconds) / len(meshes)
    return total


@one_blas_thread()
def query_cost(features: Sequence[Features], queries: int = 40) -> dict[str, float]:
    """Return the CPU seconds of laying out a bank, of its first query, and of others once and, median, once more.

    What a query finds is laid out when it is first found, and kept: so is it by the process that answers searches.
    """
    args = {f"{place:04d}": item.arg for place, item in enumerate(features)}
    start = time.process_time()
    searcher = Searcher.of(args)
    built = time.process_time()
    chosen = list(args)[:: max(1, len(args) // queries)]
    searcher.search(args[chosen[0]], exclude=chosen[0])
    warm = time.process_time()
    for name in chosen:
        searcher.search(args[name], exclude=name)
    once = time.process_time()
    again = []
    for name in chosen:
        began = time.process_time()
        searcher.search(args[name], exclude=name)
        again.append(time.process_time() - began)
    return {
        "lay out": built - start,
        "first query": warm - built,
        "query that finds what was not found before": (once - warm) / len(chosen),
        "query": float(np.median(again)),
    }

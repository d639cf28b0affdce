"""Parts of shapes, cut off by a random plane, as queries whose share of a whole is not told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.retrieval.features import part_of
from benchmarks.retrieval.measures import per_query
from benchmarks.retrieval.variants import cropped
from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval.arg import Arg
from shapery_retrieval.search import Searcher

SHARES = (0.7, 0.5, 0.3)


def partial_queries(
    bank: Mapping[str, Arg], labels: np.ndarray, meshes: Mapping[int, TriangleMesh], chosen: Sequence[int], seed: int
) -> dict[str, Any]:
    """Search with parts of some shapes of a bank; the shapes themselves are left out of it.

    Parameters
    ----------
    bank
        Graphs by names whose order is that of `labels`.
    labels : (n,)
        Classes.
    meshes, chosen
        By place in the bank, and which of them are cut.
    seed
        Of the planes, with the place.
    """
    names = list(bank)
    label_of = dict(zip(names, labels.tolist(), strict=True))
    searcher = Searcher.of(bank)
    rows: dict[str, Any] = {}
    for share in SHARES:
        relevant = []
        for place in chosen:
            name = names[place]
            arg, hypotheses = part_of(cropped(share)(meshes[place], np.random.default_rng(seed + place)))
            answer = searcher.search(arg, limit=len(bank), exclude=name, partial=True, hypotheses=hypotheses)
            relevant.append([label_of[hit.shape_id] == label_of[name] for hit in answer.hits])
        found = {key: float(values.mean()) for key, values in per_query(np.array(relevant)).items()}
        rows[f"{share:.0%} of the surface"] = {**found, "queries": len(chosen)}
        print(share, rows[f"{share:.0%} of the surface"], flush=True)
    return rows

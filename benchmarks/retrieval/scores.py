"""Score matrices of a bank by every method that is compared: higher is more alike."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.retrieval.features import Features
from shapery_retrieval.nodes import FV1, FV2
from shapery_retrieval.packing import BLOCKS, Blocks, pack_level
from shapery_retrieval.ranking import GROUPS, affinity, diffuse, local_scale, local_scales
from shapery_retrieval.search import score_matrix
from shapery_retrieval.vector import cue_distances, pack

Array = NDArray[np.float64]


def by_parts(features: Sequence[Features], blocks: Blocks = BLOCKS, levels: Sequence[int] = (1, 2)) -> Array:
    """Compare the graphs below the root alone: parts by some of their features, and the distances between parts."""
    args = [item.arg for item in features]
    n = len(args)
    total = np.zeros((n, n))
    for number in levels:
        level = pack_level(args, number, blocks)
        for i in range(n):
            later = np.arange(i + 1, n)
            total[i, later] += level.divergences(level, i, later)
    return -(total + total.T)


def on_local_scales(scores: Array) -> Array:
    """Turn negative distances into affinities as the whole score does, each row's shape left out of all scales."""
    n = len(scores)
    result = np.eye(n)
    for i in range(n):
        others = np.flatnonzero(np.arange(n) != i)
        square = np.where(np.eye(n - 1, dtype=bool), np.inf, -scores[np.ix_(others, others)])
        scales = np.array([local_scale(row) for row in square])
        result[i, others] = affinity(-scores[i, others], local_scale(-scores[i, others]), scales)
    return result


def by_whole(features: Sequence[Features], group: str) -> Array:
    """Compare one group of the root's descriptors alone."""
    vectors = pack([item.arg for item in features]).vectors
    total = np.zeros((len(vectors), len(vectors)))
    for cue, weight in GROUPS[group].items():
        distances = cue_distances(vectors, vectors, cue)
        scales = local_scales(distances)
        total += weight * affinity(distances, scales[:, None], scales[None, :])
    return total


def nearness(vectors: Array, order: int = 2) -> Array:
    """Negative distance between vectors."""
    return -np.stack([np.linalg.norm(vectors - row, ord=order, axis=1) for row in vectors])


def own_methods(features: Sequence[Features]) -> dict[str, Array]:
    """Return the matrices of the graph alone and of what ``shapery matrix`` gives, without and with re-ranking."""
    pure = score_matrix([item.arg for item in features])
    return {
        "ARG alone (parts and relations)": by_parts(features),
        "whole score, pure query": pure,
        "whole score, re-ranked": diffuse(pure),
    }


def all_methods(features: Sequence[Features]) -> dict[str, Array]:
    """Return every method's matrix; those of `own_methods` are among them."""
    heat = np.stack([item.arg.whole["quantiles"][: 16 * 9] for item in features]).astype(np.float64)
    own = own_methods(features)
    parts = own.pop("ARG alone (parts and relations)")
    return {
        "D2": nearness(np.stack([item.d2 for item in features]), 1),
        "ShapeDNA, 30 log eigenvalues": nearness(np.log(np.stack([item.eigenvalues[1:31] for item in features]))),
        "quantiles of the HKS": nearness(heat, 1),
        "FV1, one level of 16 parts": by_parts(features, ((1.0, FV1),), (1,)),
        "FV2, one level of 16 parts": by_parts(features, ((1.0, FV2),), (1,)),
        "FV1, hierarchy": by_parts(features, ((1.0, FV1),)),
        "FV2, hierarchy": by_parts(features, ((1.0, FV2),)),
        "ARG alone (parts and relations)": parts,
        "ARG alone, on local scales": on_local_scales(parts),
        "depth views alone": by_whole(features, "views"),
        "intrinsic descriptors alone": by_whole(features, "intrinsic"),
        **own,
    }

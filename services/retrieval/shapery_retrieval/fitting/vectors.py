"""Axes and landmarks of `shapery_retrieval.vector`, from the graphs of generated shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from shapery_retrieval.arg import Arg
from shapery_retrieval.packing import pack_levels, part_distances, whole_arrays
from shapery_retrieval.ranking import GROUPS, RANK
from shapery_retrieval.vector import SIZES

LANDMARKS = 48
Array = NDArray[np.float64]


def fit_vectors(args: Sequence[Arg], rng: np.random.Generator) -> dict[str, NDArray[np.generic]]:
    """Return the arrays of the vocabulary by which graphs become vectors.

    Parameters
    ----------
    args
        Graphs of generated shapes, computed with the words of the same vocabulary.
    rng
        Draws the landmarks among them.
    """
    votes = {cue: weight for cues in GROUPS.values() for cue, weight in cues.items()}
    found: dict[str, NDArray[np.generic]] = {}
    for cue, values in whole_arrays(args).items():
        mean = values.astype(np.float64).mean(axis=0)
        centred = values - mean
        axes = np.linalg.svd(centred, full_matrices=False)[2][: SIZES[cue]].T
        apart = _distances(centred @ axes)
        unit = np.sqrt(votes[cue]) / _neighbour(apart)
        found[f"{cue}.mean"] = mean.astype(np.float16)
        found[f"{cue}.axes"] = (axes * unit).astype(np.float16)
        found[f"{cue}.unlike"] = np.array(apart[np.triu_indices(len(args), 1)].mean() * unit, dtype=np.float32)
    return {**found, **_fit_landmarks(args, rng), **fit_patches(args)}


def fit_patches(args: Sequence[Arg]) -> dict[str, NDArray[np.generic]]:
    """Return mean and spread of the features of patches."""
    features = np.concatenate([arg.whole["patch_features"].astype(np.float64) for arg in args])
    masses = np.concatenate([arg.whole["patch_masses"] for arg in args]).astype(np.float64)
    mean = masses @ features / masses.sum()
    spread = np.sqrt(masses @ (features - mean) ** 2 / masses.sum())
    return {"patch_mean": mean.astype(np.float32), "patch_spread": spread.astype(np.float32)}


def _fit_landmarks(args: Sequence[Arg], rng: np.random.Generator) -> dict[str, NDArray[np.generic]]:
    levels = pack_levels(args)
    chosen = np.sort(rng.choice(len(args), LANDMARKS, replace=False))
    apart = np.stack([part_distances(levels, i, levels, chosen) for i in range(len(args))])
    among = apart[chosen]
    among = (among + among.T) / 2
    centring = np.eye(LANDMARKS) - 1 / LANDMARKS
    values, axes = np.linalg.eigh(-0.5 * centring @ among @ centring)
    keep = np.argsort(-values)[: SIZES["parts"] - 1]
    transform = axes[:, keep] / np.sqrt(np.maximum(values[keep], 1e-9))
    mean = among.mean(axis=0)
    places = -0.5 * (apart - mean) @ transform
    rest = np.maximum((apart - _distances(places, places[chosen]) ** 2).mean(axis=1) / 2, 0.0)
    bare = [replace(args[i], whole={}).to_bytes() for i in chosen.tolist()]
    return {
        "landmarks": np.frombuffer(b"".join(bare), dtype=np.uint8),
        "landmark_sizes": np.array([len(data) for data in bare], dtype=np.int64),
        "landmark_mean": mean.astype(np.float32),
        "landmark_axes": transform.astype(np.float32),
        "landmark_places": places[chosen].astype(np.float32),
        "parts_unit": np.array(_neighbour(_distances(places) ** 2 + rest[:, None] + rest), dtype=np.float32),
    }


def _distances(points: Array, others: Array | None = None) -> Array:
    others = points if others is None else others
    squares = (points**2).sum(axis=1)[:, None] + (others**2).sum(axis=1) - 2 * points @ others.T
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def _neighbour(apart: Array) -> float:
    """Median distance to the neighbour of the rank that local scales are taken at."""
    return float(np.median(np.sort(apart, axis=1)[:, RANK]))

"""``python -m shapery_retrieval.fitting words|vectors|parts [SHAPES]``: generate shapes and fit the vocabulary anew.

First the words and spreads by which graphs are described; then, with these, the axes and landmarks by which graphs
become vectors, and the words by which a bank is scanned for wholes of a part.
"""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_retrieval.arg import Arg
from shapery_retrieval.decompose import decompose, take_samples
from shapery_retrieval.describe import build_arg
from shapery_retrieval.fitting.k_means import k_means
from shapery_retrieval.fitting.parts import WeightedFeatures, fit_parts
from shapery_retrieval.fitting.shapes import generated_shape
from shapery_retrieval.fitting.vectors import fit_vectors
from shapery_retrieval.nodes import build_levels
from shapery_retrieval.normalise import normalise
from shapery_retrieval.patches import LocalSurface
from shapery_retrieval.signals import compute_signals
from shapery_retrieval.views import view_features
from shapery_retrieval.vocabulary import FILE

WAVE_WORDS, VIEW_WORDS, VIEW_AXES = 64, 1200, 48
Array = NDArray[np.float64]


def fit(shapes: int, rng: np.random.Generator) -> dict[str, NDArray[np.generic]]:
    """Return the arrays of the vocabulary, from so many generated shapes."""
    waves: list[Array] = []
    views: list[NDArray[np.float32]] = []
    nodes: list[Array] = []
    masses: list[Array] = []
    seen: list[NDArray[np.float32]] = []
    while len(seen) < shapes:
        mesh = generated_shape(rng)
        if mesh is None:
            continue
        try:
            normalised = normalise(mesh)
            signals = compute_signals(normalised)
        except InvalidInput:
            continue
        decomposition = decompose(signals)
        for level in build_levels(signals, decomposition, normalised.mesh.edges)[1:]:
            nodes.append(level.features.astype(np.float64))
            masses.append(level.masses.astype(np.float64))
        waves.append(signals.wave[rng.choice(len(signals.wave), 300, p=signals.areas)])
        found = view_features(normalised.mesh)
        seen.append(found)
        views.append(found[rng.permutation(len(found))[:500]])
        print(f"\r{len(seen)} of {shapes} shapes", end="", file=sys.stderr, flush=True)  # noqa: T201
    print(file=sys.stderr)  # noqa: T201
    wave_points = np.concatenate(waves)
    wave_words = k_means(wave_points, WAVE_WORDS, rng)
    nearest = ((wave_points[::17, None] - wave_words[None]) ** 2).sum(axis=2).min(axis=1)
    points = np.concatenate(views).astype(np.float64)
    mean = points.mean(axis=0)
    axes = np.linalg.eigh(np.cov((points - mean).T))[1][:, ::-1][:, :VIEW_AXES]
    view_words = k_means((points - mean) @ axes, VIEW_WORDS, rng)
    shown = np.zeros(VIEW_WORDS)
    for found in seen:
        projected = (found.astype(np.float64) - mean) @ axes
        shown[np.unique(np.argmax(projected @ view_words.T - 0.5 * (view_words**2).sum(axis=1), axis=1))] += 1
    all_nodes, mass = np.concatenate(nodes), np.concatenate(masses)
    node_mean = mass @ all_nodes / mass.sum()
    node_spread = np.sqrt(mass @ (all_nodes - node_mean) ** 2 / mass.sum())
    return {
        "waves": wave_words.astype(np.float32),
        "wave_width": np.float32(np.sqrt(np.median(nearest))),
        "view_mean": mean.astype(np.float16),
        "view_axes": axes.astype(np.float16),
        "views": view_words.astype(np.float16),
        "view_sharpness": np.float32(20.0),
        "view_rarity": np.log(shapes / np.maximum(shown, 0.5)).astype(np.float16),
        "node_mean": node_mean.astype(np.float32),
        "node_spread": node_spread.astype(np.float32),
    }


def generated_graphs(shapes: int, rng: np.random.Generator) -> list[Arg]:
    """Return the graphs of so many generated shapes."""
    args: list[Arg] = []
    while len(args) < shapes:
        mesh = generated_shape(rng)
        if mesh is not None:
            args.append(build_arg(mesh))
            print(f"\r{len(args)} of {shapes} shapes", end="", file=sys.stderr, flush=True)  # noqa: T201
    print(file=sys.stderr)  # noqa: T201
    return args


def generated_patches(shapes: int, rng: np.random.Generator) -> list[WeightedFeatures]:
    """Return weights and features of the patches of so many generated shapes."""
    found: list[WeightedFeatures] = []
    while len(found) < shapes:
        mesh = generated_shape(rng)
        if mesh is not None:
            normalised = normalise(mesh)
            signals = compute_signals(normalised)
            found.append(LocalSurface(normalised, signals, take_samples(signals)).described(1.0))
            print(f"\r{len(found)} of {shapes} shapes", end="", file=sys.stderr, flush=True)  # noqa: T201
    print(file=sys.stderr)  # noqa: T201
    return found


def main(stage: str, shapes: int | None) -> None:
    """Fit one of the stages and keep what the file has of the others."""
    with np.load(FILE, allow_pickle=False) as stored:
        arrays: dict[str, NDArray[np.generic]] = dict(stored)
    if stage == "words":
        arrays |= fit(shapes or 240, np.random.default_rng(2011))
    elif stage == "vectors":
        arrays |= fit_vectors(generated_graphs(shapes or 400, np.random.default_rng(101)), np.random.default_rng(7))
    else:
        arrays |= fit_parts(generated_patches(shapes or 200, np.random.default_rng(101)), np.random.default_rng(7))
    np.savez_compressed(FILE, allow_pickle=False, **arrays)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else None)

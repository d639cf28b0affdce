"""What was learned once from shapes that the project generates itself: words, axes and spreads.

``python -m shapery_retrieval.fitting`` writes the file anew. Nothing in it comes from a bank that is searched or
evaluated, so a graph means the same in every bank.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

CUES = ("covariance", "quantiles", "wave_words", "views")
"""Descriptors at the root."""
FILE = Path(__file__).with_name("vocabulary.npz")


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """The learned constants.

    Attributes
    ----------
    waves : (w, 16) float64
        Words of wave kernel signatures; `wave_width` is how softly they are assigned.
    view_mean : (128,), view_axes : (128, c), views : (v, c) float32
        Mean and principal axes of view features, and words in these axes.
    node_mean, node_spread : (d,) float64
        Of the features of graph nodes, over parts weighted by area.
    patch_mean, patch_spread : (29,) float64
        Of the features of patches, weighted by area.
    patch_words : (255, 29) float32, patch_reach : (255,) float64
        Typical patches, standardised, and how far from each the twelfth nearest generated shape has its nearest one.
    cue_axes
        For each descriptor at the root its mean and its principal axes, of a length that makes the distance to the
        twelfth neighbour about the root of the cue's vote.
    landmarks
        Graphs, as bytes, among which the parts of others are placed.
    landmark_mean : (l,), landmark_axes : (l, c), landmark_places : (l, c)
        Mean divergence from each landmark, the map from divergences to places, and where the landmarks themselves are.
    parts_unit
        Divergence of a twelfth neighbour.
    unlike
        Mean distance of shapes by each descriptor at the root, in the unit of `cue_axes`.
    """

    waves: NDArray[np.float64]
    wave_width: float
    view_mean: NDArray[np.float32]
    view_axes: NDArray[np.float32]
    views: NDArray[np.float32]
    view_sharpness: float
    view_rarity: NDArray[np.float32]
    node_mean: NDArray[np.float64]
    node_spread: NDArray[np.float64]
    patch_mean: NDArray[np.float64]
    patch_spread: NDArray[np.float64]
    patch_words: NDArray[np.float32]
    patch_reach: NDArray[np.float64]
    cue_axes: Mapping[str, tuple[NDArray[np.float32], NDArray[np.float32]]]
    landmarks: tuple[bytes, ...]
    landmark_mean: NDArray[np.float64]
    landmark_axes: NDArray[np.float64]
    landmark_places: NDArray[np.float64]
    parts_unit: float
    unlike: Mapping[str, float]


@cache
def vocabulary() -> Vocabulary:
    """Load the shipped vocabulary once."""
    with np.load(FILE, allow_pickle=False) as stored:
        axes = stored["view_axes"].astype(np.float32)
        return Vocabulary(
            waves=stored["waves"].astype(np.float64),
            wave_width=float(stored["wave_width"]),
            view_mean=stored["view_mean"].astype(np.float32),
            view_axes=axes,
            views=stored["views"].astype(np.float32),
            view_sharpness=float(stored["view_sharpness"]),
            view_rarity=stored["view_rarity"].astype(np.float32),
            node_mean=stored["node_mean"].astype(np.float64),
            node_spread=stored["node_spread"].astype(np.float64),
            patch_mean=stored["patch_mean"].astype(np.float64),
            patch_spread=stored["patch_spread"].astype(np.float64),
            patch_words=stored["patch_words"].astype(np.float32),
            patch_reach=stored["patch_reach"].astype(np.float64),
            cue_axes=MappingProxyType(
                {
                    name: (stored[f"{name}.mean"].astype(np.float32), stored[f"{name}.axes"].astype(np.float32))
                    for name in CUES
                }
            ),
            landmarks=_split(stored["landmarks"], stored["landmark_sizes"]),
            landmark_mean=stored["landmark_mean"].astype(np.float64),
            landmark_axes=stored["landmark_axes"].astype(np.float64),
            landmark_places=stored["landmark_places"].astype(np.float64),
            parts_unit=float(stored["parts_unit"]),
            unlike=MappingProxyType({name: float(stored[f"{name}.unlike"]) for name in CUES}),
        )


def _split(data: NDArray[np.uint8], sizes: NDArray[np.int64]) -> tuple[bytes, ...]:
    ends = np.cumsum(sizes).tolist()
    return tuple(data[end - size : end].tobytes() for end, size in zip(ends, sizes.tolist(), strict=True))

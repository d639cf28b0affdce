"""What was learned once from shapes that the project generates itself: words, axes and spreads.

``python -m shapery_retrieval.fitting`` writes the file anew. Nothing in it comes from a bank that is searched or
evaluated, so a graph means the same in every bank.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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
        )

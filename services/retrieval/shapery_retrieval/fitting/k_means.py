"""Words of a vocabulary."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def k_means(points: Array, count: int, rng: np.random.Generator, rounds: int = 12) -> Array:
    """Lloyd's algorithm from a random start; words that nothing is near to begin anew at a random point."""
    words = points[rng.choice(len(points), count, replace=False)].copy()
    for _ in range(rounds):
        nearest = np.concatenate(
            [np.argmax(block @ words.T - 0.5 * (words**2).sum(axis=1), axis=1) for block in np.array_split(points, 64)]
        )
        counts = np.bincount(nearest, minlength=count)
        sums = np.stack([np.bincount(nearest, column, count) for column in points.T], axis=1)
        words = np.where(
            counts[:, None] > 0, sums / np.maximum(counts, 1)[:, None], points[rng.integers(len(points), size=count)]
        )
    return np.asarray(words)

"""Trajectories in the few directions that matter at the error that is allowed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

LOST: Final = 0.01
"""Share of the allowed squared error that lies outside the directions, at the most."""


@dataclass(frozen=True, eq=False)
class Trajectories:
    """The trajectories of all vertices."""

    full: FloatArray
    """(n, F, 3) without the offset."""
    points: FloatArray
    """(n, d) their coordinates in the directions."""
    directions: FloatArray
    """(d, 3F) orthonormal, the most important first."""
    size: float
    """Root of the sum of all squared coordinates."""

    @classmethod
    def of(cls, full: FloatArray, squared_error: float) -> Trajectories:
        """Find the directions that are needed where a squared error, over all vertices and frames, is allowed."""
        flat = full.reshape(len(full), -1)
        n, t = flat.shape
        energies, vectors = np.linalg.eigh(flat.T @ flat if t <= n else flat @ flat.T)
        energies, vectors = np.maximum(energies[::-1], 0.0), vectors[:, ::-1]
        outside = np.cumsum(energies[::-1])[::-1]
        size = float(np.sqrt(outside[0])) if len(outside) else 0.0
        count = max(1, int((outside > LOST * squared_error).sum()))
        if t <= n:
            directions = np.ascontiguousarray(vectors[:, :count].T)
            return cls(full, flat @ vectors[:, :count], directions, size)
        roots = np.sqrt(energies[:count])
        directions = (vectors[:, :count].T @ flat) / np.where(roots > 0.0, roots, 1.0)[:, None]
        return cls(full, vectors[:, :count] * roots, directions, size)

"""A sequence to measure on, and what a method makes of it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.topology import Topology

ROOT = Path(__file__).resolve().parent.parent.parent
DATA = Path(os.environ.get("SHAPERY_TEST_DATA", ROOT.parent / "shared" / "data")) / "motion"
RESULTS = Path(__file__).resolve().parent.parent / "results"

TARGETS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
"""KG errors in percent."""


@dataclass(frozen=True, eq=False)
class Case:
    """A sequence."""

    name: str
    frames: NDArray[np.float64]
    """(F, n, 3)"""
    faces: NDArray[np.int32]
    """(m, 3)"""

    @cached_property
    def topology(self) -> Topology:
        """Of the faces."""
        return Topology(self.frames.shape[1], self.faces)

    @cached_property
    def spread(self) -> float:
        """Root mean squared distance of the vertices from their frame's centroid: 100 % of the KG error."""
        centred = self.frames - self.frames.mean(axis=1, keepdims=True)
        return math.sqrt(float((centred**2).sum(axis=2).mean()))

    @property
    def numbers(self) -> int:
        """Vertices times frames: what bits are divided by."""
        return int(self.frames.shape[0] * self.frames.shape[1])

    def kg(self, decoded: NDArray[np.float64]) -> float:
        """KG error in percent."""
        return 100 * math.sqrt(float(((decoded - self.frames) ** 2).sum() / self.numbers)) / self.spread


def load(name: str) -> Case:
    """Read a sequence of the shared data by its name."""
    with np.load(DATA / f"{name}.npz") as stored:
        return Case(name, stored["vertices"].astype(np.float64), stored["faces"].astype(np.int32))


@dataclass(frozen=True, eq=False)
class Coded:
    """What a method made of a sequence: real coded bytes, and what they decode to."""

    motion_bytes: int
    """All but the connectivity."""
    decoded: NDArray[np.float64]
    """(F, n, 3), from the coded whole numbers."""
    decode_seconds: float = math.nan
    """CPU time of decoding; not a number where it was not taken."""
    connectivity_bytes: int | None = None
    """Where the method codes it."""
    settings: dict[str, Any] = field(default_factory=dict)


Method = Callable[[Case, float], Coded | None]
"""Codes a sequence at a KG error in percent; nothing where the method does not reach it."""


def to_target(attempt: Callable[[float], float], first: float, target: float, *, rounds: int = 12) -> float:
    """Return the largest step found whose error is at most `target`.

    Parameters
    ----------
    attempt
        The error at a step; it rises with the step, nearly in proportion.
    first
        Where to begin.
    """
    low, high, step = 0.0, math.inf, first
    for _ in range(rounds):
        error = attempt(step)
        if error <= target:
            low = step
            if error > 0.995 * target:
                break
        else:
            high = step
        guess = step * min(max(0.998 * target / max(error, 1e-300), 0.25), 4.0)
        if not low < guess < high:
            guess = math.sqrt(low * high) if low > 0 and math.isfinite(high) else (2 * low or high / 4)
        step = guess
    return low

"""Matching of two graphs: a score, and which parts correspond (section 4.6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_retrieval.arg import Arg


@dataclass(frozen=True, eq=False)
class LevelMatch:
    """How two shapes match on one level.

    Attributes
    ----------
    score
        In [0, 1]; 1 for a shape with itself.
    transport : (k, l) float64
        How much of the query's area the matching carries from each of its parts to each part of the other.
    """

    score: float
    transport: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Match:
    """How two shapes match: symmetric, in [0, 1], 1 for a shape with itself."""

    score: float
    levels: tuple[LevelMatch, ...]
    best_level: int


def match(query: Arg, other: Arg, *, partial: bool = False) -> Match:
    """Match two graphs."""
    raise NotImplementedError

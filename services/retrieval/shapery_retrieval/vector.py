"""The vector of a graph: what is compared first, over a whole bank, before parts are matched.

The descriptors at the root are projected to their principal axes, and the parts are placed among landmark graphs so
that squared distances come near to what a matching would give. Axes and landmarks are those of shapes that the project
generates, so a vector means the same in every bank. Each cue has its own segment, in units of its distances to near
neighbours.

References
----------
V. de Silva, J. Tenenbaum, Sparse multidimensional scaling using landmark points, Stanford, 2004.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.retrieval import VECTOR_DIMENSION
from shapery_retrieval.arg import Arg
from shapery_retrieval.packing import PackedLevel, pack_level, pack_levels, part_distances, whole_arrays
from shapery_retrieval.ranking import local_scales
from shapery_retrieval.vocabulary import CUES, vocabulary

SIZES = MappingProxyType({"covariance": 48, "quantiles": 48, "wave_words": 24, "views": 111, "parts": 25})
"""How many numbers each cue has. The last one of ``parts`` is the root of what the landmarks leave unexplained."""


def _segments() -> dict[str, slice]:
    ends = np.cumsum(list(SIZES.values())).tolist()
    return {cue: slice(end - size, end) for (cue, size), end in zip(SIZES.items(), ends, strict=True)}


SEGMENTS: Mapping[str, slice] = MappingProxyType(_segments())
assert SEGMENTS["parts"].stop == VECTOR_DIMENSION

Vectors = NDArray[np.float32]
Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PackedGraphs:
    """Several graphs, laid out for matching and for ranking.

    Attributes
    ----------
    levels
        The levels below the root.
    vectors : (n, 256) float32
        Their vectors.
    """

    levels: tuple[PackedLevel, ...]
    vectors: Vectors

    def __len__(self) -> int:
        return len(self.vectors)


def pack(args: Sequence[Arg]) -> PackedGraphs:
    """Lay out graphs side by side and compute their vectors; see `pack_levels` for what is refused."""
    levels = pack_levels(args)
    return PackedGraphs(levels, vectors_of(levels, whole_arrays(args)))


def vector_of(arg: Arg) -> Array:
    """(256,) vector of a graph; shapes near each other by it are worth a closer look."""
    return np.asarray(pack([arg]).vectors[0], dtype=np.float64)


def vectors_of(levels: Sequence[PackedLevel], whole: Mapping[str, NDArray[np.floating]]) -> Vectors:
    """(n, 256) vectors of graphs from their levels and their descriptors at the root."""
    words = vocabulary()
    result = np.empty((len(levels[0]), VECTOR_DIMENSION), dtype=np.float32)
    for cue in CUES:
        mean, axes = words.cue_axes[cue]
        result[:, SEGMENTS[cue]] = (whole[cue] - mean) @ axes
    result[:, SEGMENTS["parts"]] = _among_landmarks(levels)
    return result


def cue_distances(query: Vectors, vectors: Vectors, cue: str) -> Array:
    """(n,) distances of a vector from others, or (m, n) of several, by one cue.

    For the parts it is an estimate of `shapery_retrieval.packing.part_distances`, which are squares in nature.
    """
    return _distances(query, vectors, cue, np.float64)


def neighbour_scales(vectors: Vectors, cue: str) -> Array:
    """(n,) local scales by one cue of the neighbourhoods of all shapes; see `shapery_retrieval.ranking.local_scales`.

    In single precision: the distance to a twelfth neighbour is far from none.
    """
    return local_scales(_distances(vectors, vectors, cue, np.float32)).astype(np.float64)


def _distances(query: Vectors, vectors: Vectors, cue: str, dtype: type[np.floating[Any]]) -> NDArray[Any]:
    segment = SEGMENTS[cue]
    own, others = query[..., segment].astype(dtype), vectors[:, segment].astype(dtype)
    own_squares, squares = np.square(own).sum(axis=-1), np.square(others).sum(axis=1)
    if cue == "parts":
        # the rests add up, whatever they are of
        own, others = own[..., :-1], others[:, :-1]
    apart = own @ others.T
    apart *= -2
    apart += own_squares[..., None]
    apart += squares
    np.maximum(apart, 0, out=apart)
    if cue == "parts":
        apart *= vocabulary().parts_unit
        return np.asarray(apart)
    return np.asarray(np.sqrt(apart, out=apart))


@cache
def _landmarks() -> tuple[PackedLevel, ...]:
    args = [Arg.from_bytes(data) for data in vocabulary().landmarks]
    return tuple(pack_level(args, level) for level in range(1, len(args[0].levels)))


def _among_landmarks(levels: Sequence[PackedLevel]) -> Array:
    words = vocabulary()
    everyone = np.arange(len(words.landmarks))
    apart = np.stack([part_distances(levels, i, _landmarks(), everyone) for i in range(len(levels[0]))])
    places = -0.5 * (apart - words.landmark_mean) @ words.landmark_axes
    explained = ((places[:, None] - words.landmark_places[None]) ** 2).sum(axis=2)
    # Each divergence is about the squared distance of two places and a share of either graph that no place explains.
    rest = np.maximum((apart - explained).mean(axis=1) / 2, 0.0)
    return np.asarray(np.concatenate((places, np.sqrt(rest)[:, None]), axis=1) / np.sqrt(words.parts_unit))

"""Bases and fields of the clusters, to and from their streams."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from shapery_motion.entropy._coder_kernels import BINS
from shapery_motion.entropy.stream import PACE, Stream
from shapery_motion.graph import VertexGraph
from shapery_motion.trajectory import _basis_kernels, _field_kernels, _level_kernels
from shapery_motion.trajectory._tree_kernels import pairing_tree
from shapery_motion.trajectory.borders import Border, DecodedCluster

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

DEPENDENT_PACE: Final = 12
"""How fast the mixer learns in the streams of dependent quantisation."""
COSTS: Final = np.array([-np.log2(max(k, 0.5) / 4096) for k in range(4097)], dtype=np.float32)
"""Bits of a decision by its probability in 1/4096, for estimates."""
_NO_TARGETS: Final[FloatArray] = np.zeros((0, 0))
_EMPTY: Final[FloatArray] = np.zeros((0, 0, 0))
_NOTHING_BESIDE: Final[tuple[FloatArray, FloatArray]] = (np.zeros(0), np.zeros((0, 0)))


@dataclass(frozen=True, eq=False)
class PairingTree:
    """The tree of a cluster: see `_tree_kernels.pairing_tree`."""

    parts: tuple[Any, ...]
    vertices: int

    @classmethod
    def of_members(cls, graph: VertexGraph, members: IntArray, scratch: IntArray) -> PairingTree:
        """Build the tree of a cluster.

        Parameters
        ----------
        graph
            Of the whole mesh.
        members
            Vertices of the cluster, ascending.
        scratch
            (n,) all -1; it is left so.
        """
        scratch[members] = np.arange(len(members))
        starts, neighbours = _subgraph(graph, members, scratch)
        scratch[members] = -1
        children, levels, sizes, links, link_starts, link_weights, inner_weights = pairing_tree(starts, neighbours)
        pairs = len(children)
        parents = np.full(len(members) + pairs, pairs, dtype=np.int64)
        parents[children.reshape(-1)] = np.repeat(np.arange(pairs), 2)
        parts = (
            children,
            levels,
            sizes,
            links,
            link_starts,
            link_weights.astype(np.float64),
            inner_weights.astype(np.float64),
            parents,
        )
        return cls(parts, len(members))


def _subgraph(graph: VertexGraph, members: IntArray, local: IntArray) -> tuple[IntArray, NDArray[np.int32]]:
    """Return the graph among some vertices, numbered by `local`."""
    counts = graph.starts[members + 1] - graph.starts[members]
    owners = np.repeat(np.arange(len(members)), counts)
    ends = np.cumsum(counts)
    at = np.arange(int(ends[-1]) if len(ends) else 0) - np.repeat(ends - counts, counts)
    targets = local[graph.neighbours[graph.starts[members][owners] + at]]
    inside = targets >= 0
    starts = np.concatenate(([0], np.cumsum(np.bincount(owners[inside], minlength=len(members))))).astype(np.int64)
    return starts, targets[inside].astype(np.int32)


def _places(sizes: IntArray, dependent: bool) -> IntArray:
    """Return where the contexts of each kind begin: one row, or one for each of two quantisers."""
    first = np.concatenate(([0], np.cumsum(sizes)[:-1]))
    return np.stack([first, first + sizes.sum()]) if dependent else first[None]


class BasisStream:
    """Streams TBAS and, with dependent quantisation, TBA2."""

    def __init__(
        self, *, data: memoryview | None = None, room: int = 0, trade: float = 0.0, dependent: bool = False
    ) -> None:
        sizes = _basis_kernels.BASIS_SIZES
        self._places = _places(sizes, dependent)
        sets = len(self._places)
        self._stream = Stream(
            sets * int(sizes.sum()) * BINS + _basis_kernels.SIGN_SLOTS,
            sets * _basis_kernels.MIXER_ROWS * BINS,
            data=data,
            room=room,
            pace=DEPENDENT_PACE if dependent else PACE,
        )
        self._trade = trade

    def code(self, cuts: IntArray, rank: int, targets: FloatArray = _EMPTY) -> IntArray:
        """Code the bases of a cluster; return their coefficients (rank, F, 3) in half steps.

        Encoding, `targets` (rank, F, 3) are what they should be, in steps.
        """
        stream = self._stream
        quantised = np.zeros((rank, int(cuts[-1]), 3), dtype=np.int64)
        levels = np.zeros_like(quantised)
        _basis_kernels.code_bases(
            *stream.parts, stream.weights, self._places, cuts, rank, targets, quantised, levels, COSTS, self._trade
        )
        return levels

    @property
    def stream(self) -> Stream:
        """What is beneath."""
        return self._stream


class FieldStream:
    """Streams TFLD, TFL2, TFL3 and, with dependent quantisation, TFL4."""

    def __init__(
        self, *, data: memoryview | None = None, room: int = 0, trade: float = 0.0, dependent: bool = False
    ) -> None:
        sizes = _level_kernels.FIELD_SIZES
        self._places = _places(sizes, dependent)
        sets = len(self._places)
        self._stream = Stream(
            sets * int(sizes.sum()) * BINS,
            sets * _level_kernels.MIXER_ROWS * BINS,
            data=data,
            room=room,
            pace=DEPENDENT_PACE if dependent else PACE,
        )
        self._trade = trade

    def code(
        self,
        tree: PairingTree,
        rank: int,
        targets: FloatArray = _NO_TARGETS,
        beside: tuple[FloatArray, FloatArray] = _NOTHING_BESIDE,
        carry: FloatArray = _NO_TARGETS,
    ) -> FloatArray:
        """Code the fields of a cluster, in units of the step; return them (rank, n) as a decoder has them.

        `beside` is what `Border.predict` tells; without it the stream is of the first edition. Encoding, `targets` (n,
        rank) are changed: by `carry` (rank, rank), the share of a field's error that each later one takes over.
        """
        stream = self._stream
        quantised = np.zeros((rank, tree.vertices), dtype=np.int64)
        decoded = np.zeros((rank, tree.vertices))
        if rank:
            _field_kernels.code_fields(
                *stream.parts,
                stream.weights,
                self._places,
                *tree.parts,
                *beside,
                targets,
                carry,
                rank,
                quantised,
                decoded,
                COSTS,
                self._trade,
            )
        return decoded

    def code_around_mean(
        self,
        tree: PairingTree,
        levels: IntArray,
        functions: FloatArray,
        border: Border,
        before: list[DecodedCluster],
        targets: FloatArray = _NO_TARGETS,
        carry: FloatArray = _NO_TARGETS,
    ) -> FloatArray:
        """Code the fields of a cluster whose first function is its mean trajectory; return all (r, n).

        Parameters
        ----------
        tree
            Of the cluster.
        levels : (r, F, 3)
            Cosine coefficients of its functions; of the first, in half steps divided by the root of n.
        functions : (r, 3 F)
            The functions, of unit norm or 0.
        border, before
            Its border, and the clusters of lower number.
        targets, carry
            Without the mean: see `code`.
        """
        fields = np.zeros((len(levels), tree.vertices))
        if len(levels):
            first = 0.5 * levels[0].reshape(-1)
            # one after the other, as every decoder adds them
            fields[0] = np.sqrt(np.cumsum(first * first)[-1]) / np.sqrt(tree.vertices)
            beside = border.predict(before, functions[1:], fields[0, 0] * functions[0])
            fields[1:] = self.code(tree, len(levels) - 1, targets, beside, carry)
        return fields

    @property
    def stream(self) -> Stream:
        """What is beneath."""
        return self._stream

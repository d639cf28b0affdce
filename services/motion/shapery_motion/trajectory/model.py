"""Section TMOD: what a group of the profile ``trajectory`` is made of, beside the numbers themselves."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from shapery_motion.container.sections import damaged
from shapery_motion.entropy.stream import Stream
from shapery_motion.graph import VertexGraph
from shapery_motion.trajectory import _model_kernels as kernels

MODEL, BASES = "TMOD", "TBAS"
FIELDS, SECOND_FIELDS, FIRST_FIELDS = "TFL3", "TFL2", "TFLD"
"""The stream of fields with plain quantisation, and as versions 1.1 and 1.0 of the format had it."""
DEPENDENT_BASES, DEPENDENT_FIELDS = "TBA2", "TFL4"
"""Both streams with dependent quantisation."""
MAX_CLUSTERS: Final = 1 << 16
MAX_RANK: Final = 4096
FARTHEST: Final = 1e30
"""Coordinates stay below this: no square overflows, and single precision holds them."""

_FIXED: Final = struct.Struct("<4d3I")


@dataclass(frozen=True, eq=False)
class GroupModel:
    """The side information of a group."""

    offset: NDArray[np.float64]
    """(3,) what is added to all coordinates."""
    step: float
    """The step of all coefficients, in the unit of the coordinates."""
    sources: NDArray[np.int64]
    """(F,) for each frame, which of the kept frames it shows."""
    labels: NDArray[np.int64]
    """(n,) the cluster of each vertex."""
    ranks: NDArray[np.int64]
    """(K,) functions of time of each cluster."""
    cuts: tuple[NDArray[np.int64], ...]
    """For each cluster, where its runs of kept frames begin, and their number last."""

    @property
    def kept(self) -> int:
        """Number of frames that are kept."""
        return int(self.cuts[0][-1])

    @cached_property
    def members(self) -> tuple[NDArray[np.int64], ...]:
        """The vertices of each cluster, ascending."""
        order = np.argsort(self.labels, kind="stable")
        ends = np.cumsum(np.bincount(self.labels, minlength=len(self.ranks)))
        return tuple(np.split(order, ends[:-1]))

    @property
    def memory(self) -> int:
        """Bytes that the opened group takes, by the formula in the specification of the format."""
        sizes = np.bincount(self.labels, minlength=len(self.ranks))
        return memory_of(sizes, self.ranks, self.kept, len(self.labels))

    def pack(self, graph: VertexGraph) -> bytes:
        """Return the payload of the section."""
        runs = [np.diff(cuts) for cuts in self.cuts]
        total = sum(map(len, runs))
        stream = Stream(kernels.MODEL_SLOTS, room=64 + 8 * (len(self.sources) + len(self.labels) + total) + 16 * total)
        kernels.code_frames(*stream.parts, self.sources.copy())
        kernels.code_ranks(*stream.parts, self.ranks.copy())
        starts = np.zeros(len(runs) + 1, dtype=np.int64)
        kernels.code_runs(*stream.parts, self.kept, starts, np.concatenate(runs))
        kernels.code_labels(*stream.parts, graph.starts, graph.neighbours, len(self.ranks), self.labels.copy())
        fixed = _FIXED.pack(*self.offset.tolist(), self.step, self.kept, len(self.ranks), total)
        return fixed + stream.finished()

    @classmethod
    def unpack(cls, payload: memoryview, frames: int, graph: VertexGraph, memory: int) -> GroupModel:
        """Read the section.

        Raises
        ------
        InvalidInput
            ``corrupt_file`` where it contradicts itself or asks for more than `memory` bytes.
        """
        if len(payload) < _FIXED.size:
            raise damaged(MODEL, f"has {len(payload)} bytes, fewer than {_FIXED.size}")
        x, y, z, step, kept, clusters, total = _FIXED.unpack_from(payload)
        if not (max(abs(x), abs(y), abs(z)) <= FARTHEST and 0 < step <= FARTHEST):
            raise damaged(MODEL, f"has the step {step} and the offset {x}, {y}, {z}")
        if not (1 <= kept <= frames and 1 <= clusters <= min(MAX_CLUSTERS, graph.vertices)):
            raise damaged(MODEL, f"tells of {clusters} clusters of {graph.vertices} vertices in {kept} frames")
        if not clusters <= total <= clusters * kept:
            raise damaged(MODEL, f"tells of {total} runs of frames")
        if 8 * total > memory:
            raise damaged(MODEL, "asks for more memory than the header tells")
        stream = Stream(kernels.MODEL_SLOTS, data=payload[_FIXED.size :])
        sources = np.zeros(frames, dtype=np.int64)
        if kernels.code_frames(*stream.parts, sources) != kept:
            raise damaged(MODEL, "refers to frames that are not there")
        ranks = np.zeros(clusters, dtype=np.int64)
        kernels.code_ranks(*stream.parts, ranks)
        if ranks.max() > MAX_RANK:
            raise damaged(MODEL, f"gives a cluster {ranks.max()} modes")
        starts = np.zeros(clusters + 1, dtype=np.int64)
        lengths = np.zeros(total, dtype=np.int64)
        if not kernels.code_runs(*stream.parts, kept, starts, lengths) or starts[-1] != total:
            raise damaged(MODEL, "has runs that do not make up its frames")
        labels = np.zeros(graph.vertices, dtype=np.int64)
        if not kernels.code_labels(*stream.parts, graph.starts, graph.neighbours, clusters, labels):
            raise damaged(MODEL, "names a cluster that is not there")
        stream.check_end(MODEL)
        sizes = np.bincount(labels, minlength=clusters)
        if not sizes.all():
            raise damaged(MODEL, "has a cluster without vertices")
        if memory_of(sizes, ranks, kept, len(labels)) > memory:
            raise damaged(MODEL, "asks for more memory than the header tells")
        cuts = tuple(
            np.concatenate(([0], np.cumsum(lengths[starts[c] : starts[c + 1]]))).astype(np.int64)
            for c in range(clusters)
        )
        return cls(np.array([x, y, z]), step, sources, labels, ranks, cuts)


def memory_of(sizes: NDArray[Any], ranks: NDArray[np.int64], kept: int, vertices: int) -> int:
    """Return the bytes that an opened group takes: its fields and bases twice over, and its side information."""
    return int((sizes * ranks).sum() * 16 + ranks.sum() * kept * 48 + vertices * 400)

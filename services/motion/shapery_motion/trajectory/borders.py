"""Borders: edges from a cluster to those before it, along which its fields are predicted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shapery_motion.graph import VertexGraph
from shapery_motion.trajectory import _border_kernels as kernels

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

AT_ONCE: Final = 64
"""Vertices whose trajectories are held at the same time."""
_NONE: Final[FloatArray] = np.zeros(0)


@dataclass(frozen=True, eq=False)
class DecodedCluster:
    """A cluster as a decoder has it."""

    fields: FloatArray
    """(r, n) in units of the step."""
    functions: FloatArray
    """(r, 3 F): of unit norm, frame after frame, x, y, z of each."""

    @classmethod
    def of(cls, fields: FloatArray, functions: FloatArray) -> DecodedCluster:
        """Put the functions (F, r, 3) of a cluster in rows."""
        return cls(fields, in_rows(functions))


def in_rows(functions: FloatArray) -> FloatArray:
    """Return functions (F, r, 3) as rows (r, 3 F)."""
    return np.ascontiguousarray(functions.transpose(1, 0, 2)).reshape(functions.shape[1], 3 * len(functions))


@dataclass(frozen=True, eq=False)
class Border:
    """The edges from a cluster's vertices to those of clusters of lower number."""

    owners: IntArray
    """(e,) vertices by their number in the cluster, ascending."""
    targets: IntArray
    """(e,) the ends beyond, numbered as they ascend in the mesh."""
    beyond: tuple[tuple[int, IntArray, IntArray], ...]
    """Cluster, numbers within it, and numbers among the ends, of the ends in each of the other clusters."""
    vertices: int

    @classmethod
    def of_members(cls, graph: VertexGraph, members: IntArray, labels: IntArray, local: IntArray) -> Border:
        """Find the border of a cluster.

        Parameters
        ----------
        graph
            The mesh.
        members
            Vertices of the cluster, ascending.
        labels : (n,)
            Clusters of all vertices.
        local : (n,)
            Number of each vertex within its cluster.
        """
        counts = graph.starts[members + 1] - graph.starts[members]
        owners = np.repeat(np.arange(len(members)), counts)
        ends = np.cumsum(counts)
        at = np.arange(len(owners)) - np.repeat(ends - counts, counts) + np.repeat(graph.starts[members], counts)
        neighbours = graph.neighbours[at].astype(np.int64)
        outside = labels[neighbours] < labels[members[0]]
        found, targets = np.unique(neighbours[outside], return_inverse=True)
        beyond = []
        for label in np.unique(labels[found]).tolist():
            places = np.flatnonzero(labels[found] == label)
            beyond.append((label, local[found[places]], places))
        return cls(owners[outside], targets.reshape(-1).astype(np.int64), tuple(beyond), len(members))

    def predict(
        self, before: list[DecodedCluster], functions: FloatArray, mean: FloatArray = _NONE
    ) -> tuple[FloatArray, FloatArray]:
        """Return how many edges lead from each vertex to earlier clusters, and what lies beyond them on average.

        Parameters
        ----------
        before
            The clusters of lower number.
        functions : (r, 3 F)
            Of this cluster.
        mean : (3 F,)
            Its mean trajectory in units of the step, if it has one.

        Returns
        -------
        (n,), (r, n)
            Counts; means in units of the step.
        """
        rank = len(functions)
        values = np.zeros((rank, sum(len(places) for _, _, places in self.beyond)))
        for label, inside, places in self.beyond:
            other = before[label]
            for k in range(0, len(places), AT_ONCE):
                some = slice(k, k + AT_ONCE)
                kernels.project(other.fields, other.functions, inside[some], mean, functions, places[some], values)
        counts, means = np.zeros(self.vertices), np.zeros((rank, self.vertices))
        kernels.averages(self.owners, self.targets, values, counts, means)
        return counts, means


def numbers_within(labels: IntArray, members: tuple[IntArray, ...]) -> IntArray:
    """Return the number (n,) of each vertex within its cluster."""
    local = np.zeros(len(labels), dtype=np.int64)
    for some in members:
        local[some] = np.arange(len(some))
    return local

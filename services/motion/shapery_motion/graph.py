"""The vertices of a mesh and their neighbours, as both sides of the codec see them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import IntArray
from shapery_geometry.topology import Topology


@dataclass(frozen=True, eq=False)
class VertexGraph:
    """Which vertices share an edge: the neighbours of v are ``neighbours[starts[v]:starts[v + 1]]``, ascending."""

    starts: NDArray[np.int64]
    neighbours: NDArray[np.int32]

    @property
    def vertices(self) -> int:
        """Number of vertices, in use or not."""
        return len(self.starts) - 1

    @classmethod
    def of_edges(cls, vertices: int, edges: IntArray) -> VertexGraph:
        """Build the graph of undirected edges, each given once; loops are left out."""
        edges = edges[edges[:, 0] != edges[:, 1]]
        ends = np.concatenate((edges, edges[:, ::-1]))
        order = np.lexsort((ends[:, 1], ends[:, 0]))
        counts = np.bincount(ends[:, 0], minlength=vertices)
        starts = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
        return cls(starts, np.ascontiguousarray(ends[order, 1], dtype=np.int32))

    @classmethod
    def of_faces(cls, vertices: int, faces: IntArray) -> VertexGraph:
        """Build the graph of the edges of triangles."""
        return cls.of_edges(vertices, Topology(vertices, faces).edges)

"""What follows from the faces of a mesh alone: edges, boundary, fans, components, Euler characteristic, genus."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput

IntArray = NDArray[np.int32]


class Topology:
    """What follows from the faces alone. Every property is computed when first asked for, and kept.

    Parameters
    ----------
    vertex_count
        Number of vertices, in use or not.
    faces : (m, 3) int32
        Valid vertex indices.
    """

    def __init__(self, vertex_count: int, faces: IntArray) -> None:
        self.vertex_count = vertex_count
        self.faces = faces

    @cached_property
    def half_edges(self) -> IntArray:
        """(3m, 2) the directed sides of the faces: side k of face f, from corner k to corner k + 1, is row 3f + k."""
        return np.stack((self.faces, np.roll(self.faces, -1, axis=1)), axis=2).reshape(-1, 2)

    @cached_property
    def _unique(self) -> tuple[IntArray, NDArray[np.int64], NDArray[np.int64]]:
        ends = np.sort(self.half_edges, axis=1).astype(np.int64)
        keys, inverse, counts = np.unique(
            ends[:, 0] * max(self.vertex_count, 1) + ends[:, 1], return_inverse=True, return_counts=True
        )
        edges = np.stack(np.divmod(keys, max(self.vertex_count, 1)), axis=1).astype(np.int32)
        return edges, inverse.reshape(-1), counts

    @cached_property
    def edges(self) -> IntArray:
        """(e, 2) the undirected edges, each once, smaller index first, sorted.

        A face that names a vertex twice contributes a loop (a, a).
        """
        return self._unique[0]

    @cached_property
    def face_edges(self) -> IntArray:
        """(m, 3) index into `edges` of each face's sides, from corner k to corner k + 1."""
        return self._unique[1].reshape(-1, 3).astype(np.int32)

    @cached_property
    def edge_face_counts(self) -> NDArray[np.int64]:
        """(e,) how many face sides lie on each edge."""
        return self._unique[2]

    @cached_property
    def _edge_balance(self) -> NDArray[np.int64]:
        """(e,) sides that run from the smaller to the larger index, minus those that run back."""
        half = self.half_edges
        direction = np.sign(half[:, 1].astype(np.int64) - half[:, 0])
        return np.bincount(self._unique[1], weights=direction, minlength=len(self.edges)).astype(np.int64)

    @cached_property
    def boundary_edges(self) -> IntArray:
        """(b, 2) the edges that one face alone has, directed as in that face; without loops."""
        half = self.half_edges
        return np.asarray(half[(self.edge_face_counts[self._unique[1]] == 1) & (half[:, 0] != half[:, 1])])

    @cached_property
    def boundary_loops(self) -> list[IntArray]:
        """The closed paths of `boundary_edges`, each an array of vertices (the first is not repeated).

        Where more than two boundary edges meet in a vertex, the paths cross there in an arbitrary but fixed way; where
        an odd number does, which takes a non-manifold mesh, a path ends there open.
        """
        remaining: dict[int, list[int]] = {}
        for a, b in self.boundary_edges.tolist():
            remaining.setdefault(a, []).append(b)
            remaining.setdefault(b, []).append(a)
        loops: list[IntArray] = []
        for first in [int(a) for a in self.boundary_edges[:, 0]]:
            if not remaining[first]:
                continue
            path, here = [first], first
            # prefers the direction of the face: of two open ends the first one listed
            while remaining[here]:
                there = remaining[here].pop(0)
                remaining[there].remove(here)
                here = there
                if here == first:
                    break
                path.append(here)
            loops.append(np.array(path, dtype=np.int32))
        return loops

    @cached_property
    def closed(self) -> bool:
        """Whether the surface has faces but no border: every edge lies on an even number of face sides.

        This is what it takes to part inside from outside; two boxes that share an edge are closed, not manifold. The
        loop of a face that names a vertex twice is no border.
        """
        odd = (self.edge_face_counts % 2 == 1) & (self.edges[:, 0] != self.edges[:, 1])
        return len(self.faces) > 0 and not odd.any()

    @cached_property
    def oriented(self) -> bool:
        """Whether neighbouring faces run along their common edge in opposite directions.

        On an edge of more than two faces as many must run one way as the other (one more where their number is odd).
        """
        loops = self.edges[:, 0] == self.edges[:, 1]
        return not np.any((np.abs(self._edge_balance) > 1) & ~loops)

    @cached_property
    def degenerate_faces(self) -> IntArray:
        """(k,) faces that name a vertex more than once."""
        a, b, c = self.faces.T
        return np.flatnonzero((a == b) | (b == c) | (c == a)).astype(np.int32)

    @cached_property
    def nonmanifold_edges(self) -> IntArray:
        """(k, 2) edges of more than two face sides."""
        return self.edges[self.edge_face_counts > 2]

    @cached_property
    def nonmanifold_vertices(self) -> IntArray:
        """(k,) vertices whose faces do not form one fan: those of non-manifold edges, and where two fans touch."""
        # Imported here because the kernels bring numba, which most that is asked of a mesh does without.
        from shapery_geometry import _topology_kernels as kernels

        bad = np.zeros(self.vertex_count, dtype=bool)
        bad[self.nonmanifold_edges.ravel()] = True
        # Two corners at one vertex are linked where their faces share an edge at that vertex. Then a vertex has as many
        # fans as it has sets of linked corners.
        fans = np.zeros(self.vertex_count, dtype=np.int64)
        last = np.full(len(self.edges), -1, dtype=np.int32)
        corners = np.arange(self.faces.size, dtype=np.int32)
        kernels.count_fans(np.ascontiguousarray(self.faces), self.face_edges, last, corners, fans)
        bad |= fans > 1
        return np.flatnonzero(bad).astype(np.int32)

    @cached_property
    def manifold(self) -> bool:
        """Whether every point has a disk or a half disk around it.

        That is: no face names a vertex twice, no edge has more than two faces, the faces of every vertex form one fan.
        """
        return not len(self.degenerate_faces) and not len(self.nonmanifold_edges) and not len(self.nonmanifold_vertices)

    @cached_property
    def referenced(self) -> NDArray[np.bool_]:
        """(n,) whether a face uses the vertex."""
        used = np.zeros(self.vertex_count, dtype=bool)
        used[self.faces.ravel()] = True
        return used

    @cached_property
    def _components(self) -> tuple[int, IntArray]:
        from shapery_geometry import _topology_kernels as kernels

        labels = np.arange(self.vertex_count, dtype=np.int32)
        kernels.join_pairs(np.ascontiguousarray(self.edges[:, 0]), np.ascontiguousarray(self.edges[:, 1]), labels)
        result = np.full(self.vertex_count, -1, dtype=np.int32)
        if not len(self.faces):
            return 0, result
        firsts = self.referenced & (labels == np.arange(self.vertex_count))
        rank = np.cumsum(firsts, dtype=np.int32) - 1
        result[self.referenced] = rank[labels[self.referenced]]
        return int(firsts.sum()), result

    @property
    def component_count(self) -> int:
        """Number of parts connected through common vertices; vertices without a face are no part."""
        return self._components[0]

    @property
    def vertex_components(self) -> IntArray:
        """(n,) component of each vertex, numbered by their first vertex; −1 where no face uses it."""
        return self._components[1]

    @cached_property
    def face_components(self) -> IntArray:
        """(m,) component of each face."""
        return np.asarray(self.vertex_components[self.faces[:, 0]])

    @cached_property
    def euler_characteristics(self) -> NDArray[np.int64]:
        """(c,) vertices − edges + faces of each component."""
        c = self.component_count
        vertices = np.bincount(self.vertex_components[self.referenced], minlength=c)
        edges = np.bincount(self.vertex_components[self.edges[:, 0]], minlength=c)
        faces = np.bincount(self.face_components, minlength=c)
        return (vertices - edges + faces).astype(np.int64)

    @property
    def euler_characteristic(self) -> int:
        """Vertices in use − edges + faces of the whole mesh."""
        return int(self.euler_characteristics.sum())

    @cached_property
    def genus_per_component(self) -> NDArray[np.int64]:
        """(c,) number of handles of each component: (2 − χ − boundary loops) / 2.

        Raises
        ------
        InvalidInput
            ``invalid_mesh`` for a mesh that is not manifold or not oriented, for which the genus has no meaning.
        """
        if not self.manifold:
            raise InvalidInput(
                "invalid_mesh",
                f"The genus needs a manifold mesh, but {len(self.nonmanifold_edges)} edges and "
                f"{len(self.nonmanifold_vertices)} vertices are not manifold and {len(self.degenerate_faces)} faces "
                "are degenerate.",
                "Repair the mesh first.",
            )
        if not self.oriented:
            raise InvalidInput(
                "invalid_mesh",
                f"The genus needs an oriented mesh, but along {int((np.abs(self._edge_balance) > 1).sum())} edges "
                "both faces run the same way.",
                "Orient the mesh first.",
            )
        starts = np.array([loop[0] for loop in self.boundary_loops], dtype=np.int64)
        loops = np.bincount(self.vertex_components[starts], minlength=self.component_count)
        return (2 - self.euler_characteristics - loops) // 2

"""From transformations of faces back to vertices: Algorithm 2 of section 5.4 (Eq. 5.5–5.9).

Each face wants to move by its own matrix, and neighbours must keep their common vertices. Eq. 5.7 asks for the vertices
whose transformations come closest to the given ones; the fourth vertices are free unknowns of it, and eliminating them
leaves a Laplace-like system in the true vertices alone: minimise Σ_f w_f ‖(S_f − T_f) P_f‖² with P_f the projection on
the face's plane in the key frame. Its matrix depends on the key frame only, so that it is factorised once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import SuperLU, splu

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import IntArray
from shapery_geometry.topology import Topology
from shapery_motion.gradient import _deformation_kernels as kernels
from shapery_motion.gradient.deformation import FaceFrames, FloatArray

Weighting = Literal["uniform", "area"]


@dataclass(frozen=True, eq=False)
class Gluing:
    """The system of one key frame.

    Parameters
    ----------
    source
        The faces of the key frame; degenerate ones take no part.
    vertex_count
        Number n of vertices.
    anchors : (a,) int32
        Vertices whose positions are given in every frame. Each part of the mesh needs one; see `choose_anchors`.
    weighting
        Of the faces in Eq. 5.7: ``uniform`` as in the text, or by their ``area`` in the key frame, which makes the
        matrix the cotangent Laplacian. Errors are alike; but needles, whose rows grow as 1/height², cost the uniform
        system five more digits (chickenCrossing, all faces known: exact to 2e-5 of an edge, by area to 4e-10).

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where a part of the mesh has no anchor.
    """

    source: FaceFrames
    vertex_count: int
    anchors: IntArray
    weighting: Weighting = "area"

    def __post_init__(self) -> None:
        labels = glued_parts(self.source, self.vertex_count)
        held = np.zeros(labels.max(initial=-1) + 1, dtype=bool)
        held[labels[self.anchors]] = True
        if not held.all():
            vertex = int(np.flatnonzero(~held[labels])[0])
            raise InvalidInput("invalid_mesh", f"The part of the mesh with vertex {vertex} has no anchor.")

    @cached_property
    def _hats(self) -> FloatArray:
        """(m, 3, 3) the weighted gradient of each corner's hat function on each face."""
        first, second = self.source.inverse[:, 0], self.source.inverse[:, 1]
        hats = np.stack((-first - second, first, second), axis=1)
        return np.ascontiguousarray(hats * self._weights[:, None, None])

    @cached_property
    def _weights(self) -> FloatArray:
        if self.weighting == "uniform":
            return self.source.solid.astype(np.float64)
        a, b = self.source.columns[:, :, 0], self.source.columns[:, :, 1]
        areas = 0.5 * np.linalg.norm(np.cross(a, b), axis=1) * self.source.solid
        # of mean 1, so that the matrix has no unit
        total = float(areas.sum())
        return np.asarray(areas * (len(areas) / total if total > 0 else 1.0))

    @cached_property
    def _free(self) -> NDArray[np.int64]:
        held = np.zeros(self.vertex_count, dtype=bool)
        held[self.anchors] = True
        return np.flatnonzero(~held)

    @cached_property
    def _system(self) -> tuple[SuperLU | None, csc_array[np.float64]]:
        """The factorised block of the free vertices, and the block that couples them with the anchors."""
        n, faces = self.vertex_count, self.source.faces
        first, second = self.source.inverse[:, 0], self.source.inverse[:, 1]
        plain = np.stack((-first - second, first, second), axis=1)
        values = np.einsum("fik,fjk->fij", self._hats, plain)
        rows = np.repeat(faces, 3, axis=1).ravel()
        columns = np.tile(faces, (1, 3)).ravel()
        matrix = coo_array((values.ravel(), (rows, columns)), shape=(n, n)).tocsc()
        block = matrix[:, self._free].tocsr()
        coupling = matrix[:, self.anchors].tocsr()[self._free].tocsc()
        if not len(self._free):
            return None, coupling
        # The matrix is symmetric and positive definite: a symmetric ordering and pivots from the diagonal keep it so.
        factor = splu(
            block[self._free].tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        return factor, coupling

    def factorise(self) -> Gluing:
        """Do now what the first `solve` would do, and return this."""
        _ = self._system
        return self

    def solve(self, labels: NDArray[Any], matrices: FloatArray, anchor_positions: NDArray[Any]) -> FloatArray:
        """Return the vertices (n, 3) of a predicted frame.

        Parameters
        ----------
        labels : (m,) integers
            For each face the number of its matrix.
        matrices : (k, 3, 3)
            The transformation of each cluster.
        anchor_positions : (a, 3)
            Where the anchors are in this frame.
        """
        held = np.asarray(anchor_positions, dtype=np.float64)
        right = np.empty((self.vertex_count, 3))
        kernels.divergence(self.source.faces, self._hats, labels, np.ascontiguousarray(matrices), right)
        factor, coupling = self._system
        result = np.empty((self.vertex_count, 3))
        result[self.anchors] = held
        if factor is not None:
            result[self._free] = factor.solve(right[self._free] - coupling @ held)
        return result


def glued_parts(source: FaceFrames, vertex_count: int) -> NDArray[np.int64]:
    """(n,) number of the part each vertex belongs to, through faces that are not degenerate.

    A vertex of degenerate faces only, or of none, is a part of its own.
    """
    faces = source.faces[source.solid]
    ones = np.ones(2 * len(faces), dtype=np.int8)
    ends = (np.concatenate((faces[:, 0], faces[:, 0])), np.concatenate((faces[:, 1], faces[:, 2])))
    graph = coo_array((ones, ends), shape=(vertex_count, vertex_count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def choose_anchors(
    source: FaceFrames,
    vertices: NDArray[Any],
    *,
    boundary: int = 8,
    spread: int = 0,
    topology: Topology | None = None,
) -> IntArray:
    """Choose the vertices whose positions are stored with every predicted frame.

    Parameters
    ----------
    source
        The faces of the key frame.
    vertices : (n, 3)
        Its vertices.
    boundary
        How many anchors a part with an open boundary gets along it, evenly. The text asks for more than one.
    spread
        How many anchors are spread over the whole mesh besides, each as far from all others as can be. The text has
        none; they stop the drift that the gluing adds up from the errors of the transformations.
    topology
        Of the faces, where it is known already.

    Returns
    -------
    (a,) int32
        First those that each part needs (the vertex nearest to its centre, those along its boundary), sorted; then the
        spread ones, each the farthest from all before it.
    """
    points = np.asarray(vertices, dtype=np.float64)
    labels = glued_parts(source, len(points))
    count = int(labels.max(initial=-1)) + 1
    sizes = np.maximum(np.bincount(labels, minlength=count), 1)
    centres = np.stack([np.bincount(labels, points[:, axis], minlength=count) / sizes for axis in range(3)], axis=1)
    distance = np.linalg.norm(points - centres[labels], axis=1)
    order = np.lexsort((distance, labels))
    chosen = set(order[np.unique(labels[order], return_index=True)[1]].tolist())
    if boundary > 1:
        chosen |= _along_boundaries(topology or Topology(len(points), source.faces), labels, boundary)
    return _spread_out(points, np.array(sorted(chosen), dtype=np.int32), spread)


def _along_boundaries(topology: Topology, labels: NDArray[np.int64], count: int) -> set[int]:
    """Return about `count` vertices along the boundary of each part, evenly over the length of its loops."""
    by_part: dict[int, list[int]] = {}
    for loop in topology.boundary_loops:
        for vertex in loop.tolist():
            by_part.setdefault(int(labels[vertex]), []).append(vertex)
    chosen: set[int] = set()
    for path in by_part.values():
        take = min(count, max(len(path) // 4, 1))
        chosen |= {path[(k * len(path)) // take] for k in range(take)}
    return chosen


def _spread_out(points: FloatArray, anchors: IntArray, count: int) -> IntArray:
    """Add `count` vertices, each the farthest from all that were chosen before it."""
    if count <= 0 or not len(points):
        return anchors
    nearest = np.full(len(points), np.inf)
    for vertex in anchors:
        np.minimum(nearest, ((points - points[vertex]) ** 2).sum(axis=1), out=nearest)
    chosen = anchors.tolist()
    for _ in range(count):
        farthest = int(nearest.argmax())
        if not nearest[farthest] > 0:
            break
        chosen.append(farthest)
        np.minimum(nearest, ((points - points[farthest]) ** 2).sum(axis=1), out=nearest)
    return np.array(chosen, dtype=np.int32)

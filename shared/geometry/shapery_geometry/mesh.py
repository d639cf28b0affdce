"""Triangle meshes: the one representation of a surface that all parts of Shapery pass around.

Vertices are float64 (RAS millimetres for surfaces from volumes, model units for others), faces are int32 indices in
counter-clockwise order seen from outside. A mesh never changes: its arrays are read-only copies, so what was computed
once stays true. What is derived from the connectivity alone lies in `Topology`, which meshes of one sequence can share.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.topology import Topology

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True, eq=False, init=False)
class TriangleMesh:
    """A triangle mesh in space.

    Parameters
    ----------
    vertices : (n, 3) float64
        Points, RAS mm or model units. Converted and copied.
    faces : (m, 3) int32
        Vertex indices from 0, counter-clockwise seen from outside. Converted and copied.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where a shape is wrong, a coordinate is not finite or an index lies outside the vertices.

    Notes
    -----
    Nothing else is demanded: degenerate, duplicate and non-manifold faces are allowed, and told by
    `shapery_geometry.repair.mesh_report`. Meshes compare by identity; use `same_as` for equality of content.
    """

    vertices: FloatArray
    faces: IntArray

    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        points = checked_vertices(vertices)
        object.__setattr__(self, "vertices", points)
        object.__setattr__(self, "faces", checked_faces(faces, len(points)))

    def __repr__(self) -> str:
        return f"TriangleMesh({len(self.vertices)} vertices, {len(self.faces)} faces)"

    def same_as(self, other: TriangleMesh) -> bool:
        """Whether `other` has bitwise equal vertices and faces in the same order."""
        return np.array_equal(self.vertices, other.vertices) and np.array_equal(self.faces, other.faces)

    def with_vertices(self, vertices: ArrayLike) -> TriangleMesh:
        """Return the mesh with the same faces over other points, sharing what is known of the connectivity.

        Raises
        ------
        InvalidInput
            ``invalid_mesh`` where the number of points differs.
        """
        points = checked_vertices(vertices)
        if len(points) != len(self.vertices):
            raise InvalidInput(
                "invalid_mesh", f"The mesh has {len(self.vertices)} vertices, but {len(points)} are given."
            )
        mesh = object.__new__(TriangleMesh)
        object.__setattr__(mesh, "vertices", points)
        object.__setattr__(mesh, "faces", self.faces)
        if "topology" in self.__dict__:
            mesh.__dict__["topology"] = self.topology
        return mesh

    def flipped(self) -> TriangleMesh:
        """Return the mesh with every face turned over."""
        return TriangleMesh(self.vertices, self.faces[:, ::-1])

    @cached_property
    def topology(self) -> Topology:
        """Edges, boundary, components and all else that does not depend on where the vertices are."""
        return Topology(len(self.vertices), self.faces)

    @cached_property
    def corners(self) -> FloatArray:
        """(m, 3, 3) points of each face's three corners."""
        return self.vertices[self.faces]

    @cached_property
    def face_cross(self) -> FloatArray:
        """(m, 3) cross product of two sides of each face: its normal times twice its area."""
        a, b, c = self.corners[:, 0], self.corners[:, 1], self.corners[:, 2]
        return np.cross(b - a, c - a)

    @cached_property
    def face_areas(self) -> FloatArray:
        """(m,) area of each face, in the square of the vertices' unit."""
        return 0.5 * np.asarray(np.sqrt(np.einsum("ij,ij->i", self.face_cross, self.face_cross)))

    @cached_property
    def face_normals(self) -> FloatArray:
        """(m, 3) unit normal of each face; zero where the face has no area."""
        return _normalised(self.face_cross)

    @cached_property
    def vertex_normals(self) -> FloatArray:
        """(n, 3) unit normals, each face weighted by its angle at the vertex; zero where no face has an area.

        References
        ----------
        G. Thürmer, C. A. Wüthrich, Computing vertex normals from polygonal facets, J. Graphics Tools 3(1), 1998,
        doi:10.1080/10867651.1998.10487487.
        """
        weighted = self.corner_angles[:, :, None] * self.face_normals[:, None, :]
        sums = np.zeros_like(self.vertices)
        flat = self.faces.ravel()
        for axis in range(3):
            sums[:, axis] = np.bincount(flat, weights=weighted[:, :, axis].ravel(), minlength=len(self.vertices))
        return _normalised(sums)

    @cached_property
    def corner_angles(self) -> FloatArray:
        """(m, 3) angle in radians of each face at each of its corners; zero at a side of no length."""
        p = self.corners
        angles = np.empty((len(p), 3))
        for k in range(3):
            u = p[:, (k + 1) % 3] - p[:, k]
            v = p[:, (k + 2) % 3] - p[:, k]
            # atan2 keeps its precision for needles, where arccos of the cosine loses half of the digits
            angles[:, k] = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
        return angles

    @cached_property
    def area(self) -> float:
        """Sum of the faces' areas."""
        return float(self.face_areas.sum())

    @cached_property
    def volume(self) -> float:
        """Signed volume by the divergence theorem: positive where faces look outwards.

        It means something for closed and oriented meshes only; parts that overlap count more than once.
        """
        if not len(self.faces):
            return 0.0
        # about the centre, so that a mesh far from the origin loses no digits
        p = self.corners - self.vertices[self.faces[0, 0]]
        return float(np.einsum("ij,ij->", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6.0)

    @cached_property
    def centroid(self) -> FloatArray:
        """(3,) centre of the surface: the mean over faces weighted by area; of the vertices where it has no area."""
        if self.area > 0:
            return np.asarray(self.face_areas @ self.corners.mean(axis=1) / self.area)
        if not len(self.vertices):
            raise InvalidInput("invalid_mesh", "A mesh of no vertices has no centre.")
        return np.asarray(self.vertices.mean(axis=0))

    @cached_property
    def bounding_box(self) -> FloatArray:
        """(2, 3) least and largest coordinates over all vertices, whether a face uses them or not."""
        if not len(self.vertices):
            raise InvalidInput("invalid_mesh", "A mesh of no vertices has no bounding box.")
        return np.stack((self.vertices.min(axis=0), self.vertices.max(axis=0)))

    @cached_property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal."""
        low, high = self.bounding_box
        return float(np.linalg.norm(high - low))

    @cached_property
    def edge_lengths(self) -> FloatArray:
        """(e,) length of each of `edges`."""
        ends = self.vertices[self.edges]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

    @property
    def edges(self) -> IntArray:
        """(e, 2) the undirected edges; see `Topology.edges`."""
        return self.topology.edges

    @property
    def boundary_edges(self) -> IntArray:
        """(b, 2) the edges of one face, directed as in it; see `Topology.boundary_edges`."""
        return self.topology.boundary_edges

    @property
    def closed(self) -> bool:
        """Whether the surface has no border; see `Topology.closed`."""
        return self.topology.closed

    @property
    def manifold(self) -> bool:
        """Whether every point has a disk or half disk around it; see `Topology.manifold`."""
        return self.topology.manifold

    @property
    def oriented(self) -> bool:
        """Whether neighbouring faces agree on which side is out; see `Topology.oriented`."""
        return self.topology.oriented

    @property
    def euler_characteristic(self) -> int:
        """Vertices in use − edges + faces."""
        return self.topology.euler_characteristic

    @property
    def component_count(self) -> int:
        """Number of connected parts; see `Topology.component_count`."""
        return self.topology.component_count

    @property
    def genus(self) -> int:
        """Number of handles over all components; see `Topology.genus_per_component`."""
        return int(self.topology.genus_per_component.sum())


def icosphere(center: ArrayLike = (0.0, 0.0, 0.0), radius: float = 1.0, subdivisions: int = 3) -> TriangleMesh:
    """Return a sphere of nearly equal triangles: an icosahedron whose faces are split in four, again and again.

    Parameters
    ----------
    center : (3,)
        In the unit of the result's vertices.
    radius
        Distance of every vertex from `center`.
    subdivisions
        How often to split: 20 · 4^subdivisions faces, 10 · 4^subdivisions + 2 vertices.

    Raises
    ------
    ValueError
        For a radius that is not positive, or more than 9 subdivisions (5 million faces).
    """
    if not (np.isfinite(radius) and radius > 0):
        raise ValueError(f"the radius must be positive, not {radius}")
    if not 0 <= subdivisions <= 9:
        raise ValueError(f"subdivisions must lie in 0..9, not {subdivisions}")
    g = (1 + 5**0.5) / 2
    points = np.array(
        [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g],
         [0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]
    )  # fmt: skip
    faces = np.array(
        [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6],
         [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10],
         [8, 6, 7], [9, 8, 1]],
        dtype=np.int32,
    )  # fmt: skip
    points = _normalised(points)
    for _ in range(subdivisions):
        topology = Topology(len(points), faces)
        middle = topology.face_edges + len(points)
        points = np.concatenate((points, _normalised(points[topology.edges].sum(axis=1))))
        (a, b, c), (ab, bc, ca) = faces.T, middle.T
        quarters = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        faces = np.concatenate([np.stack(q, axis=1) for q in quarters]).astype(np.int32)
    return TriangleMesh(np.asarray(center, dtype=np.float64) + radius * points, faces)


def checked_vertices(vertices: ArrayLike) -> FloatArray:
    """Return a read-only (n, 3) float64 copy, or raise ``invalid_mesh`` naming the first vertex that is not finite."""
    with np.errstate(invalid="ignore"):
        points = np.array(vertices, dtype=np.float64, order="C")
    if points.size == 0:
        points = points.reshape(0, 3)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidInput("invalid_mesh", f"Vertices must have the shape (n, 3), not {points.shape}.")
    if not np.isfinite(points).all():
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        raise InvalidInput(
            "invalid_mesh",
            f"{len(bad)} of {len(points)} vertices have coordinates that are not finite; the first is vertex {bad[0]}: "
            f"({', '.join(f'{x:g}' for x in points[bad[0]])}).",
            "Remove or correct these vertices.",
        )
    points.setflags(write=False)
    return points


def checked_faces(faces: ArrayLike, vertex_count: int) -> IntArray:
    """Return a read-only (m, 3) int32 copy, or raise ``invalid_mesh`` naming the first index out of range."""
    given = np.asarray(faces)
    if given.size == 0:
        given = np.zeros((0, 3), dtype=np.int32)
    if given.ndim != 2 or given.shape[1] != 3:
        raise InvalidInput("invalid_mesh", f"Faces must have the shape (m, 3), not {given.shape}.")
    if not np.issubdtype(given.dtype, np.integer):
        raise InvalidInput("invalid_mesh", f"Faces must be whole numbers, not {given.dtype}.")
    if vertex_count > np.iinfo(np.int32).max:
        raise InvalidInput("invalid_mesh", f"A mesh can have at most 2147483647 vertices, not {vertex_count}.")
    if given.size and (given.min() < 0 or given.max() >= vertex_count):
        bad = np.flatnonzero(((given < 0) | (given >= vertex_count)).any(axis=1))
        raise InvalidInput(
            "invalid_mesh",
            f"{len(bad)} of {len(given)} faces name vertices that do not exist; the first is face {bad[0]} "
            f"{tuple(given[bad[0]].tolist())}, and vertices run from 0 to {vertex_count - 1}.",
        )
    result = np.array(given, dtype=np.int32, order="C")
    result.setflags(write=False)
    return result


def _normalised(vectors: FloatArray) -> FloatArray:
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return np.asarray(vectors / np.where(lengths > 0, lengths, 1.0)[:, None])

"""A Laplacian that bears bad triangles: intrinsic Delaunay triangulation of mollified lengths.

References
----------
M. Fisher, B. Springborn, P. Schröder, A. I. Bobenko, An algorithm for the construction of intrinsic Delaunay
triangulations, Computing 81, 2007, doi:10.1007/s00607-007-0249-8.
N. Sharp, K. Crane, A Laplacian for nonmanifold triangle meshes, Computer Graphics Forum 39(5), 2020,
doi:10.1111/cgf.14069 (for the mollification; where an edge has more than two faces we leave it as it is, instead of
gluing a second cover).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators import _intrinsic_kernels as kernels

MOLLIFICATION = 1e-5
"""By how much every triangle inequality holds at least, as a share of the mean length of sides."""


@dataclass(frozen=True, eq=False)
class IntrinsicTriangulation:
    """Triangles known by the lengths of their sides, over the vertices of a mesh.

    Attributes
    ----------
    vertex_count
        Of the mesh.
    faces : (m, 3) int32
        Vertices; a side may join a vertex to itself.
    lengths : (m, 3) float64
        Length of the side from corner k to corner k + 1.
    """

    vertex_count: int
    faces: NDArray[np.int32]
    lengths: NDArray[np.float64]

    @property
    def face_areas(self) -> NDArray[np.float64]:
        """(m,) by Heron's formula."""
        return np.asarray(kernels.areas(self.lengths))

    def vertex_areas(self) -> NDArray[np.float64]:
        """(n,) a third of each face to each of its corners."""
        shares = np.repeat(self.face_areas / 3, 3)
        return np.bincount(self.faces.ravel(), weights=shares, minlength=self.vertex_count).astype(np.float64)

    def laplacian(self) -> csr_array[np.float64]:
        """Return the (n, n) stiffness matrix, positive semidefinite, as `cotangent_laplacian` defines it."""
        half = kernels.half_cotangents(self.lengths).ravel()
        i, j = self.faces.ravel(), np.roll(self.faces, -1, axis=1).ravel()
        rows, columns = np.concatenate((i, j, i, j)), np.concatenate((j, i, i, j))
        values = np.concatenate((-half, -half, half, half))
        return coo_array((values, (rows, columns)), shape=(self.vertex_count, self.vertex_count)).tocsr()


def intrinsic_delaunay(mesh: TriangleMesh) -> IntrinsicTriangulation:
    """Return the intrinsic Delaunay triangulation of a surface.

    Every side is lengthened by the same small amount, so that no triangle is degenerate, and edges of exactly two faces
    that agree on their orientation are flipped until the angles opposite them sum to at most π. The surface stays the
    same, and the weights of its Laplacian are not negative on such edges.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` for a mesh without area.
    """
    if not mesh.area > 0:
        raise InvalidInput("invalid_mesh", f"The mesh of {len(mesh.faces)} faces has no area.")
    points = mesh.corners
    lengths = np.linalg.norm(np.roll(points, -1, axis=1) - points, axis=2)
    slack = np.min([np.roll(lengths, -k, 1) @ [-1.0, 1.0, 1.0] for k in range(3)], axis=0)
    lengths += max(0.0, MOLLIFICATION * float(lengths.mean()) - float(slack.min()))
    faces = np.array(mesh.faces)
    kernels.flip_to_delaunay(faces, lengths, kernels.find_twins(faces), 60 * len(faces))
    return IntrinsicTriangulation(len(mesh.vertices), faces, lengths)

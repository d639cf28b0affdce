"""Mean and Gaussian curvature of a mesh at its vertices.

References
----------
M. Meyer, M. Desbrun, P. Schröder, A. H. Barr, Discrete differential-geometry operators for triangulated 2-manifolds,
Visualization and Mathematics III, 2003, doi:10.1007/978-3-662-05105-4_2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.laplacian import cotangent_laplacian, vertex_areas


def angle_defects(mesh: TriangleMesh) -> NDArray[np.float64]:
    """Return what the angles around each vertex lack to a full turn, or on the boundary to half a turn.

    Returns
    -------
    (n,) float64
        Radians; zero where a vertex has no face. For a manifold mesh the sum is 2π times the Euler characteristic
        (Gauss–Bonnet).
    """
    sums = np.bincount(mesh.faces.ravel(), weights=mesh.corner_angles.ravel(), minlength=len(mesh.vertices))
    full = np.where(_on_boundary(mesh), np.pi, 2 * np.pi)
    return np.where(mesh.topology.referenced, full - sums, 0.0)


def gaussian_curvature(mesh: TriangleMesh) -> NDArray[np.float64]:
    """Return the angle defect over the mixed area of each vertex.

    Returns
    -------
    (n,) float64
        One over the square of the mesh's unit: 1 / r² on a sphere. NaN on the boundary, where the defect measures how
        the boundary bends and not the surface, and where a vertex has no area.
    """
    return _density(mesh, angle_defects(mesh))


def mean_curvature(mesh: TriangleMesh) -> NDArray[np.float64]:
    """Return H, the mean of the two principal curvatures, with the sign that the normals give it.

    Returns
    -------
    (n,) float64
        One over the mesh's unit: 1 / r on a sphere whose faces look outwards, −1 / r where they look inwards. NaN on
        the boundary and where a vertex has no area.

    Notes
    -----
    L x = 2 A H n with the cotangent Laplacian L, the positions x and the mixed areas A.
    """
    bending = np.asarray(cotangent_laplacian(mesh) @ mesh.vertices, dtype=np.float64)
    normal_part = np.einsum("ij,ij->i", bending, mesh.vertex_normals)
    return _density(mesh, normal_part / 2)


def principal_curvatures(mesh: TriangleMesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the smaller and the larger principal curvature, H ∓ √(H² − K); NaN as in `mean_curvature`.

    Where noise makes H² − K negative, which no smooth surface has, both are H.
    """
    mean, gaussian = mean_curvature(mesh), gaussian_curvature(mesh)
    spread = np.sqrt(np.maximum(mean**2 - gaussian, 0.0))
    return mean - spread, mean + spread


def _density(mesh: TriangleMesh, values: NDArray[np.float64]) -> NDArray[np.float64]:
    areas = vertex_areas(mesh, "mixed")
    inner = (areas > 0) & ~_on_boundary(mesh)
    return np.where(inner, values / np.where(inner, areas, 1.0), np.nan)


def _on_boundary(mesh: TriangleMesh) -> NDArray[np.bool_]:
    boundary = np.zeros(len(mesh.vertices), dtype=bool)
    boundary[mesh.boundary_edges.ravel()] = True
    return boundary

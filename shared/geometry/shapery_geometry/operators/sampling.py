"""Points spread evenly over a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Points on a mesh and where they are on it."""

    points: NDArray[np.float64]
    """(k, 3) in the unit of the mesh."""
    faces: NDArray[np.int32]
    """(k,) the face of each point."""
    barycentric: NDArray[np.float64]
    """(k, 3) weights of the face's corners, summing to 1."""


def sample_surface(mesh: TriangleMesh, count: int, rng: np.random.Generator) -> SurfaceSamples:
    """Draw points with equal density per area.

    Parameters
    ----------
    mesh
        Some of its faces must have an area.
    count
        How many points.
    rng
        The same generator state gives the same points.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` for a surface without area.

    Notes
    -----
    The faces are drawn by one random offset and equal steps over the cumulative area, so each face gets its expected
    number of points to within one.
    """
    if not mesh.area > 0:
        raise InvalidInput("invalid_mesh", f"The mesh of {len(mesh.faces)} faces has no area to draw points from.")
    cumulative = np.cumsum(mesh.face_areas)
    steps = (np.arange(count) + rng.random()) * (cumulative[-1] / max(count, 1))
    faces = np.minimum(np.searchsorted(cumulative, steps, side="right"), len(mesh.faces) - 1).astype(np.int32)
    # the square root makes the density equal (R. Osada et al., Shape distributions, ACM TOG 21, 2002)
    root, along = np.sqrt(rng.random(count)), rng.random(count)
    barycentric = np.stack((1 - root, root * (1 - along), root * along), axis=1)
    points = np.einsum("ik,ikj->ij", barycentric, mesh.corners[faces])
    return SurfaceSamples(points, faces, barycentric)

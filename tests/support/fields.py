"""Fields whose level sets are known, and what must hold of a surface that a flow hands out."""

from __future__ import annotations

import numpy as np

from shapery_geometry.intersections import self_intersections
from shapery_segmentation.flow import FlowResult


def grid(n: int, spacing: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, n, n, 3) in mm around the origin and the affine of their grid."""
    affine = np.diag([spacing, spacing, spacing, 1.0])
    affine[:3, 3] = -0.5 * spacing * (n - 1)
    index = np.stack(np.meshgrid(*(np.arange(n),) * 3, indexing="ij"), axis=-1)
    return index * spacing + affine[:3, 3], affine


def field_of(distance: np.ndarray, slope: float = 1.5) -> np.ndarray:
    """Return a field that is 0 on the surface and rises inwards, like an enhancing object behind a smooth border."""
    return np.clip(-slope * distance, -6.0, 6.0).astype(np.float32)


def ball(points: np.ndarray, center: tuple[float, float, float], radius: float) -> np.ndarray:
    """Return the signed distance to a ball, negative inside."""
    return np.asarray(np.linalg.norm(points - center, axis=-1) - radius)


def assert_sound(result: FlowResult, genus: int = 0, parts: int = 1) -> None:
    """Check what is promised of every surface that is handed out."""
    mesh = result.mesh
    assert mesh.closed
    assert mesh.manifold
    assert mesh.oriented
    assert mesh.volume > 0
    assert mesh.component_count == parts
    assert mesh.euler_characteristic == 2 * parts - 2 * genus
    assert len(self_intersections(mesh)) == 0
    # Nothing is lost when it is stored in single precision.
    assert np.array_equal(mesh.vertices, mesh.vertices.astype(np.float32))

"""Which voxels belong to a vessel, from its surface."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_geometry.mask_metrics import intersection_over_union
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.vessels.fit import half_covered

SAMPLES = 8


def half_of_a_ball(center: np.ndarray, radius: float, grid: Volume) -> np.ndarray:
    """Return the voxels of which at least half lies in a ball, counted at points."""
    fine = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    covered = np.zeros(grid.shape)
    index = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing="ij"), axis=-1)
    for shift in np.stack(np.meshgrid(fine, fine, fine), axis=-1).reshape(-1, 3):
        covered += np.linalg.norm(grid.to_world(index + shift) - center, axis=-1) < radius
    return np.asarray(covered >= 0.5 * SAMPLES**3)


@pytest.mark.parametrize("spacing", [(1.0, 1.0, 1.0), (0.9, 1.1, 1.0)])
def test_half_a_voxel_counts_as_a_voxel(spacing: tuple[float, float, float]) -> None:
    grid = Volume(np.zeros((9, 9, 9), np.uint8), np.diag([*spacing, 1.0]))
    both: list[tuple[float, float]] = []
    for number in range(12):
        rng = np.random.default_rng(number)
        center, radius = 4.0 + rng.uniform(-0.5, 0.5, 3), 1.8
        turned = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turned *= np.sign(np.linalg.det(turned))
        # Edges of half the radius, as vessels have them.
        ball = icosphere((0.0, 0.0, 0.0), radius, 1)
        surface = TriangleMesh(ball.vertices @ turned.T + center, ball.faces)
        truth = half_of_a_ball(center, radius, grid)
        both.append(
            (
                intersection_over_union(half_covered(surface, grid), truth),
                intersection_over_union(rasterize(surface, grid), truth),
            )
        )
    ours, plain = np.mean(both, axis=0)
    assert ours > 0.97
    assert ours > plain + 0.02


def test_a_flat_surface_is_where_it_is() -> None:
    ball = icosphere((20.0, 20.0, 20.0), 15.0, 4)
    grid = Volume(np.zeros((40, 40, 40), np.uint8), np.eye(4))
    assert intersection_over_union(half_covered(ball, grid), rasterize(ball, grid)) > 0.99

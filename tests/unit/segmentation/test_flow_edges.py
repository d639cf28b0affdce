"""The edge indicator, and the flow of Eq. 3.1 that it stops."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import icosphere
from shapery_segmentation.flow import NormalFlowParams, normal_flow
from shapery_segmentation.flow.edges import EdgeIndicator

PARAMS = NormalFlowParams(model="gradient", edge_lengths=(1.5,))


def blob(n: int = 40, radius: float = 9.0, spacing: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return intensities of a ball of 300 in 100, their affine, and the points."""
    affine = np.diag([spacing, spacing, spacing, 1.0])
    affine[:3, 3] = -0.5 * spacing * (n - 1)
    index = np.stack(np.meshgrid(*(np.arange(n),) * 3, indexing="ij"), axis=-1)
    points = index * spacing + affine[:3, 3]
    distance = np.linalg.norm(points, axis=-1) - radius
    return (100.0 + 200.0 / (1.0 + np.exp(2.0 * distance))).astype(np.float32), affine, points


def test_the_indicator_is_low_at_the_edge_and_one_elsewhere() -> None:
    image, affine, points = blob()
    edges = EdgeIndicator(image, affine, 1.0, 98.0)
    edges.follow(np.array([[-9.0, -9, -9], [9.0, 9, 9]]))
    assert edges.values.dtype == np.float32
    index = np.linalg.inv(affine)[:3, 3] - edges.inverse[:, 3]
    low = np.rint(index).astype(int)
    radius = np.linalg.norm(points, axis=-1)[
        tuple(slice(a, a + n) for a, n in zip(low, edges.values.shape, strict=True))
    ]
    assert edges.values[np.abs(radius - 9.0) < 0.3].max() < 0.15
    assert edges.values[radius < 4.0].min() > 0.95
    assert edges.values[radius > 15.0].min() > 0.95


def test_the_gradient_is_taken_in_mm() -> None:
    # A ramp of 3 units per mm along x, on an oblique, anisotropic grid: |∇| is 3 everywhere, whatever the grid.
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    affine = np.eye(4)
    affine[:3, :3] = turn * (0.5, 1.0, 3.0)
    index = np.stack(np.meshgrid(np.arange(40), np.arange(30), np.arange(14), indexing="ij"), axis=-1)
    image = (3.0 * (index @ affine[:3, :3].T)[..., 0]).astype(np.float32)
    centre = affine[:3, :3] @ (20, 15, 7)
    edges = EdgeIndicator(image, affine, 0.0, 50.0)
    edges.follow(centre[None])
    assert edges._unit == pytest.approx(3.0, rel=1e-4)
    assert np.allclose(edges.values, 0.1, atol=1e-3)


def test_intensities_in_other_units_give_the_same_indicator() -> None:
    image, affine, _ = blob()
    points = np.array([[-9.0, -9, -9], [9.0, 9, 9]])
    first, second = EdgeIndicator(image, affine, 1.0, 98.0), EdgeIndicator(image * 37.0 - 500.0, affine, 1.0, 98.0)
    first.follow(points)
    second.follow(points)
    assert np.allclose(first.values, second.values, atol=1e-3)


def test_the_box_follows_and_keeps_its_unit() -> None:
    image, affine, _ = blob(n=70, radius=20.0)
    edges = EdgeIndicator(image, affine, 1.0, 98.0)
    edges.follow(np.zeros((1, 3)))
    small, unit = edges.values.shape, edges._unit
    assert max(small) < 30
    edges.follow(np.array([[1.0, 0, 0]]))
    assert edges.values.shape == small
    edges.follow(np.array([[20.0, 0, 0]]))
    assert edges.values.shape[0] > small[0]
    assert edges._unit == unit


def test_a_constant_image_has_no_edges() -> None:
    edges = EdgeIndicator(np.full((20, 20, 20), 7.0, np.float32), np.eye(4), 1.0, 90.0)
    edges.follow(np.full((1, 3), 10.0))
    assert (edges.values == 1.0).all()


@pytest.mark.parametrize(("balloon", "radius"), [(0.3, 4.0), (-0.3, 15.0)], ids=["grows", "shrinks"])
def test_eq_3_1_stops_at_the_edge_from_either_side(balloon: float, radius: float) -> None:
    image, affine, _ = blob()
    params = NormalFlowParams(model="gradient", edge_lengths=(1.5, 1.0), balloon=balloon)
    result = normal_flow(image, None, affine, icosphere(radius=radius, subdivisions=3), params, threshold=0.0)
    assert result.converged
    assert result.mesh.closed
    assert result.mesh.genus == 0
    assert len(self_intersections(result.mesh)) == 0
    radii = np.linalg.norm(result.mesh.vertices, axis=1)
    # A fraction of a voxel, on the side the balloon pushes to.
    assert np.abs(radii - 9.0).max() < 0.7


def test_the_gradient_model_does_not_care_about_brightness() -> None:
    image, affine, _ = blob()
    dark = 400.0 - image
    results = [
        normal_flow(i, None, affine, icosphere(radius=4.0, subdivisions=2), PARAMS, threshold=0.0).mesh.volume
        for i in (image, dark, image * 0.01)
    ]
    assert results[1] == pytest.approx(results[0], rel=0.01)
    assert results[2] == pytest.approx(results[0], rel=0.01)


def test_the_gradient_model_takes_the_gate_too() -> None:
    image, affine, points = blob()
    allowed = points[..., 0] < 3.0
    result = normal_flow(image, allowed, affine, icosphere(radius=3.0, subdivisions=2), PARAMS, threshold=0.0)
    assert result.mesh.vertices[:, 0].max() < 4.2
    assert result.mesh.vertices[:, 0].min() < -8.0

"""Topological balls and their surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from shapery_geometry.intersections import self_intersections
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.seeding.ball import ball_inside, surface_of


def sphere(shape: tuple[int, int, int], radius: float) -> np.ndarray:
    index = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    return np.linalg.norm(index - (np.array(shape) - 1) / 2, axis=-1) <= radius


def shell() -> np.ndarray:
    return sphere((25, 25, 25), 10.2) & ~sphere((25, 25, 25), 6.3)


def torus() -> np.ndarray:
    x, y, z = np.meshgrid(*(np.arange(-14, 15),) * 3, indexing="ij")
    return (np.hypot(x, y) - 9.0) ** 2 + z**2 <= 3.4**2


def noise(seed: int) -> np.ndarray:
    field = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=(24, 22, 26)), 1.2)
    return field > 0


@pytest.mark.parametrize("region", [sphere((15, 15, 15), 5.0), shell(), torus(), noise(1), noise(2), noise(3)])
def test_surface_of_a_ball_has_genus_zero(region: np.ndarray) -> None:
    ball, start = ball_inside(region)
    assert region[tuple(start)]
    assert not (ball & ~region).any()
    mesh = surface_of(ball, np.eye(4))
    assert mesh.closed
    assert mesh.manifold
    assert mesh.oriented
    assert mesh.component_count == 1
    assert mesh.genus == 0
    assert mesh.volume > 0


@pytest.mark.parametrize(("region", "share"), [(sphere((15, 15, 15), 5.0), 1.0), (shell(), 0.9), (torus(), 0.95)])
def test_ball_fills_the_region_but_for_seams(region: np.ndarray, share: float) -> None:
    assert ball_inside(region)[0].sum() >= share * region.sum()


def test_surface_of_any_voxels_is_a_closed_manifold() -> None:
    # Random voxels have every neighbourhood there is, corners and edges that touch included.
    voxels = np.random.default_rng(5).random((12, 13, 11)) < 0.4
    mesh = surface_of(voxels, np.eye(4))
    assert mesh.closed
    assert mesh.manifold
    assert mesh.oriented


@pytest.mark.parametrize("density", [0.15, 0.4, 0.7])
def test_an_even_surface_has_the_topology_of_the_full_one(density: float) -> None:
    rng = np.random.default_rng(6)
    for voxels in (rng.random((12, 13, 11)) < density, noise(5), noise(6)[:9, :9, :9]):
        full, even = surface_of(voxels, np.eye(4)), surface_of(voxels, np.eye(4), even=True)
        assert even.closed
        assert even.manifold
        assert even.oriented
        assert even.euler_characteristic == full.euler_characteristic
        assert even.component_count == full.component_count
        assert len(even.vertices) <= len(full.vertices)


def test_an_even_surface_is_made_of_few_triangles_of_one_size() -> None:
    voxels = sphere((25, 25, 25), 9.0)
    full, even = surface_of(voxels, np.eye(4)), surface_of(voxels, np.eye(4), even=True)
    assert len(even.faces) < 0.4 * len(full.faces)
    assert even.edge_lengths.min() > 0.4
    assert even.edge_lengths.max() < 2.4
    assert len(self_intersections(even)) == 0
    # Between the voxels inside and their neighbours outside, a little nearer to the inside where it is convex.
    radii = np.linalg.norm(even.vertices - 12.0, axis=1)
    assert radii.min() > 8.2
    assert radii.max() < 9.6


@pytest.mark.parametrize("even", [False, True])
def test_the_surface_lies_where_the_level_vanishes(even: bool) -> None:
    index = np.stack(np.meshgrid(*(np.arange(24),) * 3, indexing="ij"), axis=-1)
    level = (8.3 - np.linalg.norm(index - 11.5, axis=-1)).astype(np.float32)
    mesh = surface_of(level > 0, np.eye(4), even=even, level=level)
    radii = np.linalg.norm(mesh.vertices - 11.5, axis=1)
    # It keeps a tenth of the way between two voxels from both.
    assert np.abs(radii - 8.3).max() < 0.1 * np.sqrt(3.0)


def test_surface_encloses_exactly_the_voxels_in_any_frame() -> None:
    voxels = noise(4)
    affine = np.array([[0.0, -1.2, 0.1, 5.0], [0.9, 0.0, 0.0, -7.0], [0.0, 0.2, 2.5, 3.0], [0.0, 0.0, 0.0, 1.0]])
    for matrix in (affine, affine * np.array([-1.0, 1.0, 1.0, 1.0])):
        mesh = surface_of(voxels, matrix)
        assert mesh.volume > 0
        np.testing.assert_array_equal(rasterize(mesh, Volume(voxels, matrix)), voxels)


def test_least_depth_keeps_a_distance_and_never_loses_the_seed() -> None:
    region = sphere((21, 21, 21), 8.0)
    ball, _ = ball_inside(region, least_depth=3.0)
    assert ball.any()
    assert ndimage.distance_transform_edt(region)[ball].min() > 3.0
    assert ball_inside(region, least_depth=50.0)[0].sum() == 1


def test_one_voxel_and_none() -> None:
    single = np.zeros((3, 3, 3), bool)
    single[0, 1, 2] = True
    assert ball_inside(single)[0].sum() == 1
    assert surface_of(single, np.eye(4)).genus == 0
    with pytest.raises(ValueError, match="without voxels"):
        ball_inside(np.zeros((3, 3, 3), bool))

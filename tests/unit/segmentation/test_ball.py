"""Topological balls and their surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

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

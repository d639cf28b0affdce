"""Which voxels belong to a vessel, from its surface."""

from __future__ import annotations

import time

import numpy as np
import pytest
from scipy import ndimage, sparse

from shapery_geometry.intersections import self_intersections
from shapery_geometry.mask_metrics import intersection_over_union
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.phantoms import tube_phantom
from shapery_segmentation.seeding.ball import surface_of
from shapery_segmentation.vessels import _coverage_kernels as kernels
from shapery_segmentation.vessels import segment_vessels
from shapery_segmentation.vessels.fit import _bells, _cotangents, _laplacian, _nearly, _nearly_inverse, half_covered

SAMPLES = 8


def sponge(size: int, share: float) -> np.ndarray:
    """Return the largest piece of where correlated noise is high."""
    noise = ndimage.gaussian_filter(np.random.default_rng(0).standard_normal((size,) * 3), 1.5)
    labels, _ = ndimage.label(noise > np.quantile(noise, 1.0 - share))
    return np.asarray(labels == 1 + np.argmax(np.bincount(labels.ravel())[1:]))


def genus(surface: TriangleMesh) -> int:
    return 1 - (len(surface.vertices) - len(surface.faces) // 2) // 2


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


@pytest.mark.parametrize("low", [(0, 0, 0), (4, 3, 2)])
def test_shares_add_up_to_the_volume_and_agree_with_counted_points(low: tuple[int, int, int]) -> None:
    ball = icosphere((5.2, 4.9, 5.1), 3.0, 3)
    shares = np.zeros((11 - low[0], 11 - low[1], 11 - low[2]), dtype=np.float32)
    kernels.cover(ball.vertices, ball.faces, 4, np.array(low), shares)
    fine = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    index = np.stack(np.meshgrid(*map(np.arange, shares.shape), indexing="ij"), axis=-1) + np.array(low)
    counted = np.zeros(shares.shape)
    for shift in np.stack(np.meshgrid(fine, fine, fine), axis=-1).reshape(-1, 3):
        counted += np.linalg.norm(index + shift - (5.2, 4.9, 5.1), axis=-1) < 3.0
    assert np.abs(shares - counted / SAMPLES**3).max() < 0.1
    if low == (0, 0, 0):
        assert shares.sum() == pytest.approx(ball.volume, rel=5e-3)


def test_columns_that_meet_edges_and_corners_enter_and_leave_once() -> None:
    # An octahedron whose corners and edges lie on the columns.
    points = np.array([(6.125, 4.125, 4.0), (2.125, 4.125, 4.0), (4.125, 6.125, 4.0), (4.125, 2.125, 4.0),
                       (4.125, 4.125, 6.0), (4.125, 4.125, 2.0)])  # fmt: skip
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    shares = np.zeros((9, 9, 9), dtype=np.float32)
    kernels.cover(points, np.array(faces, dtype=np.int32), 4, np.zeros(3, dtype=np.int64), shares)
    assert shares.min() > -1e-6
    assert shares.max() < 1 + 1e-6
    assert np.abs(shares[..., -1]).max() < 1e-6
    assert shares.sum() == pytest.approx(4.0 / 3.0 * 8.0, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("polarity", ["bright", "dark"])
def test_a_wall_that_every_voxel_crosses_is_found_through_the_noise(polarity: str) -> None:
    found = []
    for number in range(11, 14):
        phantom = tube_phantom(
            np.random.default_rng(number),
            radius=1.5,
            bend=5.0,
            polarity=polarity,  # type: ignore[arg-type]
            bias=0.4,
        )
        found.append(intersection_over_union(segment_vessels(phantom.volume).mask, phantom.truth.data == 3))
    assert np.mean(found) > 0.94


@pytest.mark.slow
@pytest.mark.parametrize(("radius", "least"), [(1.5, 0.8), (3.0, 0.91), (5.0, 0.965)])
def test_the_blur_of_a_scanner_moves_no_wall(radius: float, least: float) -> None:
    sharp = tube_phantom(np.random.default_rng(3), (48, 48, 48), radius=radius, snr=1e9)
    noise = np.random.default_rng(5).normal(0.0, np.ptp(sharp.volume.data) / 15.0, sharp.volume.shape)
    seen = ndimage.gaussian_filter(sharp.volume.data, 1.0) + noise
    found = segment_vessels(Volume(seen.astype(np.float32), sharp.volume.affine)).mask
    assert intersection_over_union(found, sharp.truth.data == 3) > least


def test_a_blurred_voxel_shows_what_a_filter_shows() -> None:
    sharp = np.random.default_rng(2).random((9, 11, 10)).astype(np.float32)
    places = np.array([(4, 5, 5), (0, 0, 0), (8, 10, 9), (1, 9, 4)])
    out = np.empty((len(places), 2))
    kernels.blurred(sharp, places, _bells((0.0, 0.7)), out)
    seen = ndimage.gaussian_filter(sharp.astype(np.float64), 0.7, mode="constant", radius=3)
    np.testing.assert_allclose(out[:, 0], sharp[tuple(places.T)], atol=1e-6)
    np.testing.assert_allclose(out[:, 1], seen[tuple(places.T)], atol=1e-4)


def test_what_preconditions_a_round_is_nearly_its_inverse() -> None:
    ball = icosphere((0.0, 0.0, 0.0), 4.0, 3)
    weights, area = _cotangents(ball.vertices, ball.faces)
    matrix = (sparse.diags_array(2.0 * area) + _laplacian(weights)).tocsr()
    solve = _nearly_inverse(matrix)
    inverse = np.stack([solve(unit) for unit in np.eye(len(area))])
    # Symmetric and positive, or conjugate gradients would go astray.
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-12)
    share = np.linalg.eigvals(inverse @ matrix.toarray()).real
    # Chebyshev's bound for eigenvalues from .03 to 2 is .08.
    assert share.min() > 0.91
    assert share.max() < 1.09


def test_a_sponge_takes_the_memory_of_its_surface() -> None:
    surface = surface_of(sponge(44, 0.35), np.eye(4))
    count = len(surface.vertices)
    assert genus(surface) > 100
    weights, area = _cotangents(surface.vertices, surface.faces)
    told, stiff = 100.0 * area, np.full(count, 40.0)
    before = time.process_time()
    nearly = _nearly(weights, area, stiff, told)
    rng = np.random.default_rng(1)
    for _ in range(10):
        nearly.matvec(rng.normal(size=count))
    # Factors of this take minutes.
    assert time.process_time() - before < 10.0


@pytest.mark.slow
def test_a_sponge_that_is_taken_for_vessels_has_a_surface() -> None:
    rng = np.random.default_rng(2)
    inside = sponge(40, 0.24)
    values = 50.0 + 100.0 * ndimage.gaussian_filter(inside.astype(np.float32), 0.5) + rng.normal(0.0, 5.0, inside.shape)
    found = segment_vessels(Volume(values.astype(np.float32), np.eye(4)), polarity="bright")
    assert intersection_over_union(found.mask, inside) > 0.65
    assert genus(found.trees[0].surface) >= 3
    assert len(self_intersections(found.trees[0].surface)) == 0

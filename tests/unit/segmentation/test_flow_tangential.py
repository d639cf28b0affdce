"""The tangential flow and the model selection, on fields with a known border."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shapery_contracts.errors import InvalidInput
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_segmentation.flow.selection import (
    SelectionParams,
    cluster_sizes,
    moving_vertices,
    opened,
    selected_flow,
)
from shapery_segmentation.flow.tangential import (
    TangentialFlowParams,
    TangentialFlowResult,
    seed_triangle,
    tangential_flow,
)

FloatArray = NDArray[np.float64]
Field = NDArray[np.float32]
SIZE = 48


def _points(fine: int = 1) -> FloatArray:
    return np.stack(np.meshgrid(*[(np.arange(SIZE * fine) + 0.5) / fine - SIZE / 2] * 3, indexing="ij"), axis=-1)


AFFINE = np.eye(4)
AFFINE[:3, 3] = 0.5 - SIZE / 2


def _field(distance: FloatArray) -> Field:
    """Return a field that falls from 1 to −1 over two mm of a signed distance, negative inside."""
    return np.clip(-distance, -1.0, 1.0).astype(np.float32)


def _capsule(p: FloatArray, a: tuple[float, ...], b: tuple[float, ...], radius: float) -> FloatArray:
    start, way = np.array(a), np.subtract(b, a)
    t = np.clip(((p - start) @ way) / (way @ way), 0.0, 1.0)
    return np.asarray(np.linalg.norm(p - start - t[..., None] * way, axis=-1) - radius)


def _tube() -> Field:
    return _field(_capsule(_points(), (0, 0, -17), (0, 0, 17), 3.0))


def _fork(fine: int = 1) -> Field:
    p = _points(fine)
    arms = [((0, 0, -18), (0, 0, 0), 3.5), ((0, 0, 0), (11, 2, 16), 2.6), ((0, 0, 0), (-10, -3, 15), 2.2)]
    return _field(np.minimum.reduce([_capsule(p, *arm) for arm in arms]))


def _torus() -> Field:
    p = _points()
    return _field(np.hypot(np.hypot(p[..., 0], p[..., 1]) - 13.0, p[..., 2]) - 4.0)


def _ball() -> Field:
    return _field(np.linalg.norm(_points(), axis=-1) - 12.0)


TUBE_VOLUME = np.pi * 9 * 34 + 36 * np.pi
FORK_VOLUME = float(np.count_nonzero(_fork(2) > 0)) / 8


def _grow(field: Field, point: tuple[float, float, float], edge: float = 1.0) -> TangentialFlowResult:
    seed = seed_triangle(field, AFFINE, point, edge_length=edge)
    assert seed is not None
    return tangential_flow(field, AFFINE, seed, TangentialFlowParams(edge_length=edge))


def _sound(mesh: TriangleMesh) -> None:
    assert mesh.closed
    assert mesh.manifold
    assert mesh.oriented
    assert len(self_intersections(mesh)) == 0


@pytest.mark.parametrize(
    ("make", "point", "euler", "volume"),
    [
        pytest.param(_tube, (0, 0, 0), 2, TUBE_VOLUME, id="tube"),
        pytest.param(_torus, (13, 0, 0), 0, 2 * np.pi**2 * 13 * 16, id="torus"),
        pytest.param(_fork, (0, 0, -9), 2, FORK_VOLUME, id="fork"),
    ],
)
def test_one_triangle_becomes_the_whole_surface(make, point, euler, volume) -> None:  # type: ignore[no-untyped-def]
    field = make()
    result = _grow(field, point)
    _sound(result.mesh)
    assert result.holes == 0
    assert not result.limited
    assert result.mesh.component_count == 1
    assert result.mesh.euler_characteristic == euler
    # Chords of an edge length cut off h²/(6r²) of a round section, and the field is sampled every millimetre.
    assert 0.92 * volume < result.mesh.volume < 1.01 * volume
    # Vertices lie on the border itself.
    index = result.mesh.vertices - AFFINE[:3, 3]
    value = field[tuple(np.rint(index).astype(int).T)]
    assert np.abs(value).max() < 1.0
    assert np.percentile(result.mesh.edge_lengths, 1) > 0.4
    assert np.percentile(result.mesh.edge_lengths, 99) < 1.8


def test_the_same_again() -> None:
    first, second = _grow(_fork(), (0, 0, -9)), _grow(_fork(), (0, 0, -9))
    np.testing.assert_array_equal(first.mesh.vertices, second.mesh.vertices)
    np.testing.assert_array_equal(first.mesh.faces, second.mesh.faces)


def test_another_frame_gives_the_same_surface() -> None:
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_euler("xyz", [30, -20, 50], degrees=True).as_matrix()
    turn[:3, 3] = (30.0, -12.0, 7.0)
    field = _tube()
    plain = _grow(field, (0, 0, 0))
    matrix = turn @ AFFINE
    center = turn[:3, 3]
    seed = seed_triangle(field, matrix, center, edge_length=1.0)
    assert seed is not None
    moved = tangential_flow(field, matrix, seed, TangentialFlowParams(edge_length=1.0))
    _sound(moved.mesh)
    assert moved.mesh.volume == pytest.approx(plain.mesh.volume, rel=0.02)
    np.testing.assert_allclose(moved.mesh.centroid, center, atol=0.15)


def test_work_follows_the_surface_not_the_way() -> None:
    result = _grow(_tube(), (0, 0, 0), 0.8)
    vertices = len(result.mesh.vertices)
    assert vertices <= result.grown + 3
    # Every vertex is put in once: what is taken out around holes and grown again is little.
    assert result.grown < 1.1 * vertices


def test_it_stops_at_the_number_of_vertices_that_is_set() -> None:
    field = _tube()
    seed = seed_triangle(field, AFFINE, (0, 0, 0), edge_length=1.0)
    assert seed is not None
    result = tangential_flow(field, AFFINE, seed, TangentialFlowParams(edge_length=1.0, max_vertices=200))
    assert result.limited
    assert result.holes > 0
    assert len(result.mesh.vertices) <= 200
    assert result.mesh.oriented
    assert len(self_intersections(result.mesh)) == 0


def test_a_hole_where_there_is_no_gradient_is_stitched() -> None:
    field = _tube()
    # A patch of the wall that says nothing: half-way values without a border.
    field[24:32, 20:28, 22:26] = 0.0
    result = _grow(field, (0, 0, -8))
    assert result.refused > 0
    assert result.holes == 0
    _sound(result.mesh)
    assert result.mesh.euler_characteristic == 2


def test_two_walls_close_together_do_not_touch() -> None:
    p = _points()
    field = _field(
        np.minimum(_capsule(p, (-4.0, 0, -15), (-4.0, 0, 15), 3.0), _capsule(p, (4.0, 0, -15), (4.0, 0, 15), 3.0))
    )
    result = _grow(field, (-4.0, 0, 0))
    _sound(result.mesh)
    # The other tube is another object.
    assert result.mesh.vertices[:, 0].max() < 0.0


def test_seeds_and_parameters_that_cannot_be() -> None:
    field = _tube()
    assert seed_triangle(np.full((8, 8, 8), 1.0, np.float32), np.eye(4), (4, 4, 4), edge_length=1.0) is None
    with pytest.raises(InvalidInput) as caught:
        tangential_flow(field, AFFINE, TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32)))
    assert caught.value.code == "invalid_mesh"
    twice = TriangleMesh(np.eye(3), [[0, 1, 2], [0, 1, 2]])
    with pytest.raises(InvalidInput, match="not manifold"):
        tangential_flow(field, AFFINE, twice)
    with pytest.raises(ValueError, match="edge_length"):
        TangentialFlowParams(edge_length=-1.0)
    with pytest.raises(ValueError, match="steps must rise"):
        TangentialFlowParams(least_step=1.2, largest_step=1.0)


@pytest.mark.parametrize(
    ("make", "center", "model", "volume"),
    [
        pytest.param(_tube, (0, 0, 0), "tangential", TUBE_VOLUME, id="tube"),
        pytest.param(_fork, (0, 0, -9), "tangential", FORK_VOLUME, id="fork"),
        pytest.param(_ball, (1, 2, 0), "normal", 2304 * np.pi, id="ball"),
        pytest.param(_ball, (4, -3, 2), "normal", 2304 * np.pi, id="ball-aside"),
    ],
)
def test_the_model_follows_the_shape(make, center, model, volume) -> None:  # type: ignore[no-untyped-def]
    field = make()
    result = selected_flow(field, AFFINE, icosphere(center, 1.5, 2), SelectionParams(edge_length=1.0))
    assert result.model == model
    assert not result.vanished
    _sound(result.mesh)
    assert result.mesh.euler_characteristic == 2
    assert result.mesh.volume == pytest.approx(volume, rel=0.08)
    if model == "tangential":
        # Two ends, and long before the normal flow would have reached them.
        assert len(result.clusters) == 2
        assert result.iterations < 60


def test_without_the_switch_the_normal_flow_goes_the_whole_way() -> None:
    ball = icosphere((0, 0, 0), 1.5, 2)
    alone = selected_flow(_tube(), AFFINE, ball, SelectionParams(edge_length=1.0, switch=False))
    both = selected_flow(_tube(), AFFINE, ball, SelectionParams(edge_length=1.0))
    assert alone.model == "normal"
    assert alone.tangential is None
    assert alone.iterations > 2 * both.iterations
    assert alone.mesh.volume == pytest.approx(both.mesh.volume, rel=0.06)


def test_a_seed_in_nothing_vanishes() -> None:
    result = selected_flow(_tube(), AFFINE, icosphere((15, 15, 0), 1.5, 2), SelectionParams(edge_length=1.0))
    assert result.vanished


def test_clusters_are_those_of_adjacent_vertices() -> None:
    ball = icosphere((0, 0, 0), 10.0, 3)
    chosen = np.abs(ball.vertices[:, 2]) > 8.0
    sizes = cluster_sizes(ball, chosen)
    assert len(sizes) == 2
    assert sizes.sum() == chosen.sum()
    assert len(cluster_sizes(ball, np.zeros(len(chosen), dtype=bool))) == 0
    mesh = opened(ball, chosen)
    assert len(mesh.topology.boundary_loops) == 2
    assert mesh.manifold
    field = _field(np.linalg.norm(_points(), axis=-1) - 15.0)
    inverse = np.linalg.inv(AFFINE).astype(np.float64)
    assert moving_vertices(field, inverse, ball).all()
    assert not moving_vertices(field, inverse, icosphere((0, 0, 0), 15.0, 3)).any()

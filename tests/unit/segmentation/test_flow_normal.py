"""The normal flow on fields whose surface is known, and on fields that want to break it."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.flow import FlowState, NormalFlowParams, normal, normal_flow
from shapery_segmentation.flow.evolving import Evolution
from shapery_segmentation.mesh import DynamicMesh
from shapery_segmentation.seeding.ball import surface_of
from tests.support.fields import assert_sound, ball, field_of, grid

FIXED = NormalFlowParams(threshold_share=None)
"""The threshold stays as given, so that the answer is a level set of the field."""

COARSE = replace(FIXED, edge_lengths=(1.5,))


# --- closed forms --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "seed",
    [((0, 0, 0), 4.0), ((5, 3, -4), 2.5), ((1, 0, 0), 16.0), ((9, 0, 0), 4.0)],
    ids=["inside", "off the centre", "around", "across"],
)
def test_a_ball_is_found_from_wherever_the_seed_meets_it(seed: tuple[tuple[float, float, float], float]) -> None:
    points, affine = grid(44)
    field = field_of(ball(points, (0, 0, 0), 11.0))
    result = normal_flow(field, None, affine, icosphere(*seed, 3), FIXED, threshold=0.0)
    assert_sound(result)
    assert result.converged
    assert not result.vanished
    radii = np.linalg.norm(result.mesh.vertices, axis=1)
    # Curvature pulls inwards by a tenth of an edge length over the slope, interpolation by h²/8r.
    assert np.abs(radii - 11.0).max() < 0.15
    assert result.mesh.volume == pytest.approx(4 / 3 * np.pi * 11.0**3, rel=0.02)


def test_an_ellipsoid_is_found() -> None:
    points, affine = grid(48)
    axes = np.array([18.0, 11.0, 7.0])
    scaled = np.linalg.norm(points / axes, axis=-1)
    result = normal_flow(field_of((scaled - 1.0) * 10.0), None, affine, icosphere(radius=4.0), FIXED, threshold=0.0)
    assert_sound(result)
    assert result.converged
    residual = np.linalg.norm(result.mesh.vertices / axes, axis=1) - 1.0
    # In mm along the shortest axis.
    assert np.abs(residual).max() * 7.0 < 0.4
    assert result.mesh.volume == pytest.approx(4 / 3 * np.pi * axes.prod(), rel=0.03)


def test_the_edges_have_the_length_of_the_last_stage() -> None:
    points, affine = grid(36)
    field = field_of(ball(points, (0, 0, 0), 9.0))
    for lengths in ((2.0,), (2.0, 1.2)):
        result = normal_flow(
            field, None, affine, icosphere(radius=4.0), replace(FIXED, edge_lengths=lengths), threshold=0.0
        )
        assert [s.edge_length for s in result.stages] == list(lengths)
        assert result.mesh.edge_lengths.mean() == pytest.approx(lengths[-1], rel=0.15)
        assert result.mesh.edge_lengths.max() < 1.75 * lengths[-1]
        # Angles below 10° are for broken meshes.
        assert np.rad2deg(result.mesh.corner_angles.min()) > 10.0


def test_a_torus_is_filled_to_a_ball_with_a_seam() -> None:
    points, affine = grid(44)
    ring = np.hypot(np.hypot(points[..., 0], points[..., 1]) - 12.0, points[..., 2]) - 5.0
    result = normal_flow(field_of(ring), None, affine, icosphere((12, 0, 0), 3.0, 2), COARSE, threshold=0.0)
    # The genus of the seed is kept: the fronts meet opposite the seed and stop, an edge length apart.
    assert_sound(result, genus=0)
    inside = rasterize(result.mesh, Volume(ring, affine))
    truth = ring < 0
    assert (inside & truth).sum() / (inside | truth).sum() > 0.93
    assert (truth & ~inside & (points[..., 0] < -5.0)).sum() > 20
    assert result.frozen > 0


def test_a_seed_of_genus_one_keeps_its_hole() -> None:
    points, affine = grid(44)
    ring = np.hypot(np.hypot(points[..., 0], points[..., 1]) - 12.0, points[..., 2]) - 5.0
    s, t = (a.ravel() for a in np.meshgrid(np.arange(40), np.arange(12), indexing="ij"))
    a, b = 2 * np.pi * s / 40, 2 * np.pi * t / 12
    vertices = np.stack(((12 + 2 * np.cos(b)) * np.cos(a), (12 + 2 * np.cos(b)) * np.sin(a), 2 * np.sin(b)), axis=1)
    right, up, both = ((s + 1) % 40) * 12 + t, s * 12 + (t + 1) % 12, ((s + 1) % 40) * 12 + (t + 1) % 12
    here = s * 12 + t
    seed = TriangleMesh(vertices, np.concatenate((np.stack((here, right, both), 1), np.stack((here, both, up), 1))))
    result = normal_flow(field_of(ring), None, affine, seed, COARSE, threshold=0.0)
    assert_sound(result, genus=1)
    assert result.converged
    x, y, z = result.mesh.vertices.T
    assert np.abs(np.hypot(np.hypot(x, y) - 12.0, z) - 5.0).max() < 0.3


def test_two_balls_side_by_side_do_not_fold_over_each_other() -> None:
    points, affine = grid(48)
    # 1.5 mm apart, joined by a neck far thinner than the gap that fronts keep.
    pair = np.minimum(ball(points, (-8.75, 0, 0), 8.0), ball(points, (8.75, 0, 0), 8.0))
    neck = np.maximum(np.hypot(points[..., 1], points[..., 2]) - 2.0, np.abs(points[..., 0]) - 6.0)
    field = field_of(np.minimum(pair, neck))
    result = normal_flow(field, None, affine, icosphere((-8.75, 0, 0), 4.0, 2), FIXED, threshold=0.0)
    assert_sound(result)
    inside = rasterize(result.mesh, Volume(field, affine))
    truth = field > 0
    assert (inside & truth).sum() / (inside | truth).sum() > 0.95
    # Both balls belong to it, the gap between them away from the neck does not.
    gap = (np.abs(points[..., 0]) < 0.6) & (np.hypot(points[..., 1], points[..., 2]) > 4.0)
    assert not (inside & gap).any()


def test_a_thin_sheet_is_covered_without_touching() -> None:
    points, affine = grid(48)
    # 3 mm thick.
    sheet = np.maximum(
        np.abs(points[..., 2] - 3.0 * np.sin(points[..., 0] / 6.0)) - 1.5,
        np.hypot(points[..., 0], points[..., 1]) - 16.0,
    )
    result = normal_flow(field_of(sheet, 2.0), None, affine, icosphere((0, 0, 0), 1.2, 2), FIXED, threshold=0.0)
    assert_sound(result)
    inside = rasterize(result.mesh, Volume(sheet, affine))
    truth = sheet < 0
    assert (inside & truth).sum() / (inside | truth).sum() > 0.85


def test_a_shell_around_a_necrosis_is_wrapped() -> None:
    points, affine = grid(44)
    radius = np.linalg.norm(points, axis=-1)
    shell = np.maximum(radius - 15.0, 8.0 - radius)
    result = normal_flow(field_of(shell), None, affine, icosphere((11.5, 0, 0), 2.0, 2), COARSE, threshold=0.0)
    assert_sound(result, genus=0)
    inside = rasterize(result.mesh, Volume(shell, affine))
    truth = shell < 0
    assert (inside & truth).sum() / (inside | truth).sum() > 0.85
    # A sphere that wraps a cavity leaves a seam where its fronts met, and never fills the cavity.
    assert not inside[radius < 6.5].any()


def test_a_seed_in_a_necrosis_is_told_to_have_vanished() -> None:
    points, affine = grid(44)
    radius = np.linalg.norm(points, axis=-1)
    shell = np.maximum(radius - 15.0, 8.0 - radius)
    result = normal_flow(field_of(shell), None, affine, icosphere((0, 0, 0), 3.0, 2), COARSE, threshold=0.0)
    assert result.vanished
    assert not result.converged
    assert result.mesh.volume < 2.0 * 1.5**3
    assert result.mesh.closed
    assert len(self_intersections(result.mesh)) == 0


def test_a_flake_beside_the_object_retreats() -> None:
    points, affine = grid(36)
    field = field_of(ball(points, (0, 0, 0), 7.0))
    # The seed has a plate of 2 mm on its side that is not object: both of its sides are in each other's way.
    plate = np.maximum(np.abs(points[..., 2]) - 0.9, np.hypot(points[..., 0] - 8.0, points[..., 1]) - 6.0)
    cells = np.minimum(ball(points, (0, 0, 0), 7.0), plate) < 0
    result = normal_flow(field, None, affine, surface_of(cells, affine), FIXED, threshold=0.0)
    assert_sound(result)
    # Of the 7 mm that it stuck out at most its root is left.
    assert np.linalg.norm(result.mesh.vertices, axis=1).max() < 10.5
    assert result.mesh.volume < 1.03 * 4.0 / 3.0 * np.pi * 7.0**3


# --- the gate, the threshold, the grid -----------------------------------------------------------------------------


def test_the_surface_stays_where_it_is_allowed() -> None:
    points, affine = grid(40)
    field = np.full(points.shape[:3], 5.0, dtype=np.float32)
    allowed = ball(points, (0, 0, 0), 10.0) < 0
    result = normal_flow(field, allowed, affine, icosphere(radius=4.0, subdivisions=2), COARSE, threshold=0.0)
    assert_sound(result)
    radii = np.linalg.norm(result.mesh.vertices, axis=1)
    assert radii.max() < 10.6
    assert radii.mean() == pytest.approx(9.7, abs=0.4)


def test_the_surface_does_not_leave_the_grid() -> None:
    field = np.full((20, 16, 12), 5.0, dtype=np.float32)
    result = normal_flow(field, None, np.eye(4), icosphere((9, 8, 6), 3.0, 2), COARSE, threshold=0.0)
    assert_sound(result)
    assert (result.mesh.vertices > -0.8).all()
    assert (result.mesh.vertices < np.array([19, 15, 11]) + 0.8).all()
    # Edges and corners of the box are rounded off.
    assert result.mesh.volume > 0.85 * 19 * 15 * 11


def test_the_running_threshold_follows_the_median_inside() -> None:
    points, affine = grid(40)
    distance = ball(points, (0, 0, 0), 10.0)
    # A plateau of 4 inside, 0 outside, 4 mm wide in between.
    field = np.clip(2.0 - distance, 0.0, 4.0).astype(np.float32)
    running = replace(COARSE, threshold_share=0.45, threshold_range=(0.5, 3.0))
    result = normal_flow(field, None, affine, icosphere(radius=4.0, subdivisions=2), running, threshold=3.0)
    inside = rasterize(result.mesh, Volume(field, affine))
    assert result.threshold == pytest.approx(0.45 * np.median(field[inside]), rel=0.03)
    assert np.linalg.norm(result.mesh.vertices, axis=1).mean() == pytest.approx(12.0 - result.threshold, abs=0.15)
    clipped = replace(running, threshold_range=(2.5, 3.0))
    assert normal_flow(field, None, affine, icosphere(radius=4.0), clipped, threshold=3.0).threshold == 2.5


def test_voxels_that_are_not_finite_are_outside() -> None:
    points, affine = grid(36)
    field = field_of(ball(points, (0, 0, 0), 9.0))
    field[points[..., 0] > 3.0] = np.nan
    field[points[..., 0] < -5.0] = np.inf
    result = normal_flow(field, None, affine, icosphere(radius=2.5, subdivisions=2), COARSE, threshold=0.0)
    assert_sound(result)
    assert result.mesh.vertices[:, 0].max() < 3.6
    assert result.mesh.vertices[:, 0].min() > -5.6


OBLIQUE = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


@pytest.mark.parametrize("spacing", [(1.0, 1.0, 1.0), (0.7, 1.1, 2.5)], ids=["isotropic", "anisotropic"])
def test_an_oblique_grid_gives_the_surface_in_mm(spacing: tuple[float, float, float]) -> None:
    assert np.allclose(OBLIQUE @ OBLIQUE.T, np.eye(3))
    shape = np.ceil(34.0 / np.array(spacing)).astype(int)
    affine = np.eye(4)
    affine[:3, :3] = OBLIQUE * spacing
    affine[:3, 3] = (60, -40, 90) - affine[:3, :3] @ ((shape - 1) / 2)
    index = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    points = index @ affine[:3, :3].T + affine[:3, 3]
    field = field_of(ball(points, (60, -40, 90), 10.0))
    result = normal_flow(field, None, affine, icosphere((61, -40, 89), 4.0, 2), FIXED, threshold=0.0)
    assert_sound(result)
    assert result.converged
    radii = np.linalg.norm(result.mesh.vertices - (60, -40, 90), axis=1)
    # Trilinear interpolation between planes 2.5 mm apart bends the level set of a ball by up to 0.1 mm.
    assert np.abs(radii - 10.0).max() < (0.15 if spacing[2] == 1.0 else 0.3)


def asymmetric(points: np.ndarray) -> np.ndarray:
    """Return a distance to a shape that no rotation or reflection of the axes maps to itself."""
    return np.minimum(
        np.minimum(ball(points, (0, 0, 0), 6.0), ball(points, (5, 2, 1), 4.0)), ball(points, (-1, 6, 3), 3.5)
    )


ORIENTATIONS = [
    (axes, signs) for axes in itertools.permutations(range(3)) for signs in itertools.product((1, -1), repeat=3)
]


def test_all_48_orientations_of_the_grid_give_the_same_surface() -> None:
    points, affine = grid(26)
    field = field_of(asymmetric(points))
    seed = icosphere(radius=3.0, subdivisions=2)
    expected = normal_flow(field, None, affine, seed, COARSE, threshold=0.0).mesh
    assert len(ORIENTATIONS) == 48
    for axes, signs in ORIENTATIONS:
        turned = np.transpose(field, axes)[tuple(slice(None, None, s) for s in signs)]
        matrix = np.zeros((4, 4))
        matrix[3, 3] = 1.0
        for new, (old, sign) in enumerate(zip(axes, signs, strict=True)):
            matrix[:, new] += affine[:, old] * sign
            if sign < 0:
                matrix[:3, 3] += affine[:3, old] * (field.shape[old] - 1)
        matrix[:3, 3] += affine[:3, 3]
        mesh = normal_flow(turned, None, matrix, seed, COARSE, threshold=0.0).mesh
        # The same places are sampled; only rounding differs.
        assert mesh.volume == pytest.approx(expected.volume, rel=2e-3)
        assert np.abs(mesh.bounding_box - expected.bounding_box).max() < 0.1


def test_a_moved_and_turned_world_gives_the_moved_and_turned_surface() -> None:
    points, affine = grid(26)
    field = field_of(asymmetric(points))
    seed = icosphere(radius=3.0, subdivisions=2)
    expected = normal_flow(field, None, affine, seed, COARSE, threshold=0.0).mesh
    motion = np.eye(4)
    motion[:3, :3] = OBLIQUE
    motion[:3, 3] = (130.0, -75.0, 20.0)
    turned = TriangleMesh(seed.vertices @ OBLIQUE.T + motion[:3, 3], seed.faces)
    mesh = normal_flow(field, None, motion @ affine, turned, COARSE, threshold=0.0).mesh
    back = (mesh.vertices - motion[:3, 3]) @ OBLIQUE
    assert mesh.volume == pytest.approx(expected.volume, rel=5e-3)
    assert np.abs(back.min(axis=0) - expected.vertices.min(axis=0)).max() < 0.15
    assert np.abs(back.max(axis=0) - expected.vertices.max(axis=0)).max() < 0.15


def test_the_same_input_gives_the_same_bytes() -> None:
    points, affine = grid(30)
    rng = np.random.default_rng(4)
    field = field_of(ball(points, (0, 0, 0), 8.0)) + rng.normal(size=points.shape[:3]).astype(np.float32)
    first, second = (
        normal_flow(field, None, affine, icosphere(radius=4.0, subdivisions=2), threshold=1.5) for _ in range(2)
    )
    assert first.mesh.same_as(second.mesh)
    assert (first.threshold, first.iterations, first.stages) == (second.threshold, second.iterations, second.stages)


# --- what must hold whatever comes ---------------------------------------------------------------------------------


@given(
    seed=st.integers(0, 2**32 - 1),
    contrast=st.sampled_from([0.5, 3.0, 50.0]),
    grain=st.sampled_from([0.0, 0.8, 1.6]),
    length=st.sampled_from([1.1, 2.0]),
)
@settings(max_examples=10, deadline=None)
def test_noise_never_breaks_the_surface(seed: int, contrast: float, grain: float, length: float) -> None:
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(16, 16, 16))
    if grain:
        noise = ndimage.gaussian_filter(noise, grain)
        noise /= noise.std()
    field = (contrast * (noise + 0.4)).astype(np.float32)
    params = replace(FIXED, edge_lengths=(length,), max_iterations=40)
    result = normal_flow(field, None, np.eye(4), icosphere((8, 8, 8), 4.0, 2), params, threshold=0.0)
    if not result.vanished:
        assert_sound(result)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=8, deadline=None)
@pytest.mark.slow
def test_a_field_that_flips_every_voxel_never_breaks_the_surface(seed: int) -> None:
    rng = np.random.default_rng(seed)
    index = np.stack(np.meshgrid(*(np.arange(16),) * 3, indexing="ij"), axis=-1)
    board = ((index // rng.integers(1, 4)).sum(axis=-1) % 2) * 200.0 - rng.uniform(20.0, 180.0)
    params = replace(FIXED, edge_lengths=(float(rng.uniform(0.8, 2.5)),), max_iterations=40, curvature_weight=0.0)
    result = normal_flow(
        board.astype(np.float32), None, np.eye(4), icosphere((10, 10, 10), 5.0, 2), params, threshold=0.0
    )
    if not result.vanished:
        assert_sound(result)


@pytest.mark.parametrize("gaps", [(0.0, 0.0), (0.3, 0.3)])
def test_the_exact_test_alone_keeps_the_surface_whole(gaps: tuple[float, float]) -> None:
    # Without the distance that fronts keep, only the test of the triangles stands between them.
    points, affine = grid(36)
    ring = np.hypot(np.hypot(points[..., 0], points[..., 1]) - 10.0, points[..., 2]) - 4.0
    params = replace(COARSE, front_gap=gaps[0], rear_gap=gaps[1], step=0.5, max_iterations=150)
    result = normal_flow(field_of(ring, 8.0), None, affine, icosphere((10, 0, 0), 2.5, 2), params, threshold=0.0)
    assert_sound(result, genus=0)


@given(
    weights=st.tuples(st.floats(0, 1), st.floats(0, 1)),
    gaps=st.tuples(st.floats(0, 2), st.floats(0, 2)),
    opposed=st.floats(-1, 1),
    step=st.floats(0.05, 0.5),
)
@settings(max_examples=10, deadline=None)
def test_no_setting_breaks_the_surface(
    weights: tuple[float, float], gaps: tuple[float, float], opposed: float, step: float
) -> None:
    points, affine = grid(26)
    rng = np.random.default_rng(7)
    shell = np.maximum(ball(points, (0, 0, 0), 10.0), -ball(points, (0, 0, 0), 5.5))
    field = field_of(shell, 3.0) + rng.normal(size=shell.shape).astype(np.float32)
    params = replace(
        COARSE, curvature_weight=weights[0], tangential_weight=weights[1], front_gap=gaps[0], rear_gap=gaps[1],
        opposed=opposed, step=step, max_iterations=80,
    )  # fmt: skip
    result = normal_flow(field, None, affine, icosphere((7.5, 0, 0), 1.8, 2), params, threshold=0.0)
    if not result.vanished:
        assert_sound(result)


def test_a_flow_that_ends_touching_itself_begins_again_with_every_move_tested(monkeypatch: pytest.MonkeyPatch) -> None:
    points, affine = grid(26)
    field = field_of(ball(points, (0, 0, 0), 7.0))
    thorough: list[bool] = []

    class Noted(Evolution):
        def __init__(self, *given: object) -> None:
            thorough.append(bool(given[-1]))
            super().__init__(*given)  # type: ignore[arg-type]

    mend = DynamicMesh.mend
    answers = iter([False])
    monkeypatch.setattr(normal, "Evolution", Noted)
    seed = icosphere(radius=3.0)
    with monkeypatch.context() as patched:
        # What came of it in the end, this says, cannot be mended.
        patched.setattr(DynamicMesh, "mend", lambda self, rounds: next(answers, None) is None and mend(self, rounds))
        result = normal_flow(field, None, affine, seed, COARSE, threshold=0.0)
    assert thorough == [False, True]
    assert_sound(result)
    assert result.mesh.same_as(normal_flow(field, None, affine, seed, COARSE, threshold=0.0).mesh)


# --- oscillation, reports, refusals --------------------------------------------------------------------------------


def test_vertices_that_oscillate_are_stopped_at_the_border() -> None:
    points, affine = grid(30)
    # A step so steep that a full step of the flow lands on the other side again and again.
    field = np.where(ball(points, (0, 0, 0), 8.0) < 0, 100.0, -100.0).astype(np.float32)
    params = replace(COARSE, aging_limit=2, window=200, max_iterations=120)
    result = normal_flow(field, None, affine, icosphere(radius=5.0, subdivisions=2), params, threshold=0.0)
    assert_sound(result)
    assert result.aged > 0.5 * len(result.mesh.vertices)
    assert result.converged
    assert np.abs(np.linalg.norm(result.mesh.vertices, axis=1) - 8.0).max() < 0.8


def test_every_iteration_is_reported_and_may_end_the_flow() -> None:
    points, affine = grid(26)
    field = field_of(ball(points, (0, 0, 0), 7.0))
    told: list[FlowState] = []
    result = normal_flow(field, None, affine, icosphere(radius=3.0), FIXED, threshold=0.0, on_iteration=told.append)
    assert [s.iteration for s in told] == list(range(1, result.iterations + 1))
    assert [s.stage for s in told] == sorted(s.stage for s in told)
    assert told[-1].stage == 1
    assert all(0 <= s.awake <= s.vertices + 50 for s in told)
    assert sum(s.iterations for s in result.stages) == result.iterations

    class Cancelled(Exception):
        pass

    def stop(state: FlowState) -> None:
        if state.iteration == 3:
            raise Cancelled

    with pytest.raises(Cancelled):
        normal_flow(field, None, affine, icosphere(radius=3.0), FIXED, threshold=0.0, on_iteration=stop)


def test_the_cap_on_iterations_is_told() -> None:
    points, affine = grid(40)
    params = replace(COARSE, max_iterations=5)
    field = field_of(ball(points, (0, 0, 0), 15.0))
    result = normal_flow(field, None, affine, icosphere(radius=3.0), params, threshold=0.0)
    assert not result.converged
    assert result.iterations == 5
    assert result.awake > 0
    assert_sound(result)


def test_parts_of_a_seed_that_vanish_are_left_out() -> None:
    points, affine = grid(44)
    field = field_of(ball(points, (-8, 0, 0), 8.0))
    a, b = icosphere((-8, 0, 0), 4.0, 2), icosphere((14, 0, 0), 3.0, 2)
    seed = TriangleMesh(np.concatenate((a.vertices, b.vertices)), np.concatenate((a.faces, b.faces + len(a.vertices))))
    result = normal_flow(field, None, affine, seed, COARSE, threshold=0.0)
    assert_sound(result)
    assert result.mesh.vertices[:, 0].max() < 0.5


def test_a_seed_that_looks_inwards_is_refused() -> None:
    with pytest.raises(InvalidInput, match="look inwards"):
        normal_flow(np.ones((8, 8, 8), np.float32), None, np.eye(4), icosphere((4, 4, 4)).flipped(), threshold=0.0)


def test_shapes_must_agree() -> None:
    with pytest.raises(InvalidInput, match=r"\(8, 8, 8\), the region allowed has \(8, 8, 7\)"):
        normal_flow(np.ones((8, 8, 8), np.float32), np.ones((8, 8, 7), bool), np.eye(4), icosphere(), threshold=0.0)


def test_the_threshold_must_be_finite() -> None:
    with pytest.raises(ValueError, match="finite"):
        normal_flow(np.ones((8, 8, 8), np.float32), None, np.eye(4), icosphere(), threshold=np.nan)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("edge_lengths", ()), ("edge_lengths", (1.0, -1.0)), ("model", "other"), ("topology", "other"),
        ("step", 0.9), ("opposed", 2.0), ("patience", 0), ("threshold_range", (2.0, 1.0)), ("gradient_sigma", -1.0),
    ],
)  # fmt: skip
def test_parameters_out_of_range_are_refused(name: str, value: object) -> None:
    with pytest.raises(ValueError, match=name):
        NormalFlowParams(**{name: value})  # type: ignore[arg-type]

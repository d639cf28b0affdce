"""Geometric interpolation (Eq. 3.16), aging and damping: each alone, and what the ablation reports of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from shapery_geometry.mesh import icosphere
from shapery_segmentation.flow import NormalFlowParams, normal_flow
from shapery_segmentation.flow.ablation import COMBINATIONS, ablate
from shapery_segmentation.flow.interpolation import LEAST_WEIGHT, WORTHWHILE, contrasts, interpolated
from shapery_segmentation.phantoms.blob import defective_blob
from tests.support.fields import assert_sound, ball, field_of, grid


def test_the_solution_is_that_of_the_dense_system() -> None:
    sphere = icosphere(radius=5.0, subdivisions=1)
    rng = np.random.default_rng(3)
    points, n = sphere.vertices + 0.3 * rng.normal(size=sphere.vertices.shape), len(sphere.vertices)
    trusted = np.ones(n, dtype=bool)
    trusted[:20] = False
    weight = rng.uniform(0.0, 1.0, n)
    # With most vertices in the part that is solved, it is the whole of Eq. 3.12.
    laplacian = np.eye(n)
    for v in range(n):
        ring = np.unique(sphere.faces[(sphere.faces == v).any(axis=1)])
        ring = ring[ring != v]
        laplacian[v, ring] = -1.0 / len(ring)
    near = ~trusted
    for _ in range(2):
        rows, near = near, near | (np.abs(laplacian[near]).sum(axis=0) > 0)
    a = laplacian[rows][:, near]
    omega = np.where(trusted, np.maximum(weight, LEAST_WEIGHT), 0.0)[near]
    dense = np.linalg.lstsq(
        np.vstack((a, np.diag(omega))), np.vstack((np.zeros((len(a), 3)), omega[:, None] * points[near]))
    )[0]
    expected = points.copy()
    expected[np.flatnonzero(near)[~trusted[near]]] = dense[~trusted[near]]
    assert np.allclose(interpolated(points, sphere.faces, trusted, weight), expected, atol=1e-8)


def test_vertices_astray_come_back_to_the_sphere() -> None:
    sphere = icosphere(radius=10.0, subdivisions=3)
    rng = np.random.default_rng(5)
    trusted = rng.uniform(size=len(sphere.vertices)) > 0.2
    points = sphere.vertices.copy()
    points[~trusted] += rng.normal(size=(int((~trusted).sum()), 3))
    out = interpolated(points, sphere.faces, trusted, np.ones(len(points)))
    assert np.array_equal(out[trusted], points[trusted])
    assert np.abs(np.linalg.norm(out[~trusted], axis=1) - 10.0).max() < 0.35
    assert np.abs(np.linalg.norm(points[~trusted], axis=1) - 10.0).max() > 1.0


@pytest.mark.parametrize("value", [True, False], ids=["all trusted", "none trusted"])
def test_nothing_moves_where_there_is_nothing_to_say(value: bool) -> None:
    sphere = icosphere(radius=3.0, subdivisions=1)
    trusted = np.full(len(sphere.vertices), value)
    out = interpolated(sphere.vertices, sphere.faces, trusted, np.ones(len(trusted)))
    assert np.array_equal(out, sphere.vertices)


def test_a_turned_surface_has_the_turned_solution() -> None:
    sphere = icosphere(radius=4.0, subdivisions=2)
    rng = np.random.default_rng(8)
    points = sphere.vertices + 0.2 * rng.normal(size=sphere.vertices.shape)
    trusted, weight = rng.uniform(size=len(points)) > 0.3, rng.uniform(size=len(points))
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    shift = np.array([30.0, -4.0, 7.0])
    out = interpolated(points, sphere.faces, trusted, weight)
    assert np.allclose(interpolated(points @ turn.T + shift, sphere.faces, trusted, weight), out @ turn.T + shift)


def grainy() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a steep and noisy field, its affine and the ball in it: a step runs over the border and back."""
    points, affine = grid(34)
    distance = ball(points, (0, 0, 0), 10.0)
    noise = np.random.default_rng(2).normal(size=distance.shape)
    return (field_of(distance, 6.0) + noise).astype(np.float32), affine, distance < 0


def test_what_the_ablation_reports() -> None:
    field, affine, truth = grainy()
    params = NormalFlowParams(
        threshold_share=None,
        edge_lengths=(1.5,),
        step=0.5,
        window=8,
        max_iterations=120,
        interpolation_share=WORTHWHILE,
    )
    rows = {
        row.without: row for row in ablate(field, None, affine, icosphere(radius=5.0), truth, params, threshold=0.0)
    }
    assert list(rows) == list(COMBINATIONS)
    assert all(row.iou > 0.8 for row in rows.values())
    # Parts that are left out do nothing, the others do.
    assert rows[("damping",)].aged > 0
    assert all(row.aged == 0 for without, row in rows.items() if "aging" in without)
    assert all(row.interpolations == 0 for without, row in rows.items() if "interpolation" in without)
    # Damping and aging leave less to oscillate.
    nothing = rows[("damping", "aging", "interpolation")]
    assert rows[("aging", "interpolation")].oscillations < nothing.oscillations
    assert rows[("damping", "interpolation")].oscillations < nothing.oscillations
    assert rows[("damping", "interpolation")].iterations <= nothing.iterations


@pytest.mark.parametrize("kind", ["gap", "stripes"])
def test_a_border_that_is_lost_is_bridged(kind: Literal["gap", "stripes"]) -> None:
    phantom = defective_blob(np.random.default_rng(0), kind)
    field = np.asarray(phantom.volume.data)
    seed = icosphere(phantom.center, 7.0, 2)
    params = NormalFlowParams(threshold_share=None, edge_lengths=(2.0, 1.3), interpolation_share=WORTHWHILE)
    with_it, without = (
        normal_flow(field, None, phantom.volume.affine, seed, p, threshold=0.0)
        for p in (params, replace(params, interpolation_share=None))
    )
    assert with_it.interpolations > 0
    assert without.interpolations == 0
    assert_sound(with_it)
    off = [float(np.abs(phantom.distance(result.mesh.vertices)).mean()) for result in (with_it, without)]
    assert off[0] < 0.7 * off[1]


def test_contrasts_tell_where_there_is_a_border() -> None:
    points, affine = grid(34)
    sphere = icosphere(radius=10.0, subdivisions=3)
    field = field_of(ball(points, (0, 0, 0), 10.0), 1.0).astype(np.float32)
    field[points[..., 0] > 4.0] = 0.0
    for sign in (1.0, -1.0):
        found = contrasts(sphere.vertices, sphere.faces, np.float32(sign) * field, np.linalg.inv(affine)[:3], 1.0)
        assert (found[sphere.vertices[:, 0] < 0.0] > 0.8).all()
        assert (found[sphere.vertices[:, 0] > 8.0] < 0.3).all()


@pytest.mark.parametrize(
    ("name", "value"), [("aging_limit", 0), ("interpolation_share", 1.5), ("damping", 0.0)], ids=str
)
def test_parameters_out_of_range_are_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=name):
        replace(NormalFlowParams(), **{name: value})


def test_a_part_that_nothing_holds_stays_where_it_is() -> None:
    ball = icosphere(radius=5.0, subdivisions=2)
    other = ball.vertices + 20.0
    n = len(ball.vertices)
    points = np.concatenate((ball.vertices, other))
    faces = np.concatenate((ball.faces, ball.faces + n)).astype(np.int32)
    trusted = np.arange(2 * n) < n
    trusted[:9] = False
    moved = points.copy()
    moved[:9] *= 1.3
    out = interpolated(moved, faces, trusted, np.ones(2 * n))
    assert (out[n:] == other).all()
    assert np.abs(np.linalg.norm(out[:9], axis=1) - 5.0).max() < 0.5
    assert (interpolated(moved, faces, np.zeros(2 * n, dtype=np.bool_), np.ones(2 * n)) == moved).all()

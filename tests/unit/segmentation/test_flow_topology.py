"""Parts that merge, rings that close, necks that split; and the same cases with the topology kept."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.flow import NormalFlowParams, normal_flow
from shapery_segmentation.flow.topology import reconnected, without_remains
from shapery_segmentation.seeding.ball import surface_of
from tests.support.fields import assert_sound, ball, field_of, grid

Topology = Literal["preserve", "adaptive"]

COARSE = NormalFlowParams(threshold_share=None, edge_lengths=(1.5,))
BOTH = pytest.mark.parametrize("topology", ["preserve", "adaptive"])


def joined(*surfaces: TriangleMesh) -> TriangleMesh:
    """Return several surfaces as one mesh."""
    offsets = np.cumsum([0] + [len(s.vertices) for s in surfaces[:-1]])
    return TriangleMesh(
        np.concatenate([s.vertices for s in surfaces]),
        np.concatenate([s.faces + int(o) for s, o in zip(surfaces, offsets, strict=True)]),
    )


def dumbbell(points: np.ndarray) -> np.ndarray:
    """Return the distance to two balls of 8 mm with a bar of 7 mm between them."""
    pair = np.minimum(ball(points, (-10, 0, 0), 8.0), ball(points, (10, 0, 0), 8.0))
    bar = np.maximum(np.hypot(points[..., 1], points[..., 2]) - 3.5, np.abs(points[..., 0]) - 8.0)
    return np.asarray(np.minimum(pair, bar))


@BOTH
def test_two_seeds_in_one_dumbbell(topology: Topology) -> None:
    points, affine = grid(44)
    field = field_of(dumbbell(points))
    seed = joined(icosphere((-10, 0, 0), 4.0, 2), icosphere((10, 0, 0), 4.0, 2))
    result = normal_flow(field, None, affine, seed, replace(COARSE, topology=topology), threshold=0.0)
    assert_sound(result, parts=1 if topology == "adaptive" else 2)
    assert result.converged
    x, y, z = result.mesh.vertices.T
    # What is kept apart leaves a seam in the middle of the bar; what merges does not.
    assert ((np.abs(x) < 4.0) & (np.hypot(y, z) < 1.5)).any() == (topology == "preserve")


@BOTH
def test_a_seed_that_flows_around_a_ring(topology: Topology) -> None:
    points, affine = grid(40)
    ring = np.hypot(np.hypot(points[..., 0], points[..., 1]) - 12.0, points[..., 2]) - 4.5
    params = replace(COARSE, topology=topology)
    result = normal_flow(field_of(ring), None, affine, icosphere((12, 0, 0), 3.0, 2), params, threshold=0.0)
    assert_sound(result, genus=1 if topology == "adaptive" else 0)
    if topology == "adaptive":
        x, y, z = result.mesh.vertices.T
        # The whole of it is the ring's surface: no seam is left. A few vertices may still be on their way.
        off = np.abs(np.hypot(np.hypot(x, y) - 12.0, z) - 4.5)
        assert np.percentile(off, 99) < 0.2
        assert off.max() < 0.6


@BOTH
def test_a_neck_that_nothing_supports(topology: Topology) -> None:
    points, affine = grid(44)
    pair = np.minimum(ball(points, (-10, 0, 0), 8.0), ball(points, (10, 0, 0), 8.0))
    seed = surface_of(dumbbell(points) < 0, affine)
    result = normal_flow(field_of(pair), None, affine, seed, replace(COARSE, topology=topology), threshold=0.0)
    assert_sound(result, parts=2 if topology == "adaptive" else 1)
    if topology == "adaptive":
        assert np.abs(result.mesh.vertices[:, 0]).min() > 1.5


def test_a_shell_closes_around_its_necrosis() -> None:
    points, affine = grid(36)
    radius = np.linalg.norm(points, axis=-1)
    shell = np.maximum(radius - 14.0, 8.0 - radius)
    params = replace(COARSE, topology="adaptive")
    result = normal_flow(field_of(shell), None, affine, icosphere((11, 0, 0), 2.0, 2), params, threshold=0.0)
    # An outer and an inner sphere, the inner one facing the necrosis.
    assert_sound(result, parts=2)
    inside = rasterize(result.mesh, Volume(shell, affine))
    assert (inside & (shell < 0)).sum() / (inside | (shell < 0)).sum() > 0.93


def test_fronts_on_both_sides_of_a_gap_stay_apart() -> None:
    points, affine = grid(40)
    # 1.2 mm of nothing between two slabs: nearer than fronts may come, but not object.
    slabs = np.minimum(ball(points, (-8.6, 0, 0), 8.0), ball(points, (8.6, 0, 0), 8.0))
    seed = joined(icosphere((-8.6, 0, 0), 5.0, 2), icosphere((8.6, 0, 0), 5.0, 2))
    result = normal_flow(field_of(slabs, 3.0), None, affine, seed, replace(COARSE, topology="adaptive"), threshold=0.0)
    assert_sound(result, parts=2)


def test_the_same_input_gives_the_same_bytes() -> None:
    points, affine = grid(44)
    seed = joined(icosphere((-10, 0, 0), 4.0, 2), icosphere((10, 0, 0), 4.0, 2))
    params = replace(COARSE, topology="adaptive", edge_lengths=(2.0,))
    runs = [normal_flow(field_of(dumbbell(points)), None, affine, seed, params, threshold=0.0) for _ in range(2)]
    assert runs[0].reconnections > 0
    assert runs[0].mesh.same_as(runs[1].mesh)


def test_a_surface_with_nothing_to_change_is_left_alone() -> None:
    def nowhere(grid: Volume) -> np.ndarray:
        return np.zeros(grid.shape, dtype=np.bool_)

    assert reconnected(icosphere(radius=6.0), nowhere, 1.5) is None


def test_two_balls_merge_only_where_object_lies_between_them() -> None:
    pair = joined(icosphere((-6.5, 0, 0), 6.0, 3), icosphere((6.5, 0, 0), 6.0, 3))
    merged = reconnected(pair, lambda grid: np.ones(grid.shape, dtype=np.bool_), 1.0, cell=0.5)
    assert merged is not None
    assert merged.component_count == 1
    assert merged.genus == 0
    assert merged.volume > pair.volume
    assert reconnected(pair, lambda grid: np.zeros(grid.shape, dtype=np.bool_), 1.0, cell=0.5) is None


def test_parts_that_enclose_next_to_nothing_are_left_out() -> None:
    large, small = icosphere((0, 0, 0), 5.0, 2), icosphere((9, 0, 0), 0.5, 1)
    kept = without_remains(joined(large, small), 2.0)
    assert kept.component_count == 1
    assert len(kept.vertices) == len(large.vertices)
    both = joined(large, icosphere((9, 0, 0), 1.0, 1))
    assert without_remains(both, 2.0) is both

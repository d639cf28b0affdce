"""The conservative test of two triangles, against exact predicates and against figures whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from shapery_geometry.intersections import self_intersections, triangles_intersect
from shapery_geometry.mesh import TriangleMesh
from shapery_segmentation.mesh import _contact_kernels as kernels

GAP = 1e-4


@njit
def _touching(ia, p, ib, q, gap):
    a = ((p[0, 0], p[0, 1], p[0, 2]), (p[1, 0], p[1, 1], p[1, 2]), (p[2, 0], p[2, 1], p[2, 2]))
    b = ((q[0, 0], q[0, 1], q[0, 2]), (q[1, 0], q[1, 1], q[1, 2]), (q[2, 0], q[2, 1], q[2, 2]))
    na = kernels.cross(kernels.subtract(a[1], a[0]), kernels.subtract(a[2], a[0]))
    nb = kernels.cross(kernels.subtract(b[1], b[0]), kernels.subtract(b[2], b[0]))
    la, lb = np.sqrt(kernels.dot(na, na)), np.sqrt(kernels.dot(nb, nb))
    ua = (na[0] / la, na[1] / la, na[2] / la) if la > 0.0 else (0.0, 0.0, 0.0)
    ub = (nb[0] / lb, nb[1] / lb, nb[2] / lb) if lb > 0.0 else (0.0, 0.0, 0.0)
    return kernels.touching((ia[0], ia[1], ia[2]), a, ua, (ib[0], ib[1], ib[2]), b, ub, gap)


def touching(points: np.ndarray, first: tuple[int, int, int], second: tuple[int, int, int], gap: float = GAP) -> bool:
    """Ask about two faces over rows of `points`."""
    a, b = np.array(first), np.array(second)
    return bool(_touching(a, points[a], b, points[b], gap))


def exact(points: np.ndarray, first: tuple[int, int, int], second: tuple[int, int, int]) -> bool:
    return len(self_intersections(TriangleMesh(points, np.array([first, second])))) > 0


coordinates = st.integers(-4, 4)
"""A coarse lattice: triangles share planes, edges and points all the time."""


@given(st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=6, max_size=6, unique=True))
@settings(max_examples=300, deadline=None)
@pytest.mark.slow
def test_triangles_without_common_vertex_never_count_as_apart_when_they_meet(rows: list[tuple[int, int, int]]) -> None:
    p = np.array(rows, dtype=np.float64)
    if triangles_intersect(p[:3], p[3:]):
        assert touching(p, (0, 1, 2), (3, 4, 5))
    else:
        # On this lattice what is apart is apart by more than 1e-3, and the test is complete.
        areas = TriangleMesh(p, [[0, 1, 2], [3, 4, 5]]).face_areas
        assert areas.min() == 0 or not touching(p, (0, 1, 2), (3, 4, 5))


@given(st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=5, max_size=5, unique=True))
@settings(max_examples=300, deadline=None)
def test_triangles_with_one_common_vertex(rows: list[tuple[int, int, int]]) -> None:
    p = np.array(rows, dtype=np.float64)
    if TriangleMesh(p, [[0, 1, 2], [0, 3, 4]]).face_areas.min() == 0:
        return
    assert touching(p, (0, 1, 2), (0, 3, 4)) == exact(p, (0, 1, 2), (0, 3, 4))


@given(st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=4, max_size=4, unique=True))
@settings(max_examples=200, deadline=None)
def test_triangles_with_a_common_edge(rows: list[tuple[int, int, int]]) -> None:
    p = np.array(rows, dtype=np.float64)
    if TriangleMesh(p, [[0, 1, 2], [1, 0, 3]]).face_areas.min() == 0:
        return
    assert touching(p, (0, 1, 2), (1, 0, 3)) == exact(p, (0, 1, 2), (1, 0, 3))


@given(st.integers(0, 2**32 - 1), st.floats(-3, 0))
@settings(max_examples=100, deadline=None)
def test_no_random_pair_that_meets_counts_as_apart(seed: int, flatness: float) -> None:
    rng = np.random.default_rng(seed)
    # Nearly flat pairs are the hard ones.
    p = rng.normal(size=(6, 3)) * (1.0, 1.0, 10.0**flatness)
    if triangles_intersect(p[:3], p[3:]):
        assert touching(p, (0, 1, 2), (3, 4, 5))
    if exact(p[:5], (0, 1, 2), (0, 3, 4)):
        assert touching(p, (0, 1, 2), (0, 3, 4))


@pytest.mark.parametrize("distance", [0.5, 1.5])
def test_clearance_is_kept_between_parallel_faces(distance: float) -> None:
    p = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, distance * GAP], [1, 0, distance * GAP], [0, 1, distance * GAP]]
    )
    assert touching(p, (0, 1, 2), (3, 4, 5)) == (distance < 1.0)


def test_opposite_angles_in_one_plane_do_not_touch() -> None:
    # Two faces of a flat fan, on either side of their common vertex, whose edges lie on two common lines.
    p = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [-1, 0, 0], [-0.5, -1, 0]], dtype=np.float64)
    assert not touching(p, (0, 1, 2), (0, 3, 4))


def test_all_pairs_of_a_flat_fan_are_apart() -> None:
    angles = np.arange(6) * np.pi / 3
    p = np.concatenate((np.zeros((1, 3)), np.stack((np.cos(angles), np.sin(angles), 0 * angles), axis=1)))
    faces = [(0, 1 + k, 1 + (k + 1) % 6) for k in range(6)]
    for i in range(6):
        for j in range(i):
            assert not touching(p, faces[i], faces[j])


def test_folded_faces_touch_and_open_ones_do_not() -> None:
    for degrees, expected in ((0.0, True), (0.01, True), (5.0, False), (90.0, False), (180.0, False)):
        t = np.deg2rad(degrees)
        p = np.array([[0, 0, 0], [1, 0, 0], [0.3, 1, 0], [0.6, np.cos(t), np.sin(t)]])
        assert touching(p, (0, 1, 2), (1, 0, 3)) == expected


def test_the_same_vertices_twice_touch() -> None:
    p = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float64)
    assert touching(p, (0, 1, 2), (2, 1, 0))


def test_faces_without_area_count_as_touching_their_neighbours() -> None:
    p = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], dtype=np.float64)
    assert touching(p, (0, 1, 2), (1, 0, 3))

"""Self-intersections against an independent reference in rational numbers, and constructed cases by name."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray

from shapery_geometry import _predicates_kernels as predicates
from shapery_geometry.intersections import self_intersections, triangles_intersect
from shapery_geometry.mesh import TriangleMesh, icosphere

Point = tuple[Fraction, Fraction, Fraction]


def minus(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def dot(a: Point, b: Point) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Point, b: Point) -> Point:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def half_spaces(triangle: list[Point]) -> list[tuple[Point, Point]]:
    """Pairs (origin, normal) with a triangle = all x where normal · (x − origin) ≥ 0 for all of them."""
    a, b, c = triangle
    normal = cross(minus(b, a), minus(c, a))
    both = []
    if any(normal):
        both = [(a, normal)]
        sides = [(p, cross(normal, minus(q, p))) for p, q in ((a, b), (b, c), (c, a))]
    else:
        p, q = max(combinations(triangle, 2), key=lambda ends: dot(minus(*ends), minus(*ends)))
        along = minus(q, p)
        axes: list[Point] = [tuple(Fraction(int(i == k)) for i in range(3)) for k in range(3)]  # type: ignore[misc]
        both = [(p, cross(along, axis)) for axis in axes] if any(along) else [(p, axis) for axis in axes]
        sides = [(p, along), (q, minus(p, q))]
    return sides + both + [(origin, minus(minus(n, n), n)) for origin, n in both]


def clip(polygon: list[Point], origin: Point, normal: Point) -> list[Point]:
    """Corners of the part of a convex set, given as the hull of a cycle of points, in a closed half space."""
    result = []
    for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        s, t = dot(normal, minus(p, origin)), dot(normal, minus(q, origin))
        if s >= 0:
            result.append(p)
        if (s > 0 and t < 0) or (s < 0 and t > 0):
            r = s / (s - t)
            step = minus(q, p)
            result.append((p[0] + r * step[0], p[1] + r * step[1], p[2] + r * step[2]))
    return result


def common_points(first: list[Point], second: list[Point]) -> list[Point]:
    """Points whose hull is the intersection of two triangles."""
    polygon = list(second)
    for origin, normal in half_spaces(first):
        polygon = clip(polygon, origin, normal)
    return polygon


def on_segment(x: Point, p: Point, q: Point) -> bool:
    along, to = minus(q, p), minus(x, p)
    if not any(along):
        return not any(to)
    return not any(cross(along, to)) and 0 <= dot(along, to) <= dot(along, along)


def reference_pairs(points: NDArray[np.float64], faces: NDArray[np.int32]) -> list[list[int]]:
    exact: list[Point] = [tuple(Fraction(float(x)) for x in row) for row in points]  # type: ignore[misc]
    pairs = []
    for i, j in combinations(range(len(faces)), 2):
        shared = sorted(set(faces[i].tolist()) & set(faces[j].tolist()))
        if len(shared) == 3:
            pairs.append([i, j])
            continue
        found = common_points([exact[k] for k in faces[i]], [exact[k] for k in faces[j]])
        if shared:
            p, q = exact[shared[0]], exact[shared[-1]]
            found = [x for x in found if not on_segment(x, p, q)]
        if found:
            pairs.append([i, j])
    return pairs


@pytest.mark.parametrize("size", [2, 3, 5])
def test_random_triangles_on_a_small_grid_against_the_reference(size: int) -> None:
    # few coordinates make touching, coplanar, collinear and degenerate cases frequent
    rng = np.random.default_rng(size)
    seen: dict[tuple[int, bool], int] = {}
    for _ in range(350):
        points = rng.integers(0, size, (6, 3)).astype(float)
        shared = int(rng.integers(0, 3))
        faces = np.array([[0, 1, 2], [3, 4, 5]])
        faces[1, :shared] = rng.permutation(3)[:shared]
        faces[1] = rng.permutation(faces[1])
        mesh = TriangleMesh(points, faces)
        expected = reference_pairs(mesh.vertices, mesh.faces)
        assert self_intersections(mesh).tolist() == expected, (points.tolist(), faces.tolist())
        seen[shared, bool(expected)] = seen.get((shared, bool(expected)), 0) + 1
    # each case occurred, or the comparison says little
    assert len(seen) == 6
    assert min(seen.values()) >= 2


def test_random_soup_against_the_reference() -> None:
    rng = np.random.default_rng(1)
    points = rng.integers(0, 40, (45, 3)) * 0.1
    mesh = TriangleMesh(points, np.array([rng.permutation(45)[:3] for _ in range(60)]))
    expected = reference_pairs(mesh.vertices, mesh.faces)
    found = self_intersections(mesh)
    assert found.dtype == np.int32
    assert found.tolist() == expected
    assert len(expected) > 50
    for count in (1, 7):
        some = self_intersections(mesh, limit=count)
        assert len(some) == count
        assert all(pair in expected for pair in some.tolist())
    asked = [3, 17, 44]
    wanted = [pair for pair in expected if set(pair) & set(asked)]
    assert self_intersections(mesh, faces=asked).tolist() == wanted
    mask = np.isin(np.arange(60), asked)
    assert self_intersections(mesh, faces=mask).tolist() == wanted


@pytest.mark.parametrize("scale", [1e-250, 1e-3, 1.0, 1e30, 1e200])
def test_the_unit_does_not_matter(scale: float) -> None:
    rng = np.random.default_rng(5)
    points = rng.integers(-8, 8, (30, 3)) * 0.125
    faces = np.array([rng.permutation(30)[:3] for _ in range(25)])
    expected = reference_pairs(points, faces.astype(np.int32))
    assert self_intersections(TriangleMesh(points * 2.0 ** round(np.log2(scale)), faces)).tolist() == expected


def test_an_embedded_sphere_has_none_and_a_dent_through_its_other_side_has_some() -> None:
    sphere = icosphere(subdivisions=4)
    assert len(self_intersections(sphere)) == 0
    points = sphere.vertices.copy()
    points[0] *= -1.2
    pairs = self_intersections(TriangleMesh(points, sphere.faces))
    moved = (sphere.faces == 0).any(axis=1)
    assert len(pairs) > 0
    assert moved[pairs].any(axis=1).all()


def test_two_spheres_intersect_where_they_overlap_only() -> None:
    one = icosphere(subdivisions=3)
    for shift, expected in ((0.0, False), (0.5, True), (1.9, True), (2.1, False)):
        radius = 0.5 if shift == 0 else 1.0
        both = TriangleMesh(
            np.concatenate((one.vertices, one.vertices * radius + [shift, 0.01, 0.02])),
            np.concatenate((one.faces, one.faces + len(one.vertices))),
        )
        pairs = self_intersections(both)
        assert bool(len(pairs)) is expected
        assert ((pairs < len(one.faces)).sum(axis=1) == 1).all()


BASE = [[0.0, 0, 0], [4, 0, 0], [0, 4, 0]]


@pytest.mark.parametrize(
    ("name", "other", "expected"),
    [
        ("pierces", [[1, 1, -1], [1, 1, 1], [2, 1, 1]], True),
        ("passes beside", [[5, 5, -1], [5, 5, 1], [6, 5, 1]], False),
        ("corner on the face", [[1, 1, 0], [1, 1, 1], [2, 1, 1]], True),
        ("corner just above the face", [[1, 1, 5e-324], [1, 1, 1], [2, 1, 1]], False),
        ("corner on a side", [[2, 2, 0], [3, 3, 1], [3, 3, -1]], True),
        ("corner just beside a side", [[2 + 2**-51, 2, 0], [3, 3, 1], [3, 3, -1]], False),
        ("corner on a corner", [[4, 0, 0], [5, 0, 1], [5, 0, -1]], True),
        ("sides cross", [[1, -1, -1], [1, 1, 1], [1, -3, 1]], True),
        ("side along a side", [[1, 0, 0], [3, 0, 0], [2, 0, 1]], True),
        ("parallel above", [[0, 0, 1], [4, 0, 1], [0, 4, 1]], False),
        ("coplanar inside", [[1, 1, 0], [2, 1, 0], [1, 2, 0]], True),
        ("coplanar around", [[-9, -9, 0], [20, -9, 0], [-9, 20, 0]], True),
        ("coplanar beside, boxes overlap", [[3, 3, 0], [4, 3, 0], [3, 4, 0]], False),
        ("coplanar, touching in a corner", [[4, 0, 0], [6, 0, 0], [6, 2, 0]], True),
        ("coplanar, star without corners inside", [[3, 3, 0], [-1, 1.5, 0], [1.5, -1, 0]], True),
        ("the same triangle", BASE, True),
        ("a segment through", [[1, 1, -1], [1, 1, 1], [1, 1, 0.5]], True),
        ("a segment in the plane beside", [[3, 3, 0], [4, 4, 0], [5, 5, 0]], False),
        ("a point on it", [[1, 1, 0], [1, 1, 0], [1, 1, 0]], True),
        ("a point off it", [[1, 1, 1], [1, 1, 1], [1, 1, 1]], False),
    ],
)
def test_constructed_triangles(name: str, other: list[list[float]], expected: bool) -> None:
    rng = np.random.default_rng(2)
    for _ in range(4):
        first, second = rng.permutation(np.array(BASE)), rng.permutation(np.array(other, dtype=float))
        assert triangles_intersect(first, second) is expected, name
        assert triangles_intersect(second, first) is expected, name


def test_segments_without_area() -> None:
    def degenerate(p: list[float], q: list[float]) -> list[list[float]]:
        return [p, q, q]

    assert triangles_intersect(degenerate([0, 0, 0], [2, 2, 2]), degenerate([0, 2, 0], [2, 0, 2]))
    assert not triangles_intersect(degenerate([0, 0, 0], [2, 2, 2]), degenerate([0, 2, 0], [2, 0, 2.5]))
    assert triangles_intersect(degenerate([0, 0, 0], [1, 2, 3]), degenerate([0.5, 1, 1.5], [2, 4, 6]))
    assert not triangles_intersect(degenerate([0, 0, 0], [1, 2, 3]), degenerate([1.5, 3, 4.5], [2, 4, 6]))


@pytest.mark.parametrize(
    ("name", "points", "faces", "expected"),
    [
        ("an open book", [[0, 0, 0], [0, 0, 1], [1, 0, 0], [1, 1, 0]], [[0, 1, 2], [1, 0, 3]], False),
        ("a flat book", [[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 0, 0]], [[0, 1, 2], [1, 0, 3]], False),
        ("a closed book", [[0, 0, 0], [0, 0, 1], [1, 0, 0], [2, 0, 0]], [[0, 1, 2], [1, 0, 3]], True),
        ("almost closed", [[0, 0, 0], [0, 0, 1], [1, 0, 0], [2, 1e-300, 0]], [[0, 1, 2], [1, 0, 3]], False),
        ("the same face turned", [[0, 0, 0], [0, 0, 1], [1, 0, 0]], [[0, 1, 2], [2, 1, 0]], True),
        ("two in one corner, apart", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 1]], [[0, 1, 2], [0, 3, 4]],
         False),
        ("two in one corner, crossing", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1], [1, 1, -1]],
         [[0, 1, 2], [0, 3, 4]], True),
        ("two in one corner, side along side", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [0, 0, 1]],
         [[0, 1, 2], [0, 3, 4]], True),
        ("two in one corner, flat and apart", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]],
         [[0, 1, 2], [0, 3, 4]], False),
        ("two in one corner, one within the other", [[0, 0, 0], [4, 0, 0], [0, 4, 0], [2, 1, 0], [1, 2, 0]],
         [[0, 1, 2], [0, 3, 4]], True),
        ("a corner at the same place but not the same",
         [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [-1, 0, 0], [0, -1, 1]], [[0, 1, 2], [3, 4, 5]], True),
        ("a side without length", [[0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [1, 0, 3]], False),
        ("a side without length, one behind the other", [[0, 0, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0]],
         [[0, 1, 2], [1, 0, 3]], True),
    ],
)  # fmt: skip
def test_constructed_neighbours(name: str, points: list[list[float]], faces: list[list[int]], expected: bool) -> None:
    mesh = TriangleMesh(points, faces)
    assert bool(len(self_intersections(mesh))) is expected, name
    assert bool(reference_pairs(mesh.vertices, mesh.faces)) is expected, name


def test_predicates_are_exact_where_plain_arithmetic_is_not() -> None:
    rng = np.random.default_rng(3)
    zeros = wrong = 0
    for k in range(1500):
        points = rng.normal(size=(4, 3)) * 10.0 ** rng.integers(-8, 8)
        points[3] = rng.dirichlet(np.ones(3)) @ points[:3]
        if k % 3 == 0:
            points = np.round(points * 2.0**20) / 2.0**20 + rng.integers(-5, 5) * 1e6
        if k % 3 == 1:
            points[3] = points[0] + 0.5 * (points[1] - points[0])
        a, b, c, d = [tuple(Fraction(float(x)) for x in row) for row in points]
        value = dot(minus(a, d), cross(minus(b, d), minus(c, d)))  # type: ignore[arg-type]
        expected = int(value > 0) - int(value < 0)
        assert predicates.orient3d(points, 0, 1, 2, 3) == expected
        assert predicates.orient3d_exact(points, 0, 1, 2, 3) == expected
        plain = np.sign(np.linalg.det(points[:3] - points[3]))
        wrong += plain != expected
        planar = (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0])
        assert predicates.orient2d(points, 0, 1, 2, 0, 1) == int(planar > 0) - int(planar < 0)
        zeros += expected == 0
    assert zeros > 5
    assert wrong > 100


def test_nearly_collinear_points_in_the_plane() -> None:
    # the classic picture: a grid of neighbouring doubles around a diagonal line
    step = 2.0**-53
    wrong = 0
    for i in range(24):
        for j in range(24):
            points = np.array([[0.5 + i * step, 0.5 + j * step, 0], [12, 12, 0], [24, 24, 0]])
            (a, b), (c, d), (e, f) = [(Fraction(float(x)), Fraction(float(y))) for x, y, _ in points]
            value = (a - e) * (d - f) - (b - f) * (c - e)
            expected = int(value > 0) - int(value < 0)
            assert predicates.orient2d(points, 0, 1, 2, 0, 1) == expected
            assert predicates.orient2d_exact(points, 0, 1, 2, 0, 1) == expected
            wrong += np.sign((points[0, 0] - 24) * (12 - 24) - (points[0, 1] - 24) * (12 - 24)) != expected
    assert wrong > 0


def test_a_mesh_without_faces() -> None:
    assert self_intersections(TriangleMesh(np.eye(3), [])).shape == (0, 2)

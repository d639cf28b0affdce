"""Operators: closed forms, identities, order of convergence, and the fast path against the plain one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_geometry.bvh import build_face_tree
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.operators import (
    angle_defects,
    closest_points,
    cotangent_laplacian,
    gaussian_curvature,
    mass_matrix,
    mean_curvature,
    principal_curvatures,
    sample_surface,
    surface_distances,
    vertex_areas,
)
from shapery_geometry.operators._closest_point_kernels import closest_on_triangle

RIGHT = TriangleMesh([[0, 0, 0], [2, 0, 0], [0, 2, 0]], [[0, 1, 2]])
TETRAHEDRON = TriangleMesh(
    [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
)


def shaken(seed: int = 0, subdivisions: int = 2, holes: int = 0) -> TriangleMesh:
    rng = np.random.default_rng(seed)
    sphere = icosphere(subdivisions=subdivisions)
    points = sphere.vertices * (1 + 0.2 * rng.normal(size=(len(sphere.vertices), 1)))
    return TriangleMesh(points, sphere.faces[holes:])


def test_laplacian_of_one_triangle() -> None:
    # cotangents: 0 at the right angle, 1 at the others
    expected = 0.5 * np.array([[2, -1, -1], [-1, 1, 0], [-1, 0, 1]])
    assert cotangent_laplacian(RIGHT).toarray() == pytest.approx(expected, abs=1e-15)
    assert vertex_areas(RIGHT) == pytest.approx(np.full(3, 2 / 3))
    assert vertex_areas(RIGHT, "mixed") == pytest.approx([1, 0.5, 0.5])
    assert mass_matrix(RIGHT).toarray() == pytest.approx(np.diag(np.full(3, 2 / 3)))
    assert mass_matrix(RIGHT, lumped=False).toarray() == pytest.approx((np.eye(3) + 1) / 6)


def test_laplacian_of_the_regular_tetrahedron() -> None:
    # each edge lies between two equal sided triangles: weight cot 60°
    weight = 1 / np.sqrt(3)
    assert cotangent_laplacian(TETRAHEDRON).toarray() == pytest.approx(weight * (4 * np.eye(4) - 1))
    assert angle_defects(TETRAHEDRON) == pytest.approx(np.full(4, np.pi))
    area = np.sqrt(3) / 4 * 8
    assert vertex_areas(TETRAHEDRON) == pytest.approx(np.full(4, area))
    assert vertex_areas(TETRAHEDRON, "mixed") == pytest.approx(np.full(4, area))
    assert gaussian_curvature(TETRAHEDRON) == pytest.approx(np.full(4, np.pi / area))


def test_mixed_areas_of_an_obtuse_triangle() -> None:
    mesh = TriangleMesh([[0, 0, 0], [4, 0, 0], [-1, 1, 0]], [[0, 1, 2]])
    assert vertex_areas(mesh, "mixed") == pytest.approx([1, 0.5, 0.5])
    with pytest.raises(ValueError, match="barycentric"):
        vertex_areas(mesh, "voronoi")  # type: ignore[arg-type]


@pytest.mark.parametrize("holes", [0, 20])
def test_identities_of_the_laplacian(holes: int) -> None:
    mesh = shaken(holes=holes)
    laplacian = cotangent_laplacian(mesh)
    assert abs(laplacian @ np.ones(len(mesh.vertices))).max() < 1e-13
    assert abs(laplacian - laplacian.T).max() < 1e-15
    values = np.linalg.eigvalsh(laplacian.toarray())
    # as many zeros as components, here also for the vertices that lost all faces
    zeros = mesh.component_count + int((~mesh.topology.referenced).sum())
    assert (np.abs(values[:zeros]) < 1e-12).all()
    assert values[zeros] > 1e-3
    for lumped in (True, False):
        assert mass_matrix(mesh, lumped=lumped).sum() == pytest.approx(mesh.area)
    assert vertex_areas(mesh, "mixed").sum() == pytest.approx(mesh.area)
    assert vertex_areas(mesh, "mixed").min() >= 0


def test_laplacian_is_the_energy_of_the_gradient() -> None:
    # a linear function on a flat mesh has the energy |g|² × area, and is harmonic inside
    rng = np.random.default_rng(0)
    u, v = np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij")
    points = np.stack((u.ravel(), v.ravel(), np.zeros(30)), axis=1)
    i = np.arange(30).reshape(6, 5)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    faces = np.concatenate((np.stack((a, b, c), 1), np.stack((a, c, d), 1)))
    inner = np.zeros((6, 5), dtype=bool)
    inner[1:-1, 1:-1] = True
    points[inner.ravel(), :2] += rng.uniform(-0.2, 0.2, (int(inner.sum()), 2))
    mesh = TriangleMesh(points, faces)
    gradient = np.array([0.7, -1.3, 0])
    values = points @ gradient
    laplacian = cotangent_laplacian(mesh)
    assert values @ (laplacian @ values) == pytest.approx(gradient @ gradient * 20)
    assert (laplacian @ values)[inner.ravel()] == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize(
    ("mesh", "characteristic"), [(shaken(), 2), (shaken(holes=1), 1), (TETRAHEDRON, 2), (RIGHT, 1)]
)
def test_defects_sum_to_the_euler_characteristic(mesh: TriangleMesh, characteristic: int) -> None:
    assert mesh.euler_characteristic == characteristic
    assert angle_defects(mesh).sum() == pytest.approx(2 * np.pi * characteristic, abs=1e-10)


def test_curvatures_of_spheres() -> None:
    for radius in (0.1, 1, 25.0):
        sphere = icosphere((3, 4, 5), radius, 4)
        assert mean_curvature(sphere) == pytest.approx(np.full(len(sphere.vertices), 1 / radius), rel=1e-4)
        # measured: within 0.2 % on this mesh of 2,562 vertices
        assert gaussian_curvature(sphere) == pytest.approx(np.full(len(sphere.vertices), radius**-2), rel=3e-3)
        low, high = principal_curvatures(sphere)
        assert (low <= high).all()
        assert low.mean() == pytest.approx(1 / radius, rel=0.03)
        assert mean_curvature(sphere.flipped()).mean() == pytest.approx(-1 / radius, rel=1e-4)


def test_curvature_of_a_torus_converges() -> None:
    large, small = 2.0, 0.5
    errors = []
    for n in (16, 32, 64):
        rings = 2 * n
        u, w = np.meshgrid(np.arange(rings), np.arange(n), indexing="ij")
        a, b = 2 * np.pi * u.ravel() / rings, 2 * np.pi * w.ravel() / n
        distance = large + small * np.cos(b)
        points = np.stack((distance * np.cos(a), distance * np.sin(a), small * np.sin(b)), axis=1)
        i = np.arange(rings * n).reshape(rings, n)
        right, up = np.roll(i, -1, 0), np.roll(i, -1, 1)
        both = np.roll(right, -1, 1)
        faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((i, right, both), (i, both, up))])
        mesh = TriangleMesh(points, faces)
        assert mesh.volume > 0
        expected = (1 / small + np.cos(b) / distance) / 2
        errors.append(np.abs(mean_curvature(mesh) - expected).mean())
        gaussian = np.cos(b) / (small * distance)
        assert np.abs(gaussian_curvature(mesh) - gaussian).mean() < 12 / n**2
    # of second order: the error falls by four
    for coarse, fine in pairwise(errors):
        assert coarse / fine > 3.5


def test_the_boundary_has_no_curvature_and_degenerate_faces_do_no_harm() -> None:
    mesh = shaken(holes=1)
    boundary = np.unique(mesh.boundary_edges)
    for values in (mean_curvature(mesh), gaussian_curvature(mesh), *principal_curvatures(mesh)):
        assert np.flatnonzero(np.isnan(values)).tolist() == boundary.tolist()
    flat = TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [5, 5, 5]], [[0, 1, 2], [0, 1, 3], [1, 1, 3]])
    assert np.isfinite(cotangent_laplacian(flat).toarray()).all()
    assert cotangent_laplacian(flat).toarray().sum() == pytest.approx(0, abs=1e-14)
    assert angle_defects(flat)[4] == 0
    assert np.isnan(mean_curvature(flat)[4])


# distances --------------------------------------------------------------------------------------------------------


def nearest_by_search(a: np.ndarray, b: np.ndarray, c: np.ndarray, p: np.ndarray) -> float:
    """Nearest distance to a triangle by refining a grid of barycentric weights: slow, and needs no geometry."""
    centre, size = np.array([1 / 3, 1 / 3]), 1.0
    best = np.inf
    for _ in range(40):
        s, t = np.meshgrid(np.linspace(-size, size, 9), np.linspace(-size, size, 9))
        weights = np.stack((centre[0] + s.ravel(), centre[1] + t.ravel()), axis=1)
        weights = np.clip(weights, 0, 1)
        weights /= np.maximum(weights.sum(axis=1, keepdims=True), 1)
        points = a + weights[:, :1] * (b - a) + weights[:, 1:] * (c - a)
        squares = ((points - p) ** 2).sum(axis=1)
        k = int(squares.argmin())
        best = min(best, float(squares[k]))
        centre, size = weights[k], size * 0.6
    return float(np.sqrt(best))


def test_nearest_point_of_one_triangle() -> None:
    rng = np.random.default_rng(0)
    for _ in range(60):
        a, b, c = rng.normal(size=(3, 3)) * rng.uniform(0.1, 3, (3, 1))
        p = rng.normal(size=3) * 2
        w0, w1, w2, square = closest_on_triangle(a, b, c, p)
        assert min(w0, w1, w2) >= 0
        assert w0 + w1 + w2 == pytest.approx(1)
        assert np.linalg.norm(w0 * a + w1 * b + w2 * c - p) == pytest.approx(np.sqrt(square), rel=1e-9)
        assert np.sqrt(square) == pytest.approx(nearest_by_search(a, b, c, p), rel=1e-5)


@pytest.mark.parametrize(
    ("point", "distance"),
    [((0.5, 0.5, 3), 3), ((0.5, 0.5, 0), 0), ((-3, -4, 0), 5), ((5, 0, 0), 3), ((1, -2, 0), 2), ((2, 2, 0), 2**0.5),
     ((0, 2, 1), 1)],
)  # fmt: skip
def test_nearest_point_in_closed_form(point: tuple[float, ...], distance: float) -> None:
    found = closest_points(RIGHT, [point])
    assert found.distances == pytest.approx([distance])
    assert np.linalg.norm(found.points - point) == pytest.approx(distance)


def test_degenerate_triangles_are_segments_and_points() -> None:
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [3, 0, 0]], [[0, 1, 2]])
    assert closest_points(mesh, [[2, 1, 0], [5, 0, 0], [-1, 0, 0]]).distances == pytest.approx([1, 2, 1])
    point = TriangleMesh([[1, 1, 1]], [[0, 0, 0]])
    assert closest_points(point, [[1, 1, 3]]).distances == pytest.approx([2])


@pytest.mark.parametrize("count", [1, 2, 3, 5, 9, 33])
def test_the_tree_finds_what_a_search_of_all_faces_finds(count: int) -> None:
    rng = np.random.default_rng(count)
    points = rng.normal(size=(count + 2, 3))
    mesh = TriangleMesh(points, [rng.permutation(count + 2)[:3] for _ in range(count)])
    queries = rng.normal(size=(50, 3)) * 2
    found = closest_points(mesh, queries, tree=build_face_tree(mesh))
    every = np.array([[closest_on_triangle(*mesh.corners[f], p)[3] for f in range(count)] for p in queries])
    assert found.distances == pytest.approx(np.sqrt(every.min(axis=1)))
    chosen = every[np.arange(50), found.faces]
    assert chosen == pytest.approx(every.min(axis=1))
    nearest = np.einsum("ik,ikj->ij", found.barycentric, mesh.corners[found.faces])
    assert nearest == pytest.approx(found.points)


def test_points_on_the_surface_are_at_no_distance() -> None:
    rng = np.random.default_rng(0)
    mesh = shaken()
    samples = sample_surface(mesh, 500, rng)
    # rounding of coordinates around 1
    assert closest_points(mesh, samples.points).distances.max() < 1e-14
    assert samples.points == pytest.approx(np.einsum("ik,ikj->ij", samples.barycentric, mesh.corners[samples.faces]))
    assert samples.barycentric.min() >= 0


def test_samples_are_spread_by_area() -> None:
    mesh = shaken(subdivisions=1)
    samples = sample_surface(mesh, 4000, np.random.default_rng(1))
    expected = 4000 * mesh.face_areas / mesh.area
    counts = np.bincount(samples.faces, minlength=len(mesh.faces))
    assert np.abs(counts - expected).max() <= 1
    # inside a triangle the mean of even points is its centre; 4000 points scatter by about 1 / sqrt(4000 · 18)
    assert samples.barycentric.mean(axis=0) == pytest.approx(np.full(3, 1 / 3), abs=0.02)
    again = sample_surface(mesh, 4000, np.random.default_rng(1))
    assert np.array_equal(samples.points, again.points)
    with pytest.raises(InvalidInput, match="no area"):
        sample_surface(TriangleMesh(np.eye(3), []), 3, np.random.default_rng(0))


@pytest.mark.parametrize("samples", [0, 3000])
def test_distances_of_concentric_spheres(samples: int) -> None:
    rng = np.random.default_rng(0)
    one, two = icosphere((1, 2, 3), 2, 4), icosphere((1, 2, 3), 2.5, 4)
    found = surface_distances(one, two, samples=samples, rng=rng)
    # both are inscribed polyhedra; their sides lie up to 0.3 % of the radius inside
    assert found.assd == pytest.approx(0.5, abs=2e-3)
    assert found.hd95 == pytest.approx(0.5, abs=5e-3)
    assert found.hausdorff == pytest.approx(0.5, abs=8e-3)
    swapped = surface_distances(two, one, samples=samples, rng=np.random.default_rng(5))
    assert swapped.assd == pytest.approx(found.assd, abs=1e-3)
    same = surface_distances(one, one, samples=samples, rng=rng)
    assert max(same.assd, same.hd95, same.hausdorff) < 1e-14


def test_distances_are_weighted_by_area_and_not_by_vertices() -> None:
    # a square of area 100 with one corner cut fine; the other lies 1 above it, the fine part 3
    base = TriangleMesh([[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]], [[0, 1, 2], [0, 2, 3]])
    lifted = TriangleMesh(base.vertices + np.array([0, 0, 1]), base.faces)
    sphere = icosphere((5, 5, 30), 0.01, 4)
    dense = TriangleMesh(
        np.concatenate((lifted.vertices, sphere.vertices)), np.concatenate((lifted.faces, sphere.faces + 4))
    )
    found = surface_distances(base, dense)
    # 2,562 vertices on an area of 0.001 do not count, but for the largest distance
    assert found.assd == pytest.approx(1, rel=1e-3)
    assert found.hd95 == pytest.approx(1)
    assert found.hausdorff == pytest.approx(30.01, rel=1e-6)


def test_hd95_leaves_out_a_twentieth_of_the_area() -> None:
    strip = np.arange(101.0)
    low, high = np.stack((strip, 0 * strip, 0 * strip), 1), np.stack((strip, 0 * strip + 1, 0 * strip), 1)
    i = np.arange(100)
    faces = np.concatenate((np.stack((i, i + 1, i + 102), 1), np.stack((i, i + 102, i + 101), 1)))
    flat = TriangleMesh(np.concatenate((low, high)), faces)
    # raised by little, so that the slope between does not change the areas
    for raised, expected in ((3, 0), (8, 0.1)):
        points = flat.vertices.copy()
        points[points[:, 0] < raised, 2] = 0.1
        assert surface_distances(TriangleMesh(points, faces), flat).hd95 == pytest.approx(expected, abs=1e-9)


def test_what_has_no_distance_is_refused() -> None:
    with pytest.raises(InvalidInput, match="without faces"):
        closest_points(TriangleMesh(np.eye(3), []), [[0, 0, 0]])
    with pytest.raises(InvalidInput, match="not finite"):
        closest_points(RIGHT, [[0, 0, np.nan]])
    with pytest.raises(InvalidInput, match="no area"):
        surface_distances(RIGHT, TriangleMesh(np.eye(3), []))
    with pytest.raises(ValueError, match="give rng"):
        surface_distances(RIGHT, RIGHT, samples=10)

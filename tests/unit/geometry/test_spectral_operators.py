"""Intrinsic triangulations, spectra, geodesics and rays: closed forms, invariances, and meshes that break others."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.operators import cotangent_laplacian
from shapery_geometry.operators.geodesics import GeodesicSurface, Links
from shapery_geometry.operators.intrinsic import intrinsic_delaunay
from shapery_geometry.operators.rays import first_hits
from shapery_geometry.operators.spectrum import laplacian_spectrum


def grid(n: int = 20, stretch: float = 1.0) -> TriangleMesh:
    """The unit square, `stretch` times as wide, of n × n cells cut along one diagonal."""
    x, y = np.meshgrid(np.linspace(0, stretch, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    points = np.stack((x.ravel(), y.ravel(), np.zeros(x.size)), axis=1)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    lower = np.stack((corner, corner + n + 1, corner + n + 2), axis=1)
    upper = np.stack((corner, corner + n + 2, corner + 1), axis=1)
    return TriangleMesh(points, np.concatenate((lower, upper)))


def test_the_sphere_has_the_spectrum_l_times_l_plus_one() -> None:
    triangles = intrinsic_delaunay(icosphere(subdivisions=4))
    values = laplacian_spectrum(triangles.laplacian(), triangles.vertex_areas(), 25).values
    exact = np.repeat([0, 2, 6, 12, 20], [1, 3, 5, 7, 9])
    # linear elements of size 0.06 are off by about h² λ / 12
    np.testing.assert_allclose(values, exact, rtol=0.02, atol=1e-8)


def test_the_square_has_the_spectrum_of_cosines() -> None:
    triangles = intrinsic_delaunay(grid(40))
    values = laplacian_spectrum(triangles.laplacian(), triangles.vertex_areas(), 8).values
    np.testing.assert_allclose(values / np.pi**2, [0, 1, 1, 2, 4, 4, 5, 5], rtol=0.01, atol=1e-8)


def test_eigenfunctions_are_orthonormal_and_solve_the_equation() -> None:
    triangles = intrinsic_delaunay(icosphere(subdivisions=3))
    laplacian, areas = triangles.laplacian(), triangles.vertex_areas()
    found = laplacian_spectrum(laplacian, areas, 30)
    np.testing.assert_allclose(found.functions.T @ (areas[:, None] * found.functions), np.eye(30), atol=1e-7)
    residual = laplacian @ found.functions - areas[:, None] * found.functions * found.values
    assert np.abs(residual).max() < 1e-6
    # what is constant stays, whatever time passes
    np.testing.assert_allclose(found.low_pass(np.full(len(areas), 3.0), 5.0), 3.0, atol=1e-6)


def test_parts_that_do_not_hang_together_are_refused() -> None:
    ball = icosphere(subdivisions=2)
    two = TriangleMesh(
        np.concatenate((ball.vertices, ball.vertices + 5)), np.concatenate((ball.faces, ball.faces + 162))
    )
    triangles = intrinsic_delaunay(two)
    with pytest.raises(InvalidInput, match="does not hang together"):
        laplacian_spectrum(triangles.laplacian(), triangles.vertex_areas(), 10)


def test_a_delaunay_mesh_keeps_its_laplacian() -> None:
    ball = icosphere(subdivisions=2)
    ours, plain = intrinsic_delaunay(ball).laplacian(), cotangent_laplacian(ball)
    np.testing.assert_allclose(ours.toarray(), plain.toarray(), atol=1e-9)


@given(st.floats(0.02, 50))
@settings(max_examples=15, deadline=None)
def test_stretched_triangles_get_weights_that_are_not_negative(stretch: float) -> None:
    mesh = grid(8, stretch)
    # sheared, so that all triangles become obtuse
    mesh = mesh.with_vertices(mesh.vertices + mesh.vertices[:, [1, 0, 2]] * [3.7, 0, 0])
    triangles = intrinsic_delaunay(mesh)
    dense = triangles.laplacian().toarray()
    inner = np.ones(len(dense), dtype=bool)
    inner[mesh.boundary_edges.ravel()] = False
    off = dense - np.diag(np.diag(dense))
    assert off[inner].max() < 1e-6
    np.testing.assert_allclose(dense.sum(axis=1), 0, atol=1e-8 * np.abs(dense).max())
    # flipping changes no area, mollification next to none
    assert triangles.face_areas.sum() == pytest.approx(mesh.area, rel=2e-3)


def test_faces_without_area_do_no_harm() -> None:
    mesh = grid(10)
    flat = np.concatenate((mesh.faces, [[0, 11, 22]]))
    triangles = intrinsic_delaunay(TriangleMesh(mesh.vertices, flat))
    values = laplacian_spectrum(triangles.laplacian(), triangles.vertex_areas(), 6).values
    assert np.isfinite(values).all()
    assert values[1] > 1


def test_geodesics_on_the_sphere_are_great_circles() -> None:
    ball = icosphere(subdivisions=4)
    surface = GeodesicSurface(intrinsic_delaunay(ball))
    found = surface.distances([0, 77])
    for row, source in zip(found, (0, 77), strict=True):
        exact = np.arccos(np.clip(ball.vertices @ ball.vertices[source], -1, 1))
        assert np.abs(row - exact).max() < 0.05
        assert np.abs(row - exact).mean() < 0.02


def test_geodesics_in_the_plane_are_straight() -> None:
    mesh = grid(20)
    row = GeodesicSurface(intrinsic_delaunay(mesh)).distances([0])[0]
    # the unfolded source is exact where nothing bends
    np.testing.assert_allclose(row, np.linalg.norm(mesh.vertices, axis=1), rtol=2e-4, atol=1e-4)


@given(st.integers(0, 100))
@settings(max_examples=10, deadline=None)
def test_geodesics_do_not_depend_on_the_order_of_vertices(seed: int) -> None:
    ball = icosphere(subdivisions=2)
    shape = ball.with_vertices(ball.vertices * [1, 2, 3] + 0.01 * np.sin(9 * ball.vertices[:, ::-1]))
    order = np.random.default_rng(seed).permutation(len(ball.vertices))
    rank = np.argsort(order)
    other = TriangleMesh(shape.vertices[order], rank[shape.faces])
    ours = GeodesicSurface(intrinsic_delaunay(shape)).distances([5])[0]
    theirs = GeodesicSurface(intrinsic_delaunay(other)).distances([rank[5]])[0]
    np.testing.assert_allclose(theirs[rank], ours, rtol=1e-9)


def test_links_join_what_faces_do_not() -> None:
    a = icosphere(subdivisions=2)
    two = TriangleMesh(
        np.concatenate((a.vertices, a.vertices + np.array([4, 0, 0]))), np.concatenate((a.faces, a.faces + 162))
    )
    triangles = intrinsic_delaunay(two)
    assert np.isinf(GeodesicSurface(triangles).distances([0])[0, 162:]).all()
    right, left = int(np.argmax(two.vertices[:162, 0])), 162 + int(np.argmin(two.vertices[162:, 0]))
    joined = GeodesicSurface(triangles, Links(np.array([[right, left]]), np.array([2.0])))
    assert joined.distances([right])[0, left] == 2.0
    assert np.isfinite(joined.distances([0])).all()


def test_farthest_points_spread_evenly() -> None:
    surface = GeodesicSurface(intrinsic_delaunay(icosphere(subdivisions=3)))
    points, reach = surface.farthest_points(12, 0)
    assert len(set(points.tolist())) == 12
    np.testing.assert_allclose(reach, surface.distances(points))
    # twelve points on a sphere: the icosahedron's are 1.107 apart
    assert reach[:, points][~np.eye(12, dtype=bool)].min() > 0.7


def test_rays_from_the_centre_meet_the_sphere() -> None:
    ball = icosphere(radius=2.0, subdivisions=3)
    along = np.random.default_rng(0).normal(size=(200, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    distances, faces = first_hits(ball, np.zeros((200, 3)), along)
    assert (distances <= 2.0).all()
    assert (distances > 1.98).all()
    hit = along * distances[:, None]
    normals = ball.face_normals[faces]
    np.testing.assert_allclose(((hit - ball.corners[faces, 0]) * normals).sum(axis=1), 0, atol=1e-9)


def test_rays_agree_with_testing_every_face() -> None:
    rng = np.random.default_rng(3)
    soup = TriangleMesh(rng.normal(size=(90, 3)), np.arange(90).reshape(30, 3))
    origins, along = rng.normal(size=(100, 3)), rng.normal(size=(100, 3))
    distances, faces = first_hits(soup, origins, along, beyond=0.1)
    for o, d, found, face in zip(origins, along, distances, faces, strict=True):
        best, which = np.inf, -1
        for f, (a, b, c) in enumerate(soup.corners):
            weights = np.linalg.solve(np.stack((b - a, c - a, -d), axis=1), o - a)
            if min(weights[0], weights[1], 1 - weights[0] - weights[1]) >= 0 and 0.1 < weights[2] < best:
                best, which = weights[2], f
        assert which == face
        assert found == pytest.approx(best)


def test_rays_along_axes_and_past_everything() -> None:
    ball = icosphere(subdivisions=2)
    distances, faces = first_hits(ball, [[0, 0, 5], [3, 0, 5]], [[0, 0, -1], [0, 0, -1]])
    assert distances[0] == pytest.approx(4, abs=0.05)
    assert np.isinf(distances[1])
    assert faces[1] == -1

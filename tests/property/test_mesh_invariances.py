"""What must not change when a mesh is moved, renumbered, scaled or written down."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.mesh_io import read_mesh, write_mesh
from shapery_geometry.operators import (
    angle_defects,
    closest_points,
    cotangent_laplacian,
    gaussian_curvature,
    mean_curvature,
    surface_distances,
    vertex_areas,
)
from shapery_geometry.repair import mesh_report, repair

few = settings(max_examples=25, deadline=None, derandomize=True)
seeds = st.integers(0, 2**32 - 1)
SPHERE = icosphere(subdivisions=1)


def bumpy(seed: int, amount: float = 0.3) -> TriangleMesh:
    rng = np.random.default_rng(seed)
    radii = np.exp(amount * rng.normal(size=(len(SPHERE.vertices), 1)))
    return SPHERE.with_vertices(SPHERE.vertices * radii)


def soup(seed: int, points: int = 24, faces: int = 40) -> TriangleMesh:
    """Any triangles over points of a small grid: touching, coplanar, degenerate and duplicate faces are frequent."""
    rng = np.random.default_rng(seed)
    return TriangleMesh(rng.integers(0, 4, (points, 3)), rng.integers(0, points, (faces, 3)))


def rotation(rng: np.random.Generator) -> np.ndarray:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


@few
@given(seeds, st.floats(-6, 6))
def test_motion_and_scale_of_measures(seed: int, exponent: float) -> None:
    rng = np.random.default_rng(seed)
    scale = 10.0**exponent
    mesh = bumpy(seed)
    turn = rotation(rng)
    shift = rng.normal(size=3)
    moved = mesh.with_vertices((mesh.vertices @ turn.T + shift) * scale)
    assert moved.area == pytest.approx(mesh.area * scale**2, rel=1e-12)
    assert moved.volume == pytest.approx(mesh.volume * scale**3, rel=1e-10)
    assert moved.vertex_normals == pytest.approx(mesh.vertex_normals @ turn.T, abs=1e-10)
    assert vertex_areas(moved, "mixed") == pytest.approx(vertex_areas(mesh, "mixed") * scale**2, rel=1e-9)
    assert angle_defects(moved) == pytest.approx(angle_defects(mesh), abs=1e-10)
    size = np.abs(gaussian_curvature(mesh)).max()
    assert gaussian_curvature(moved) * scale**2 == pytest.approx(gaussian_curvature(mesh), abs=1e-9 * size)
    assert mean_curvature(moved) * scale == pytest.approx(mean_curvature(mesh), abs=1e-8 * size)
    difference = cotangent_laplacian(moved) - cotangent_laplacian(mesh)
    assert abs(difference).max() < 1e-9 * abs(cotangent_laplacian(mesh)).max()


@few
@given(seeds)
def test_renumbering_changes_nothing_but_the_numbers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = bumpy(seed)
    to = rng.permutation(len(mesh.vertices))
    points = np.empty_like(mesh.vertices)
    points[to] = mesh.vertices
    order = rng.permutation(len(mesh.faces))
    faces = to[mesh.faces][order]
    turned = np.stack([np.roll(f, k) for f, k in zip(faces, rng.integers(0, 3, len(faces)), strict=True)])
    other = TriangleMesh(points, turned)
    assert (other.closed, other.manifold, other.oriented, other.genus) == (True, True, True, 0)
    assert other.volume == pytest.approx(mesh.volume)
    assert other.vertex_normals[to] == pytest.approx(mesh.vertex_normals, abs=1e-12)
    assert mean_curvature(other)[to] == pytest.approx(mean_curvature(mesh), rel=1e-9, abs=1e-9)
    assert surface_distances(mesh, other).hausdorff < 1e-12
    pairs = order[self_intersections(other)]
    expected = self_intersections(mesh)
    assert sorted(map(sorted, pairs.tolist())) == expected.tolist()


@few
@given(seeds)
def test_self_intersections_do_not_depend_on_how_faces_are_written(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = soup(seed)
    expected = self_intersections(mesh).tolist()
    axes = rng.permutation(3)
    signs = rng.choice([-1.0, 1.0], 3)
    # exact changes of coordinates: axes exchanged and mirrored, a shift by whole numbers, a power of two
    points = (mesh.vertices[:, axes] * signs + rng.integers(-5, 5, 3)) * 2.0 ** rng.integers(-40, 40)
    faces = np.stack([rng.permutation(f) for f in mesh.faces])
    assert self_intersections(TriangleMesh(points, faces)).tolist() == expected
    asked = rng.random(len(mesh.faces)) < 0.3
    chosen = [pair for pair in expected if asked[pair].any()]
    assert self_intersections(mesh, faces=asked).tolist() == chosen


@few
@given(seeds, st.sampled_from([".ply", ".obj", ".off"]))
def test_any_mesh_survives_a_file(seed: int, suffix: str) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(10, 3)) * 10.0 ** rng.integers(-300, 300, (10, 3))
    mesh = TriangleMesh(points, rng.integers(0, 10, (7, 3)))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"mesh{suffix}"
        write_mesh(mesh, path)
        assert read_mesh(path).same_as(mesh)


@few
@given(seeds)
def test_repair_of_any_soup(seed: int) -> None:
    mesh = soup(seed)
    done = repair(mesh)
    report = mesh_report(done.mesh)
    assert (report.duplicate_vertices, report.unreferenced_vertices) == (0, 0)
    assert (report.degenerate_faces, report.duplicate_faces) == (0, 0)
    # every face that is left is one that was there, and none that was not degenerate is gone altogether
    places = [{tuple(p) for p in corners} for corners in mesh.corners.tolist()]
    found = [{tuple(p) for p in corners} for corners in done.mesh.corners.tolist()]
    assert found == [places[source] for source in done.face_source.tolist()]
    wanted = {frozenset(corners) for corners in places if len(corners) == 3}
    assert {frozenset(corners) for corners in found} == wanted
    # nothing is left to do: neighbours agree as far as they can
    again = repair(done.mesh)
    assert again.mesh is done.mesh


@few
@given(seeds)
def test_topology_counts_agree(seed: int) -> None:
    mesh = soup(seed)
    topology = mesh.topology
    assert topology.edge_face_counts.sum() == 3 * len(mesh.faces)
    assert np.array_equal(np.sort(topology.edges[topology.face_edges].reshape(-1, 2)), np.sort(topology.half_edges))
    assert topology.euler_characteristics.sum() == topology.referenced.sum() - len(mesh.edges) + len(mesh.faces)
    assert set(topology.face_components.tolist()) == set(range(topology.component_count))
    for loop in topology.boundary_loops:
        steps = {frozenset(e) for e in topology.boundary_edges.tolist()}
        assert all(frozenset(e) in steps for e in zip(loop.tolist(), [*loop[1:].tolist()], strict=False))


@few
@given(seeds)
def test_nearest_points_are_nearest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = soup(seed)
    queries = rng.uniform(-2, 6, (20, 3))
    found = closest_points(mesh, queries)
    assert np.linalg.norm(queries - found.points, axis=1) == pytest.approx(found.distances, abs=1e-12)
    # no corner and no point within a face is nearer
    weights = rng.dirichlet(np.ones(3), len(mesh.faces))
    inside = np.einsum("ik,ikj->ij", weights, mesh.corners)
    for points in (mesh.vertices[mesh.topology.referenced], inside):
        others = np.linalg.norm(queries[:, None] - points[None], axis=2).min(axis=1)
        assert (found.distances <= others + 1e-12).all()

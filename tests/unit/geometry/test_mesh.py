"""Triangle meshes: validation, measures in closed form, and what follows from connectivity."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh, icosphere

TETRAHEDRON = (
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
)


def torus(rings: int = 12, sides: int = 7, large: float = 2.0, small: float = 0.5) -> TriangleMesh:
    u, w = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")
    a, b = 2 * np.pi * u / rings, 2 * np.pi * w / sides
    points = np.stack(
        ((large + small * np.cos(b)) * np.cos(a), (large + small * np.cos(b)) * np.sin(a), small * np.sin(b)), axis=-1
    )
    here, right = u * sides + w, (u + 1) % rings * sides + w
    up, both = u * sides + (w + 1) % sides, (u + 1) % rings * sides + (w + 1) % sides
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((here, right, both), (here, both, up))])
    return TriangleMesh(points.reshape(-1, 3), faces)


def test_tetrahedron_in_closed_form() -> None:
    mesh = TriangleMesh(*TETRAHEDRON)
    assert mesh.vertices.dtype == np.float64
    assert mesh.faces.dtype == np.int32
    assert mesh.area == pytest.approx(1.5 + np.sqrt(3) / 2, rel=1e-15)
    assert mesh.volume == pytest.approx(1 / 6, rel=1e-15)
    assert mesh.closed
    assert mesh.manifold
    assert mesh.oriented
    assert (mesh.euler_characteristic, mesh.component_count, mesh.genus) == (2, 1, 0)
    assert mesh.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
    assert mesh.topology.edge_face_counts.tolist() == [2] * 6
    assert sorted(mesh.edge_lengths) == pytest.approx([1, 1, 1, 2**0.5, 2**0.5, 2**0.5])
    assert mesh.bounding_box.tolist() == [[0, 0, 0], [1, 1, 1]]
    assert mesh.diagonal == pytest.approx(3**0.5)
    # the three right angles at the origin, and by symmetry the diagonal direction
    assert mesh.vertex_normals[0] == pytest.approx(-np.ones(3) / 3**0.5)
    assert mesh.face_normals[2] == pytest.approx(np.ones(3) / 3**0.5)
    assert mesh.corner_angles.sum(axis=1) == pytest.approx(np.full(4, np.pi))
    assert mesh.flipped().volume == pytest.approx(-1 / 6)


def test_volume_does_not_depend_on_where_the_mesh_is() -> None:
    mesh = icosphere(subdivisions=2)
    far = mesh.with_vertices(mesh.vertices + np.array([1e6, -2e6, 3e6]))
    # coordinates of 3e6 are rounded by 2e-10
    assert far.volume == pytest.approx(mesh.volume, rel=1e-8)


def test_icosphere_lies_on_its_sphere_and_converges_to_it() -> None:
    errors = []
    for level in (2, 3, 4):
        mesh = icosphere((1, -2, 3), 2.5, level)
        assert len(mesh.faces) == 20 * 4**level
        assert len(mesh.vertices) == 10 * 4**level + 2
        assert np.linalg.norm(mesh.vertices - [1, -2, 3], axis=1) == pytest.approx(np.full(len(mesh.vertices), 2.5))
        assert mesh.closed
        assert mesh.manifold
        assert mesh.oriented
        errors.append(1 - mesh.volume / (4 / 3 * np.pi * 2.5**3))
        outwards = (mesh.vertices - [1, -2, 3]) / 2.5
        assert np.einsum("ij,ij->i", mesh.vertex_normals, outwards).min() > 0.999
    # inscribed, so the error is positive; of second order in the edge length, so it falls fourfold
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.02)
    assert errors[2] > 0


@pytest.mark.parametrize(("radius", "subdivisions"), [(0.0, 1), (-1.0, 1), (float("nan"), 1), (1.0, -1), (1.0, 10)])
def test_icosphere_refuses_senseless_numbers(radius: float, subdivisions: int) -> None:
    with pytest.raises(ValueError, match="must"):
        icosphere(radius=radius, subdivisions=subdivisions)


def test_torus_has_one_handle() -> None:
    mesh = torus()
    assert (mesh.closed, mesh.manifold, mesh.oriented) == (True, True, True)
    assert mesh.volume > 0
    assert mesh.euler_characteristic == 0
    assert mesh.genus == 1


def test_several_components_are_counted_apart() -> None:
    first, second = torus(), icosphere(subdivisions=1)
    points = np.concatenate((second.vertices + 10, [[5.0, 5, 5]], first.vertices))
    faces = np.concatenate((first.faces + len(second.vertices) + 1, second.faces))
    mesh = TriangleMesh(points, faces)
    topology = mesh.topology
    assert mesh.component_count == 2
    # numbered by their first vertex: the sphere comes first though its faces come last
    assert topology.genus_per_component.tolist() == [0, 1]
    assert topology.euler_characteristics.tolist() == [2, 0]
    assert topology.vertex_components[len(second.vertices)] == -1
    assert not topology.referenced[len(second.vertices)]
    assert topology.face_components.tolist() == [1] * len(first.faces) + [0] * len(second.faces)
    assert mesh.genus == 1


def test_a_hole_is_a_boundary_loop_in_the_direction_of_its_faces() -> None:
    sphere = icosphere(subdivisions=2)
    centre = 0
    mesh = TriangleMesh(sphere.vertices, sphere.faces[~(sphere.faces == centre).any(axis=1)])
    assert not mesh.closed
    assert mesh.manifold
    assert mesh.oriented
    loops = mesh.topology.boundary_loops
    assert len(loops) == 1
    assert len(loops[0]) == 5
    directed = {tuple(e) for e in mesh.boundary_edges.tolist()}
    assert {(int(a), int(b)) for a, b in zip(loops[0], np.roll(loops[0], -1), strict=True)} == directed
    assert mesh.genus == 0
    assert not mesh.topology.referenced[centre]


def test_moebius_strip_is_manifold_but_not_oriented() -> None:
    n = 9
    angle = 2 * np.pi * np.arange(n) / n
    low = np.stack((np.cos(angle), np.sin(angle), np.zeros(n)), axis=1)
    points = np.concatenate((low - np.array([0, 0, 0.1]), low + np.array([0, 0, 0.1])))
    faces = []
    for k in range(n):
        a, c = k, k + n
        b, d = (k + 1, k + 1 + n) if k < n - 1 else (n, 0)
        faces += [[a, b, d], [a, d, c]]
    mesh = TriangleMesh(points, faces)
    assert mesh.manifold
    assert not mesh.oriented
    assert len(mesh.topology.boundary_loops) == 1
    with pytest.raises(InvalidInput, match="both faces run the same way") as caught:
        _ = mesh.genus
    assert caught.value.code == "invalid_mesh"


def test_two_tetrahedra_on_one_edge_are_closed_but_not_manifold() -> None:
    points = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [1, 1, 0], [-1, 0, 0], [-1, -1, 0.0]])
    one, two = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]), np.array([0, 1, 4, 5])
    faces = np.concatenate((one, two[one]))
    mesh = TriangleMesh(points, faces)
    assert mesh.closed
    assert mesh.oriented
    assert not mesh.manifold
    assert mesh.topology.nonmanifold_edges.tolist() == [[0, 1]]
    assert mesh.topology.nonmanifold_vertices.tolist() == [0, 1]
    with pytest.raises(InvalidInput, match="1 edges and 2 vertices are not manifold"):
        _ = mesh.genus


def test_two_tetrahedra_on_one_vertex_touch_in_two_fans() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1.0]])
    one = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    mesh = TriangleMesh(points, np.concatenate((one, np.array([0, 4, 5, 6])[one])))
    assert mesh.closed
    assert not mesh.manifold
    assert mesh.topology.nonmanifold_edges.size == 0
    assert mesh.topology.nonmanifold_vertices.tolist() == [0]
    assert mesh.component_count == 1


def test_a_turned_face_breaks_the_orientation_and_not_the_closedness() -> None:
    sphere = icosphere(subdivisions=1)
    faces = sphere.faces.copy()
    faces[7] = faces[7, ::-1]
    mesh = TriangleMesh(sphere.vertices, faces)
    assert mesh.closed
    assert mesh.manifold
    assert not mesh.oriented


def test_a_face_that_names_a_vertex_twice_is_degenerate() -> None:
    mesh = TriangleMesh(np.eye(3), [[0, 1, 2], [0, 0, 1]])
    assert mesh.topology.degenerate_faces.tolist() == [1]
    assert not mesh.manifold
    assert mesh.face_normals[1].tolist() == [0, 0, 0]
    assert np.isfinite(mesh.vertex_normals).all()
    # the loop from vertex 0 to itself is no border, the sides of the other face are
    assert mesh.boundary_edges.tolist() == [[1, 2], [2, 0]]


def test_a_degenerate_face_on_a_closed_surface_leaves_it_closed() -> None:
    sphere = icosphere(subdivisions=1)
    a, b, _ = sphere.faces[0]
    mesh = TriangleMesh(sphere.vertices, [*sphere.faces.tolist(), [a, a, b]])
    assert mesh.closed
    assert not mesh.manifold


def test_nothing_at_all() -> None:
    mesh = TriangleMesh([], [])
    assert (len(mesh.vertices), len(mesh.faces), mesh.area, mesh.volume) == (0, 0, 0.0, 0.0)
    assert not mesh.closed
    assert (mesh.component_count, mesh.euler_characteristic, mesh.genus) == (0, 0, 0)
    with pytest.raises(InvalidInput, match="no bounding box"):
        _ = mesh.bounding_box
    with pytest.raises(InvalidInput, match="no centre"):
        _ = mesh.centroid


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]], "1 of 3 vertices .* the first is vertex 1"),
        ([[0, 0, 0], [1, 0, 0], [0, np.inf, 0]], [[0, 1, 2]], "the first is vertex 2: \\(0, inf, 0\\)"),
        ([[0, 0], [1, 0]], [[0, 1, 1]], "shape \\(n, 3\\), not \\(2, 2\\)"),
        (np.eye(3), [[0, 1, 3]], "face 0 \\(0, 1, 3\\), and vertices run from 0 to 2"),
        (np.eye(3), [[0, 1, 2], [0, -1, 2]], "1 of 2 faces .* face 1"),
        (np.eye(3), [[0, 1, 2, 0]], "shape \\(m, 3\\), not \\(1, 4\\)"),
        (np.eye(3), [[0.0, 1.0, 2.0]], "whole numbers, not float64"),
        ([], [[0, 0, 0]], "1 of 1 faces"),
    ],
)
def test_invalid_arrays_are_refused_with_figures(vertices: object, faces: object, message: str) -> None:
    with pytest.raises(InvalidInput, match=message) as caught:
        TriangleMesh(vertices, faces)  # type: ignore[arg-type]
    assert caught.value.code == "invalid_mesh"


def test_a_mesh_cannot_be_changed_through_its_arrays_or_those_it_was_made_from() -> None:
    points = np.eye(3)
    mesh = TriangleMesh(points, np.array([[0, 1, 2]]))
    points[0] = 9
    assert mesh.vertices[0].tolist() == [1, 0, 0]
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 9
    with pytest.raises(ValueError, match="read-only"):
        mesh.faces[0] = 0


def test_with_vertices_shares_the_topology_and_checks_the_count() -> None:
    sphere = icosphere(subdivisions=1)
    assert sphere.closed
    moved = sphere.with_vertices(sphere.vertices * 2)
    assert moved.topology is sphere.topology
    assert moved.volume == pytest.approx(8 * sphere.volume)
    assert moved.same_as(icosphere(radius=2, subdivisions=1))
    assert not moved.same_as(sphere)
    with pytest.raises(InvalidInput, match="42 vertices, but 41 are given"):
        sphere.with_vertices(sphere.vertices[1:])

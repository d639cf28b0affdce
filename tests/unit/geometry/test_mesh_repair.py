"""Reports and repairs: each step does what it says, says how much, and where everything has gone."""

from __future__ import annotations

import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.repair import (
    Repair,
    drop_degenerate_faces,
    drop_duplicate_faces,
    drop_unreferenced_vertices,
    mesh_report,
    orient,
    repair,
    submesh,
    weld,
)

ROOT = Path(__file__).resolve().parents[3]


def split(mesh: TriangleMesh) -> TriangleMesh:
    """Every face with vertices of its own."""
    return TriangleMesh(mesh.corners.reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))


def assert_traced(before: TriangleMesh, done: Repair) -> None:
    """The maps lead every face and vertex to what it was."""
    source = before.faces[done.face_source]
    assert (np.sort(done.vertex_map[source], axis=1) == np.sort(done.mesh.faces, axis=1)).all()
    kept = done.vertex_map >= 0
    assert np.array_equal(np.unique(done.vertex_map[kept]), np.arange(len(done.mesh.vertices)))
    assert np.allclose(done.mesh.vertices[done.vertex_map[kept]], before.vertices[kept], atol=1e-5)


def test_a_sound_mesh_is_reported_so_and_left_alone() -> None:
    sphere = icosphere(subdivisions=2)
    report = mesh_report(sphere, intersections=True)
    assert report.sound
    assert (report.vertices, report.faces, report.components, report.genus) == (162, 320, 1, 0)
    faults = {k: v for k, v in report.as_dict().items() if v is not True and v != 0}
    assert faults == {"vertices": 162, "faces": 320, "components": 1, "euler_characteristic": 2}
    assert mesh_report(sphere).self_intersections is None
    done = repair(sphere)
    assert done.mesh is sphere
    assert done.changed == 0
    assert [name for name, _ in done.changes] == [
        "weld", "drop_degenerate_faces", "drop_duplicate_faces", "drop_unreferenced_vertices", "orient",
    ]  # fmt: skip


def test_every_fault_is_counted() -> None:
    sphere = icosphere(subdivisions=1)
    top = sphere.vertices[0]
    points = np.concatenate((sphere.vertices, [top, [9, 9, 9], [9, 9, 9], [0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]]))
    n = len(sphere.vertices)
    extra = [[0, 0, 1], [n + 3, n + 4, n + 5], [*sphere.faces[3][::-1]], [*np.roll(sphere.faces[40], 1)]]
    mesh = TriangleMesh(points, np.concatenate((sphere.faces, extra)))
    report = mesh_report(mesh)
    assert report.duplicate_vertices == 2
    assert report.unreferenced_vertices == 3
    assert report.degenerate_faces == 1
    assert report.flat_faces == 1
    assert report.duplicate_faces == 2
    assert report.boundary_edges == 3
    assert report.nonmanifold_edges == 6
    assert not report.sound
    assert report.genus is None


def test_unwelded_faces_are_welded_exactly() -> None:
    sphere = icosphere(subdivisions=2)
    soup = split(sphere)
    assert mesh_report(soup).components == 320
    done = weld(soup)
    assert done.changes == (("weld", 960 - 162),)
    assert done.mesh.closed
    assert np.array_equal(done.mesh.corners, sphere.corners)
    assert_traced(soup, done)
    # nothing that lies apart is joined without a tolerance
    rng = np.random.default_rng(0)
    shaken = TriangleMesh(soup.vertices + rng.uniform(-1e-7, 1e-7, soup.vertices.shape), soup.faces)
    assert weld(shaken).changed == 0
    assert weld(shaken).mesh is shaken
    done = weld(shaken, 1e-6)
    assert (len(done.mesh.vertices), done.mesh.closed) == (162, True)
    assert_traced(shaken, done)
    # the first of those that were joined keeps its place
    assert np.isin(done.mesh.vertices.view("V24"), shaken.vertices.view("V24")).all()


def test_welding_joins_over_others_and_keeps_faces_that_collapse() -> None:
    mesh = TriangleMesh([[0, 0, 0], [0.6, 0, 0], [1.2, 0, 0], [0, 5, 0]], [[0, 1, 3], [0, 2, 3]])
    done = weld(mesh, 0.7)
    assert done.vertex_map.tolist() == [0, 0, 0, 1]
    assert done.mesh.faces.tolist() == [[0, 0, 1], [0, 0, 1]]
    assert drop_degenerate_faces(done.mesh).changes == (("drop_degenerate_faces", 2),)
    with pytest.raises(ValueError, match="negative"):
        weld(mesh, -1.0)
    with pytest.raises(ValueError, match="negative"):
        weld(mesh, float("nan"))


def test_flat_faces_are_dropped_only_when_asked() -> None:
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [3, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3], [1, 1, 2]])
    assert drop_degenerate_faces(mesh).mesh.faces.tolist() == [[0, 1, 2], [0, 1, 3]]
    done = drop_degenerate_faces(mesh, flat=True)
    assert done.mesh.faces.tolist() == [[0, 1, 3]]
    assert done.changed == 2
    assert_traced(mesh, done)


def test_the_first_of_duplicates_stays() -> None:
    mesh = TriangleMesh(np.eye(3), [[0, 1, 2], [1, 2, 0], [2, 1, 0]])
    done = drop_duplicate_faces(mesh)
    assert done.mesh.faces.tolist() == [[0, 1, 2]]
    assert done.face_source.tolist() == [0]


def test_unreferenced_vertices_go_and_the_others_keep_their_order() -> None:
    mesh = TriangleMesh([[0, 0, 0], [9, 9, 9], [1, 0, 0], [0, 1, 0]], [[3, 0, 2]])
    done = drop_unreferenced_vertices(mesh)
    assert done.vertex_map.tolist() == [0, -1, 1, 2]
    assert done.mesh.faces.tolist() == [[2, 0, 1]]
    assert_traced(mesh, done)


@pytest.mark.parametrize("share", [0.1, 0.45, 0.9])
def test_faces_are_turned_to_agree_and_to_look_outwards(share: float) -> None:
    rng = np.random.default_rng(4)
    sphere = icosphere(subdivisions=2)
    both = TriangleMesh(
        np.concatenate((sphere.vertices, sphere.vertices + 5)),
        np.concatenate((sphere.faces, sphere.faces + len(sphere.vertices))),
    )
    turned = rng.random(len(both.faces)) < share
    mesh = TriangleMesh(both.vertices, np.where(turned[:, None], both.faces[:, ::-1], both.faces))
    done = orient(mesh)
    assert done.mesh.oriented
    assert done.mesh.volume == pytest.approx(both.volume)
    assert done.changes == (("orient", int(turned.sum())),)
    assert_traced(mesh, done)
    # without a wish for the outside, the smaller part of each sphere is turned
    kept = orient(mesh, outward=False)
    assert kept.mesh.oriented
    halves = turned.reshape(2, -1).sum(axis=1)
    assert kept.changed == np.minimum(halves, len(sphere.faces) - halves).sum()


def test_what_agrees_already_is_left_inside_out_when_asked() -> None:
    inside_out = icosphere().flipped()
    assert orient(inside_out, outward=False).mesh is inside_out
    assert orient(inside_out).mesh.volume > 0


def test_an_open_patch_has_no_outside() -> None:
    sphere = icosphere(subdivisions=2).flipped()
    patch = TriangleMesh(sphere.vertices, sphere.faces[:100])
    assert orient(patch).mesh is patch


def test_a_strip_of_one_side_is_left_as_it_is() -> None:
    n = 9
    faces = []
    for k in range(n):
        b, d = (k + 1, k + 1 + n) if k < n - 1 else (n, 0)
        faces += [[k, b, d], [k, d, k + n]]
    rng = np.random.default_rng(0)
    mesh = TriangleMesh(rng.normal(size=(2 * n, 3)), faces)
    assert not mesh.oriented
    assert orient(mesh).mesh is mesh


def test_repair_of_everything_at_once() -> None:
    rng = np.random.default_rng(1)
    sphere = icosphere(subdivisions=2)
    soup = split(sphere)
    faces = np.concatenate((soup.faces, soup.faces[5:8, ::-1], [[4, 4, 5]]))
    faces = np.where(rng.random(len(faces))[:, None] < 0.3, faces[:, ::-1], faces)
    mesh = TriangleMesh(np.concatenate((soup.vertices, [[7, 7, 7]])), faces)
    done = repair(mesh)
    assert mesh_report(done.mesh, intersections=True).sound
    assert len(done.mesh.faces) == len(sphere.faces)
    assert done.mesh.volume == pytest.approx(sphere.volume)
    assert dict(done.changes)["weld"] == 960 - 162
    assert dict(done.changes)["drop_degenerate_faces"] == 1
    assert dict(done.changes)["drop_duplicate_faces"] == 3
    assert dict(done.changes)["drop_unreferenced_vertices"] == 1
    assert done.vertex_map[-1] == -1
    assert_traced(mesh, done)
    again = repair(done.mesh)
    assert again.mesh is done.mesh
    assert again.changed == 0


def test_submesh_keeps_the_order_of_the_mesh() -> None:
    sphere = icosphere(subdivisions=1)
    done = submesh(sphere, np.array([7, 3]))
    assert done.face_source.tolist() == [3, 7]
    assert np.array_equal(done.mesh.corners, sphere.corners[[3, 7]])
    assert done.mesh.topology.referenced.all()
    assert_traced(sphere, done)
    mask = np.zeros(len(sphere.faces), dtype=bool)
    mask[[3, 7]] = True
    assert submesh(sphere, mask).mesh.same_as(done.mesh)
    with pytest.raises(InvalidInput, match="the mesh has 80"):
        submesh(sphere, np.array([80]))


def test_nothing_is_repaired_to_nothing() -> None:
    empty = TriangleMesh([], [])
    assert repair(empty).mesh is empty
    report = mesh_report(empty, intersections=True)
    assert not report.closed
    assert report.components == 0


# what is loaded -------------------------------------------------------------------------------------------------------


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False, cwd=ROOT
    )


def test_reading_and_repairing_load_no_heavy_library() -> None:
    done = run(
        """
        import sys
        import shapery_geometry
        assert "numpy" not in sys.modules
        import shapery_geometry.mesh_io, shapery_geometry.sequence
        print(sorted({name for name in ("numba", "trimesh") if name in sys.modules}))
        """
    )
    assert done.stdout == "[]\n", done.stderr

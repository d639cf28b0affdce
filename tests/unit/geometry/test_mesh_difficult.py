"""Real files that break mesh code: what each is, counted independently, so that none is read as something it isn't.

The numbers of vertices and faces are those in the files (counted in their headers and lines); each n-gon gives n − 2
triangles. Where a file is not what it seems, a comment says why the expectation is right.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh_io import read_mesh
from shapery_geometry.repair import mesh_report, repair

pytestmark = pytest.mark.data


@dataclass(frozen=True)
class Expected:
    vertices: int
    faces: int
    components: int = 1
    closed: bool = True
    manifold: bool = True
    oriented: bool = True
    genus: int | None = 0
    loops: int = 0
    unreferenced: int = 0
    duplicate_vertices: int = 0
    duplicate_faces: int = 0
    flat_faces: int = 0
    intersecting: bool = False


OPEN_DISK = {"closed": False, "loops": 1}
MESHES = {
    "common_spot.obj": Expected(2930, 5856),
    # quads and triangles; head and two eyes; one edge of three faces
    "common_suzanne.obj": Expected(507, 968, 3, False, False, genus=None, loops=4, duplicate_vertices=2,
                                   duplicate_faces=1, intersecting=True),
    # Bézier patches of body, lid, handle and spout that overlap and are not joined
    "common_teapot.obj": Expected(3644, 6320, 4, False, False, genus=None, loops=21, duplicate_vertices=403,
                                  intersecting=True),
    "ligl_3holes.off": Expected(3596, 7200, genus=3),
    "ligl_face.obj": Expected(25905, 51712, **OPEN_DISK),
    # 1838 quads whose numbers run on over lines
    "ligl_inspired_mesh_quads_Smooth.off": Expected(1963, 2 * 1838, **OPEN_DISK),
    "ligltest_cube_with_fold.ply": Expected(26, 48, intersecting=True),
    # an octahedron with its inner walls, every wall from both sides
    "ligltest_degenerated.obj": Expected(7, 24, manifold=False, genus=None, duplicate_faces=12, intersecting=True),
    # four faces among 5009 vertices
    "ligltest_sliver_tet.ply": Expected(5009, 4, unreferenced=5005, duplicate_vertices=26),
    # each side of the boxes is a part of its own
    "ligltest_two-boxes-bad-self-union.ply": Expected(486, 708, 12, False, loops=12, duplicate_vertices=102,
                                                      intersecting=True),
    "tri_bunny.ply": Expected(8171, 16301, 1, False, False, genus=None, loops=11, unreferenced=25, duplicate_faces=87,
                              intersecting=True),
    # a UV seam runs down one side, and the poles are 101 vertices each: without welding it is an open strip
    "tri_capsule.obj": Expected(5252, 10200, closed=False, loops=1, duplicate_vertices=250, flat_faces=200,
                                intersecting=True),
    # every face twice, once from each side
    "tri_chair_model.obj": Expected(3186, 12756, 4, True, False, genus=None, duplicate_vertices=28,
                                    duplicate_faces=6382, intersecting=True),
    # a hundred bodies that run through each other
    "tri_cycloidal.ply": Expected(21384, 43368, 100, True, False, genus=None, intersecting=True),
    # corners that should coincide differ in the last digits, and are not welded for it
    "tri_featuretype.STL": Expected(2010, 3476, closed=False, genus=1, loops=16, intersecting=True),
    "tri_fuze.obj": Expected(502, 1000),
    "tri_joined_tetrahedra.obj": Expected(5, 8, manifold=False, genus=None, duplicate_faces=1, intersecting=True),
    # two bodies whose faces do not agree on what is outside
    "tri_multibody.stl": Expected(20, 32, 2, oriented=False, genus=None),
    "tri_octagonal_pocket.ply": Expected(1658, 3262, 2, False, False, genus=None, loops=5, intersecting=True),
    "tri_quadknot.obj": Expected(1440, 2 * 1440, genus=1),
    # n-gons; nine bodies that are pushed into each other
    "tri_rabbit.obj": Expected(644, 1252, 9, intersecting=True),
    "tri_soup.stl": Expected(300, 100, 100, False, loops=100, intersecting=True),
    "tri_tet.ply": Expected(4, 4),
}  # fmt: skip
REFUSED = {
    "tri_empty.ply": ("empty_content", "neither points nor faces"),
    "tri_points_bin.ply": ("empty_content", "5 points and no faces: it is a point cloud"),
}


@pytest.fixture(scope="module")
def difficult(shared_data: Path) -> Path:
    return shared_data / "meshes" / "difficult"


def test_every_file_has_an_expectation(difficult: Path) -> None:
    assert sorted(p.name for p in difficult.iterdir()) == sorted([*MESHES, *REFUSED])


@pytest.mark.parametrize("name", MESHES)
def test_it_is_read_as_what_it_is(name: str, difficult: Path) -> None:
    mesh = read_mesh(difficult / name)
    report = mesh_report(mesh, intersections=True)
    found = Expected(
        vertices=report.vertices,
        faces=report.faces,
        components=report.components,
        closed=report.closed,
        manifold=report.manifold,
        oriented=report.oriented,
        genus=report.genus,
        loops=report.boundary_loops,
        unreferenced=report.unreferenced_vertices,
        duplicate_vertices=report.duplicate_vertices,
        duplicate_faces=report.duplicate_faces,
        flat_faces=report.flat_faces,
        intersecting=bool(report.self_intersections),
    )
    assert found == MESHES[name]


@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused_with_its_reason(name: str, difficult: Path) -> None:
    code, message = REFUSED[name]
    with pytest.raises(InvalidInput, match=message) as caught:
        read_mesh(difficult / name)
    assert caught.value.code == code


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        # the seam is closed again, and the poles become points
        ("tri_capsule.obj", (5002, 10000)),
        ("tri_multibody.stl", (20, 32)),
        ("ligltest_sliver_tet.ply", (4, 4)),
    ],
)
def test_repair_makes_a_sound_mesh_of_it(name: str, counts: tuple[int, int], difficult: Path) -> None:
    mesh = read_mesh(difficult / name)
    fixed = repair(mesh).mesh
    report = mesh_report(fixed, intersections=True)
    assert (report.vertices, report.faces) == counts
    assert report.sound
    assert fixed.volume > 0


@pytest.mark.parametrize("number", [1, 52, 123, 200, 262, 360, 386, 400])
def test_watertight_meshes_are_closed_manifold_and_oriented(number: int, shared_data: Path) -> None:
    mesh = read_mesh(shared_data / "meshes" / "watertight" / f"{number}.ply")
    assert (mesh.closed, mesh.manifold, mesh.oriented, mesh.component_count) == (True, True, True, 1)
    assert mesh.volume > 0
    assert mesh.genus == (2 - (len(mesh.vertices) - len(mesh.edges) + len(mesh.faces))) // 2
    assert mesh.topology.referenced.all()
    assert np.abs(mesh.vertices).max() < 1e6

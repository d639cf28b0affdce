"""The dynamic mesh: what every operation keeps, whatever it is asked for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_contracts.errors import InvalidInput
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_segmentation.mesh import DynamicMesh
from shapery_segmentation.mesh import _grid_kernels as grid
from shapery_segmentation.mesh import _remesh_kernels as passes
from shapery_segmentation.mesh.arrays import (
    CARELESS,
    CLEARANCE,
    CREATED,
    FREE_VERTEX,
    ORIGIN,
    SCALE,
    TOUCHED,
    TWIN,
    VERTEX_TOP,
)
from shapery_segmentation.mesh.invariants import defects
from shapery_segmentation.seeding.ball import surface_of


def everywhere(mesh: DynamicMesh) -> np.ndarray:
    return np.ones(mesh.vertex_slots, dtype=np.int8)


def split(mesh: DynamicMesh, h: int) -> int:
    """Split one edge; return the new vertex, or −1."""
    expected = (
        mesh.arrays.layout[FREE_VERTEX] if mesh.arrays.layout[FREE_VERTEX] >= 0 else mesh.arrays.layout[VERTEX_TOP]
    )
    h = min(h, int(mesh.arrays.half_edges[h, TWIN]))
    done, resume = passes.split_pass(mesh.arrays, h, h + 1, 1.0, 0.0, everywhere(mesh))
    assert resume == -1
    return int(expected) if done else -1


def flip(mesh: DynamicMesh, h: int) -> bool:
    """Flip one edge, however well it lies."""
    h = min(h, int(mesh.arrays.half_edges[h, TWIN]))
    return bool(passes.flip_pass(mesh.arrays, h, h + 1, -np.inf, everywhere(mesh)))


def collapse(mesh: DynamicMesh, h: int, longest: float = 100.0) -> bool:
    """Collapse one edge in one direction or the other, however long it is."""
    h = min(h, int(mesh.arrays.half_edges[h, TWIN]))
    active = everywhere(mesh)
    return bool(passes.collapse_pass(mesh.arrays, h, h + 1, 1.0, np.inf, longest, active, np.zeros_like(active)))


def next_around_face(h: int) -> int:
    return h - 2 if h % 3 == 2 else h + 1


def ready(surface: TriangleMesh, edge_length: float = 100.0) -> DynamicMesh:
    """Return a mesh on which operations can be called one by one: its grid is filled, nothing is remeshed."""
    mesh = DynamicMesh(surface, edge_length)
    mesh.remesh(np.zeros(mesh.vertex_slots, dtype=np.int8))
    assert defects(mesh) == []
    return mesh


def edge(mesh: DynamicMesh, h: int) -> tuple[int, int]:
    origins = mesh.arrays.half_edges[:, ORIGIN]
    return int(origins[h]), int(origins[next_around_face(h)])


def longest_edge(mesh: DynamicMesh) -> int:
    """Return a half-edge of the longest edge; only edges that are the longest of a face are ever split."""
    used = np.flatnonzero(mesh.arrays.half_edges[:, ORIGIN] >= 0)
    ends = [edge(mesh, int(h)) for h in used]
    points = mesh.arrays.points[:, :3]
    return int(used[np.argmax([np.linalg.norm(points[u] - points[v]) for u, v in ends])])


def torus(major: float = 6.0, minor: float = 2.0, n: int = 36, m: int = 14) -> TriangleMesh:
    """Return a closed surface of genus 1 with faces that look outwards."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    s, t = 2 * np.pi * i / n, 2 * np.pi * j / m
    vertices = np.stack(
        ((major + minor * np.cos(t)) * np.cos(s), (major + minor * np.cos(t)) * np.sin(s), minor * np.sin(t)), axis=1
    )
    right, up, both = ((i + 1) % n) * m + j, i * m + (j + 1) % m, ((i + 1) % n) * m + (j + 1) % m
    here = i * m + j
    mesh = TriangleMesh(vertices, np.concatenate((np.stack((here, right, both), 1), np.stack((here, both, up), 1))))
    assert mesh.volume > 0
    return mesh


def cube(n: int = 4, side: float = 8.0) -> TriangleMesh:
    """Return a cube of n² squares a side, each cut in two: flat, with many faces in one plane."""
    cells = np.ones((n, n, n), dtype=bool)
    step = side / n
    return surface_of(cells, np.diag([step, step, step, 1.0]))


SURFACES = {"sphere": lambda: icosphere((1, 2, 3), 5.0, 2), "torus": torus, "cube": cube}


# --- taking a surface in -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SURFACES)
def test_a_surface_goes_in_and_comes_out(name: str) -> None:
    surface = SURFACES[name]()
    mesh = DynamicMesh(surface, 1.0)
    assert defects(mesh) == []
    out = mesh.to_triangle_mesh()
    assert len(out.vertices) == len(surface.vertices)
    assert out.genus == surface.genus
    assert out.volume == pytest.approx(surface.volume, rel=1e-6)
    assert mesh.volume == pytest.approx(out.volume, rel=1e-5)
    order = np.lexsort(out.vertices.T)
    expected = surface.vertices.astype(np.float32).astype(np.float64)
    assert np.array_equal(out.vertices[order], expected[np.lexsort(expected.T)])


def test_vertices_that_no_face_uses_are_left_out() -> None:
    sphere = icosphere(radius=2.0, subdivisions=1)
    mesh = DynamicMesh(TriangleMesh(np.concatenate(([[9.0, 9, 9]], sphere.vertices)), sphere.faces + 1), 1.0)
    assert mesh.vertex_count == len(sphere.vertices)


def test_an_open_surface_is_refused() -> None:
    sphere = icosphere(subdivisions=1)
    with pytest.raises(InvalidInput, match="3 half-edges") as caught:
        DynamicMesh(TriangleMesh(sphere.vertices, sphere.faces[1:]), 1.0)
    assert caught.value.code == "invalid_mesh"


def test_a_face_turned_over_is_refused() -> None:
    sphere = icosphere(subdivisions=1)
    faces = sphere.faces.copy()
    faces[0] = faces[0, ::-1]
    with pytest.raises(InvalidInput, match="half-edges"):
        DynamicMesh(TriangleMesh(sphere.vertices, faces), 1.0)


def test_two_parts_with_a_common_vertex_are_refused() -> None:
    one = icosphere((0, 0, 0), 1.0, 1)
    other = icosphere((0, 0, 0), 1.0, 1)
    shift = one.vertices[0] * 2.0
    faces = other.faces + len(one.vertices)
    # The antipode of vertex 0 in the second sphere is where vertex 0 of the first one is.
    opposite = int(np.argmin(other.vertices @ one.vertices[0]))
    faces[faces == opposite + len(one.vertices)] = 0
    both = TriangleMesh(np.concatenate((one.vertices, other.vertices + shift)), np.concatenate((one.faces, faces)))
    with pytest.raises(InvalidInput, match="1 vertices in which it touches itself"):
        DynamicMesh(both, 1.0)


def test_spheres_that_overlap_are_refused() -> None:
    a, b = icosphere((0, 0, 0), 2.0, 2), icosphere((3, 0, 0), 2.0, 2)
    both = TriangleMesh(np.concatenate((a.vertices, b.vertices)), np.concatenate((a.faces, b.faces + len(a.vertices))))
    with pytest.raises(InvalidInput, match="touch others"):
        DynamicMesh(both, 1.0)


def test_what_touched_before_is_mended_or_refused() -> None:
    """A corner of a sphere that was pushed out through the far side."""
    pushed = icosphere((0, 0, 0), 2.0, 3)
    vertices = pushed.vertices.copy()
    vertices[0] *= -1.2
    pushed = TriangleMesh(vertices, pushed.faces)
    assert len(self_intersections(pushed))
    mesh = DynamicMesh(pushed, 0.35, test=False)
    mesh.retriangulate(2)
    assert len(self_intersections(mesh.to_triangle_mesh())) == 0
    assert not defects(mesh)
    # Two spheres through each other are beyond smoothing.
    one, other = icosphere((0, 0, 0), 2.0, 3), icosphere((1.5, 0, 0), 2.0, 3)
    both = TriangleMesh(
        np.concatenate((one.vertices, other.vertices)), np.concatenate((one.faces, other.faces + len(one.vertices)))
    )
    with pytest.raises(InvalidInput, match="touch others"):
        DynamicMesh(both, 0.35, test=False).retriangulate(2)


@pytest.mark.parametrize("length", [0.0, -1.0, np.nan])
def test_edge_lengths_must_be_positive(length: float) -> None:
    with pytest.raises(ValueError, match="edge length"):
        DynamicMesh(icosphere(), length)


# --- one operation -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SURFACES)
def test_a_split_adds_a_vertex_and_leaves_the_shape(name: str) -> None:
    mesh = ready(SURFACES[name]())
    vertices, faces, volume = mesh.vertex_count, mesh.face_count, mesh.volume
    u, v = edge(mesh, longest_edge(mesh))
    w = split(mesh, longest_edge(mesh))
    assert w >= 0
    assert (mesh.vertex_count, mesh.face_count) == (vertices + 1, faces + 2)
    assert np.allclose(mesh.arrays.points[w, :3], mesh.arrays.points[[u, v], :3].mean(axis=0), atol=1e-6)
    assert mesh.arrays.vertices[w, TOUCHED] == CREATED
    assert mesh.volume == pytest.approx(volume, rel=1e-5)
    assert defects(mesh) == []


@pytest.mark.parametrize("name", SURFACES)
def test_a_collapse_takes_back_what_a_split_added(name: str) -> None:
    mesh = ready(SURFACES[name]())
    before = mesh.to_triangle_mesh()
    w = split(mesh, longest_edge(mesh))
    h = int(np.flatnonzero(mesh.arrays.half_edges[:, ORIGIN] == w)[0])
    assert collapse(mesh, h)
    after = mesh.to_triangle_mesh()
    assert (len(after.vertices), len(after.faces)) == (len(before.vertices), len(before.faces))
    assert after.genus == before.genus
    assert defects(mesh) == []


@pytest.mark.parametrize("name", ["torus", "cube"])
def test_a_flip_exchanges_the_diagonal_and_flips_back(name: str) -> None:
    mesh = ready(SURFACES[name]())
    before = mesh.to_triangle_mesh()
    edges = {tuple(e) for e in before.edges.tolist()}
    flipped = 0
    for h in range(0, 3 * len(before.faces), 41):
        if not flip(mesh, h):
            continue
        flipped += 1
        after = mesh.to_triangle_mesh()
        assert len(edges ^ {tuple(e) for e in after.edges.tolist()}) == 2
        assert defects(mesh) == []
        # The bound on the volume: the tetrahedron over the two faces.
        assert abs(after.volume - before.volume) <= 0.05 * before.volume
        assert flip(mesh, h)
        assert {tuple(e) for e in mesh.to_triangle_mesh().edges.tolist()} == edges
    assert flipped >= 5
    assert defects(mesh) == []


def test_a_tetrahedron_is_never_collapsed_nor_flipped() -> None:
    p = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float64)
    mesh = ready(TriangleMesh(p, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    for h in range(12):
        assert not collapse(mesh, h)
        assert not flip(mesh, h)
    assert defects(mesh) == []


def test_no_collapse_closes_the_hole_of_a_torus() -> None:
    # A tube of three vertices around: collapsing one of these rings' edges would pinch it.
    mesh = ready(torus(6.0, 0.5, n=40, m=3))
    for h in range(3 * 240):
        if mesh.arrays.half_edges[h, ORIGIN] >= 0:
            collapse(mesh, h)
    out = mesh.to_triangle_mesh()
    assert out.genus == 1
    assert defects(mesh) == []


def test_a_collapse_makes_no_edge_longer_than_allowed() -> None:
    mesh = ready(icosphere(radius=5.0, subdivisions=3))
    for h in range(600):
        if mesh.arrays.half_edges[h, ORIGIN] >= 0:
            collapse(mesh, h, 1.5)
    lengths = mesh.to_triangle_mesh().edge_lengths
    assert mesh.vertex_count < 642
    assert lengths.max() <= 1.5 + 1e-9


# --- remeshing -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("length", [0.7, 1.5, 4.0])
def test_remeshing_reaches_the_edge_length_and_keeps_the_surface(name: str, length: float) -> None:
    surface = SURFACES[name]()
    mesh = DynamicMesh(surface, length)
    mesh.remesh(rounds=30)
    assert defects(mesh) == []
    out = mesh.to_triangle_mesh()
    assert out.closed
    assert out.manifold
    assert out.oriented
    assert out.genus == surface.genus
    assert out.component_count == 1
    assert len(self_intersections(out)) == 0
    assert np.percentile(out.edge_lengths, 99) <= 1.5 * length
    # Triangles inside a round surface of radius r miss a share of the volume that grows with (h/r)².
    radius = {"sphere": 5.0, "torus": 2.0, "cube": 4.0}[name]
    assert out.volume == pytest.approx(surface.volume, rel=0.01 + 0.5 * (length / radius) ** 2)


def test_remeshing_a_fine_mesh_again_does_nothing() -> None:
    mesh = DynamicMesh(icosphere(radius=5.0, subdivisions=3), 1.0)
    mesh.remesh(rounds=30)
    done = mesh.remesh()
    assert done.splits + done.collapses + done.flips <= 0.01 * mesh.face_count


def test_the_scale_of_a_vertex_refines_around_it() -> None:
    mesh = DynamicMesh(icosphere(radius=5.0, subdivisions=3), 1.0)
    mesh.remesh(rounds=10)
    near = np.linalg.norm(mesh.arrays.points[:, :3] - (0, 0, 5.0), axis=1) < 2.0
    mesh.arrays.points[near, SCALE] = 0.5
    mesh.remesh(rounds=20)
    assert defects(mesh) == []
    out = mesh.to_triangle_mesh()
    middle = out.vertices[out.edges].mean(axis=1)
    distance = np.linalg.norm(middle - (0, 0, 5.0), axis=1)
    assert out.edge_lengths[distance < 1.2].mean() < 0.65 * out.edge_lengths[distance > 4.0].mean()


def test_only_active_edges_change() -> None:
    mesh = DynamicMesh(icosphere(radius=5.0, subdivisions=2), 0.5)
    points = mesh.arrays.points[:, :3]
    active = (points[:, 2] > 3.0).astype(np.int8)
    mesh.remesh(active)
    out = mesh.to_triangle_mesh()
    low = out.vertices[out.edges].max(axis=1)[:, 2] < -1.0
    assert out.edge_lengths[low].min() > 0.8
    assert defects(mesh) == []


def test_arrays_grow_as_often_as_needed() -> None:
    mesh = DynamicMesh(icosphere(radius=5.0, subdivisions=0), 0.5)
    slots = mesh.vertex_slots
    mesh.remesh(rounds=40)
    assert mesh.vertex_slots > 4 * slots
    assert mesh.vertex_count > 1000
    assert defects(mesh) == []


def test_compacting_keeps_the_surface_and_closes_the_gaps() -> None:
    mesh = DynamicMesh(icosphere(radius=5.0, subdivisions=4), 1.5)
    mesh.remesh(rounds=20)
    before = mesh.to_triangle_mesh()
    mesh.compact()
    assert defects(mesh) == []
    after = mesh.to_triangle_mesh()
    assert np.array_equal(mesh.live, np.arange(mesh.vertex_count))
    assert (len(after.vertices), len(after.faces)) == (len(before.vertices), len(before.faces))
    assert after.volume == pytest.approx(before.volume, rel=1e-12)


# --- moving --------------------------------------------------------------------------------------------------------


def test_vertices_go_where_they_are_sent() -> None:
    mesh = DynamicMesh(icosphere((10, 20, 30), 5.0, 3), 1.0)
    live = mesh.live
    target = mesh.arrays.points[live, :3] + (0.1, -0.2, 0.05)
    assert mesh.move(live, target).all()
    assert np.allclose(mesh.arrays.points[live, :3], target, atol=2e-6)
    assert defects(mesh) == []


def test_a_vertex_that_would_cross_another_part_stays() -> None:
    a, b = icosphere((0, 0, 0), 2.0, 2), icosphere((4.1, 0, 0), 2.0, 2)
    both = TriangleMesh(np.concatenate((a.vertices, b.vertices)), np.concatenate((a.faces, b.faces + len(a.vertices))))
    mesh = DynamicMesh(both, 1.0)
    live = mesh.live
    points = mesh.arrays.points[live, :3]
    left = points[:, 0] < 2.05
    before = points.copy()
    moved = mesh.move(live[left], points[left] + (0.6, 0, 0))
    assert defects(mesh) == []
    assert moved.any()
    assert not moved.all()
    # What went back is where it was, what moved is where it was sent.
    after = mesh.arrays.points[live, :3]
    assert np.array_equal(after[left][~moved], before[left][~moved])
    assert np.allclose(after[left][moved], before[left][moved] + (0.6, 0, 0), atol=1e-5)
    assert np.array_equal(after[~left], before[~left])


def test_a_face_is_not_turned_over() -> None:
    mesh = DynamicMesh(icosphere(radius=5.0, subdivisions=2), 1.0)
    v = int(mesh.live[0])
    inward = mesh.arrays.points[v, :3] * 0.2
    assert not mesh.move(np.array([v], dtype=np.int32), inward[None]).any()
    assert defects(mesh) == []


def test_nothing_moves_if_nobody_is_named() -> None:
    mesh = DynamicMesh(icosphere(radius=5.0, subdivisions=1), 1.0)
    assert mesh.move(np.zeros(0, dtype=np.int32), np.zeros((0, 3))).shape == (0,)
    assert defects(mesh) == []


@given(st.integers(0, 2**32 - 1), st.sampled_from(sorted(SURFACES)), st.floats(0.02, 1.5), st.floats(0.6, 2.5))
@settings(max_examples=15, deadline=None)
@pytest.mark.slow
def test_random_moves_and_remeshing_keep_everything(seed: int, name: str, size: float, length: float) -> None:
    rng = np.random.default_rng(seed)
    surface = SURFACES[name]()
    mesh = DynamicMesh(surface, length)
    for _ in range(4):
        live = mesh.live
        some = live[rng.random(len(live)) < 0.7]
        mesh.move(some, mesh.arrays.points[some, :3] + size * rng.normal(size=(len(some), 3)))
        assert defects(mesh) == []
        mesh.remesh((rng.random(mesh.vertex_slots) < 0.5).astype(np.int8))
        assert defects(mesh) == []
    out = mesh.to_triangle_mesh()
    assert out.genus == surface.genus
    assert len(self_intersections(out)) == 0


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=10, deadline=None)
def test_any_order_of_single_operations_keeps_everything(seed: int) -> None:
    rng = np.random.default_rng(seed)
    surface = SURFACES[("sphere", "torus", "cube")[seed % 3]]()
    mesh = ready(surface)
    done = np.zeros(3, dtype=int)
    for _ in range(60):
        half_edges = np.flatnonzero(mesh.arrays.half_edges[:, ORIGIN] >= 0)
        h = int(rng.choice(half_edges[half_edges < 3 * (mesh.face_count + 100)]))
        if mesh.arrays.half_edges[3 * (h // 3), ORIGIN] < 0:
            continue
        kind = int(rng.integers(3))
        if kind == 0:
            done[0] += split(mesh, h) >= 0
        elif kind == 1:
            done[1] += flip(mesh, h)
        else:
            done[2] += collapse(mesh, h)
        assert mesh.face_count - mesh.vertex_count * 2 == -2 * (2 - 2 * surface.genus)
    assert defects(mesh) == []
    assert (done > 0).all()
    assert mesh.to_triangle_mesh().genus == surface.genus


def test_the_checker_finds_what_is_broken() -> None:
    mesh = ready(icosphere(radius=5.0, subdivisions=2))
    mesh.arrays.points[0, 0] += 1.0 / 3.0
    found = defects(mesh)
    assert "a position is not a float32 value" in found
    assert "what is known of a face is not what its corners say" in found
    mesh = ready(icosphere(radius=5.0, subdivisions=2))
    mesh.arrays.half_edges[0, 1] = 1
    assert defects(mesh) == ["twins are not mutual"]
    mesh = ready(icosphere(radius=5.0, subdivisions=2))
    mesh.arrays.links[3, 11] = 1
    assert defects(mesh) == ["a face is still marked as about to be replaced"]


@pytest.mark.parametrize("name", SURFACES)
def test_faces_cut_into_four_leave_the_surface_as_it_is(name: str) -> None:
    surface = SURFACES[name]()
    mesh = DynamicMesh(surface, 1.0)
    mesh.arrays.points[mesh.live[:5], SCALE] = 0.5
    assert mesh.subdivide() is not None
    assert defects(mesh) == []
    out = mesh.to_triangle_mesh()
    assert len(out.faces) == 4 * len(surface.faces)
    assert out.genus == surface.genus
    assert out.volume == pytest.approx(surface.volume, rel=1e-6)
    assert out.area == pytest.approx(surface.area, rel=1e-6)
    assert out.edge_lengths.mean() == pytest.approx(0.5 * surface.edge_lengths.mean(), rel=0.05)
    # New vertices take the finer target of their ends.
    assert (mesh.arrays.points[mesh.live, SCALE] == 0.5).sum() > 5


@pytest.mark.parametrize("touching", [False, True])
def test_a_mesh_is_brought_to_its_edge_length_and_with_care_where_that_made_contacts(
    touching: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = DynamicMesh(icosphere(radius=6.0, subdivisions=4), 2.0)
    careless: list[int] = []
    remesh = DynamicMesh.remesh

    def noted(self: DynamicMesh, **given: int) -> object:
        careless.append(int(given.get("careless", False)))
        return remesh(self, **given)  # type: ignore[arg-type]

    # Where it touches itself after that, the surface to start from is asked, too.
    answers = iter([touching, False])
    with monkeypatch.context() as patched:
        patched.setattr(DynamicMesh, "remesh", noted)
        patched.setattr(DynamicMesh, "touches_itself", lambda self: next(answers))
        mesh.retriangulate(8)
    assert careless == ([1, 0] if touching else [1])
    assert mesh.arrays.layout[CARELESS] == 0
    assert mesh.arrays.bound[CLEARANCE] == DynamicMesh(icosphere(radius=6.0), 2.0).arrays.bound[CLEARANCE]
    assert defects(mesh) == []
    assert mesh.to_triangle_mesh().edge_lengths.mean() == pytest.approx(2.0, rel=0.2)


def test_a_seed_that_touches_itself_is_refused_where_its_contacts_are_met() -> None:
    a, b = icosphere((0, 0, 0), 2.0, 2), icosphere((3, 0, 0), 2.0, 2)
    both = TriangleMesh(np.concatenate((a.vertices, b.vertices)), np.concatenate((a.faces, b.faces + len(a.vertices))))
    mesh = DynamicMesh(both, 1.0, test=False)
    with pytest.raises(InvalidInput, match="touch others"):
        mesh.retriangulate(2)


def test_a_vertex_that_pierces_the_surface_is_mended_and_little_else_moves() -> None:
    mesh = DynamicMesh(icosphere(radius=5.0, subdivisions=3), 1.0)
    before = mesh.to_triangle_mesh()
    assert mesh.mend(1)
    assert mesh.to_triangle_mesh().same_as(before)
    v = int(mesh.live[7])
    mesh.arrays.points[v, :3] = (-1.1 * mesh.arrays.points[v, :3]).astype(np.float32)
    grid.measure_all(mesh.arrays)
    assert mesh.touches_itself()
    assert mesh.mend(4)
    assert defects(mesh) == []
    after = mesh.to_triangle_mesh()
    assert np.linalg.norm(after.vertices - before.vertices, axis=1).max() < 1.0
    assert (after.vertices != before.vertices).any(axis=1).sum() < 40


def test_the_fast_test_for_contacts_says_what_the_plain_one_says() -> None:
    rng = np.random.default_rng(11)
    answers = []
    for size in (0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.6) * 3:
        mesh = DynamicMesh(icosphere(radius=3.0, subdivisions=2), 1.0)
        # Vertices are put where no move would put them.
        live = mesh.live
        mesh.arrays.points[live, :3] += rng.normal(scale=size, size=(len(live), 3)).astype(np.float32)
        grid.measure_all(mesh.arrays)
        answers.append(mesh.touches_itself())
        assert answers[-1] == (mesh.contacts() > 0)
    assert 3 < sum(answers) < len(answers) - 3


def test_what_is_mended_around_the_contacts_is_sound_as_a_whole() -> None:
    rng = np.random.default_rng(5)
    mended = []
    for count in (1, 3, 6, 12) * 3:
        mesh = DynamicMesh(icosphere(radius=3.0, subdivisions=3), 0.5)
        chosen = rng.choice(mesh.live, count, replace=False)
        # Through the other side, so that much is pierced.
        mesh.arrays.points[chosen, :3] *= -1.1
        mesh.arrays.points[:, :3] = mesh.arrays.points[:, :3].astype(np.float32)
        grid.measure_all(mesh.arrays)
        touched = mesh.contacts() > 0
        sound = mesh.mend(6)
        assert sound == (mesh.contacts() == 0)
        mended.append(touched and sound)
    assert sum(mended) > 3

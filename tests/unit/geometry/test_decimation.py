"""Fewer faces for the same shape: what must stay stays, and what bends keeps its vertices."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_geometry.decimation import decimate
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.operators.surface_distance import closest_points
from shapery_geometry.repair import mesh_report, weld

SPHERE = icosphere((5, 6, 7), 10, 4)


def grid(n: int) -> TriangleMesh:
    """Return a flat unit square of 2n² faces."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate((np.stack((a, a + n + 1, a + n + 2), 1), np.stack((a, a + n + 2, a + 1), 1)))
    return TriangleMesh(np.stack((x / n, y / n, np.zeros(len(x))), 1), faces)


def torus(n: int) -> TriangleMesh:
    """Return a torus of 2n² faces, which is a grid whose opposite sides are one."""
    square = weld(grid(n).with_vertices(_around(grid(n).vertices)), 1e-9).mesh
    return square if square.volume > 0 else square.flipped()


def _around(places: np.ndarray) -> np.ndarray:
    a, b = 2 * np.pi * places[:, 0], 2 * np.pi * places[:, 1]
    return np.stack(((3 + np.cos(b)) * np.cos(a), (3 + np.cos(b)) * np.sin(a), np.sin(b)), axis=1)


def test_a_sphere_stays_one() -> None:
    few = decimate(SPHERE, 300)
    report = mesh_report(few, intersections=True)
    assert report.sound
    assert report.genus == 0
    assert report.faces == 300
    assert abs(few.volume / SPHERE.volume - 1) < 0.02
    assert closest_points(few, SPHERE.vertices).distances.max() < 0.4
    assert decimate(few, 300) is few
    with pytest.raises(ValueError, match="4 faces"):
        decimate(SPHERE, 3)


def test_handles_and_components_are_kept() -> None:
    ring = torus(32)
    two = TriangleMesh(
        np.concatenate((ring.vertices, SPHERE.vertices + 100)),
        np.concatenate((ring.faces, SPHERE.faces + len(ring.vertices))),
    )
    for faces in (400, 4):
        few = decimate(two, faces)
        report = mesh_report(few)
        assert report.components == 2
        assert report.euler_characteristic == 0 + 2
        assert report.sound
    # neither a torus nor a second sphere can go below a few faces without tearing
    assert 4 < len(decimate(two, 4).faces) < 60


def test_a_rim_keeps_its_shape_and_the_flat_inside_is_even() -> None:
    square = grid(30)
    few = decimate(square, 200)
    assert few.area == pytest.approx(1, abs=1e-3)
    assert few.euler_characteristic == 1
    assert np.abs(few.vertices[:, 2]).max() < 1e-12
    corners = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]])
    apart = np.linalg.norm(few.vertices[:, None] - corners, axis=2).min(axis=0)
    assert apart.max() < 0.02
    assert few.face_areas.max() < 8 * np.median(few.face_areas)


def test_edges_are_kept_and_flats_give_their_vertices() -> None:
    n = 12
    sides = []
    for axis in range(3):
        for end in (0.0, 1.0):
            side = np.roll(grid(n).vertices, axis, axis=1)
            side[:, (axis + 2) % 3] = end
            sides.append(TriangleMesh(side, grid(n).faces if end else grid(n).faces[:, ::-1]))
    starts = np.cumsum([0, *(len(side.vertices) for side in sides)])
    soup = TriangleMesh(
        np.concatenate([side.vertices for side in sides]),
        np.concatenate([side.faces + start for side, start in zip(sides, starts[:-1], strict=True)]),
    )
    box = weld(soup, 1e-6).mesh
    assert box.closed
    few = decimate(box, 60)
    assert mesh_report(few, intersections=True).sound
    assert few.volume == pytest.approx(1, abs=5e-3)


def test_what_is_not_manifold_is_reduced_without_topology() -> None:
    # three sheets that meet in one edge, and every face twice removed from being a surface
    sheet = grid(16).vertices
    turned = [sheet @ np.array([[1, 0, 0], [0, np.cos(t), np.sin(t)], [0, -np.sin(t), np.cos(t)]]) for t in (0, 2, 4)]
    book = weld(
        TriangleMesh(np.concatenate(turned), np.concatenate([grid(16).faces + 289 * k for k in range(3)])), 1e-9
    ).mesh
    assert len(book.topology.nonmanifold_edges) == 16
    few = decimate(book, 100)
    assert len(few.faces) <= 100
    assert few.area == pytest.approx(3, abs=0.05)
    crumbs = [icosphere((3 * k, 0, 0), 1, 1) for k in range(40)]
    many = TriangleMesh(
        np.concatenate([c.vertices for c in crumbs]), np.concatenate([c.faces + 42 * k for k, c in enumerate(crumbs)])
    )
    held = decimate(many, 100)
    assert held.component_count == 40
    assert len(held.faces) > 100
    assert len(decimate(many, 100, keep_topology=False).faces) < len(held.faces)


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_units_places_and_runs_change_nothing(unit: float) -> None:
    bumpy = SPHERE.with_vertices(SPHERE.vertices * (1 + 0.1 * np.sin(SPHERE.vertices)))
    few = decimate(bumpy, 500)
    again = decimate(bumpy.with_vertices(bumpy.vertices * unit + unit), 500)
    assert decimate(bumpy, 500).same_as(few)
    assert np.array_equal(again.faces, few.faces)
    assert np.allclose((again.vertices - unit) / unit, few.vertices, atol=1e-5)


@pytest.mark.parametrize("seed", range(12))
def test_any_soup_leaves_something(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(rng.integers(4, 30), 3)) * 10.0 ** rng.integers(-9, 9)
    faces = rng.integers(0, len(points), size=(rng.integers(6, 100), 3))
    soup = TriangleMesh(points, np.concatenate((faces, faces[::-1, ::-1])))
    for keep_topology in (True, False):
        few = decimate(soup, 5, keep_topology=keep_topology)
        assert len(few.faces) > 0
        assert len(few.topology.degenerate_faces) == 0
        assert few.topology.referenced.all()
    twice = TriangleMesh(np.eye(3), [[0, 1, 2]] * 6)
    assert len(decimate(twice, 4, keep_topology=False).faces) > 0


def test_faces_without_area_do_not_stop_it() -> None:
    flat = np.zeros(len(SPHERE.vertices))
    line = SPHERE.with_vertices(np.stack((SPHERE.vertices[:, 0], flat, flat), axis=1))
    found = decimate(line, 100)
    assert np.isfinite(found.vertices).all()
    doubled = TriangleMesh(SPHERE.vertices, np.concatenate((SPHERE.faces, SPHERE.faces[:50], [[0, 0, 1]])))
    assert len(decimate(doubled, 500).faces) <= 600

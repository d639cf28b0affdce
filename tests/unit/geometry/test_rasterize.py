"""Voxels inside a closed surface."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume

BOX_FACES = np.array(
    [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
     [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
)  # fmt: skip


def box_mesh(low: tuple[float, ...], high: tuple[float, ...]) -> TriangleMesh:
    corners = [
        [(low, high)[b][axis] for axis, b in enumerate((x, y, z))] for z, y, x in itertools.product((0, 1), repeat=3)
    ]
    mesh = TriangleMesh(np.array(corners), BOX_FACES)
    assert mesh.volume > 0
    return mesh


def grid(shape: tuple[int, int, int] = (12, 11, 10), affine: np.ndarray | None = None) -> Volume:
    return Volume(np.zeros(shape, np.uint8), np.eye(4) if affine is None else affine)


def test_box_between_voxel_centres_is_exact() -> None:
    mask = rasterize(box_mesh((1.5, 2.5, 3.5), (6.5, 7.5, 8.5)), grid())
    expected = np.zeros((12, 11, 10), bool)
    expected[2:7, 3:8, 4:9] = True
    np.testing.assert_array_equal(mask, expected)


def test_box_through_voxel_centres_counts_each_side_once() -> None:
    # Half-open on every axis: the box of 5³ mm holds 5³ voxels, not 4³ or 6³.
    low = rasterize(box_mesh((2, 3, 4), (7, 8, 9)), grid())
    assert low.sum() == 125
    # Two boxes that share a side share no voxel and miss none.
    left = rasterize(box_mesh((2, 3, 4), (4, 8, 9)), grid())
    right = rasterize(box_mesh((4, 3, 4), (7, 8, 9)), grid())
    assert not (left & right).any()
    np.testing.assert_array_equal(left | right, low)


def test_sphere_agrees_with_its_triangles() -> None:
    centre, radius = np.array([10.2, 9.7, 11.4]), 7.3
    sphere = icosphere(centre, radius, 4)
    mask = rasterize(sphere, grid((22, 22, 24)))
    index = np.stack(np.meshgrid(*map(np.arange, mask.shape), indexing="ij"), axis=-1)
    distance = np.linalg.norm(index - centre, axis=-1)
    # The polyhedron lies between the sphere and the sphere shrunk by the sagitta of its longest edge.
    sagitta = radius - np.sqrt(radius**2 - (sphere.edge_lengths.max() / np.sqrt(3)) ** 2)
    assert mask[distance < radius - sagitta].all()
    assert not mask[distance > radius].any()


def test_vertices_and_edges_on_columns_leave_no_stripes() -> None:
    # An octahedron on integer coordinates: every axis column runs through vertices and edges.
    points = np.array([[5, 5, 1], [5, 5, 9], [1, 5, 5], [9, 5, 5], [5, 1, 5], [5, 9, 5]], float)
    faces = [[0, 4, 2], [0, 3, 4], [0, 5, 3], [0, 2, 5], [1, 2, 4], [1, 4, 3], [1, 3, 5], [1, 5, 2]]
    mesh = TriangleMesh(points, faces)
    mesh = mesh if mesh.volume > 0 else mesh.flipped()
    mask = rasterize(mesh, grid((11, 11, 11)))
    index = np.stack(np.meshgrid(*map(np.arange, mask.shape), indexing="ij"), axis=-1)
    norm = np.abs(index - 5).sum(axis=-1)
    assert mask[norm < 4].all()
    assert not mask[norm > 4].any()


def test_cavity_and_overlap() -> None:
    outer = box_mesh((1.5,) * 3, (8.5,) * 3)
    inner = box_mesh((3.5,) * 3, (5.5,) * 3)
    hollow = TriangleMesh(
        np.concatenate((outer.vertices, inner.vertices)), np.concatenate((outer.faces, inner.faces[:, ::-1] + 8))
    )
    assert rasterize(hollow, grid()).sum() == 7**3 - 2**3
    both = TriangleMesh(
        np.concatenate((outer.vertices, inner.vertices)), np.concatenate((outer.faces, inner.faces + 8))
    )
    assert rasterize(both, grid()).sum() == 7**3


def test_parts_outside_the_grid_are_cut() -> None:
    mask = rasterize(box_mesh((-5.5, 2.5, 3.5), (3.5, 70.5, 100.5)), grid())
    expected = np.zeros((12, 11, 10), bool)
    expected[:4, 3:, 4:] = True
    np.testing.assert_array_equal(mask, expected)
    assert not rasterize(box_mesh((40, 40, 40), (50, 50, 50)), grid()).any()
    # Everything inside, the surface wholly outside.
    assert rasterize(box_mesh((-9,) * 3, (40,) * 3), grid()).all()


def test_oblique_anisotropic_left_handed_grid() -> None:
    rng = np.random.default_rng(3)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    for sign in (1, -1):
        affine = np.eye(4)
        affine[:3, :3] = rotation @ np.diag([0.7 * sign, 1.1, 2.6])
        affine[:3, 3] = (-4, 7, 1)
        volume = grid((30, 20, 9), affine)
        centre = volume.to_world((14.3, 9.2, 4.1))
        mask = rasterize(icosphere(centre, 6.0, 5), volume)
        index = np.stack(np.meshgrid(*map(np.arange, mask.shape), indexing="ij"), axis=-1)
        distance = np.linalg.norm(volume.to_world(index) - centre, axis=-1)
        # 5 subdivisions leave the polyhedron within 0.01 mm of the sphere.
        assert mask[distance < 5.99].all()
        assert not mask[distance > 6.0].any()


def test_mask_does_not_depend_on_the_order_of_axes() -> None:
    mesh = icosphere((7.31, 6.83, 7.77), 5.123, 3)
    reference = grid((16, 15, 17))
    expected = rasterize(mesh, reference)
    for axes in itertools.permutations(range(3)):
        for flips in itertools.product((1, -1), repeat=3):
            shape, origin, affine = (16, 15, 17), np.zeros(3), np.zeros((4, 4))
            affine[3, 3] = 1
            for k, axis in enumerate(axes):
                affine[axis, k] = flips[axis]
                origin[axis] = shape[axis] - 1 if flips[axis] < 0 else 0
            affine[:3, 3] = origin
            mask = rasterize(mesh, grid(tuple(shape[a] for a in axes), affine))
            back = mask.transpose(np.argsort(axes))[tuple(slice(None, None, f) for f in flips)]
            np.testing.assert_array_equal(back, expected)


def test_far_from_the_origin_and_very_fine_grids() -> None:
    affine = np.diag([1e-3, 1e-3, 1e-3, 1.0])
    affine[:3, 3] = 5000.0
    mask = rasterize(box_mesh((5000.0015,) * 3, (5000.0065,) * 3), grid((10, 10, 10), affine))
    assert mask.sum() == 125
    # A surface of 40,000 voxels across: coordinates are rounded more coarsely, not wrapped.
    huge = rasterize(box_mesh((-20000.3, 2.5, 3.5), (20000.2, 7.5, 8.5)), grid())
    expected = np.zeros((12, 11, 10), bool)
    expected[:, 3:8, 4:9] = True
    np.testing.assert_array_equal(huge, expected)


def test_a_surface_known_to_be_closed_gives_the_same_voxels() -> None:
    box = box_mesh((1.3, 2.2, 0.7), (8.6, 7.1, 6.4))
    np.testing.assert_array_equal(rasterize(box, grid(), known_closed=True), rasterize(box, grid()))


def test_open_surface_is_refused_and_empty_one_is_empty() -> None:
    sphere = icosphere((5, 5, 5), 3, 1)
    with pytest.raises(InvalidInput) as caught:
        rasterize(TriangleMesh(sphere.vertices, sphere.faces[1:]), grid())
    assert caught.value.code == "invalid_mesh"
    assert "3 boundary edges" in caught.value.message
    assert not rasterize(TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), grid()).any()

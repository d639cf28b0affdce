"""How shapes stand in their pictures, and what viewers are given of them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_retrieval.normalise import MIN_VERTICES, web_mesh
from shapery_retrieval.pose import pose_of
from shapery_retrieval.preview import preview

Y_UP = np.eye(3)
Z_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Turns what has y up so that z is up."""


def boxes(*corners: tuple[tuple[float, float, float], tuple[float, float, float]]) -> TriangleMesh:
    """Boxes between pairs of corners."""
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    faces = np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))
    choice = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)])
    points = [np.where(choice, high, low) for low, high in corners]
    return TriangleMesh(np.concatenate(points), np.concatenate([faces + 8 * k for k in range(len(points))]))


def table() -> TriangleMesh:
    """A table with y up, twice as wide as deep."""
    legs = [((x, 0.0, z), (x + 0.1, 0.9, z + 0.1)) for x in (0.0, 1.9) for z in (0.0, 0.9)]
    return boxes(((0, 0.9, 0), (2, 1, 1)), *legs)


def goblet() -> TriangleMesh:
    """A foot, a stem and a wide cup, with y up."""
    return boxes(
        ((-0.5, 0, -0.5), (0.5, 0.1, 0.5)), ((-0.1, 0.1, -0.1), (0.1, 1, 0.1)), ((-0.6, 1, -0.6), (0.6, 2, 0.6))
    )


@pytest.mark.parametrize("turn", [Y_UP, Z_UP], ids=["y", "z"])
@pytest.mark.parametrize("make", [table, goblet])
def test_things_stand_whichever_axis_of_the_file_is_up(make: type, turn: NDArray[np.float64]) -> None:
    mesh = make()
    turned = pose_of(mesh.with_vertices(mesh.vertices @ turn.T + [5.0, -3, 8]))
    np.testing.assert_allclose(turned.frame[1], turn[:, 1], atol=1e-12)
    np.testing.assert_allclose(turned.frame @ turned.frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turned.frame) == pytest.approx(1)
    assert np.linalg.norm(turned.towards) == pytest.approx(1)


def test_the_long_side_lies_across_and_flat_things_are_seen_from_above() -> None:
    standing = pose_of(table())
    np.testing.assert_allclose(np.abs(standing.frame[0]), [1, 0, 0], atol=1e-12)
    plate = web_mesh(boxes(((0, 0, 0), (2, 0.1, 1))))
    assert pose_of(plate).towards[1] > standing.towards[1] + 0.2
    assert standing.towards[2] > 0.5


def test_what_reaches_out_is_in_front() -> None:
    nose = boxes(((-1, 0, -1), (1, 1, 1)), ((-0.1, 0.4, -2), (0.1, 0.5, -1)))
    np.testing.assert_allclose(pose_of(nose).frame[[0, 2]] @ [0, 0, -1], [1, 0], atol=1e-9)


def test_the_picture_shows_the_shape_as_it_stands() -> None:
    mesh = table()
    alpha = preview(mesh, 64)[..., 3]
    np.testing.assert_array_equal(alpha, preview(mesh.with_vertices(mesh.vertices @ Z_UP.T), 64)[..., 3])
    rows = (alpha > 128).sum(axis=1)[(alpha > 128).any(axis=1)]
    assert rows[: len(rows) // 2].sum() > 2 * rows[len(rows) // 2 :].sum(), "the top is above the legs"


def test_large_faces_are_split_for_viewers_and_nothing_else_is_changed() -> None:
    mesh = table()
    shown = web_mesh(mesh)
    assert shown.edge_lengths.max() <= 2 * np.sqrt(mesh.area / MIN_VERTICES) < 0.2 * mesh.edge_lengths.max()
    assert shown.area == pytest.approx(mesh.area)
    np.testing.assert_allclose(shown.bounding_box, mesh.bounding_box)
    fine = icosphere(4)
    assert len(web_mesh(fine).faces) == len(fine.faces)

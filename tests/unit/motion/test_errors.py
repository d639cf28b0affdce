"""Error measures of decoded sequences, against closed forms and plain references."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_motion.errors import ErrorMeter, dissertation_bits, interior_edges, sequence_errors

SPHERE = icosphere(subdivisions=2)


def wobble(seed: int, frames: int = 4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return SPHERE.vertices + 0.05 * rng.standard_normal((frames, len(SPHERE.vertices), 3))


def test_positions_against_the_definitions() -> None:
    a, b = wobble(1), wobble(2)
    found = sequence_errors(a, b, SPHERE.faces)
    lengths = np.array([TriangleMesh(frame, SPHERE.faces).edge_lengths.mean() for frame in a])
    distances = np.linalg.norm(a - b, axis=2)
    mean = a.mean(axis=1, keepdims=True)
    assert found.kg_percent == pytest.approx(100 * np.linalg.norm(a - b) / np.linalg.norm(a - mean), rel=1e-12)
    assert found.mean_edge == pytest.approx(lengths.mean(), rel=1e-12)
    assert found.rmse == pytest.approx(math.sqrt((distances**2).mean()), rel=1e-12)
    assert found.rmse_edges == pytest.approx(found.rmse / lengths.mean(), rel=1e-12)
    per_frame = np.sqrt((distances**2).mean(axis=1))
    np.testing.assert_allclose(found.frame_rmse, per_frame, rtol=1e-12)
    assert found.prediction == pytest.approx(per_frame.mean() / lengths.mean(), rel=1e-12)
    assert found.largest == pytest.approx(distances.max(), rel=1e-12)
    np.testing.assert_allclose(found.frame_largest, distances.max(axis=1), rtol=1e-12)
    diagonal = np.linalg.norm(a[0].max(axis=0) - a[0].min(axis=0))
    assert found.largest_fraction == pytest.approx(distances.max() / diagonal, rel=1e-12)


def test_a_turned_mesh_has_the_angle_as_its_normal_error_and_no_dihedral_error() -> None:
    # about an axis along the normal the angle would be 0, so one plane is turned about an axis within it
    plane = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    turned = Rotation.from_rotvec([math.radians(7.5), 0, 0]).apply(plane)
    found = sequence_errors([plane], [turned], faces)
    assert found.normal_degrees == pytest.approx(7.5, rel=1e-9)
    assert found.dihedral_degrees == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("fold", [-100.0, -20.0, 20.0, 150.0])
def test_dihedral_error_of_a_folded_square(fold: float) -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, -1, 0]])
    faces = np.array([[0, 1, 2], [1, 0, 3]], np.int32)
    folded = points.copy()
    folded[3] = Rotation.from_rotvec([math.radians(fold), 0, 0]).apply(points[3])
    found = sequence_errors([points], [folded], faces)
    assert found.dihedral_degrees == pytest.approx(abs(fold), rel=1e-9)
    # a fold to the other side is not the same fold
    other = points.copy()
    other[3] = Rotation.from_rotvec([math.radians(-fold), 0, 0]).apply(points[3])
    double = sequence_errors([folded], [other], faces).dihedral_degrees
    assert double == pytest.approx(min(2 * abs(fold), 360 - 2 * abs(fold)), rel=1e-9)


def test_interior_edges_name_the_two_faces() -> None:
    edges, pairs = interior_edges(SPHERE.topology)
    assert len(edges) == len(SPHERE.edges)
    for edge, pair in zip(edges[::17], pairs[::17], strict=True):
        for face in pair:
            assert set(edge) <= set(SPHERE.faces[face])
        assert pair[0] != pair[1]


@settings(max_examples=25, deadline=None)
@given(
    st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-10, 10)] * 3), st.floats(0.01, 100), st.integers(0, 99)
)
def test_relative_errors_do_not_depend_on_the_frame_of_reference(
    turn: tuple[float, ...], shift: tuple[float, ...], scale: float, seed: int
) -> None:
    a, b = wobble(seed, 2), wobble(seed + 100, 2)
    matrix = scale * Rotation.from_rotvec(turn).as_matrix()
    moved = [frames @ matrix.T + np.array(shift) for frames in (a, b)]
    before, after = sequence_errors(a, b, SPHERE.faces), sequence_errors(*moved, SPHERE.faces)
    for name in ("kg_percent", "rmse_edges", "prediction", "normal_degrees", "dihedral_degrees"):
        assert getattr(after, name) == pytest.approx(getattr(before, name), rel=1e-6)


def test_kg_does_not_count_a_common_translation_as_motion() -> None:
    a, b = wobble(3), wobble(4)
    drift = np.linspace(0, 1000, len(a))[:, None, None] * np.array([1.0, 2.0, 3.0])
    still, moving = sequence_errors(a, b, SPHERE.faces), sequence_errors(a + drift, b + drift, SPHERE.faces)
    assert moving.kg_percent == pytest.approx(still.kg_percent, rel=1e-6)


def test_faces_without_area_have_no_normal() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0]])
    faces = np.array([[0, 1, 2], [0, 3, 1], [2, 2, 1]], np.int32)
    found = sequence_errors([points], [points + np.array([0, 0, 1])], faces)
    assert found.normal_degrees == pytest.approx(0, abs=1e-6)
    flat = points.copy()
    flat[2] = [0.2, 0, 0]
    # the one face with an area lost it
    assert sequence_errors([points], [flat], faces).normal_degrees == pytest.approx(90)


def test_a_static_sequence_and_a_single_point() -> None:
    frames = np.repeat(SPHERE.vertices[None], 3, axis=0)
    exact = sequence_errors(frames, frames, SPHERE.faces)
    assert exact.kg_percent == exact.largest == exact.prediction == 0
    nothing = np.zeros((0, 3), np.int32)
    point = np.zeros((2, 1, 3))
    assert sequence_errors(point, point, nothing).kg_percent == 0
    assert math.isinf(sequence_errors(point, point + 1, nothing).kg_percent)


def test_errors_that_are_not_numbers_are_not_lost() -> None:
    a = wobble(5, 1)
    b = a.copy()
    b[0, 7, 1] = np.nan
    found = sequence_errors(a, b, SPHERE.faces, surface=False)
    assert math.isnan(found.kg_percent)
    assert math.isnan(found.largest)


def test_types_of_coordinates_are_mixed_freely() -> None:
    a, b = wobble(6), wobble(7)
    single = sequence_errors(a.astype(np.float32), b, SPHERE.faces)
    assert single.kg_percent == pytest.approx(sequence_errors(a, b, SPHERE.faces).kg_percent, rel=1e-5)


def test_what_cannot_be_compared_is_refused() -> None:
    a = wobble(8)
    with pytest.raises(InvalidInput, match="ends after 3"):
        sequence_errors(a, a[:3], SPHERE.faces)
    with pytest.raises(InvalidInput, match="more than"):
        sequence_errors(a[:3], a, SPHERE.faces)
    with pytest.raises(InvalidInput, match="no frames"):
        sequence_errors([], [], SPHERE.faces)
    with pytest.raises(InvalidInput, match="Frame 0 has the shape"):
        sequence_errors(a, a[:, :-1], SPHERE.faces)


def test_surfaces_are_measured_only_when_asked_for() -> None:
    a = wobble(9)
    meter = ErrorMeter(SPHERE.faces, len(SPHERE.vertices), surface=False)
    meter.add(a[0], a[1])
    summary = meter.result().summary()
    assert "normal_degrees" not in summary
    assert summary["kg_percent"] > 0


def test_bits_of_the_dissertation() -> None:
    # Section 5.5: the body's figure follows from Eq. 5.11, the face's does not
    assert dissertation_bits(256, 20000, 10002) == pytest.approx(30.74, abs=0.005)
    assert dissertation_bits(64, 3000, 1500) == pytest.approx(36.576, abs=0.001)
    with pytest.raises(ValueError, match="0 clusters"):
        dissertation_bits(0, 1, 1)

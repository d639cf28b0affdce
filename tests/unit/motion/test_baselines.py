"""The two methods that chapter 5 compares with: cut-off spectra, and affine motions of vertex clusters."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_motion.baselines.affine import predict_affine
from shapery_motion.baselines.spectral import spectral_basis

SPHERE = icosphere(subdivisions=3)


def bent(points: np.ndarray) -> np.ndarray:
    x, y, z = points.T
    return np.stack((x + 0.4 * np.sin(2 * y), y + 0.3 * z * z, z), axis=1)


def test_eigenvalues_of_the_sphere() -> None:
    basis = spectral_basis(SPHERE, 16)
    # l (l + 1), 2 l + 1 times; 642 vertices are off by a few per cent
    expected = [0] + [2] * 3 + [6] * 5 + [12] * 7
    np.testing.assert_allclose(basis.eigenvalues, expected, rtol=0.05, atol=1e-6)


@pytest.mark.parametrize("count", [12, 300, 642])
def test_functions_are_orthonormal_by_area(count: int) -> None:
    basis = spectral_basis(SPHERE, count)
    product = basis.functions.T @ (basis.masses[:, None] * basis.functions)
    np.testing.assert_allclose(product, np.eye(count), atol=1e-8)


def test_windows_miss_no_eigenvalue() -> None:
    rng = np.random.default_rng(1)
    rough = TriangleMesh(SPHERE.vertices * (1 + 0.05 * rng.standard_normal((642, 1))), SPHERE.faces)
    for mesh in (SPHERE, rough):
        whole, part = spectral_basis(mesh, 642), spectral_basis(mesh, 400)
        np.testing.assert_allclose(part.eigenvalues, whole.eigenvalues[:400], rtol=1e-7, atol=1e-9)


def test_the_whole_spectrum_recovers_any_frame() -> None:
    target = bent(SPHERE.vertices)
    basis = spectral_basis(SPHERE, 10_000)
    assert basis.count == len(SPHERE.vertices)
    np.testing.assert_allclose(basis.from_positions(target), target, atol=1e-9)
    np.testing.assert_allclose(basis.from_differences(target), target, atol=1e-9)


def test_more_coefficients_err_less_and_differences_keep_the_details() -> None:
    rng = np.random.default_rng(0)
    rough = TriangleMesh(SPHERE.vertices + 0.02 * rng.standard_normal(SPHERE.vertices.shape), SPHERE.faces)
    target = bent(rough.vertices)
    few, many = spectral_basis(rough, 30), spectral_basis(rough, 200)
    for name in ("from_positions", "from_differences"):
        errors = [np.linalg.norm(getattr(basis, name)(target) - target) for basis in (few, many)]
        assert errors[1] < errors[0]
    # what two frames have in common need not go through the basis
    assert np.linalg.norm(few.from_differences(target) - target) < np.linalg.norm(few.from_positions(target) - target)
    np.testing.assert_array_equal(few.from_differences(rough.vertices), rough.vertices)


def test_a_mesh_without_area_has_no_spectrum() -> None:
    with pytest.raises(InvalidInput, match="no area"):
        spectral_basis(TriangleMesh(np.zeros((3, 3)), [[0, 1, 2]]), 2)


def test_unused_vertices_do_not_spoil_the_spectrum() -> None:
    more = TriangleMesh(np.concatenate((SPHERE.vertices, [[7.0, 7, 7]])), SPHERE.faces)
    basis = spectral_basis(more, 10)
    assert np.isfinite(basis.functions).all()
    assert np.isfinite(basis.from_differences(bent(more.vertices))).all()


def test_one_affine_motion_is_one_cluster() -> None:
    matrix = np.array([[1.2, 0.3, 0], [0, 0.8, -0.5], [0.1, 0, 1]])
    target = SPHERE.vertices @ matrix.T + [5, -3, 100]
    found = predict_affine(SPHERE.vertices, target, 1, np.random.default_rng(0))
    np.testing.assert_allclose(found.vertices, target, atol=1e-7)
    np.testing.assert_allclose(found.transforms[0, :, :3], matrix, atol=1e-8)
    np.testing.assert_allclose(found.transforms[0, :, 3], [5, -3, 100], atol=1e-7)


def test_two_rigid_halves_are_found() -> None:
    left, right = icosphere((-3, 0, 0)), icosphere((3, 0, 0))
    source = np.concatenate((left.vertices, right.vertices))
    turns = [Rotation.from_rotvec([0, 0.5, 0]), Rotation.from_rotvec([1.0, 0, 0.2])]
    target = np.concatenate((turns[0].apply(left.vertices.copy()), turns[1].apply(right.vertices.copy()) - 2))
    found = predict_affine(source, target, 2, np.random.default_rng(1))
    assert set(found.labels[: len(left.vertices)]).isdisjoint(found.labels[len(left.vertices) :])
    np.testing.assert_allclose(found.vertices, target, atol=1e-7)


def test_regrouping_lowers_the_error_and_the_transforms_are_global() -> None:
    target = bent(SPHERE.vertices)
    once = predict_affine(SPHERE.vertices, target, 12, np.random.default_rng(2), iterations=0)
    settled = predict_affine(SPHERE.vertices, target, 12, np.random.default_rng(2))
    assert np.linalg.norm(settled.vertices - target) < 0.9 * np.linalg.norm(once.vertices - target)
    mine = settled.transforms[settled.labels]
    moved = np.einsum("nij,nj->ni", mine[:, :, :3], SPHERE.vertices) + mine[:, :, 3]
    np.testing.assert_allclose(moved, settled.vertices, atol=1e-9)


def test_groups_without_extent_are_moved_as_they_are() -> None:
    source = np.repeat(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), 4, axis=0)
    target = source + [[0, 1, 0]] * 12
    found = predict_affine(source, target, 30, np.random.default_rng(0))
    np.testing.assert_allclose(found.vertices, target, atol=1e-9)

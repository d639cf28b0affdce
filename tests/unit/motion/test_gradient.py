"""Local transformations, their clusters, and the gluing of chapter 5: closed forms, invariances, awkward meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_motion.gradient.clustering import FaceClusters, cluster_faces, cluster_matrices
from shapery_motion.gradient.deformation import deformation_gradients, face_frames
from shapery_motion.gradient.gluing import Gluing, Weighting, choose_anchors, glued_parts

SPHERE = icosphere(subdivisions=2)
numbers = st.floats(-2, 2)
vectors = st.tuples(numbers, numbers, numbers)


def grid(side: int = 6) -> TriangleMesh:
    """An open square of side × side vertices."""
    x, y = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    points = np.stack((x.ravel(), y.ravel(), 0.1 * np.sin(x + 2 * y).ravel()), axis=1)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.concatenate(
        (np.stack((corner, corner + side, corner + 1), 1), np.stack((corner + 1, corner + side, corner + side + 1), 1))
    )
    return TriangleMesh(points, faces.astype(np.int32))


def bent(points: np.ndarray, amount: float = 0.4) -> np.ndarray:
    """A smooth motion that is affine nowhere."""
    x, y, z = points.T
    return np.stack((x + amount * np.sin(y), y + amount * z * z, z + amount * np.cos(x) * y), axis=1)


def rebuilt(mesh: TriangleMesh, target: np.ndarray, weighting: Weighting = "area", **anchors: int) -> np.ndarray:
    """Glue the true transformation of every face."""
    source = face_frames(mesh.vertices, mesh.faces)
    held = choose_anchors(source, mesh.vertices, **anchors)
    system = Gluing(source, len(mesh.vertices), held, weighting)
    gradients = deformation_gradients(source, target)
    return system.solve(np.arange(len(mesh.faces)), gradients, target[held])


@settings(max_examples=40, deadline=None)
@given(st.lists(vectors, min_size=3, max_size=3), vectors)
def test_an_affine_motion_is_its_own_gradient_within_the_face(rows: list[tuple[float, ...]], shift: tuple) -> None:
    matrix = np.array(rows) + 3 * np.eye(3)
    source = face_frames(SPHERE.vertices, SPHERE.faces)
    found = deformation_gradients(source, SPHERE.vertices @ matrix.T + shift)
    # along the face the gradient is the matrix; across it is what Eq. 5.1 makes of the stretched area
    for column in (0, 1):
        side = source.columns[:, :, column]
        np.testing.assert_allclose(np.einsum("fij,fj->fi", found, side), side @ matrix.T, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(vectors, vectors, st.floats(0.1, 10))
def test_a_similarity_is_found_exactly(turn: tuple, shift: tuple, scale: float) -> None:
    # |c| scales as s² and the fourth vertex's offset c/√|c| as s: Eq. 5.1 is made for this
    matrix = scale * Rotation.from_rotvec(turn).as_matrix()
    source = face_frames(SPHERE.vertices, SPHERE.faces)
    found = deformation_gradients(source, SPHERE.vertices @ matrix.T + shift)
    np.testing.assert_allclose(found, np.broadcast_to(matrix, found.shape), atol=1e-9 * max(scale, 1))


def test_inverses_are_inverses() -> None:
    source = face_frames(SPHERE.vertices, SPHERE.faces)
    products = source.columns @ source.inverse
    np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), products.shape), atol=1e-12)


@pytest.mark.parametrize("weighting", ["uniform", "area"])
@pytest.mark.parametrize("mesh", [SPHERE, grid()], ids=["closed", "open"])
def test_unclustered_transformations_rebuild_any_motion(mesh: TriangleMesh, weighting: Weighting) -> None:
    target = bent(mesh.vertices)
    np.testing.assert_allclose(rebuilt(mesh, target, weighting), target, atol=1e-9)


@settings(max_examples=20, deadline=None)
@given(vectors, vectors, st.integers(0, 50))
def test_the_prediction_moves_with_the_target(turn: tuple, shift: tuple, seed: int) -> None:
    """Clusters and gluing do not depend on where the target lies and how it is turned."""
    mesh, rng = SPHERE, np.random.default_rng(seed)
    target = bent(mesh.vertices, 0.3) + 0.02 * rng.standard_normal(mesh.vertices.shape)
    rotation = Rotation.from_rotvec(turn).as_matrix()
    source = face_frames(mesh.vertices, mesh.faces)
    held = choose_anchors(source, mesh.vertices)
    system = Gluing(source, len(mesh.vertices), held)

    def predicted(frame: np.ndarray) -> np.ndarray:
        gradients = deformation_gradients(source, frame)
        clusters = cluster_faces(gradients, source.solid, 12, np.random.default_rng(3))
        matrices = cluster_matrices(clusters, source, frame, gradients)
        return system.solve(clusters.labels, matrices, frame[held])

    expected = predicted(target) @ rotation.T + shift
    np.testing.assert_allclose(predicted(target @ rotation.T + shift), expected, atol=1e-8)


def test_as_many_clusters_as_faces_are_exact() -> None:
    target = bent(SPHERE.vertices)
    source = face_frames(SPHERE.vertices, SPHERE.faces)
    gradients = deformation_gradients(source, target)
    clusters = cluster_faces(gradients, source.solid, len(SPHERE.faces), np.random.default_rng(0))
    assert clusters.count == len(SPHERE.faces)
    held = choose_anchors(source, SPHERE.vertices)
    for representative in ("least_squares", "member"):
        matrices = cluster_matrices(clusters, source, target, gradients, representative=representative)
        found = Gluing(source, len(SPHERE.vertices), held).solve(clusters.labels, matrices, target[held])
        np.testing.assert_allclose(found, target, atol=1e-9)


def test_two_rigid_halves_are_two_clusters() -> None:
    left, right = icosphere((-3, 0, 0)), icosphere((3, 0, 0))
    points = np.concatenate((left.vertices, right.vertices))
    faces = np.concatenate((left.faces, right.faces + len(left.vertices)))
    turns = [Rotation.from_rotvec([0, 0.5, 0]).as_matrix(), Rotation.from_rotvec([1.0, 0, 0.2]).as_matrix()]
    target = np.concatenate((left.vertices @ turns[0].T + 1, right.vertices @ turns[1].T - 2))
    source = face_frames(points, faces)
    gradients = deformation_gradients(source, target)
    clusters = cluster_faces(gradients, source.solid, 10, np.random.default_rng(1), tolerance=0)
    held = choose_anchors(source, points)
    assert len(held) == 2
    matrices = cluster_matrices(clusters, source, target, gradients)
    assert set(clusters.labels[: len(left.faces)]).isdisjoint(clusters.labels[len(left.faces) :])
    found = Gluing(source, len(points), held).solve(clusters.labels, matrices, target[held])
    np.testing.assert_allclose(found, target, atol=1e-9)


def test_clustering_reaches_a_fixed_point_of_lloyd() -> None:
    source = face_frames(SPHERE.vertices, SPHERE.faces)
    gradients = deformation_gradients(source, bent(SPHERE.vertices))
    clusters = cluster_faces(gradients, source.solid, 8, np.random.default_rng(5), iterations=500, tolerance=0)
    points = gradients.reshape(-1, 9)
    distances = ((points[:, None] - clusters.centres) ** 2).sum(axis=2)
    np.testing.assert_array_equal(distances.argmin(axis=1), clusters.labels)
    for k in range(clusters.count):
        np.testing.assert_allclose(clusters.centres[k], points[clusters.labels == k].mean(axis=0), atol=1e-12)
    # numbered by the first face that has them
    first = np.unique(clusters.labels, return_index=True)[1]
    assert (np.diff(first) > 0).all()


def test_more_clusters_predict_better() -> None:
    target = bent(SPHERE.vertices)
    source = face_frames(SPHERE.vertices, SPHERE.faces)
    gradients = deformation_gradients(source, target)
    held = choose_anchors(source, SPHERE.vertices)
    system = Gluing(source, len(SPHERE.vertices), held)
    errors = []
    for count in (2, 16, 128):
        clusters = cluster_faces(gradients, source.solid, count, np.random.default_rng(0))
        found = system.solve(clusters.labels, cluster_matrices(clusters, source, target, gradients), target[held])
        errors.append(np.linalg.norm(found - target))
    assert errors[0] > 2 * errors[1] > 4 * errors[2] > 0


def test_the_same_seed_gives_the_same_clusters_and_warm_starts_keep_them() -> None:
    source = face_frames(SPHERE.vertices, SPHERE.faces)
    gradients = deformation_gradients(source, bent(SPHERE.vertices))
    first, again = (cluster_faces(gradients, source.solid, 9, np.random.default_rng(2), tolerance=0) for _ in range(2))
    np.testing.assert_array_equal(first.labels, again.labels)
    warm = cluster_faces(gradients, source.solid, 9, np.random.default_rng(7), initial=first.centres)
    np.testing.assert_array_equal(first.labels, warm.labels)
    more = cluster_faces(gradients, source.solid, 14, np.random.default_rng(7), initial=first.centres)
    assert more.count == 14


def test_the_matrix_of_a_cluster_solves_its_least_squares() -> None:
    target = bent(SPHERE.vertices)
    source = face_frames(SPHERE.vertices, SPHERE.faces)
    gradients = deformation_gradients(source, target)
    clusters = FaceClusters((np.arange(len(SPHERE.faces)) % 5).astype(np.int32), np.zeros((5, 9)))
    matrices = cluster_matrices(clusters, source, target, gradients)
    moved = face_frames(target, SPHERE.faces).columns
    for k in range(5):
        mine = clusters.labels == k
        # rows of V stacked: each column v of each face is one equation Q v = ṽ
        before = source.columns[mine].transpose(0, 2, 1).reshape(-1, 3)
        after = moved[mine].transpose(0, 2, 1).reshape(-1, 3)
        np.testing.assert_allclose(matrices[k].T, np.linalg.lstsq(before, after, rcond=None)[0], atol=1e-10)


def test_degenerate_faces_take_no_part() -> None:
    mesh = grid()
    # a face on a line, one that names a vertex twice, and one whose vertices coincide
    points = np.concatenate((mesh.vertices, [[2.5, 2.5, 0.0], [9.0, 9, 9], [9.0, 9, 9], [9.0, 9, 9]]))
    extra = [[0, 1, 1], [36, 36, 36], [37, 38, 39]]
    awkward = TriangleMesh(points, np.concatenate((mesh.faces, np.array(extra, np.int32))))
    source = face_frames(awkward.vertices, awkward.faces)
    assert (~source.solid).sum() == 3
    target = bent(points)
    gradients = deformation_gradients(source, target)
    np.testing.assert_array_equal(gradients[-3:], np.broadcast_to(np.eye(3), (3, 3, 3)))
    np.testing.assert_allclose(rebuilt(awkward, target), target, atol=1e-9)
    clusters = cluster_faces(gradients, source.solid, 6, np.random.default_rng(0))
    assert np.isfinite(cluster_matrices(clusters, source, target, gradients)).all()


def test_a_face_may_collapse_or_flip_on_its_way() -> None:
    target = bent(SPHERE.vertices)
    target[SPHERE.faces[0]] = target[SPHERE.faces[0, 0]]
    target[:, 0] *= -1
    gradients = deformation_gradients(face_frames(SPHERE.vertices, SPHERE.faces), target)
    assert np.linalg.matrix_rank(gradients[0]) < 3
    np.testing.assert_allclose(rebuilt(SPHERE, target), target, atol=1e-9)


def test_a_mesh_of_needles_only_is_all_anchors() -> None:
    points = np.stack((np.arange(5.0), np.zeros(5), np.zeros(5)), axis=1)
    line = TriangleMesh(points, [[0, 1, 2], [2, 3, 4]])
    source = face_frames(line.vertices, line.faces)
    assert len(choose_anchors(source, points)) == 5
    clusters = cluster_faces(deformation_gradients(source, points), source.solid, 4, np.random.default_rng(0))
    assert clusters.count == 1
    target = bent(points)
    np.testing.assert_array_equal(rebuilt(line, target), target)


def test_parts_have_anchors_each_and_boundaries_several() -> None:
    square = grid()
    points = np.concatenate((SPHERE.vertices, square.vertices, [[5.0, 5, 5]]))
    faces = np.concatenate((SPHERE.faces, square.faces + len(SPHERE.vertices)))
    source = face_frames(points, faces)
    assert glued_parts(source, len(points)).max() == 2
    assert len(choose_anchors(source, points, boundary=0)) == 3
    held = choose_anchors(source, points, boundary=5)
    assert len(held) == 3 + 5
    assert len(choose_anchors(source, points, boundary=5, spread=20)) == 28
    np.testing.assert_allclose(rebuilt(TriangleMesh(points, faces), bent(points), spread=4), bent(points), atol=1e-9)


def test_a_part_without_an_anchor_is_refused() -> None:
    source = face_frames(SPHERE.vertices, SPHERE.faces)
    with pytest.raises(InvalidInput, match="has no anchor"):
        Gluing(source, len(SPHERE.vertices), np.zeros(0, np.int32))
    with pytest.raises(ValueError, match="must be positive"):
        cluster_faces(np.zeros((1, 3, 3)), np.ones(1, bool), 0, np.random.default_rng(0))


def test_the_gluing_solves_the_problem_with_fourth_vertices() -> None:
    """Eq. 5.7 as the text writes it, with the fourth vertices as unknowns, has the same solution."""
    mesh = icosphere(subdivisions=1)
    rng = np.random.default_rng(4)
    source = face_frames(mesh.vertices, mesh.faces)
    wanted = rng.standard_normal((len(mesh.faces), 3, 3))
    n, m = len(mesh.vertices), len(mesh.faces)
    rows, right = np.zeros((3 * m + 3, n + m)), np.zeros((3 * m + 3, 3))
    for f, (a, b, c) in enumerate(mesh.faces):
        # T = Ṽ V⁻¹, so column j of T is Σ_i (ṽ_i − ṽ_1) V⁻¹[i, j]
        for j in range(3):
            for i, vertex in enumerate((b, c, n + f)):
                rows[3 * f + j, vertex] += source.inverse[f, i, j]
                rows[3 * f + j, a] -= source.inverse[f, i, j]
            right[3 * f + j] = wanted[f, :, j]
    rows[-3, 0] = 1e6  # the anchor, held hard
    plain = np.linalg.lstsq(rows, right, rcond=None)[0][:n]
    found = Gluing(source, n, np.zeros(1, np.int32), "uniform").solve(np.arange(m), wanted, np.zeros((1, 3)))
    np.testing.assert_allclose(found, plain, atol=1e-6)


@pytest.mark.data
@pytest.mark.parametrize("name", ["chickenCrossing", "mmface4d-3k"])
def test_real_sequences_are_rebuilt_from_their_own_transformations(shared_data: Path, name: str) -> None:
    with np.load(shared_data / "motion" / f"{name}.npz") as stored:
        frames, faces = stored["vertices"], stored["faces"]
    mesh, target = TriangleMesh(frames[0], faces), frames[len(frames) // 2].astype(np.float64)
    # chickenCrossing has needles of 1e-6, and so loses a few digits
    np.testing.assert_allclose(rebuilt(mesh, target), target, atol=1e-8 * mesh.edge_lengths.mean())

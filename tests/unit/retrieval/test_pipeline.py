"""From meshes to graphs and back: invariances, and meshes that break others."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.mesh_io import read_mesh
from shapery_retrieval.arg import Arg
from shapery_retrieval.describe import Description, build_arg
from shapery_retrieval.matching import match
from shapery_retrieval.nodes import stacked_signals
from shapery_retrieval.normalise import MAX_FACES, normalise
from shapery_retrieval.signals import compute_signals
from shapery_retrieval.vector import cue_distances, pack
from shapery_retrieval.vocabulary import vocabulary

from .conftest import egg


def shuffled(mesh: TriangleMesh, seed: int) -> TriangleMesh:
    """The same surface with its vertices, faces and corners in another order."""
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(mesh.vertices))
    faces = np.argsort(order)[mesh.faces][rng.permutation(len(mesh.faces))]
    turn = (rng.integers(3, size=len(faces))[:, None] + np.arange(3)) % 3
    return TriangleMesh(mesh.vertices[order], np.take_along_axis(faces, turn, axis=1))


@pytest.mark.parametrize("seed", [1, 2])
def test_the_order_of_vertices_and_faces_changes_nothing(described_egg: Description, seed: int) -> None:
    assert build_arg(shuffled(egg(), seed)).to_bytes() == described_egg.arg.to_bytes()


def test_nor_does_it_where_faces_are_reduced() -> None:
    ball = icosphere(subdivisions=5)
    bumpy = ball.with_vertices(ball.vertices * (1 + 0.2 * np.sin(3 * ball.vertices[:, [1]])) * [1.0, 1.3, 1.8])
    reduced = normalise(bumpy)
    assert reduced.changes == (("reduce_faces", len(bumpy.faces) - MAX_FACES),)
    assert normalise(shuffled(bumpy, 3)).mesh.same_as(reduced.mesh)


def signal_moments(mesh: TriangleMesh) -> np.ndarray:
    """Means and deviations over the surface of every signal but the thickness, whose rays turn with the frame."""
    signals = compute_signals(normalise(mesh))
    columns = np.delete(stacked_signals(signals), 32, axis=1)
    mean = signals.areas @ columns
    return np.stack((mean, np.sqrt(signals.areas @ (columns - mean) ** 2)))


@pytest.fixture(scope="module")
def fine_egg() -> tuple[TriangleMesh, np.ndarray]:
    """A surface that is analysed as it is (which edges are halved may follow their rounding), and its signals."""
    mesh = egg(4)
    return mesh, signal_moments(mesh)


@pytest.mark.slow
@settings(max_examples=8, deadline=None, phases=[Phase.generate])
@given(st.integers(0, 10_000), st.floats(-6, 6), st.booleans())
def test_signals_do_not_know_place_size_or_hand(
    fine_egg: tuple[TriangleMesh, np.ndarray], seed: int, exponent: float, mirrored: bool
) -> None:
    mesh, known = fine_egg
    rng = np.random.default_rng(seed)
    turn = Rotation.random(rng=rng).as_matrix() * 10**exponent
    points = mesh.vertices @ turn.T * ([-1, 1, 1] if mirrored else [1, 1, 1]) + rng.normal(size=3) * 10**exponent
    other = mesh.with_vertices(points)
    assert np.allclose(signal_moments(other.flipped() if mirrored else other), known, rtol=0, atol=1e-6)


def moved(name: str) -> TriangleMesh:
    mesh = egg()
    turn = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    if name == "rotated":
        return mesh.with_vertices(mesh.vertices @ turn.T + [3.0, -20.0, 7.0])
    if name == "scaled":
        return mesh.with_vertices(mesh.vertices * 1e4)
    if name == "tiny":
        return mesh.with_vertices(mesh.vertices * 1e-5)
    if name == "mirrored":
        return mesh.with_vertices(mesh.vertices * [-1, 1, 1]).flipped()
    if name == "inside out":
        return mesh.flipped()
    if name == "unwelded":
        return TriangleMesh(mesh.corners.reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))
    raise AssertionError(name)


@pytest.mark.parametrize("name", ["rotated", "scaled", "tiny", "mirrored", "inside out", "unwelded"])
def test_the_same_shape_gives_the_same_graph(described_egg: Description, name: str) -> None:
    found = build_arg(moved(name))
    ours, theirs = described_egg.arg, found
    vectors = pack([ours, theirs]).vectors
    for cue in ("covariance", "quantiles"):
        assert cue_distances(vectors[0], vectors[1:], cue)[0] < 0.15 * vocabulary().unlike[cue], cue
    # ties between equal distances may move samples, and with them the borders of parts
    assert match(ours, theirs).score > 0.85
    assert match(ours, theirs).levels[1].score > 0.8


@pytest.mark.slow
def test_noise_and_resolution_change_little(described_egg: Description) -> None:
    mesh = egg()
    rng = np.random.default_rng(5)
    noisy = mesh.with_vertices(mesh.vertices + rng.normal(size=mesh.vertices.shape) * 0.002 * mesh.diagonal)
    fine = egg(4)
    torus_like = build_arg(fine)
    for other in (build_arg(noisy), torus_like):
        assert match(described_egg.arg, other).levels[1].score > 0.7


def two_balls(gap: float) -> TriangleMesh:
    mesh = egg()
    points = np.concatenate((mesh.vertices, mesh.vertices + np.array([0, 3.2 + gap, 0])))
    return TriangleMesh(points, np.concatenate((mesh.faces, mesh.faces + len(mesh.vertices))))


def test_components_are_kept_and_joined() -> None:
    arg = build_arg(two_balls(0.5))
    finest = arg.levels[-1]
    assert finest.parts == 32
    assert finest.distances.max() < 10
    # both bodies are in it: half of the area each, whatever part they are cut into
    assert 0.3 < arg.levels[1].masses[: arg.levels[1].parts // 2].sum() < 0.7


@pytest.mark.parametrize(
    ("mesh", "code"),
    [
        (TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), "empty_content"),
        (TriangleMesh(np.eye(3), np.zeros((0, 3), int)), "empty_content"),
        (TriangleMesh(np.zeros((3, 3)), [[0, 1, 2]]), "invalid_mesh"),
        (TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]), "invalid_mesh"),
        (TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1e-9, 0]], [[0, 1, 2]]), "invalid_mesh"),
    ],
    ids=["nothing", "points", "one place", "a line", "a needle"],
)
def test_what_is_no_surface_is_refused(mesh: TriangleMesh, code: str) -> None:
    with pytest.raises(InvalidInput) as refusal:
        build_arg(mesh)
    assert refusal.value.code == code
    assert refusal.value.message.endswith(".")


def test_one_triangle_is_a_surface() -> None:
    arg = build_arg(TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    assert arg.levels[-1].parts == 32


@pytest.mark.data
@pytest.mark.slow
def test_difficult_meshes_are_indexed_or_refused_with_a_sentence(shared_data) -> None:
    refused = []
    for path in sorted((shared_data / "meshes" / "difficult").iterdir()):
        try:
            arg = build_arg(read_mesh(path))
        except InvalidInput as error:
            refused.append((path.name, error.message[-1]))
            continue
        assert Arg.from_bytes(arg.to_bytes()).same_as(arg)
        for level in arg.levels:
            assert abs(float(level.masses.sum()) - 1) < 1e-3, path.name
        # a graph with meaning: parts differ, distances are of the size of the surface
        assert float(arg.levels[-1].features.astype(float).std(axis=0).max()) > 0.01, path.name
        assert 0 < arg.levels[-1].distances.max() < 10, path.name
    assert refused == [("tri_empty.ply", "."), ("tri_points_bin.ply", ".")]

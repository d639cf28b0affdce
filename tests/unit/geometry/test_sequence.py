"""Mesh sequences: every container, the order of frames, and refusals that name the first frame that differs."""

from __future__ import annotations

import io
import struct
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput, LimitExceeded, UserError
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.mesh_io import MeshLimits, write_mesh
from shapery_geometry.sequence import (
    MeshSequence,
    SequenceLimits,
    natural_key,
    open_sequence,
    read_sequence,
    write_sequence_npz,
)

FACES = icosphere(subdivisions=1).faces


def walk(frames: int = 12, dtype: str = "f4") -> np.ndarray:
    rng = np.random.default_rng(0)
    base = icosphere(subdivisions=1).vertices
    return np.stack([base * (1 + 0.1 * k) + rng.normal(size=3) for k in range(frames)]).astype(dtype)


def refused(path: Path, code: str, message: str, limits: SequenceLimits | None = None) -> None:
    with pytest.raises(UserError, match=message) as caught:
        read_sequence(path, limits=limits)
    assert caught.value.code == code


# in memory --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_a_sequence_gives_its_frames_as_meshes(dtype: str) -> None:
    vertices = walk(dtype=dtype)
    sequence = MeshSequence(vertices, FACES)
    assert (len(sequence), sequence.vertex_count) == (12, 42)
    assert sequence.vertices.dtype == dtype
    meshes = list(sequence)
    assert len(meshes) == 12
    assert np.array_equal(meshes[3].vertices, vertices[3])
    assert np.array_equal(sequence.frame(-1).vertices, vertices[11])
    assert meshes[0].topology is meshes[5].topology is sequence.topology
    assert meshes[0].closed
    with pytest.raises(ValueError, match="read-only"):
        sequence.vertices[0] = 0


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        (np.zeros((42, 3)), "shape \\(frames, n, 3\\), not \\(42, 3\\)"),
        (np.zeros((0, 42, 3)), "not \\(0, 42, 3\\)"),
        (np.zeros((2, 42, 2)), "not \\(2, 42, 2\\)"),
        (
            np.where(np.arange(2 * 42 * 3).reshape(2, 42, 3) == 200, np.nan, 0),
            "In frame 1, 1 of 42 vertices .* vertex 24",
        ),
        (np.zeros((2, 41, 3)), "vertices run from 0 to 40"),
    ],
)
def test_senseless_arrays_are_refused(vertices: np.ndarray, message: str) -> None:
    with pytest.raises(InvalidInput, match=message) as caught:
        MeshSequence(vertices, FACES)
    assert caught.value.code == "invalid_mesh"


def test_natural_order() -> None:
    names = ["b1", "a10", "a2", "a01", "a1", "A3", "a1b10", "a1b9", "a", "10", "9"]
    expected = ["9", "10", "a", "a01", "a1", "a1b9", "a1b10", "a2", "A3", "a10", "b1"]
    assert sorted(names, key=natural_key) == expected
    backwards = names[::-1]
    assert sorted(backwards, key=natural_key) == expected


# npz --------------------------------------------------------------------------------------------------------------


def saved(path: Path, vertices: np.ndarray, faces: np.ndarray = FACES, *, compressed: bool = False) -> Path:
    (np.savez_compressed if compressed else np.savez)(path, vertices=vertices, faces=faces)
    return path


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("dtype", ["<f4", "<f8", ">f4", ">f8", "<f2"])
@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("index", ["<i4", "<i8", "<u2", ">i4"])
def test_npz_of_every_type_and_order(compressed: bool, dtype: str, order: str, index: str, tmp_path: Path) -> None:
    vertices = np.asarray(walk().astype(dtype), order=order)
    path = saved(tmp_path / "walk.npz", vertices, FACES.astype(index), compressed=compressed)
    file = open_sequence(path)
    assert (file.frame_count, file.vertex_count, file.names) == (12, 42, ())
    assert np.array_equal(file.faces, FACES)
    assert file.dtype == (np.float64 if dtype[2] == "8" else np.float32)
    frames = list(file.frames())
    assert len(frames) == 12
    assert all(frame.dtype == file.dtype for frame in frames)
    assert np.array_equal(np.stack(frames), vertices)
    loaded = file.load()
    assert np.array_equal(loaded.vertices, vertices)
    assert loaded.vertices.dtype == file.dtype


def test_a_stored_npz_is_mapped_into_memory(tmp_path: Path) -> None:
    path = saved(tmp_path / "walk.npz", walk())
    assert isinstance(read_sequence(path).vertices, np.memmap)
    assert not isinstance(read_sequence(saved(path, walk(), compressed=True)).vertices, np.memmap)


def test_frames_come_one_at_a_time(tmp_path: Path) -> None:
    vertices = np.random.default_rng(0).normal(size=(60, 20_000, 3)).astype("f4")
    faces = np.array([[0, 1, 2]])
    path = saved(tmp_path / "walk.npz", vertices, faces, compressed=True)
    whole = vertices.nbytes
    del vertices
    for warm in (True, False):
        tracemalloc.start()
        count = sum(1 for _ in open_sequence(path).frames())
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert count == 60
        # a frame has 240 kB; a few of them and buffers, and far from the 14 MB of the whole
        assert warm or peak < whole / 6


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("single", [False, True])
def test_a_sequence_is_written_frame_by_frame(compressed: bool, single: bool, tmp_path: Path) -> None:
    vertices = walk(dtype="f8")
    paths = [tmp_path / name for name in ("one.npz", "two.npz")]
    for path in paths:
        write_sequence_npz(path, iter(vertices), FACES, shape=(12, 42), single=single, compressed=compressed)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    expected = vertices.astype("f4" if single else "f8")
    assert np.array_equal(read_sequence(paths[0]).vertices, expected)
    with np.load(paths[0]) as plain:
        assert np.array_equal(plain["vertices"], expected)
        assert plain["vertices"].dtype == expected.dtype
        assert np.array_equal(plain["faces"], FACES)


def test_frames_that_do_not_fit_are_not_written(tmp_path: Path) -> None:
    for frames, message in (
        (walk(11), "11 frames came in place of 12"),
        (walk(13), "frame 12 of 12"),
        (walk()[:, :41], "frame 0 of 12 has the shape \\(41, 3\\)"),
    ):
        with pytest.raises(ValueError, match=message):
            write_sequence_npz(tmp_path / "walk.npz", frames, FACES, shape=(12, 42))


@pytest.mark.parametrize(
    ("vertices", "faces", "code", "message"),
    [
        (walk()[:0], FACES, "empty_content", "no frame"),
        (walk(), FACES[:0], "empty_content", "12 frames of points and no faces"),
        (walk(), FACES + 1, "invalid_mesh", "vertices run from 0 to 41"),
        (walk(), FACES.astype("i8") - 1, "invalid_mesh", "name vertices that do not exist"),
        (walk()[0], FACES, "unsupported_format", "single mesh"),
        (walk().astype("i4"), FACES, "unsupported_format", "vertices"),
        (walk(), FACES.astype("f4"), "unsupported_format", "faces"),
    ],
)
def test_npz_refusals(vertices: np.ndarray, faces: np.ndarray, code: str, message: str, tmp_path: Path) -> None:
    refused(saved(tmp_path / "walk.npz", vertices, faces), code, message)


@pytest.mark.parametrize("compressed", [False, True])
def test_a_frame_that_is_not_finite_is_named(compressed: bool, tmp_path: Path) -> None:
    vertices = walk()
    vertices[7, 5, 1] = np.inf
    path = saved(tmp_path / "walk.npz", vertices, compressed=compressed)
    refused(path, "invalid_mesh", "In frame 7, 1 of 42 vertices .* vertex 5")
    frames = open_sequence(path).frames()
    for _ in range(7):
        next(frames)
    with pytest.raises(InvalidInput, match="In frame 7"):
        next(frames)


def test_a_damaged_npz(tmp_path: Path) -> None:
    path = saved(tmp_path / "walk.npz", walk(), compressed=True)
    data = bytearray(path.read_bytes())
    path.write_bytes(data[: len(data) // 2])
    refused(path, "corrupt_file", "truncated")
    data[2000] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(InvalidInput) as caught:
        list(open_sequence(path).frames())
    assert caught.value.code in ("corrupt_file", "invalid_mesh")


def test_limits_come_from_the_header(tmp_path: Path) -> None:
    path = saved(tmp_path / "walk.npz", walk())
    exact = SequenceLimits(frames=12, bytes=12 * 42 * 12, mesh=MeshLimits(vertices=42, faces=80))
    assert len(read_sequence(path, limits=exact)) == 12
    for limits, message in (
        (SequenceLimits(frames=11), "12 frames; at most 11"),
        (SequenceLimits(bytes=12 * 42 * 12 - 1), "takes 6048 bytes; at most 6047"),
        (SequenceLimits(mesh=MeshLimits(vertices=41)), "42 vertices; at most 41"),
        (SequenceLimits(mesh=MeshLimits(faces=79)), "80 faces; at most 79"),
    ):
        with pytest.raises(LimitExceeded, match=message):
            open_sequence(path, limits=limits)


# a mesh per frame -------------------------------------------------------------------------------------------------


def folder_of(folder: Path, suffix: str, vertices: np.ndarray, faces: np.ndarray = FACES) -> Path:
    folder.mkdir()
    for k, points in enumerate(vertices):
        write_mesh(TriangleMesh(points, faces), folder / f"frame{k}{suffix}")
    return folder


def zip_of(folder: Path, prefix: str = "") -> Path:
    path = folder.with_suffix(".zip")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        # in the order of strings, which is not that of the frames
        for name in sorted(p.name for p in folder.iterdir()):
            archive.write(folder / name, prefix + name)
    return path


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".off"])
@pytest.mark.parametrize("zipped", [False, True])
def test_a_folder_and_a_zip_of_meshes(suffix: str, zipped: bool, tmp_path: Path) -> None:
    vertices = walk(dtype="f8")
    path = folder_of(tmp_path / "walk", suffix, vertices)
    (path / "materials.mtl").write_text("newmtl a\n")
    (path / ".hidden.obj").write_text("nothing")
    if zipped:
        (path / ".hidden.obj").unlink()
        path = zip_of(path, "a folder/")
    file = open_sequence(path)
    assert file.frame_count == 12
    assert [Path(name).name for name in file.names] == [f"frame{k}{suffix}" for k in range(12)]
    sequence = file.load()
    assert np.array_equal(sequence.vertices, vertices)
    assert np.array_equal(sequence.faces, FACES)
    # a second pass begins anew
    assert sum(1 for _ in file.frames()) == 12
    assert sum(1 for _ in file.frames()) == 12


@pytest.mark.parametrize("suffix", [".stl", ".glb"])
def test_formats_that_lose_digits(suffix: str, tmp_path: Path) -> None:
    vertices = walk(3)
    sequence = read_sequence(folder_of(tmp_path / "walk", suffix, vertices))
    assert sequence.vertices.shape == vertices.shape
    for mesh, points in zip(sequence, vertices, strict=True):
        assert np.array_equal(mesh.corners, points[FACES].astype(np.float64))


def test_stl_frames_are_joined_as_the_first(tmp_path: Path) -> None:
    # in frame 1 two vertices meet by chance, and stay two
    vertices = walk(3)
    vertices[1, 5] = vertices[1, 30]
    folder = folder_of(tmp_path / "walk", ".stl", vertices)
    assert read_sequence(folder).vertex_count == 42
    # in frame 2 the corners of one vertex part
    soup = TriangleMesh(vertices[2][FACES].reshape(-1, 3), np.arange(3 * len(FACES)).reshape(-1, 3))
    apart = soup.vertices.copy()
    apart[17] += 0.01
    write_mesh(soup.with_vertices(apart), folder / "frame2.stl")
    refused(folder, "inconsistent_sequence", "in frame 0 \\(frame0.stl\\), lies apart .* frame 2 \\(frame2.stl\\)")


def test_polygons_are_cut_in_all_frames_as_in_the_first(tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    folder.mkdir()
    for k, x in enumerate((0.2, 2.0, 0.2)):
        # concave at the third corner in the first and last frame, convex in the second
        text = f"v 0 0 0\nv 2 0 0\nv {x} {x} 0\nv 0 2 0\nf 2 3 4 1\n"
        (folder / f"{k}.obj").write_text(text)
    sequence = read_sequence(folder)
    assert sequence.faces.tolist() == [[0, 1, 2], [2, 3, 0]]


def changed(folder: Path, number: int, mesh: TriangleMesh) -> None:
    write_mesh(mesh, folder / f"frame{number}.obj")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda v: TriangleMesh(v, FACES[:-1]), "frame 10 \\(frame10.obj\\) has 79 faces, and frame 0 .* has 80"),
        (lambda v: TriangleMesh([*v, [0, 0, 0]], FACES), "frame 10 \\(frame10.obj\\) has 43 vertices, .* has 42"),
        (lambda v: TriangleMesh(v, np.roll(FACES, 1, axis=0)), "face 0 is .* in frame 10 \\(frame10.obj\\)"),
        (
            lambda v: TriangleMesh(v, [*FACES[:7].tolist(), FACES[7][::-1].tolist(), *FACES[8:].tolist()]),
            "face 7 is .* in frame 10 \\(frame10.obj\\), and .* in frame 0 \\(frame0.obj\\)",
        ),
    ],
)
def test_the_first_frame_that_differs_is_named(
    change: Callable[[np.ndarray], TriangleMesh], message: str, tmp_path: Path
) -> None:
    vertices = walk(dtype="f8")
    folder = folder_of(tmp_path / "walk", ".obj", vertices)
    for number in (10, 11):
        changed(folder, number, change(vertices[number]))
    refused(folder, "inconsistent_sequence", message)
    refused(zip_of(folder), "inconsistent_sequence", message)


def test_faces_of_other_sizes_differ(tmp_path: Path) -> None:
    points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\n"
    folder = tmp_path / "walk"
    folder.mkdir()
    (folder / "1.obj").write_text(points + "f 1 2 3 4\nf 2 5 3\n")
    (folder / "2.obj").write_text(points + "f 1 2 3 4\nf 2 5 3 1\n")
    refused(folder, "inconsistent_sequence", "face 1 is \\[1, 4, 2, 0\\] in frame 1 .*, and \\[1, 4, 2\\] in frame 0")


def test_a_damaged_frame_is_named(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "walk", ".obj", walk())
    (folder / "frame3.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    refused(folder, "empty_content", "In 'frame3.obj': The OBJ file holds 3 points and no faces")
    (folder / "frame0.obj").write_bytes(b"\0\1\2")
    refused(folder, "unknown_format", "In 'frame0.obj'")
    (folder / "frame0.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    refused(folder, "invalid_mesh", "In 'frame0.obj': Face 0 names vertex 8")


def test_what_is_no_sequence(tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    folder.mkdir()
    refused(folder, "empty_content", "None of the 0 files in the folder")
    (folder / "readme.txt").write_text("nothing here")
    refused(folder, "empty_content", "None of the 1 files in the folder")
    write_mesh(icosphere(subdivisions=1), folder / "frame0.obj")
    write_mesh(icosphere(subdivisions=1), folder / "frame0.ply")
    refused(folder, "inconsistent_sequence", "several formats \\(1 .obj, 1 .ply\\)")
    refused(folder / "frame0.obj", "wrong_input_kind", "is a mesh \\(obj\\), not a sequence")


def test_limits_of_archives(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "walk", ".obj", walk(dtype="f8"))
    for path in (folder, zip_of(folder)):
        assert len(read_sequence(path)) == 12
        for limits in (
            SequenceLimits(frames=11),
            SequenceLimits(bytes=12 * 42 * 24 - 1),
            SequenceLimits(mesh=MeshLimits(bytes=1000)),
            SequenceLimits(mesh=MeshLimits(faces=79)),
            SequenceLimits(mesh=MeshLimits(vertices=41)),
        ):
            refused(path, "too_large", "at most|more than", limits)


def test_an_archive_that_leads_out_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "walk.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("../frame0.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    refused(path, "unsafe_archive", "leads out")


def test_what_an_npz_claims_costs_nothing(tmp_path: Path) -> None:
    header = {"descr": "<f4", "fortran_order": False, "shape": (10**6, 10**6, 3)}
    entry = io.BytesIO()
    np.lib.format.write_array_header_1_0(entry, header)
    path = tmp_path / "walk.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("vertices.npy", entry.getvalue() + struct.pack("<3f", 1, 2, 3))
        faces = io.BytesIO()
        np.save(faces, FACES)
        archive.writestr("faces.npy", faces.getvalue())
    refused(path, "corrupt_file", "should take 12000000000000 bytes, and has 12")


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "frames", "vertices", "faces", "components", "closed"),
    [
        ("crane", 175, 10002, 20000, 1, True),
        ("chickenCrossing", 400, 3030, 5664, 41, False),
        ("mmface4d-3k", 67, 3314, 5999, 1, False),
        ("horse-gallop", 48, 8431, 16843, 1, False),
    ],
)
def test_real_motions(
    name: str, frames: int, vertices: int, faces: int, components: int, closed: bool, shared_data: Path
) -> None:
    sequence = read_sequence(shared_data / "motion" / f"{name}.npz")
    assert (len(sequence), sequence.vertex_count, len(sequence.faces)) == (frames, vertices, faces)
    assert sequence.vertices.dtype == np.float32
    assert sequence.topology.component_count == components
    assert sequence.topology.closed is closed

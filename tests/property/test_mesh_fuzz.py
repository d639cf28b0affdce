"""Damaged files: every reader gives a mesh or an error that the user can mend, never anything else."""

from __future__ import annotations

import contextlib
import io
import struct
import zipfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_contracts.errors import UserError
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.mesh_io import read_mesh_bytes, write_mesh
from shapery_geometry.sequence import open_sequence

FORMATS = ("ply", "ply text", "ply big", "ply strips", "obj", "stl", "stl text", "off", "glb")
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=">f4")
PLY = "ply\nformat {} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n{}end_header\n"
FACES = "element face 2\nproperty list uchar int vertex_indices\n"
STRIPS = "element tristrips 1\nproperty list int int vertex_indices\n"
DAMAGE = b'0123456789-. \n\r\xff\x00eEnf/#{}[]":,'


@cache
def sound(name: str, folder: Path) -> bytes:
    """A small sound file of each kind."""
    match name:
        case "ply text":
            return (PLY.format("ascii", FACES) + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n4 0 1 3 2\n").encode()
        case "ply big":
            body = struct.pack(">B3iB4i", 3, 0, 1, 2, 4, 0, 1, 3, 2)
            return PLY.format("binary_big_endian", FACES).encode() + POINTS.tobytes() + body
        case "ply strips":
            body = struct.pack("<9i", 8, 0, 1, 2, 3, -1, 3, 2, 1)
            return PLY.format("binary_little_endian", STRIPS).encode() + POINTS.astype("<f4").tobytes() + body
        case "stl text":
            facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 {0}\nvertex 1 {0} 0\nvertex 0 1 0\nendloop\nendfacet\n"
            return ("solid a\n" + "".join(facet.format(k) for k in range(4)) + "endsolid a\n").encode()
    path = folder / f"mesh.{name}"
    write_mesh(icosphere(subdivisions=0), path)
    return path.read_bytes()


def damaged(data: bytes, seed: int) -> bytes:
    rng = np.random.default_rng(seed)
    result = bytearray(data)
    match rng.integers(0, 5):
        case 0:
            del result[int(rng.integers(0, len(result))) :]
        case 1:
            for place in rng.integers(0, len(result), rng.integers(1, 6)):
                result[place] = rng.integers(0, 256)
        case 2:
            for place in rng.integers(0, min(len(result), 400), rng.integers(1, 4)):
                result[place] = DAMAGE[int(rng.integers(0, len(DAMAGE)))]
        case 3:
            start = int(rng.integers(0, len(result)))
            del result[start : start + int(rng.integers(1, 60))]
        case 4:
            start = int(rng.integers(0, len(result)))
            result[start:start] = result[start : start + int(rng.integers(1, 40))] * int(rng.integers(1, 4))
    return bytes(result)


def read(data: bytes) -> str:
    refusal: UserError | None = None
    mesh: TriangleMesh | None = None
    try:
        mesh = read_mesh_bytes(data)
    except UserError as error:
        refusal = error
    if refusal is not None:
        # a sentence
        assert refusal.message[0].isupper() or refusal.message[0].isdigit()
        assert refusal.message[-1] in ".)"
        return refusal.code
    assert mesh is not None
    assert len(mesh.faces) > 0
    return "read"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("sound")


@pytest.mark.parametrize("name", FORMATS)
def test_the_sound_file_is_read(name: str, folder: Path) -> None:
    assert read(sound(name, folder)) == "read"


@pytest.mark.parametrize("name", FORMATS)
@settings(max_examples=120, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_damaged_file_is_read_or_refused(name: str, folder: Path, seed: int) -> None:
    read(damaged(sound(name, folder), seed))


@pytest.mark.parametrize("name", ["ply", "ply big", "stl", "glb"])
def test_a_binary_file_cut_off_anywhere_is_refused(name: str, folder: Path) -> None:
    data = sound(name, folder)
    # GLB pads its last part with up to three bytes
    for end in range(len(data) - 4):
        assert read(data[:end]) != "read", end


@settings(max_examples=80, deadline=None, derandomize=True)
@given(
    data=st.binary(max_size=300), start=st.sampled_from([b"", b"ply\n", b"OFF\n", b"glTF", b"solid x\n", b"v 0 0 0\n"])
)
def test_any_bytes_are_read_or_refused(data: bytes, start: bytes) -> None:
    read(start + data)


@cache
def sequences() -> tuple[bytes, bytes]:
    sphere = icosphere(subdivisions=0)
    packed = io.BytesIO()
    np.savez_compressed(packed, vertices=np.stack([sphere.vertices] * 3).astype("f4"), faces=sphere.faces)
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as target:
        for k in range(3):
            target.writestr(f"{k}.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 3 4\n")
    return packed.getvalue(), archive.getvalue()


@settings(max_examples=150, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), kind=st.sampled_from([0, 1]))
def test_a_damaged_sequence_is_read_or_refused(folder: Path, seed: int, kind: int) -> None:
    path = folder / "sequence"
    path.write_bytes(damaged(sequences()[kind], seed))
    with contextlib.suppress(UserError):
        for frame in open_sequence(path).frames():
            assert frame.shape[1] == 3

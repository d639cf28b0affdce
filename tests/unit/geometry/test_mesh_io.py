"""Readers and writers of single meshes: every variant of each format, and each refusal with its sentence."""

from __future__ import annotations

import io
import struct
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput, LimitExceeded, UserError
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.mesh_io import MeshLimits, read_mesh, read_mesh_bytes, write_mesh, write_ply, write_stl
from shapery_geometry.mesh_io.polygons import triangulated

CORNER = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


def refused(data: bytes, code: str, message: str, **options: object) -> UserError:
    with pytest.raises(UserError, match=message) as caught:
        read_mesh_bytes(data, **options)  # type: ignore[arg-type]
    assert caught.value.code == code
    return caught.value


def assert_read(data: bytes, points: list[list[float]], faces: list[list[int]]) -> None:
    mesh = read_mesh_bytes(data)
    assert mesh.vertices.tolist() == points
    assert mesh.faces.tolist() == faces


# every format -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off"])
def test_what_is_written_is_read_back_bit_for_bit(suffix: str, tmp_path: Path) -> None:
    sphere = icosphere((0.1, -2e-7, 3e9), 1 / 3, 2)
    path = tmp_path / f"mesh{suffix}"
    write_mesh(sphere, path)
    assert read_mesh(path).same_as(sphere)
    assert read_mesh(str(path)).same_as(sphere)
    first = path.read_bytes()
    write_mesh(sphere, path)
    assert path.read_bytes() == first


def test_stl_keeps_faces_in_order_and_welds_what_coincides(tmp_path: Path) -> None:
    sphere = icosphere(subdivisions=2)
    path = tmp_path / "mesh.stl"
    write_stl(sphere, path)
    welded = read_mesh(path)
    assert (len(welded.vertices), len(welded.faces)) == (162, 320)
    assert welded.closed
    assert welded.corners == pytest.approx(sphere.corners.astype(np.float32).astype(float), abs=0)
    # numbered by first occurrence
    assert welded.faces[0].tolist() == [0, 1, 2]
    split = read_mesh(path, weld_stl=False)
    assert split.faces.tolist() == np.arange(960).reshape(-1, 3).tolist()
    assert np.array_equal(split.corners, welded.corners)


def test_single_precision_ply(tmp_path: Path) -> None:
    sphere = icosphere(subdivisions=1)
    path = tmp_path / "mesh.ply"
    write_ply(sphere, path, comments=("model units", "made for a test"), single=True)
    assert b"comment model units\ncomment made for a test\n" in path.read_bytes()
    assert b"property float x" in path.read_bytes()
    assert np.array_equal(read_mesh(path).vertices, sphere.vertices.astype(np.float32))
    with pytest.raises(ValueError, match="one line"):
        write_ply(sphere, path, comments=("two\nlines",))


def test_a_ply_says_in_which_frame_it_is(tmp_path: Path) -> None:
    write_ply(icosphere(subdivisions=0), tmp_path / "mesh.ply")
    assert b"comment coordinates: RAS, millimetres\n" in (tmp_path / "mesh.ply").read_bytes()


def test_an_unknown_ending_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"ending '\.xyz'") as caught:
        write_mesh(icosphere(subdivisions=0), tmp_path / "mesh.xyz")
    assert caught.value.code == "unsupported_format"


def test_the_name_does_not_matter(tmp_path: Path) -> None:
    write_mesh(icosphere(subdivisions=1), tmp_path / "mesh.off")
    (tmp_path / "mesh.off").rename(tmp_path / "mesh.stl")
    assert len(read_mesh(tmp_path / "mesh.stl").vertices) == 42


def test_what_is_no_mesh_is_refused_by_kind(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="A folder was given"):
        read_mesh(tmp_path)
    np.savez(tmp_path / "walk.npz", vertices=np.zeros((2, 3, 3), np.float32), faces=np.array([[0, 1, 2]], np.int32))
    with pytest.raises(InvalidInput, match="is a sequence \\(npz\\), not a mesh") as caught:
        read_mesh(tmp_path / "walk.npz")
    assert caught.value.code == "wrong_input_kind"
    refused(b"", "empty_content", "empty")
    refused(b"hello", "unknown_format", "no format")


# OBJ --------------------------------------------------------------------------------------------------------------

OBJ_POINTS = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"


@pytest.mark.parametrize(
    ("name", "text", "faces"),
    [
        ("plain", OBJ_POINTS + "f 1 2 3\n", [[0, 1, 2]]),
        ("no end of line", OBJ_POINTS + "f 1 2 3", [[0, 1, 2]]),
        ("texture", OBJ_POINTS + "vt 0 0\nf 1/1 2/1 3/1\n", [[0, 1, 2]]),
        ("normals", OBJ_POINTS + "vn 0 0 1\nf 1//1 2//1 3//1\n", [[0, 1, 2]]),
        ("both", OBJ_POINTS + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n", [[0, 1, 2]]),
        ("seam", OBJ_POINTS + "vt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 1/2 3/2 4/1\n", [[0, 1, 2], [0, 2, 3]]),
        ("negative", OBJ_POINTS + "f -4 -3 -2\n", [[0, 1, 2]]),
        ("negative before the end", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -4 -3 -1\n",
         [[0, 1, 2], [0, 1, 3]]),
        ("forward reference", "v 0 0 0\nf 1 2 3\nv 1 0 0\nv 0 1 0\nv 0 0 1\n", [[0, 1, 2]]),
        ("windows", (OBJ_POINTS + "f 1 2 3\n").replace("\n", "\r\n"), [[0, 1, 2]]),
        ("old mac", (OBJ_POINTS + "f 1 2 3\n").replace("\n", "\r"), [[0, 1, 2]]),
        ("comments", "# 3 faces?\n" + OBJ_POINTS + "f 1 2 3 # f 2 3 4\n", [[0, 1, 2]]),
        ("continued", OBJ_POINTS + "f 1 \\\n2 \\\n3\n", [[0, 1, 2]]),
        ("groups and lines", "o a\ng b\ns off\nusemtl c\n" + OBJ_POINTS + "l 1 2\np 3\nf 1 2 3\n", [[0, 1, 2]]),
        ("blanks and tabs", OBJ_POINTS.replace(" ", "\t ") + "  f\t1 2\t3  \n", [[0, 1, 2]]),
        ("colours", OBJ_POINTS.replace("\n", " 0.5 0.5 0.5\n") + "f 1 2 3\n", [[0, 1, 2]]),
        ("weights", OBJ_POINTS.replace("\n", " 1.0\n") + "f 1 2 3\n", [[0, 1, 2]]),
        ("quad", OBJ_POINTS + "f 1 2 3 4\n", [[0, 1, 2], [0, 2, 3]]),
        ("old keyword", OBJ_POINTS + "fo 1 2 3\n", [[0, 1, 2]]),
    ],
)  # fmt: skip
def test_obj_variants(name: str, text: str, faces: list[list[int]]) -> None:
    assert_read(text.encode(), CORNER, faces)


def test_obj_keeps_vertices_that_coincide_or_are_not_used() -> None:
    mesh = read_mesh_bytes(b"v 0 0 0\nv 0 0 0\nv 1 0 0\nv 9 9 9\nv 0 1 0\nf 1 3 5\nf 2 3 5\n")
    assert len(mesh.vertices) == 5
    assert mesh.faces.tolist() == [[0, 2, 4], [1, 2, 4]]


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        (OBJ_POINTS, "empty_content", "holds 4 points and no faces: it is a point cloud"),
        (OBJ_POINTS + "f 1 2\n", "corrupt_file", "Face 0 has 2 corners"),
        (OBJ_POINTS + "f 1 2 5\n", "invalid_mesh", "Face 0 names vertex 4, and the file has 4 vertices"),
        (OBJ_POINTS + "f 1 2 3\nf 0 1 2\n", "corrupt_file", "names vertex 0, and OBJ counts from 1"),
        (OBJ_POINTS + "f -5 1 2\n", "corrupt_file", "counts back beyond"),
        (OBJ_POINTS.replace("0 0 1", "0 nan 1") + "f 1 2 3\n", "invalid_mesh", "1 of 4 vertices .* vertex 3"),
        (OBJ_POINTS.replace("0 0 1", "0 1e999 1") + "f 1 2 3\n", "invalid_mesh", "not finite"),
    ],
)
def test_obj_refusals(text: str, code: str, message: str) -> None:
    refused(text.encode(), code, message)


def test_obj_refusals_behind_what_recognition_looks_at() -> None:
    filler = OBJ_POINTS + "# filler\n" * 8000
    assert len(filler) > 1 << 16
    refused((filler + "v 1 2\nf 1 2 3\n").encode(), "corrupt_file", "A vertex of the OBJ file has 2 coordinates: '1 2'")
    refused((filler + "v 1 2 x\nf 1 2 3\n").encode(), "corrupt_file", "stands 'x', which is no number")
    refused((filler + "v 1 2 1_0\nf 1 2 3\n").encode(), "corrupt_file", "stands '1_0', which is no number")
    refused((filler + "f 1 2 3.5\n").encode(), "corrupt_file", "stands '3.5', which is no whole number")
    refused((filler + "f 1 2 " + "9" * 30).encode(), "corrupt_file", "no file can mean")
    mesh = read_mesh_bytes((filler + "f 1 2 3\n" * 3).encode())
    assert len(mesh.faces) == 3


# PLY --------------------------------------------------------------------------------------------------------------

PLY_TYPES = {
    "b": "char",
    "B": "uchar",
    "h": "short",
    "H": "ushort",
    "i": "int",
    "I": "uint",
    "f": "float",
    "d": "double",
}


def ply(
    encoding: str,
    point: str = "f",
    count: str = "B",
    index: str = "i",
    faces: list[list[int]] | None = None,
    extra: str = "",
) -> bytes:
    faces = TETRAHEDRON if faces is None else faces
    more = [f"property {PLY_TYPES[t]} extra{k}" for k, t in enumerate(extra)]
    header = ["ply", f"format {encoding} 1.0", "comment a test", "element vertex 4"]
    header += [f"property {PLY_TYPES[point]} {axis}" for axis in "xyz"] + more
    header += [
        f"element face {len(faces)}",
        *more,
        f"property list {PLY_TYPES[count]} {PLY_TYPES[index]} vertex_indices",
    ]
    head = "\n".join([*header, "end_header", ""]).encode()
    if encoding == "ascii":
        rest = "".join(" " + "7" for _ in extra)
        lines = [" ".join(f"{int(x)}" for x in p) + rest for p in CORNER]
        lines += [(rest + " ").lstrip() + f"{len(f)} " + " ".join(map(str, f)) for f in faces]
        return head + "\n".join([*lines, ""]).encode()
    order = "<" if encoding.endswith("little_endian") else ">"
    sevens = [7] * len(extra)
    whole = point not in "fd"
    data = b"".join(
        struct.pack(f"{order}3{point}{extra}", *(int(x) if whole else x for x in p), *sevens) for p in CORNER
    )
    data += b"".join(struct.pack(f"{order}{extra}{count}{len(f)}{index}", *sevens, len(f), *f) for f in faces)
    return head + data


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("extra", ["", "BdH"])
@pytest.mark.parametrize(
    ("point", "count", "index"), [("f", "B", "i"), ("d", "i", "I"), ("h", "H", "h"), ("b", "I", "B")]
)
def test_ply_of_every_type_and_byte_order(encoding: str, extra: str, point: str, count: str, index: str) -> None:
    assert_read(ply(encoding, point, count, index, extra=extra), CORNER, TETRAHEDRON)


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize(("count", "extra"), [("B", ""), ("H", "d"), ("i", "BB")])
def test_ply_of_mixed_polygons(encoding: str, count: str, extra: str) -> None:
    data = ply(encoding, count=count, extra=extra, faces=[[0, 1, 2], [0, 1, 2, 3], [3, 2, 1]])
    assert_read(data, CORNER, [[0, 1, 2], [0, 1, 2], [0, 2, 3], [3, 2, 1]])


def test_ply_of_quads_alone() -> None:
    assert_read(ply("binary_big_endian", faces=[[0, 1, 2, 3], [3, 2, 1, 0]]), CORNER,
                [[0, 1, 2], [0, 2, 3], [3, 2, 1], [3, 1, 0]])  # fmt: skip


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
def test_ply_of_triangle_strips(encoding: str) -> None:
    strip = [0, 1, 2, 3, -1, 3, 2, 1, 1, 0, -1, 0, 1]
    header = f"ply\nformat {encoding} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    if encoding == "ascii":
        body = (
            "\n".join(" ".join(str(int(x)) for x in p) for p in CORNER)
            + f"\n{len(strip)} {' '.join(map(str, strip))}\n"
        )
        data = (header + body).encode()
    else:
        data = header.encode() + np.array(CORNER, "<f4").tobytes() + struct.pack(f"<i{len(strip)}i", len(strip), *strip)
    # every second triangle turned, those that only join strips left out
    assert_read(data, CORNER, [[0, 1, 2], [2, 1, 3], [3, 2, 1]])
    refused(data[:-2], "corrupt_file", "has 13 numbers, not 14|ends before")


def test_ply_strips_that_name_missing_vertices() -> None:
    header = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    header += b"element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    refused(header + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "invalid_mesh", "names vertex 7, and the file has 3")


def test_ply_passes_over_other_elements_and_lists() -> None:
    header = (
        "ply\nformat binary_little_endian 1.0\nelement before 2\nproperty list uchar short junk\nproperty double w\n"
        "element vertex 4\nproperty float z\nproperty float y\nproperty float x\nelement empty 5\n"
        "element face 2\nproperty list uchar float texcoord\nproperty list uchar int vertex_index\nproperty uchar red\n"
        "element after 1000000\nproperty list int int junk\nend_header\n"
    )
    data = struct.pack("<B2hd", 2, 5, 6, 0.5) + struct.pack("<Bd", 0, 0.5)
    data += b"".join(struct.pack("<3f", *reversed(p)) for p in CORNER)
    data += struct.pack("<B6fB3iB", 6, 0, 0, 0, 0, 0, 0, 3, 0, 1, 2, 9)
    data += struct.pack("<BB4iB", 0, 4, 0, 1, 2, 3, 9)
    # only what claims to fit is recognised; what stands behind the faces is walked over too
    refused(header.encode() + data, "corrupt_file", "asks for")
    shorter = header.replace("after 1000000", "after 1").encode() + data + struct.pack("<iii", 2, 1, 1)
    assert_read(shorter, CORNER, [[0, 1, 2], [0, 1, 2], [0, 2, 3]])


def test_ply_indices_written_as_fractions() -> None:
    header = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    header += b"element face 1\nproperty list uchar float vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    assert read_mesh_bytes(header + b"3 0 1.0 2\n").faces.tolist() == [[0, 1, 2]]
    refused(header + b"3 0 1.5 2\n", "corrupt_file", "not whole")


def replaced(data: bytes, old: bytes, new: bytes) -> bytes:
    assert old in data
    return data.replace(old, new, 1)


@pytest.mark.parametrize(
    ("change", "code", "message"),
    [
        (lambda d: replaced(d, b"element face 4", b"element face 0"), "empty_content", "4 points and no faces"),
        (lambda d: d[:-3], "corrupt_file", "file has|ends before"),
        (lambda d: replaced(d, b"float x", b"float u"), "corrupt_file", "no number called x"),
        (lambda d: replaced(d, b"vertex_indices", b"something"), "corrupt_file", "no list called vertex_indices"),
        (lambda d: replaced(d, b"element face", b"element vertex"), "corrupt_file", "twice|no faces|no list|no number"),
        (lambda d: replaced(d, b"property float x", b"property quad x"), "unsupported_format", "unknown type 'quad'"),
        (lambda d: replaced(d, b"uchar int", b"float int"), "corrupt_file", "in fractions"),
        (lambda d: replaced(d, b"little_endian", b"middle_endian"), "unsupported_format", "middle"),
        (lambda d: replaced(d, b"end_header", b"the_header"), "corrupt_file", "does not end"),
        (lambda d: replaced(d, b"element vertex 4", b"element vertex 999999999999"), "corrupt_file", "asks for"),
        (lambda d: replaced(d, b"element vertex 4", b"element vertex 9" + b"9" * 17), "corrupt_file", "asks for"),
        (lambda d: d[:-4] + struct.pack("<i", 9), "invalid_mesh", "Face 3 names vertex 9, and the file has 4"),
        (lambda d: d[:-4] + struct.pack("<i", -1), "invalid_mesh", "Face 3 names vertex -1"),
    ],
)
def test_ply_refusals(change: Callable[[bytes], bytes], code: str, message: str) -> None:
    refused(change(ply("binary_little_endian")), code, message)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_coordinates_that_are_not_finite(bad: float) -> None:
    data = ply("binary_little_endian")
    start = data.index(b"end_header\n") + 11
    refused(
        data[: start + 16] + struct.pack("<f", bad) + data[start + 20 :], "invalid_mesh", "1 of 4 vertices .* vertex 1"
    )


def test_ply_text_refusals() -> None:
    data = ply("ascii")
    refused(replaced(data, b"\n1 0 0\n", b"\n1 0\n"), "corrupt_file", "has 2 numbers, not 3")
    refused(replaced(data, b"\n1 0 0\n", b"\n1 0 x\n"), "corrupt_file", "'x', which is no number")
    refused(replaced(data, b"3 0 2 1", b"x 0 2 1"), "corrupt_file", "begins with 'x' in place of its length")
    refused(replaced(data, b"3 0 2 1", b"3 0 2"), "corrupt_file", "has 3 numbers, not 4")
    refused(replaced(data, b"3 2 0 3\n", b""), "corrupt_file", "ends before its 4 rows of 'face'")


# STL --------------------------------------------------------------------------------------------------------------

FACET = "facet normal 0 0 0\n outer loop\n  vertex {}\n  vertex {}\n  vertex {}\n endloop\nendfacet\n"
STL = "solid a name\n" + "".join(
    FACET.format(*(" ".join(f"{x:e}" for x in CORNER[k]) for k in face)) for face in TETRAHEDRON
)


def test_text_stl() -> None:
    for text in (STL + "endsolid a name\n", STL.upper(), (STL + "endsolid\n").replace("\n", "\r\n")):
        mesh = read_mesh_bytes(text.encode())
        assert (len(mesh.vertices), len(mesh.faces), mesh.closed) == (4, 4, True)
        assert mesh.volume == pytest.approx(1 / 6)
        assert mesh.vertices[0].tolist() == CORNER[0]


def test_several_solids_are_one_mesh() -> None:
    other = STL.replace("0.000000e+00", "5.000000e+00").replace("1.000000e+00", "6.000000e+00")
    mesh = read_mesh_bytes((STL + "endsolid\n" + other + "endsolid\n").encode())
    assert (len(mesh.vertices), mesh.component_count) == (8, 2)


def test_minus_zero_is_welded_to_zero() -> None:
    mesh = read_mesh_bytes(STL.replace("vertex 0.000000e+00", "vertex -0.0", 2).encode())
    assert len(mesh.vertices) == 4


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        (STL[: STL.rindex("endfacet")], "corrupt_file", "breaks off in facet 3"),
        (STL[: STL.rindex("  vertex")], "corrupt_file", "breaks off in facet 3"),
        (
            replaced(STL.encode(), b"  vertex", b"  vertex 1 1 1\n  vertex").decode(),
            "corrupt_file",
            "Facet 0 .* 3 vertices",
        ),
        (replaced(STL.encode(), b"endfacet", b"").decode(), "corrupt_file", "Facet 0"),
        (replaced(STL.encode(), b"0.000000e+00 0", b"zero 0").decode(), "corrupt_file", "'zero', which is no number"),
        (replaced(STL.encode(), b"e+00 0.0", b"e+00\n0.0").decode(), "corrupt_file", "has 1 coordinates"),
        ("solid nothing\nendsolid nothing\n", "empty_content", "neither points nor faces"),
        (replaced(STL.encode(), b"vertex 0.000000e+00", b"vertex nan").decode(), "invalid_mesh", "not finite"),
    ],
)
def test_text_stl_refusals(text: str, code: str, message: str) -> None:
    refused(text.encode(), code, message)


def test_binary_stl_whose_header_begins_with_solid(tmp_path: Path) -> None:
    write_stl(icosphere(subdivisions=1), tmp_path / "mesh.stl")
    data = (tmp_path / "mesh.stl").read_bytes()
    assert not data.startswith(b"solid")
    assert len(read_mesh_bytes(b"solid facet normal".ljust(80) + data[80:]).faces) == 80


# OFF --------------------------------------------------------------------------------------------------------------

OFF_POINTS = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"


@pytest.mark.parametrize(
    ("text", "faces"),
    [
        ("OFF\n4 1 0\n" + OFF_POINTS + "3 0 1 2\n", [[0, 1, 2]]),
        ("OFF 4 1 0\n" + OFF_POINTS + "3 0 1 2", [[0, 1, 2]]),
        ("# said before\nOFF # here\n\n4 1\n# and here\n" + OFF_POINTS + "3 0 1 2 # there\n", [[0, 1, 2]]),
        ("OFF\n4 2 0\n" + OFF_POINTS + "4 0 1 2 3\n3 3 2 1\n", [[0, 1, 2], [0, 2, 3], [3, 2, 1]]),
        ("OFF\n4 1 0\n" + OFF_POINTS + "3 0 1 2 255 0 0\n", [[0, 1, 2]]),
        ("OFF\n4 1 0\n" + OFF_POINTS + "3 0 1 2 0.5 0.5 0.5 1.0\n", [[0, 1, 2]]),
        ("COFF\n4 1 0\n" + OFF_POINTS.replace("\n", " 255 0 0 255\n") + "3 0 1 2\n", [[0, 1, 2]]),
        ("NOFF\n4 1 0\n" + OFF_POINTS.replace("\n", " 0 0 1\n") + "3 0 1 2\n", [[0, 1, 2]]),
        ("STCNOFF\n4 1 0\n" + OFF_POINTS.replace("\n", " 0 0 1 1 1 1 1 0 0\n") + "3 0 1 2\n", [[0, 1, 2]]),
        ("OFF\r\n4 1 0\r\n" + OFF_POINTS.replace("\n", "\r\n") + "3 0 1 2\r\n", [[0, 1, 2]]),
        ("OFF\n4 2 0\n" + OFF_POINTS + "3\n0 1\n2\n4 0 1\n2 3\n", [[0, 1, 2], [0, 1, 2], [0, 2, 3]]),
        ("OFF\n4 1 0\n" + OFF_POINTS.replace(" ", "\n") + "3 0 1 2\n", [[0, 1, 2]]),
    ],
)
def test_off_variants(text: str, faces: list[list[int]]) -> None:
    assert_read(text.encode(), CORNER, faces)


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("OFF\n4 0 0\n" + OFF_POINTS, "empty_content", "4 points and no faces"),
        ("OFF\n4 2 0\n" + OFF_POINTS + "3 0 1 2\n", "corrupt_file", "4 vertices and 2 faces .* has 5 lines"),
        ("OFF\n4 1 0\n" + OFF_POINTS + "3 0 1 4\n", "invalid_mesh", "Face 0 names vertex 4"),
        ("OFF\n4 1 0\n" + OFF_POINTS + "2 0 1 4\n", "corrupt_file", "Face 0 has 2 corners"),
        ("OFF\n4 1 0\n" + OFF_POINTS + "3 0 1\n", "corrupt_file", "do not add up"),
        (
            "OFF\n4 2 0\n" + OFF_POINTS + "3 0 1 2\n3 0 1\n",
            "corrupt_file",
            "Face 1 of the OFF file should have 3 corners",
        ),
        (
            "OFF\n4 1 0\n" + OFF_POINTS.replace("0 1 0", "0 1") + "3 0 1 2\n",
            "corrupt_file",
            "Vertex 2 .* 2 coordinates",
        ),
        (
            "OFF\n4 1 0\n" + OFF_POINTS.replace("0 1 0", "0 x 0") + "3 0 1 2\n",
            "corrupt_file",
            "'x', which is no number",
        ),
        ("OFF\n400000000 1 0\n" + OFF_POINTS + "3 0 1 2\n", "too_large", "400000000 vertices; at most"),
        ("OFF\n4000000 1 0\n" + OFF_POINTS + "3 0 1 2\n", "corrupt_file", "asks for"),
        ("4OFF\n4 1 0\n" + OFF_POINTS + "3 0 1 2\n", "unsupported_format", "dimensions"),
        ("OFF BINARY\n4 1 0\n", "unsupported_format", "binary"),
        ("OFF\n4\n", "corrupt_file", "."),
    ],
)
def test_off_refusals(text: str, code: str, message: str) -> None:
    refused(text.encode(), code, message)


# polygons ---------------------------------------------------------------------------------------------------------


def area_of(points: np.ndarray, triangles: np.ndarray) -> tuple[float, float]:
    """Area of all triangles, and the sum of their signed areas."""
    a, b, c = (points[triangles[:, k], :2] for k in range(3))
    signed = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    return float(np.abs(signed).sum()), float(signed.sum())


@pytest.mark.parametrize("turn", range(4))
def test_a_concave_quad_is_cut_inside(turn: int) -> None:
    points = np.roll(np.array([[0.0, 0, 0], [2, 0, 0], [0.4, 0.4, 0], [0, 2, 0]]), turn, axis=0)
    triangles = triangulated(np.arange(4), np.array([4]), points, MeshLimits())
    total, signed = area_of(points, triangles)
    assert total == pytest.approx(signed)
    assert total == pytest.approx(0.8)


@pytest.mark.parametrize("corners", [5, 8, 40])
def test_a_comb_is_cut_inside(corners: int) -> None:
    rng = np.random.default_rng(corners)
    angle = 2 * np.pi * np.arange(corners) / corners
    radius = np.where(np.arange(corners) % 2, 1.0, 0.2) * rng.uniform(0.8, 1, corners)
    flat = np.stack((radius * np.cos(angle), radius * np.sin(angle), np.zeros(corners)), axis=1)
    x, y = flat[:, 0], flat[:, 1]
    expected = 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    for points in (flat, flat + np.array([1e3, -1e3, 5])):
        triangles = triangulated(np.arange(corners), np.array([corners]), points, MeshLimits())
        assert len(triangles) == corners - 2
        total, signed = area_of(points, triangles)
        assert total == pytest.approx(signed, rel=1e-9)
        assert total == pytest.approx(expected, rel=1e-9)
        assert len(self_intersections(TriangleMesh(points, triangles))) == 0
    # turned in space the cut is the same surface
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    triangles = triangulated(np.arange(corners), np.array([corners]), flat @ rotation.T, MeshLimits())
    assert area_of(flat, triangles)[0] == pytest.approx(expected)


def test_polygons_keep_their_order() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0], [2.5, 0.5, 0]])
    corners = np.array([0, 1, 2, 3, 1, 4, 2, 4, 6, 5, 2, 1])
    triangles = triangulated(corners, np.array([4, 3, 5]), points, MeshLimits())
    assert triangles.tolist() == [[0, 1, 2], [0, 2, 3], [1, 4, 2], [4, 6, 5], [4, 5, 2], [4, 2, 1]]


def test_polygons_that_no_cut_makes_right_still_give_all_their_triangles() -> None:
    crossed = np.array([[0.0, 0, 0], [2, 2, 0], [2, 0, 0], [0, 2, 0], [1, 5, 0]])
    assert len(triangulated(np.arange(5), np.array([5]), crossed, MeshLimits())) == 3
    same = np.zeros((6, 3))
    assert triangulated(np.arange(6), np.array([6]), same, MeshLimits()).shape == (4, 3)


def test_a_concave_polygon_of_very_many_corners_is_refused() -> None:
    angle = 2 * np.pi * np.arange(2000) / 2000
    radius = np.where(np.arange(2000) % 2, 1.0, 0.5)
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle), np.zeros(2000)), axis=1)
    with pytest.raises(InvalidInput, match="concave polygon of 2000 corners") as caught:
        triangulated(np.arange(2000), np.array([2000]), points, MeshLimits())
    assert caught.value.code == "unsupported_format"
    round_points = points / radius[:, None]
    assert len(triangulated(np.arange(2000), np.array([2000]), round_points, MeshLimits())) == 1998


# limits -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".stl", ".glb"])
def test_limits_hold_for_every_format(suffix: str, tmp_path: Path) -> None:
    sphere = icosphere(subdivisions=2)
    path = tmp_path / f"mesh{suffix}"
    write_mesh(sphere, path)
    exact = MeshLimits(vertices=162, faces=320, bytes=path.stat().st_size)
    assert len(read_mesh(path, limits=exact).faces) == 320
    tighter = [MeshLimits(faces=319), MeshLimits(bytes=path.stat().st_size - 1)]
    if suffix != ".stl":
        tighter.append(MeshLimits(vertices=161))
    for limits in tighter:
        with pytest.raises(LimitExceeded) as caught:
            read_mesh(path, limits=limits)
        assert caught.value.code == "too_large"


def test_triangles_of_polygons_count() -> None:
    text = (OBJ_POINTS + "f 1 2 3 4\n").encode()
    refused(text, "too_large", "2 faces; at most 1", limits=MeshLimits(faces=1))


@pytest.mark.parametrize(
    "data",
    [
        b"ply\nformat binary_little_endian 1.0\nelement vertex 999999999999\nelement face 1\n"
        b"property list uchar int vertex_indices\nend_header\n" + b"\0" * 30,
        (b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        b"element face 999999999999\nend_header\n0 0 0\n"),
        (b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty char x\nproperty char y\nproperty char z\n"
        b"element face 1\nproperty list uint double vertex_indices\nend_header\n\0\0\0\xff\xff\xff\x7f"),
        b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty char x\nproperty char y\nproperty char z\n"
        b"element face 2\nproperty list uint double vertex_indices\nend_header\n\0\0\0\xff\xff\xff\xff" + b"\0" * 20,
        b"OFF\n999999999999 1 0\n0 0 0\n",
        b"OFF\n1 999999999999 0\n0 0 0\n",
        b"glTF" + struct.pack("<2L", 2, 20 + 64) + struct.pack("<L4s", 64, b"JSON")
        + b'{"asset":{"version":"2.0"},"accessors":[{"count":99999999999}]}'.ljust(64),
    ],
)  # fmt: skip
def test_what_a_header_claims_costs_nothing(data: bytes) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(UserError):
            read_mesh_bytes(data)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    # reading 100 bytes takes kilobytes, plus what imports leave behind
    assert peak < 20 << 20


def test_long_files_are_read_in_pieces_that_fit_together(monkeypatch: pytest.MonkeyPatch) -> None:
    text = b"v 0 0 0\r\nv 1.25 0 0\r\n\r\nv 0 1 0\rv 0 0 1\nf 1 2 3\r\nf 2 3 4"
    from shapery_geometry.mesh_io import text as text_module

    whole = [line for lines in text_module.line_batches(io.BytesIO(text)) for line in lines if line]
    for piece in range(1, 24):
        monkeypatch.setattr(text_module, "_PIECE", piece)
        split = [line for lines in text_module.line_batches(io.BytesIO(text)) for line in lines if line]
        assert split == whole
    assert whole[1] == b"v 1.25 0 0"
    assert len(whole) == 6

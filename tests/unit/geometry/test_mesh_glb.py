"""GLB: scenes of several meshes and nodes, what is refused by name, and the frame of what is written."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shapery_contracts.errors import UserError
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.mesh_io import MeshLimits, read_mesh, read_mesh_bytes, write_scene_glb

CORNER = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4")
TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def glb(document: dict[str, Any], binary: bytes) -> bytes:
    text = json.dumps({"asset": {"version": "2.0"}, **document}).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    parts = struct.pack("<L4s", len(text), b"JSON") + text + struct.pack("<L4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4s2L", b"glTF", 2, 12 + len(parts)) + parts


def scene(**changes: Any) -> dict[str, Any]:
    """One mesh with one node, over 48 bytes of positions and 12 of indices."""
    document: dict[str, Any] = {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 60}],
    }
    return {**document, **changes}


BINARY = CORNER.tobytes() + TETRAHEDRON.astype("u1").tobytes()


def refused(data: bytes, code: str, message: str, **options: Any) -> None:
    with pytest.raises(UserError, match=message) as caught:
        read_mesh_bytes(data, **options)
    assert caught.value.code == code


def test_a_plain_scene() -> None:
    mesh = read_mesh_bytes(glb(scene(), BINARY))
    assert np.array_equal(mesh.vertices, CORNER)
    assert np.array_equal(mesh.faces, TETRAHEDRON)


@pytest.mark.parametrize(
    "node",
    [
        {"translation": [1, 2, 3], "scale": [2, 3, 4], "rotation": [0, 0, 0.5**0.5, 0.5**0.5]},
        # a quarter turn about z, written column by column
        {"matrix": [0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 1, 2, 3, 1]},
    ],
)
def test_a_node_moves_its_mesh(node: dict[str, Any]) -> None:
    mesh = read_mesh_bytes(glb(scene(nodes=[{"mesh": 0, **node}]), BINARY))
    expected = np.stack((-3 * CORNER[:, 1], 2 * CORNER[:, 0], 4 * CORNER[:, 2]), axis=1) + np.array([1, 2, 3])
    assert mesh.vertices == pytest.approx(expected, abs=1e-12)


def test_nodes_below_nodes_and_a_mesh_in_two_places() -> None:
    nodes = [
        {"translation": [10, 0, 0], "children": [1, 2]},
        {"mesh": 0, "scale": [2, 2, 2]},
        {"children": [3]},
        {"mesh": 0, "translation": [0, 5, 0]},
    ]
    mesh = read_mesh_bytes(glb(scene(nodes=nodes), BINARY))
    assert mesh.vertices == pytest.approx(
        np.concatenate((2 * CORNER + np.array([10, 0, 0]), CORNER + np.array([10, 5, 0])))
    )
    assert np.array_equal(mesh.faces, np.concatenate((TETRAHEDRON, TETRAHEDRON + 4)))
    assert mesh.component_count == 2


def test_a_mirrored_node_keeps_its_outside_out() -> None:
    mesh = read_mesh_bytes(glb(scene(nodes=[{"mesh": 0, "scale": [-1, 1, 1]}]), BINARY))
    assert mesh.volume == pytest.approx(1 / 6)


def test_primitives_over_the_same_positions_share_their_vertices() -> None:
    primitives = [{"attributes": {"POSITION": 0}, "indices": 1, "material": k} for k in range(2)] + [
        {"attributes": {"POSITION": 0}, "mode": 0}
    ]
    mesh = read_mesh_bytes(glb(scene(meshes=[{"primitives": primitives}]), BINARY))
    assert len(mesh.vertices) == 4
    assert len(mesh.faces) == 8


@pytest.mark.parametrize(
    ("mode", "order", "faces"),
    [
        (4, [0, 2, 1, 0, 1, 3], [[0, 2, 1], [0, 1, 3]]),
        (5, [0, 1, 2, 3, 3, 3, 0, 2, 1], [[0, 1, 2], [1, 3, 2], [3, 2, 0], [0, 2, 1]]),
        (6, [0, 1, 2, 3], [[1, 2, 0], [2, 3, 0]]),
    ],
)
@pytest.mark.parametrize(("component", "dtype"), [(5121, "u1"), (5123, "<u2"), (5125, "<u4")])
def test_lists_strips_and_fans(mode: int, order: list[int], faces: list[list[int]], component: int, dtype: str) -> None:
    indices = np.array(order, dtype=dtype)
    document = scene(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": mode}]}])
    document["accessors"][1] |= {"componentType": component, "count": len(order)}
    document["bufferViews"][1]["byteLength"] = indices.nbytes
    mesh = read_mesh_bytes(glb(document, CORNER.tobytes() + indices.tobytes()))
    # a fan's turn is that of the specification: (k + 1, k + 2, 0)
    assert sorted(sorted(f) for f in mesh.faces.tolist()) == sorted(sorted(f) for f in faces)
    edges = {(f[k], f[(k + 1) % 3]) for f in faces for k in range(3)}
    found = {(f[k], f[(k + 1) % 3]) for f in mesh.faces.tolist() for k in range(3)}
    assert found == edges


def test_no_indices_interleaved_and_a_scene_that_is_not_named() -> None:
    rows = np.zeros((3, 5), dtype="<f4")
    rows[:, 1:4] = CORNER[:3]
    document = {
        "nodes": [{"children": [1]}, {"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "byteOffset": 4, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 60, "byteStride": 20}],
        "buffers": [{"byteLength": 60}],
    }
    mesh = read_mesh_bytes(glb(document, rows.tobytes()))
    assert np.array_equal(mesh.vertices, CORNER[:3])
    assert mesh.faces.tolist() == [[0, 1, 2]]
    del document["nodes"]
    assert len(read_mesh_bytes(glb(document, rows.tobytes())).faces) == 1


def test_quantised_and_sparse_positions() -> None:
    quantised = (CORNER * 127).astype("i1")
    padded = np.zeros((4, 4), dtype="i1")
    padded[:, :3] = quantised
    document = scene(extensionsRequired=["KHR_mesh_quantization"], extensionsUsed=["KHR_mesh_quantization"])
    document["accessors"][0] |= {"componentType": 5120, "normalized": True}
    document["bufferViews"][0] |= {"byteLength": 16, "byteStride": 4}
    document["bufferViews"][1]["byteOffset"] = 16
    data = padded.tobytes() + TETRAHEDRON.astype("u1").tobytes()
    assert np.array_equal(read_mesh_bytes(glb(document, data)).vertices, CORNER)

    document = scene()
    document["bufferViews"] += [
        {"buffer": 0, "byteOffset": 60, "byteLength": 1},
        {"buffer": 0, "byteOffset": 64, "byteLength": 12},
    ]
    document["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 3},
    }
    data = BINARY + b"\2\0\0\0" + np.array([7, 8, 9], "<f4").tobytes()
    mesh = read_mesh_bytes(glb(document, data))
    assert mesh.vertices[2].tolist() == [7, 8, 9]
    assert np.array_equal(mesh.vertices[[0, 1, 3]], CORNER[[0, 1, 3]])


def broken(**changes: Any) -> bytes:
    document = scene()
    for path, value in changes.items():
        *parents, last = path.split("__")
        place: Any = document
        for key in parents:
            place = place[int(key)] if key.isdecimal() else place[key]
        place[int(last) if last.isdecimal() else last] = value
    return glb(document, BINARY)


@pytest.mark.parametrize(
    ("data", "code", "message"),
    [
        (broken(extensionsRequired=["KHR_draco_mesh_compression"]), "unsupported_format", "compressed with Draco"),
        (
            broken(meshes__0__primitives__0__extensions={"KHR_draco_mesh_compression": {}}),
            "unsupported_format",
            "Draco",
        ),
        (broken(bufferViews__0__extensions={"EXT_meshopt_compression": {}}), "unsupported_format", "meshopt"),
        (broken(extensionsRequired=["ACME_secret"]), "unsupported_format", "extension 'ACME_secret'"),
        (broken(nodes__0__skin=0), "unsupported_format", "skeleton"),
        (broken(buffers__0__uri="data.bin"), "unsupported_format", "elsewhere"),
        (broken(nodes__0__children=[0]), "corrupt_file", "below itself"),
        (broken(nodes__0__children=[5]), "corrupt_file", "entry 5 of a list of 1"),
        (broken(nodes__0__mesh=3), "corrupt_file", "entry 3 of a list of 1"),
        (broken(nodes__0__scale=[1, 2]), "corrupt_file", "describes its meshes wrongly"),
        (broken(nodes__0__scale=[1, 2, float("nan")]), "corrupt_file", "not finite"),
        (broken(accessors__0__count=5), "corrupt_file", "needs 60 bytes of data|needs .* bytes of data"),
        (broken(accessors__0__type="VEC2"), "corrupt_file", "'VEC2' in place of VEC3"),
        (broken(accessors__1__componentType=5126), "corrupt_file", "no whole numbers"),
        (broken(accessors__1__count=-1), "corrupt_file", "."),
        (broken(bufferViews__1__byteOffset=58), "corrupt_file", "bytes of data"),
        (broken(bufferViews__0__byteOffset=-4), "corrupt_file", "senseless"),
        (broken(bufferViews__0__byteStride=4), "corrupt_file", "senseless"),
        (broken(meshes=[]), "corrupt_file", "entry 0 of a list of 0"),
        (broken(nodes=[{}]), "empty_content", "neither points nor faces"),
        (broken(meshes__0__primitives__0__mode=0), "empty_content", "neither points nor faces"),
        (broken(accessors__0__count=3), "invalid_mesh", "names vertex 3, and has 3 vertices"),
        (glb(scene(), BINARY)[:-4], "corrupt_file", "has"),
        (b"glTF" + struct.pack("<2L", 1, 100) + b"\0" * 100, "unsupported_format", "version 1"),
        (glb(scene(), BINARY).replace(b"JSON", b"NOSJ"), "corrupt_file", "JSON"),
        (glb(scene(), BINARY).replace(b'{"asset"', b'{[asset"'), "corrupt_file", "damaged"),
        (glb(scene(), CORNER.tobytes()[:12] + struct.pack("<f", np.inf) + BINARY[16:]), "invalid_mesh", "vertex 1"),
    ],
)
def test_refusals(data: bytes, code: str, message: str) -> None:
    refused(data, code, message)


def test_instances_count_against_the_limits() -> None:
    nodes = [{"children": list(range(1, 101))}] + [{"mesh": 0}] * 100
    data = glb(scene(nodes=nodes), BINARY)
    assert len(read_mesh_bytes(data).faces) == 400
    refused(data, "too_large", "faces; at most 399", limits=MeshLimits(faces=399))
    refused(data, "too_large", "vertices; at most 399", limits=MeshLimits(vertices=399))


# writing ----------------------------------------------------------------------------------------------------------


def parsed(path: Path) -> tuple[dict[str, Any], bytes]:
    data = path.read_bytes()
    length = struct.unpack_from("<L", data, 12)[0]
    assert struct.unpack_from("<L", data, 8)[0] == len(data)
    assert len(data) % 4 == 0
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def test_a_scene_is_read_back_in_the_same_place(tmp_path: Path) -> None:
    path = tmp_path / "scene.glb"
    one, two = icosphere((10, -20, 30), 5, 1), icosphere((-40, 0, 7), 3, 0)
    write_scene_glb([("tumor", one, (1, 0.5, 0, 1)), ("vessel", two, (0, 0, 1, 0.25))], path)
    mesh = read_mesh(path)
    expected = np.concatenate((one.vertices, two.vertices)).astype(np.float32)
    assert np.array_equal(mesh.vertices, expected)
    assert np.array_equal(mesh.faces, np.concatenate((one.faces, two.faces + len(one.vertices))))
    first = path.read_bytes()
    write_scene_glb([("tumor", one, (1, 0.5, 0, 1)), ("vessel", two, (0, 0, 1, 0.25))], path)
    assert path.read_bytes() == first


def test_names_colours_and_the_frame(tmp_path: Path) -> None:
    path = tmp_path / "scene.glb"
    write_scene_glb([("tümor", icosphere(), (1, 0.5, 0, 1)), ("vessel", icosphere(), (0, 0, 1, 0.25))], path)
    document, binary = parsed(path)
    assert [node["name"] for node in document["nodes"]] == ["RAS_mm", "tümor", "vessel"]
    assert document["nodes"][0]["extras"] == {"frame": "RAS", "unit": "mm"}
    assert document["nodes"][0]["children"] == [1, 2]
    # the top of the head (RAS +z) is up (glTF +y), the nose (+y) looks away from the viewer (−z), in metres
    matrix = np.array(document["nodes"][0]["matrix"]).reshape(4, 4).T
    assert (matrix @ [0, 0, 1000, 1]).tolist() == [0, 1, 0, 1]
    assert (matrix @ [0, 1000, 0, 1]).tolist() == [0, 0, -1, 1]
    assert (matrix @ [1000, 0, 0, 1]).tolist() == [1, 0, 0, 1]
    opaque, glass = (m["pbrMetallicRoughness"]["baseColorFactor"] for m in document["materials"])
    assert opaque == pytest.approx([1, 0.214041, 0, 1], abs=1e-6)
    assert glass == [0, 0, 1, 0.25]
    assert "alphaMode" not in document["materials"][0]
    assert document["materials"][1]["alphaMode"] == "BLEND"
    # what the specification demands of every file
    assert document["buffers"] == [{"byteLength": len(binary)}]
    for view in document["bufferViews"]:
        assert view["byteOffset"] % 4 == 0
        assert view["byteOffset"] + view["byteLength"] <= len(binary)
    for mesh in document["meshes"]:
        attributes = mesh["primitives"][0]["attributes"]
        position, normal = (document["accessors"][attributes[name]] for name in ("POSITION", "NORMAL"))
        assert position["min"] == pytest.approx([-1, -1, -1], abs=0.01)
        assert position["max"] == pytest.approx([1, 1, 1], abs=0.01)
        view = document["bufferViews"][normal["bufferView"]]
        normals = np.frombuffer(binary, "<f4", 3 * normal["count"], view["byteOffset"]).reshape(-1, 3)
        assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(len(normals)), abs=1e-6)


def test_another_reader_sees_the_scene_upright_and_in_metres(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / "scene.glb"
    write_scene_glb([("a", icosphere((10, 20, 30), 5, 2), (1, 1, 1, 1))], path)
    loaded = trimesh.load(path, force="scene").to_geometry()
    assert loaded.bounds == pytest.approx(np.array([[5, 25, -25], [15, 35, -15]]) / 1000, abs=1e-6)


def test_empty_meshes_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "scene.glb"
    nothing = TriangleMesh([], [])
    write_scene_glb([("nothing", nothing, (1, 1, 1, 1)), ("something", icosphere(), (1, 1, 1, 1))], path)
    assert len(parsed(path)[0]["meshes"]) == 1
    write_scene_glb([("nothing", nothing, (1, 1, 1, 1))], path)
    refused(path.read_bytes(), "empty_content", "neither points nor faces")


@pytest.mark.parametrize("colour", [(1, 1, 1), (0, 0, 0, 2), (-0.1, 0, 0, 1), (float("nan"), 0, 0, 1)])
def test_colours_are_checked(colour: Any, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="four numbers"):
        write_scene_glb([("a", icosphere(), colour)], tmp_path / "scene.glb")

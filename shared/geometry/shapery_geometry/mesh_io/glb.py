"""GLB, the binary form of glTF 2.0.

Reading joins the meshes of all nodes of the scene into one, each moved by its node. Writing makes a scene of named
meshes with colours.

The frame: glTF has +Y up and metres, Shapery has RAS millimetres (+Z up). A scene written here keeps RAS millimetres
in its meshes, below one node called ``RAS_mm`` whose matrix turns and scales them to glTF's frame (x, y, z) →
(x, z, −y) / 1000, so that any viewer shows them upright and in their true size. The node carries
``"extras": {"frame": "RAS", "unit": "mm"}``; this reader leaves out the matrix of such a node and of those above it, so
that what was written is read back in the same place.

References
----------
Khronos Group, glTF 2.0 Specification, version 2.0.1 (ISO/IEC 12113:2022).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.formats.model import corrupt
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io.gltf_scene import GltfScene
from shapery_geometry.mesh_io.limits import MeshLimits, no_faces
from shapery_geometry.mesh_io.polygons import PolygonMesh

_MAGIC, _JSON, _BINARY = b"glTF", b"JSON", b"BIN\0"
_MOST_JSON: Final = 64 << 20
_TO_GLTF: Final = [0.001, 0, 0, 0, 0, 0, -0.001, 0, 0, 0.001, 0, 0, 0, 0, 0, 1]
"""Column by column, as glTF wants it."""

Colour = tuple[float, float, float, float]


def read_glb(stream: BinaryIO, size: int, limits: MeshLimits) -> PolygonMesh:
    """Read a GLB file of `size` bytes; see `shapery_geometry.mesh_io.read_mesh`.

    The vertices are those of each node's primitives one after another, in the order of the scene; primitives of one
    mesh that share their positions share the vertices too.
    """
    document, binary = _chunks(stream, size)
    scene = GltfScene(document, binary, limits)
    points, triangles = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)]
    total = 0
    for part in scene.parts():
        points.append(part.vertices)
        triangles.append(part.triangles + total)
        total += len(part.vertices)
    faces = np.concatenate(triangles)
    if not len(faces):
        raise no_faces("GLB", total)
    return PolygonMesh.of_triangles(np.concatenate(points), faces)


def _chunks(stream: BinaryIO, size: int) -> tuple[dict[str, Any], bytes]:
    header = stream.read(12)
    if len(header) < 12 or header[:4] != _MAGIC:
        raise corrupt("The GLB file does not begin as such.")
    version, length = struct.unpack_from("<2L", header, 4)
    if version != 2 or not 20 <= length <= size:
        raise corrupt(f"The GLB file of version {version} should have {length} bytes and has {size}.", "Send it again.")
    chunks: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= length:
        chunk_length, chunk_type = struct.unpack("<L4s", stream.read(8))
        at += 8 + chunk_length
        if at > length or (chunk_type == _JSON and chunk_length > _MOST_JSON):
            raise corrupt(f"A part of the GLB file claims {chunk_length} bytes and does not fit.", "Send it again.")
        data = stream.read(chunk_length)
        # unknown parts are to be passed over; of the known ones the first counts
        if chunk_type in (_JSON, _BINARY):
            chunks.setdefault(chunk_type, data)
    if _JSON not in chunks:
        raise corrupt("The GLB file has no JSON.")
    try:
        document = json.loads(chunks[_JSON])
    except (ValueError, RecursionError) as error:
        raise corrupt("The JSON of the GLB file is damaged.") from error
    if not isinstance(document, dict):
        raise corrupt("The JSON of the GLB file describes no scene.")
    return document, chunks.get(_BINARY, b"")


def write_scene_glb(meshes: Sequence[tuple[str, TriangleMesh, Colour]], path: Path | str) -> None:
    """Write named meshes with colours as one scene.

    Parameters
    ----------
    meshes
        For each its name, the mesh in RAS mm, and its colour: red, green, blue as on the screen (sRGB) and opacity,
        each in [0, 1]. Meshes without faces are left out, because glTF cannot hold them.
    path
        File to write; the same meshes give the same bytes. Positions are stored in single precision.

    Raises
    ------
    ValueError
        For a colour out of range.
    """
    binary = bytearray()
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []

    def accessor(values: NDArray[Any], target: int, kind: str, component: int, **more: Any) -> int:
        data = values.tobytes()
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), "target": target})
        binary.extend(data + b"\0" * (-len(data) % 4))
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": component, "count": len(values), "type": kind, **more}
        )
        return len(accessors) - 1

    nodes: list[dict[str, Any]] = []
    gltf_meshes: list[dict[str, Any]] = []
    materials: list[dict[str, Any]] = []
    for name, mesh, colour in meshes:
        if len(colour) != 4 or not all(0 <= value <= 1 for value in colour):
            raise ValueError(f"a colour is four numbers in [0, 1], not {colour}")
        if not len(mesh.faces):
            continue
        points = mesh.vertices.astype("<f4")
        low, high = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        normals = mesh.vertex_normals.astype("<f4")
        # glTF wants unit normals everywhere, and a vertex without faces has none
        normals[~mesh.vertex_normals.any(axis=1)] = (0, 0, 1)
        attributes = {
            "POSITION": accessor(points, 34962, "VEC3", 5126, min=low, max=high),
            "NORMAL": accessor(normals, 34962, "VEC3", 5126),
        }
        indices = accessor(mesh.faces.astype("<u4").reshape(-1), 34963, "SCALAR", 5125)
        materials.append(_material(name, colour))
        primitive = {"attributes": attributes, "indices": indices, "material": len(materials) - 1, "mode": 4}
        gltf_meshes.append({"name": name, "primitives": [primitive]})
        nodes.append({"name": name, "mesh": len(gltf_meshes) - 1})
    document: dict[str, Any] = {"asset": {"version": "2.0", "generator": "Shapery"}, "scene": 0}
    frame: dict[str, Any] = {"name": "RAS_mm", "matrix": _TO_GLTF, "extras": {"frame": "RAS", "unit": "mm"}}
    if nodes:
        frame["children"] = list(range(1, len(nodes) + 1))
        document |= {"meshes": gltf_meshes, "materials": materials, "accessors": accessors, "bufferViews": views}
        document["buffers"] = [{"byteLength": len(binary)}]
    document |= {"scenes": [{"nodes": [0]}], "nodes": [frame, *nodes]}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<L4s", len(text), _JSON) + text
    if binary:
        parts += struct.pack("<L4s", len(binary), _BINARY) + bytes(binary)
    Path(path).write_bytes(struct.pack("<4s2L", _MAGIC, 2, 12 + len(parts)) + parts)


def _material(name: str, colour: Colour) -> dict[str, Any]:
    *srgb, opacity = (float(value) for value in colour)
    # glTF's colours are linear light (IEC 61966-2-1)
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in srgb]
    material: dict[str, Any] = {
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*(round(c, 6) for c in linear), opacity],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.8,
        },
        "doubleSided": True,
    }
    if opacity < 1:
        material["alphaMode"] = "BLEND"
    return material

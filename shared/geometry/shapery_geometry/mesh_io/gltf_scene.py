"""The meshes of a glTF scene: nodes with their transformations, primitives, and accessors into binary data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput, UserError
from shapery_contracts.formats.model import corrupt, unsupported
from shapery_geometry.mesh_io.limits import MeshLimits

_COMPONENTS: Final = MappingProxyType({5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"})
_WIDTHS: Final = MappingProxyType({"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16})
_COMPRESSED: Final = MappingProxyType(
    {
        "KHR_draco_mesh_compression": "Draco",
        "EXT_meshopt_compression": "meshopt",
        "KHR_meshopt_compression": "meshopt",
        "MESHOPT_compression": "meshopt",
    }
)
_HARMLESS: Final = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_xmp", "KHR_animation_")
"""Required extensions that change no shape begin like this."""
_DEEPEST: Final = 200


@dataclass(frozen=True, slots=True)
class Part:
    """What one node of the scene shows, in the scene's frame."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]


class GltfScene:
    """A parsed document with its binary data.

    Parameters
    ----------
    document
        The JSON, of which nothing is trusted.
    binary
        The binary chunk; other buffers are refused.
    limits
        Checked before anything is unpacked.
    """

    def __init__(self, document: dict[str, Any], binary: bytes, limits: MeshLimits) -> None:
        self._document = document
        self._binary = binary
        self._limits = limits
        self._vertices = 0
        self._faces = 0

    def parts(self) -> Iterator[Part]:
        """Yield what each node with a mesh shows, depth first in the order of the scene.

        Raises
        ------
        InvalidInput
            ``unsupported_format`` for compressed, skinned or external data, ``corrupt_file`` for what contradicts
            itself, ``invalid_mesh`` for indices out of range.
        """
        try:
            self._check_extensions()
            yield from self._walk()
        except UserError:
            raise
        except (KeyError, IndexError, TypeError, AttributeError, ValueError, OverflowError) as error:
            raise corrupt("The JSON of the GLB file describes its meshes wrongly.") from error

    def _check_extensions(self) -> None:
        for name in self._document.get("extensionsRequired", []):
            if name in _COMPRESSED:
                raise _compressed(_COMPRESSED[name])
            if name != "KHR_mesh_quantization" and not str(name).startswith(_HARMLESS):
                raise unsupported(
                    f"The GLB file needs the extension {str(name)[:60]!r}, which is not known here.",
                    "Export it without.",
                )

    def _roots(self) -> list[int]:
        nodes = self._document.get("nodes", [])
        scenes = self._document.get("scenes")
        if scenes:
            return list(_item(scenes, self._document.get("scene", 0)).get("nodes", []))
        children = {child for node in nodes for child in node.get("children", [])}
        return [k for k in range(len(nodes)) if k not in children]

    def _walk(self) -> Iterator[Part]:
        nodes = self._document.get("nodes", [])
        if not nodes and self._document.get("meshes"):
            # a library of meshes without a scene shows each once
            for k in range(len(self._document["meshes"])):
                yield from self._mesh(k, np.eye(4))
            return
        waiting = [(index, np.eye(4), 0) for index in reversed(self._roots())]
        seen: set[int] = set()
        while waiting:
            index, above, depth = waiting.pop()
            node = _item(nodes, index)
            if index in seen or depth > _DEEPEST:
                raise corrupt(f"Node {index} of the GLB file stands below itself, or in two places.")
            seen.add(index)
            extras = node.get("extras")
            ours = isinstance(extras, dict) and extras.get("frame") == "RAS" and extras.get("unit") == "mm"
            matrix = np.eye(4) if ours else above @ _matrix(node)
            if "mesh" in node:
                if "skin" in node:
                    raise unsupported(
                        "The GLB file bends its mesh by a skeleton (a skin).", "Apply the pose before you export it."
                    )
                yield from self._mesh(node["mesh"], matrix)
            waiting += [(child, matrix, depth + 1) for child in reversed(node.get("children", []))]

    def _mesh(self, index: int, matrix: NDArray[np.float64]) -> Iterator[Part]:
        by_position: dict[int, list[dict[str, Any]]] = {}
        for primitive in _item(self._document["meshes"], index)["primitives"]:
            for name in primitive.get("extensions", {}):
                if name in _COMPRESSED:
                    raise _compressed(_COMPRESSED[name])
            if primitive.get("mode", 4) in (4, 5, 6):
                by_position.setdefault(primitive["attributes"]["POSITION"], []).append(primitive)
        for position, primitives in by_position.items():
            count = self._count(position)
            self._vertices += count
            self._limits.check(self._vertices)
            # a signalling NaN is reported when the mesh is made
            with np.errstate(invalid="ignore"):
                points = self._accessor(position, "VEC3").astype(np.float64)
            triangles = []
            for primitive in primitives:
                corners = self._count(primitive["indices"]) if "indices" in primitive else count
                mode = primitive.get("mode", 4)
                self._faces += corners // 3 if mode == 4 else max(corners - 2, 0)
                self._limits.check(faces=self._faces)
                order = (
                    self._accessor(primitive["indices"], "SCALAR").reshape(-1).astype(np.int64)
                    if "indices" in primitive
                    else np.arange(count)
                )
                triangles.append(_triangles(order, mode))
            faces = np.concatenate(triangles)
            if len(faces) and (faces.min() < 0 or faces.max() >= count):
                raise InvalidInput(
                    "invalid_mesh",
                    f"A mesh of the GLB file names vertex {int(faces.max())}, and has {count} vertices.",
                    "Check the file with the program that wrote it, and send it again.",
                )
            with np.errstate(all="ignore"):
                moved = points @ matrix[:3, :3].T + matrix[:3, 3]
                mirrored = np.linalg.det(matrix[:3, :3]) < 0
            if mirrored:
                # a mirror image has its inside out
                faces = faces[:, ::-1]
            yield Part(moved, faces)

    def _count(self, index: int) -> int:
        count = _item(self._document["accessors"], index)["count"]
        if type(count) is not int or count < 0:
            raise corrupt("An accessor of the GLB file has no count.")
        return count

    def _accessor(self, index: int, kind: str) -> NDArray[Any]:
        accessor = _item(self._document["accessors"], index)
        if accessor["type"] != kind:
            raise corrupt(f"An accessor of the GLB file holds {str(accessor['type'])[:20]!r} in place of {kind}.")
        count, component = self._count(index), accessor["componentType"]
        if kind == "SCALAR" and component not in (5121, 5123, 5125):
            raise corrupt("The indices of a mesh in the GLB file are no whole numbers.")
        width = _WIDTHS[kind]
        if "bufferView" in accessor:
            values = self._view(accessor["bufferView"], accessor.get("byteOffset", 0), component, count, width)
        else:
            values = np.zeros((count, width), dtype=_COMPONENTS[component])
        if "sparse" in accessor:
            values = self._with_sparse(values, accessor["sparse"], component, width)
        if accessor.get("normalized") and values.dtype.kind in "iu":
            return np.maximum(values / float(np.iinfo(values.dtype).max), -1.0)
        return values

    def _with_sparse(self, values: NDArray[Any], sparse: dict[str, Any], component: int, width: int) -> NDArray[Any]:
        where, what = sparse["indices"], sparse["values"]
        count = sparse["count"]
        places = self._view(where["bufferView"], where.get("byteOffset", 0), where["componentType"], count, 1)
        replaced = self._view(what["bufferView"], what.get("byteOffset", 0), component, count, width)
        values = values.copy()
        values[places.reshape(-1)] = replaced
        return values

    def _view(self, index: int, offset: int, component: int, count: int, width: int) -> NDArray[Any]:
        view = _item(self._document["bufferViews"], index)
        if "extensions" in view and any(name in _COMPRESSED for name in view["extensions"]):
            raise _compressed("meshopt")
        buffer = _item(self._document["buffers"], view["buffer"])
        if view["buffer"] != 0 or "uri" in buffer:
            raise unsupported("The GLB file keeps its data elsewhere.", "Export it with everything in one .glb file.")
        dtype = np.dtype(_COMPONENTS[component])
        row = dtype.itemsize * width
        stride = view.get("byteStride", row)
        start, length = view.get("byteOffset", 0), view["byteLength"]
        numbers = (offset, count, stride, start, length)
        if any(type(n) is not int or n < 0 for n in numbers) or stride < row:
            raise corrupt("A view into the data of the GLB file has senseless numbers.")
        needed = offset + (stride * (count - 1) + row if count else 0)
        if needed > length or start + length > len(self._binary):
            raise corrupt(
                f"A mesh of the GLB file needs {start + needed} bytes of data, and there are {len(self._binary)}.",
                "The file is truncated or wrong; send it again.",
            )
        if not count:
            return np.zeros((0, width), dtype=dtype)
        data = np.frombuffer(self._binary, dtype=np.uint8, count=needed - offset, offset=start + offset)
        rows = np.lib.stride_tricks.as_strided(data, (count, row), (stride, 1), writeable=False)
        return np.ascontiguousarray(rows).view(dtype)


def _item(items: list[Any], index: int) -> Any:
    if type(index) is not int or not 0 <= index < len(items):
        raise corrupt(f"The JSON of the GLB file names entry {str(index)[:20]} of a list of {len(items)}.")
    return items[index]


def _compressed(how: str) -> InvalidInput:
    return unsupported(f"The GLB file is compressed with {how}, which is not read.", "Export it without compression.")


def _matrix(node: dict[str, Any]) -> NDArray[np.float64]:
    if "matrix" in node:
        matrix = np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    else:
        x, y, z, w = (float(v) for v in node.get("rotation", (0, 0, 0, 1)))
        matrix = np.eye(4)
        matrix[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        matrix[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), dtype=np.float64).reshape(3)
        matrix[:3, 3] = np.array(node.get("translation", (0, 0, 0)), dtype=np.float64).reshape(3)
    if not np.isfinite(matrix).all():
        raise corrupt("A node of the GLB file is placed by numbers that are not finite.")
    return matrix


def _triangles(order: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    """Triangles of a list (mode 4), a strip (5) or a fan (6)."""
    if mode == 4:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    count = max(len(order) - 2, 0)
    k = np.arange(count)
    if mode == 6:
        return np.stack((order[k + 1], order[k + 2], np.full(count, order[0] if count else 0)), axis=1)
    odd = k % 2
    triangles = np.stack((order[k], order[k + 1 + odd], order[k + 2 - odd]), axis=1)
    a, b, c = triangles.T
    # triangles that name a vertex twice only join strips
    return np.asarray(triangles[(a != b) & (b != c) & (c != a)])

"""The one door to all mesh readers: a file in, a mesh out."""

from __future__ import annotations

import io
from pathlib import Path
from typing import BinaryIO

from shapery_contracts.errors import InvalidInput, LimitExceeded
from shapery_contracts.formats import AssetKind, FileFormat, sniff
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io.glb import read_glb
from shapery_geometry.mesh_io.limits import MeshLimits
from shapery_geometry.mesh_io.obj import read_obj
from shapery_geometry.mesh_io.off import read_off
from shapery_geometry.mesh_io.ply import read_ply
from shapery_geometry.mesh_io.polygons import PolygonMesh
from shapery_geometry.mesh_io.stl import read_stl


def read_mesh(path: Path | str, *, limits: MeshLimits | None = None, weld_stl: bool = True) -> TriangleMesh:
    """Read a triangle mesh; the format is told from the content.

    Parameters
    ----------
    path
        OBJ, PLY (plain or binary), STL (plain or binary), OFF or GLB.
    limits
        By default `MeshLimits()`. Counts that stand in a header are checked before anything is loaded.
    weld_stl
        Whether corners of an STL at exactly the same place become one vertex. In all other formats vertices keep the
        number and order that they have in the file, whether they coincide or not.

    Returns
    -------
    TriangleMesh
        In the frame and the unit of the file. Polygons are cut into triangles over their own vertices.

    Raises
    ------
    InvalidInput
        ``wrong_input_kind`` for what is no single mesh, ``empty_content`` where there is no face (a point cloud),
        ``corrupt_file``, ``unsupported_format``, ``unknown_format``, or ``invalid_mesh`` for coordinates that are not
        finite and indices out of range.
    LimitExceeded
        ``too_large``.
    """
    path = Path(path)
    if path.is_dir():
        raise InvalidInput("wrong_input_kind", "A folder was given where a mesh is needed.", "Give one mesh file.")
    with path.open("rb") as stream:
        return _read(stream, path.stat().st_size, limits or MeshLimits(), weld_stl)


def read_mesh_bytes(data: bytes, *, limits: MeshLimits | None = None, weld_stl: bool = True) -> TriangleMesh:
    """Read a triangle mesh from the bytes of a file; see `read_mesh`."""
    return _read(io.BytesIO(data), len(data), limits or MeshLimits(), weld_stl)


def _read(stream: BinaryIO, size: int, limits: MeshLimits, weld_stl: bool) -> TriangleMesh:
    return read_polygons(stream, size, limits, weld_stl=weld_stl)[0].triangulated(limits)


def read_polygons(
    stream: BinaryIO, size: int, limits: MeshLimits, *, weld_stl: bool = True
) -> tuple[PolygonMesh, FileFormat]:
    """Read a mesh whose polygons are not cut yet, and tell its format; otherwise like `read_mesh`."""
    found = sniff(stream, size)
    if found.kind is not AssetKind.MESH:
        raise InvalidInput(
            "wrong_input_kind",
            f"The file is a {found.kind} ({found.format}), not a mesh.",
            "Give a mesh as OBJ, PLY, STL, OFF or GLB.",
        )
    if size > limits.bytes:
        raise LimitExceeded("too_large", f"The mesh file has {size} bytes; at most {limits.bytes} are allowed.")
    _check_details(found, limits)
    stream.seek(0)
    match found.format:
        case "obj":
            mesh = read_obj(stream, limits)
        case "ply":
            mesh = read_ply(stream, size, limits)
        case "stl":
            mesh = read_stl(stream, size, limits, weld=weld_stl)
        case "off":
            mesh = read_off(stream, size, limits)
        case "glb":
            mesh = read_glb(stream, size, limits)
        case _:
            raise AssertionError(f"no reader for {found.format!r}")
    return mesh, found


def _check_details(found: FileFormat, limits: MeshLimits) -> None:
    counts = {name: value for name in ("vertices", "faces") if isinstance(value := found.details.get(name), int)}
    limits.check(counts.get("vertices", 0), counts.get("faces", 0))

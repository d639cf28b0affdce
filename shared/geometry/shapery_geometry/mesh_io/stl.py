"""STL, plain and binary.

STL has no vertices, only corners. By default corners at exactly the same place become one vertex, numbered by first
occurrence; nothing that lies apart is joined. The normals in the file are passed over: the order of the corners says
which side is out.

References
----------
3D Systems, StereoLithography Interface Specification, 1988.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.formats.model import corrupt
from shapery_geometry.mesh import TriangleMesh, checked_vertices
from shapery_geometry.mesh_io.limits import MeshLimits, no_faces
from shapery_geometry.mesh_io.polygons import PolygonMesh
from shapery_geometry.mesh_io.text import floats, line_batches

_RECORD: Final = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(stream: BinaryIO, size: int, limits: MeshLimits, *, weld: bool = True) -> PolygonMesh:
    """Read an STL file of `size` bytes; see `shapery_geometry.mesh_io.read_mesh`.

    Parameters
    ----------
    weld
        Whether corners at exactly the same place become one vertex. Without it, face k has the vertices 3k to 3k + 2.
    """
    head = stream.read(84)
    count = struct.unpack_from("<L", head, 80)[0] if len(head) == 84 else 0
    if count and size == 84 + 50 * count:
        limits.check(faces=count)
        corners = _binary(stream, count)
    else:
        stream.seek(0)
        corners = _text(stream, limits)
    if not len(corners):
        raise no_faces("STL", 0)
    if not weld:
        return PolygonMesh.of_triangles(corners, np.arange(len(corners), dtype=np.int64).reshape(-1, 3))
    return PolygonMesh.of_triangles(*welded_exactly(checked_vertices(corners)))


def welded_exactly(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the distinct points in the order of their first occurrence, and faces of each three points in a row."""
    # adding zero makes -0.0 and 0.0 the same bytes
    keys = np.ascontiguousarray(points + 0.0).view(np.dtype((np.void, 24))).reshape(-1)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return points[first[order]], rank[inverse.reshape(-1)].reshape(-1, 3)


def _binary(stream: BinaryIO, count: int) -> NDArray[np.float64]:
    data = stream.read(50 * count)
    if len(data) != 50 * count:
        raise corrupt(f"The STL file announces {count} triangles and ends after {len(data) // 50}.")
    records = np.frombuffer(data, dtype=_RECORD)
    # a signalling NaN is reported when the mesh is made
    with np.errstate(invalid="ignore"):
        return records["corners"].reshape(-1, 3).astype(np.float64)


def _text(stream: BinaryIO, limits: MeshLimits) -> NDArray[np.float64]:
    pieces = [np.zeros((0, 3))]
    facets = ends = total = 0
    for lines in line_batches(stream):
        words: list[bytes] = []
        for line in lines:
            lowered = line[:8].lower()
            if lowered.startswith(b"vertex"):
                row = line.split()
                if len(row) != 4:
                    raise corrupt(f"Vertex {total + len(words) // 3} of the STL file has {len(row) - 1} coordinates.")
                words += row[1:]
            elif lowered.startswith(b"facet"):
                if total + len(words) // 3 != 3 * facets or facets != ends:
                    raise _broken(facets)
                facets += 1
            elif lowered == b"endfacet":
                ends += 1
                if total + len(words) // 3 != 3 * facets or facets != ends:
                    raise _broken(facets)
        total += len(words) // 3
        limits.check(faces=facets)
        pieces.append(floats(words, "vertices").reshape(-1, 3))
    if facets != ends or total != 3 * facets:
        raise corrupt(f"The STL file breaks off in facet {facets - 1}.", "The file is truncated; send it again.")
    return np.concatenate(pieces)


def _broken(facets: int) -> Exception:
    return corrupt(f"Facet {max(facets - 1, 0)} of the STL file has more or fewer than 3 vertices.")


def write_stl(mesh: TriangleMesh, path: Path | str) -> None:
    """Write a binary STL: single precision, no indices."""
    records = np.zeros(len(mesh.faces), dtype=_RECORD)
    records["normal"] = mesh.face_normals
    records["corners"] = mesh.corners
    header = b"binary STL, RAS mm or model units".ljust(80, b" ")
    Path(path).write_bytes(header + struct.pack("<L", len(records)) + records.tobytes())

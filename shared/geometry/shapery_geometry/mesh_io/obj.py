"""Wavefront OBJ.

Geometry alone is read: vertices in the order of the file, and of each face corner the first index. Texture coordinates
and normals, which make other readers split vertices, are passed over, and so are lines, points, groups and materials.

References
----------
Wavefront Technologies, Object Files (.obj), Advanced Visualizer manual, appendix B1.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from shapery_contracts.formats.model import corrupt
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io.limits import MeshLimits, no_faces
from shapery_geometry.mesh_io.polygons import PolygonMesh
from shapery_geometry.mesh_io.text import floats, integers, line_batches


def read_obj(stream: BinaryIO, limits: MeshLimits) -> PolygonMesh:
    """Read an OBJ file; see `shapery_geometry.mesh_io.read_mesh`."""
    points = [np.zeros((0, 3))]
    corners = [np.zeros(0, dtype=np.int64)]
    counts = [np.zeros(0, dtype=np.int64)]
    vertex_count = face_count = 0
    for vertex_rows, face_rows, known in _statements(stream):
        vertex_count += len(vertex_rows)
        face_count += len(face_rows)
        limits.check(vertex_count, face_count)
        if min(map(len, vertex_rows), default=3) < 3:
            row = next(row for row in vertex_rows if len(row) < 3)
            raise corrupt(f"A vertex of the OBJ file has {len(row)} coordinates: {_shown(row)!r}.")
        points.append(floats([word for row in vertex_rows for word in row[:3]], "vertices").reshape(-1, 3))
        sizes = np.array([len(row) for row in face_rows], dtype=np.int64)
        indices = integers([word.partition(b"/")[0] for row in face_rows for word in row], "faces")
        if (indices == 0).any():
            raise corrupt("A face of the OBJ file names vertex 0, and OBJ counts from 1.")
        # negative indices count back from the last vertex before the face
        before = np.repeat(np.array(known, dtype=np.int64), sizes)
        if (indices + before < 0).any():
            raise corrupt("A face of the OBJ file counts back beyond the first vertex.")
        corners.append(np.where(indices < 0, indices + before, indices - 1))
        counts.append(sizes)
    vertices = np.concatenate(points)
    if not face_count:
        raise no_faces("OBJ", vertex_count)
    return PolygonMesh(vertices, np.concatenate(corners), np.concatenate(counts))


def _statements(stream: BinaryIO) -> Iterator[tuple[list[list[bytes]], list[list[bytes]], list[int]]]:
    """Yield in pieces the words of the vertices, those of the faces, and how many vertices stand before each face."""
    total = 0
    pending = b""
    for lines in line_batches(stream):
        vertices: list[list[bytes]] = []
        faces: list[list[bytes]] = []
        known: list[int] = []
        for line in lines:
            if pending:
                line, pending = pending + line, b""
            if line.endswith(b"\\"):
                # a backslash joins the line with the next
                pending = line[:-1] + b" "
                continue
            if line.startswith(b"v") and line[1:2] in (b"", b" ", b"\t"):
                vertices.append(line[2:].split(b"#", 1)[0].split())
            elif line.startswith(b"f") and (words := line.split(b"#", 1)[0].split())[0] in (b"f", b"fo"):
                faces.append(words[1:])
                known.append(total + len(vertices))
        total += len(vertices)
        yield vertices, faces, known


def _shown(row: list[bytes]) -> str:
    return b" ".join(row)[:40].decode("latin-1")


def write_obj(mesh: TriangleMesh, path: Path | str, *, comment: str = "") -> None:
    """Write vertices, with all their digits, and faces."""
    lines = [f"# {line}" for line in comment.splitlines()]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (mesh.faces.astype(np.int64) + 1).tolist()]
    Path(path).write_bytes("\n".join([*lines, ""]).encode())

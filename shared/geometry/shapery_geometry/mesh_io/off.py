"""The Object File Format of Geomview: OFF and its sisters with colours (C), normals (N) or texture coordinates (ST).

References
----------
Geomview manual, OFF files, http://www.geomview.org/docs/html/OFF.html.
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import BinaryIO

import numpy as np

from shapery_contracts.formats.meshes import OFF_MAGIC
from shapery_contracts.formats.model import check_data_fits, corrupt, unsupported
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io.limits import MeshLimits, no_faces
from shapery_geometry.mesh_io.polygons import PolygonMesh
from shapery_geometry.mesh_io.text import floats, integers, rows_of


def read_off(stream: BinaryIO, size: int, limits: MeshLimits) -> PolygonMesh:
    """Read an OFF file of `size` bytes; see `shapery_geometry.mesh_io.read_mesh`.

    Where each vertex and each face stands on a line of its own, what follows its coordinates or corners there (colours,
    normals, texture coordinates) is passed over.
    """
    rows = rows_of(stream, b"#")
    words = next(rows, [])
    match = OFF_MAGIC.match(words[0].decode("latin-1").removeprefix("\u00ef\u00bb\u00bf")) if words else None
    if match is None:
        raise corrupt("The file does not begin with OFF.")
    if match.group(4) or match.group(5):
        raise unsupported("The OFF file has vertices of more or fewer than 3 dimensions.", "Write it as plain OFF.")
    header = words[1:]
    if header and header[0].upper() == b"BINARY":
        raise unsupported("The OFF file is binary.", "Write it as plain text, or as PLY.")
    while len(header) < 2 and (row := next(rows, None)) is not None:
        header += row
    if len(header) < 2:
        raise corrupt("The OFF file ends before its counts.")
    vertex_count, face_count = (int(n) for n in integers(header[:2], "counts"))
    if vertex_count < 0 or face_count < 0:
        raise corrupt(f"The OFF file gives its counts as {vertex_count} and {face_count}.")
    limits.check(vertex_count, face_count)
    if not face_count:
        raise no_faces("OFF", vertex_count)
    # "0 0 0" and "1 0", each with the end of its line
    check_data_fits("OFF", 6 * vertex_count + 4 * face_count - 1, size)
    vertex_rows = list(islice(rows, vertex_count))
    if vertex_rows and len(vertex_rows[0]) < 3:
        return _flowing([*vertex_rows, *rows], vertex_count, face_count)
    face_rows = list(islice(rows, face_count))
    if len(vertex_rows) + len(face_rows) < vertex_count + face_count:
        raise corrupt(
            f"The OFF file should have {vertex_count} vertices and {face_count} faces on a line each, "
            f"and has {len(vertex_rows) + len(face_rows)} lines.",
            "The file is truncated or its header is wrong; send it again.",
        )
    if len(face_rows[0]) <= integers(face_rows[0][:1], "faces")[0]:
        return _flowing([*(row[:3] for row in vertex_rows), *face_rows, *rows], vertex_count, face_count)
    for number, row in enumerate(vertex_rows):
        if len(row) < 3:
            raise corrupt(f"Vertex {number} of the OFF file has {len(row)} coordinates.")
    vertices = floats([word for row in vertex_rows for word in row[:3]], "vertices").reshape(-1, 3)
    counts = integers([row[0] for row in face_rows], "faces")
    for number, (row, count) in enumerate(zip(face_rows, counts.tolist(), strict=True)):
        if not 0 <= count < len(row):
            raise corrupt(f"Face {number} of the OFF file should have {count} corners, and has {len(row) - 1}.")
    corners = [word for row, count in zip(face_rows, counts.tolist(), strict=True) for word in row[1 : 1 + count]]
    return PolygonMesh(vertices, integers(corners, "faces"), counts)


def _flowing(rows: list[list[bytes]], vertex_count: int, face_count: int) -> PolygonMesh:
    """Read vertices and faces whose numbers run on over lines; then nothing else may stand between them."""
    words = [word for row in rows for word in row]
    vertices = floats(words[: 3 * vertex_count], "vertices")
    numbers = integers(words[3 * vertex_count :], "faces").tolist()
    corners: list[int] = []
    counts: list[int] = []
    at = 0
    while len(counts) < face_count and at < len(numbers) and numbers[at] > 0:
        counts.append(numbers[at])
        corners += numbers[at + 1 : at + 1 + numbers[at]]
        at += 1 + numbers[at]
    if len(counts) < face_count or at != len(numbers):
        raise corrupt(
            f"The OFF file should have {vertex_count} vertices and {face_count} faces; "
            f"its {len(words)} numbers do not add up to that.",
            "The file is truncated or its header is wrong; send it again.",
        )
    return PolygonMesh(vertices.reshape(-1, 3), np.array(corners, dtype=np.int64), np.array(counts, dtype=np.int64))


def write_off(mesh: TriangleMesh, path: Path | str) -> None:
    """Write vertices, with all their digits, and faces."""
    lines = ["OFF", f"{len(mesh.vertices)} {len(mesh.faces)} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]
    Path(path).write_bytes("\n".join([*lines, ""]).encode())

"""PLY, the Stanford polygon format: plain text and binary of either byte order, polygons and triangle strips.

References
----------
G. Turk, The PLY Polygon File Format, 1994 (in the documentation of the Stanford 3D Scanning Repository).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.formats.model import corrupt, unsupported
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io.limits import MeshLimits, no_faces
from shapery_geometry.mesh_io.polygons import PolygonMesh, check_range
from shapery_geometry.mesh_io.text import floats, rows_of

TYPES: Final = MappingProxyType(
    {
        **dict.fromkeys(("char", "int8"), "i1"),
        **dict.fromkeys(("uchar", "uint8"), "u1"),
        **dict.fromkeys(("short", "int16"), "i2"),
        **dict.fromkeys(("ushort", "uint16"), "u2"),
        **dict.fromkeys(("int", "int32"), "i4"),
        **dict.fromkeys(("uint", "uint32"), "u4"),
        **dict.fromkeys(("float", "float32"), "f4"),
        **dict.fromkeys(("double", "float64"), "f8"),
    }
)
_HEADER_BYTES: Final = 1 << 16
_INDEX_NAMES: Final = ("vertex_indices", "vertex_index")
_TRUNCATED: Final = "The file is truncated or its header is wrong; send it again."


@dataclass(frozen=True, slots=True)
class _Property:
    name: str
    type: str
    count_type: str = ""
    """Type of a list's length; empty for a scalar."""


@dataclass(slots=True)
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)

    def index(self, names: Sequence[str], *, is_list: bool) -> int:
        for k, p in enumerate(self.properties):
            if p.name in names and bool(p.count_type) is is_list:
                return k
        wanted = " or ".join(names)
        raise corrupt(f"The PLY file's element {self.name!r} has no {'list' if is_list else 'number'} called {wanted}.")


def read_ply(stream: BinaryIO, size: int, limits: MeshLimits) -> PolygonMesh:
    """Read a PLY file of `size` bytes; see `shapery_geometry.mesh_io.read_mesh`.

    Of triangle strips the triangles that name a vertex twice, which only join strips, are left out.
    """
    encoding, elements, data_start = _header(stream)
    named = {element.name: element for element in elements}
    if len(named) < len(elements):
        raise corrupt("The header of the PLY file names an element twice.")
    vertex = named.get("vertex")
    faces = named.get("face")
    strips = named.get("tristrips")
    if vertex is None:
        raise corrupt("The header of the PLY file names no vertices.")
    limits.check(vertex.count, faces.count if faces else 0)
    if not any(element is not None and element.count for element in (faces, strips)):
        raise no_faces("PLY", vertex.count)
    stream.seek(data_start)
    reader: _TextReader | _BinaryReader = (
        _TextReader(stream)
        if encoding == "ascii"
        else _BinaryReader(stream.read(size), encoding.endswith("big_endian"))
    )
    vertices = np.zeros((0, 3))
    polygons = strip_lists = (np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    for element in elements:
        if element is vertex:
            columns = [element.index((axis,), is_list=False) for axis in "xyz"]
            vertices = reader.scalars(element, columns)
        elif element is faces and element.count:
            polygons = reader.lists(element, element.index(_INDEX_NAMES, is_list=True))
        elif element is strips and element.count:
            strip_lists = reader.lists(element, element.index(_INDEX_NAMES, is_list=True))
        else:
            reader.skip(element)
    corners, counts = polygons
    if len(strip_lists[0]):
        triangles = _unstripped(*strip_lists, len(vertices))
        corners = np.concatenate((corners, triangles.reshape(-1)))
        counts = np.concatenate((counts, np.full(len(triangles), 3, dtype=np.int64)))
    if not len(counts):
        raise no_faces("PLY", vertex.count)
    return PolygonMesh(vertices, corners, counts)


def _header(stream: BinaryIO) -> tuple[str, list[_Element], int]:
    head = stream.read(_HEADER_BYTES)
    end = re.search(rb"(?:\r\n|\n|\r)end_header[ \t]*(?:\r\n|\n|\r|$)", head)
    if not head.startswith(b"ply") or end is None:
        raise corrupt("The header of the PLY file does not end.")
    encoding = ""
    elements: list[_Element] = []
    for line in re.split(r"\r\n|\n|\r", head[: end.start()].decode("latin-1"))[1:]:
        match line.split():
            case [] | ["comment" | "obj_info", *_]:
                pass
            case ["format", word, *_]:
                encoding = word
            case ["element", name, count] if re.fullmatch(r"[0-9]{1,18}", count):
                elements.append(_Element(name, int(count)))
            case ["property", "list", count_type, type_, name] if elements:
                elements[-1].properties.append(_Property(name, _type(type_), _type(count_type)))
            case ["property", type_, name] if elements:
                elements[-1].properties.append(_Property(name, _type(type_)))
            case _:
                raise corrupt(f"The header of the PLY file has the line {line[:60]!r}, which means nothing there.")
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise unsupported(f"The PLY file is written as {encoding[:40]!r}.", "Write it as plain text or binary PLY.")
    for element in elements:
        for p in element.properties:
            if p.count_type.startswith("f"):
                raise corrupt(f"The PLY file counts the list {p.name[:40]!r} in fractions.")
    return encoding, elements, end.end()


def _type(word: str) -> str:
    try:
        return TYPES[word]
    except KeyError:
        raise unsupported(f"The PLY file has numbers of the unknown type {word[:40]!r}.", "Write it again.") from None


class _TextReader:
    """Elements of a plain-text file in their order, one row a line."""

    def __init__(self, stream: BinaryIO) -> None:
        self._rows = rows_of(stream)

    def _take(self, element: _Element, count: int) -> list[list[bytes]]:
        rows = list(islice(self._rows, count))
        if len(rows) < count:
            raise corrupt(f"The PLY file ends before its {element.count} rows of {element.name!r} do.", _TRUNCATED)
        return rows

    def _pieces(self, element: _Element) -> Any:
        if element.properties:
            for start in range(0, element.count, 1 << 16):
                yield self._take(element, min(1 << 16, element.count - start))

    def skip(self, element: _Element) -> None:
        for _ in self._pieces(element):
            pass

    def scalars(self, element: _Element, columns: list[int]) -> NDArray[np.float64]:
        if any(p.count_type for p in element.properties):
            raise unsupported("The PLY file has lists among its vertices.", "Write it without them.")
        width = len(element.properties)
        pieces = [np.zeros((0, len(columns)))]
        for rows in self._pieces(element):
            for row in rows:
                if len(row) != width:
                    raise corrupt(f"A row of {element.name!r} in the PLY file has {len(row)} numbers, not {width}.")
            words = [row[k] for row in rows for k in columns]
            pieces.append(floats(words, f"numbers of {element.name!r}").reshape(-1, len(columns)))
        return np.concatenate(pieces)

    def lists(self, element: _Element, wanted: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        items, counts = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
        for rows in self._pieces(element):
            chosen = [_list_in_row(row, element, wanted) for row in rows]
            values = floats([word for words in chosen for word in words], f"numbers of {element.name!r}")
            items.append(_whole(values))
            counts.append(np.array([len(words) for words in chosen], dtype=np.int64))
        return np.concatenate(items), np.concatenate(counts)


def _list_in_row(row: list[bytes], element: _Element, wanted: int) -> list[bytes]:
    at = 0
    found: list[bytes] = []
    for k, p in enumerate(element.properties):
        if not p.count_type:
            at += 1
            continue
        word = row[at] if at < len(row) else b""
        if not re.fullmatch(rb"[0-9]{1,9}", word):
            raise corrupt(f"A list in the PLY file begins with {word[:40].decode('latin-1')!r} in place of its length.")
        if k == wanted:
            found = row[at + 1 : at + 1 + int(word)]
        at += 1 + int(word)
    if at != len(row):
        raise corrupt(f"A row of {element.name!r} in the PLY file has {len(row)} numbers, not {at}.", _TRUNCATED)
    return found


class _BinaryReader:
    """Elements of a binary file in their order."""

    def __init__(self, data: bytes, big_endian: bool) -> None:
        self._data = data
        self._at = 0
        self._big = big_endian
        self._order = ">" if big_endian else "<"

    def _table(self, element: _Element, lengths: int = 0) -> NDArray[Any] | None:
        """Return the rows with all lists of one length, as one array; None if the file is too short for it."""
        fields: list[Any] = []
        for k, p in enumerate(element.properties):
            if p.count_type:
                fields += [(f"n{k}", self._order + p.count_type), (f"p{k}", self._order + p.type, (lengths,))]
            else:
                fields.append((f"p{k}", self._order + p.type))
        dtype = np.dtype(fields)
        if dtype.itemsize * element.count > len(self._data) - self._at:
            return None
        return np.frombuffer(self._data, dtype=dtype, count=element.count, offset=self._at)

    def _truncated(self, element: _Element) -> Exception:
        return corrupt(f"The PLY file ends before its {element.count} rows of {element.name!r} do.", _TRUNCATED)

    def skip(self, element: _Element) -> None:
        if not element.properties or not element.count:
            return
        if any(p.count_type for p in element.properties):
            self._walk(element, -1)
            return
        table = self._table(element)
        if table is None:
            raise self._truncated(element)
        self._at += table.nbytes

    def scalars(self, element: _Element, columns: list[int]) -> NDArray[np.float64]:
        if any(p.count_type for p in element.properties):
            raise unsupported("The PLY file has lists among its vertices.", "Write it without them.")
        table = self._table(element)
        if table is None:
            raise self._truncated(element)
        self._at += table.nbytes
        result = np.empty((element.count, len(columns)))
        # a signalling NaN is reported when the mesh is made
        with np.errstate(invalid="ignore"):
            for k, column in enumerate(columns):
                result[:, k] = table[f"p{column}"]
        return result

    def lists(self, element: _Element, wanted: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        listed = [k for k, p in enumerate(element.properties) if p.count_type]
        if listed == [wanted] and (table := self._uniform(element, wanted)) is not None:
            self._at += table.nbytes
            items = _whole(table[f"p{wanted}"])
            return items.reshape(-1), np.full(element.count, items.shape[1], dtype=np.int64)
        positions, counts = self._walk(element, wanted)
        width = np.dtype(element.properties[wanted].type).itemsize
        offsets = np.repeat(positions, counts) + width * (
            np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
        )
        gathered = np.frombuffer(self._data, dtype=np.uint8)[offsets[:, None] + np.arange(width)]
        return _whole(gathered.view(self._order + element.properties[wanted].type).reshape(-1)), counts

    def _uniform(self, element: _Element, wanted: int) -> NDArray[Any] | None:
        """Return the rows as one array if the list has the same length in all of them."""
        fixed = sum(np.dtype(p.type).itemsize for p in element.properties[:wanted])
        count_type = np.dtype(self._order + element.properties[wanted].count_type)
        start = self._at + fixed
        if start + count_type.itemsize > len(self._data):
            return None
        length = int(np.frombuffer(self._data, dtype=count_type, count=1, offset=start)[0])
        if not 0 <= length <= 1 << 20:
            return None
        table = self._table(element, length)
        return table if table is not None and (table[f"n{wanted}"] == length).all() else None

    def _walk(self, element: _Element, wanted: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        # compiled code is loaded for mixed polygons only
        from shapery_geometry.mesh_io._ply_kernels import list_positions

        # each row takes a byte at least, so this bounds what is allocated
        if element.count > len(self._data) - self._at:
            raise self._truncated(element)
        widths = [np.dtype(p.type).itemsize for p in element.properties]
        count_widths = [np.dtype(p.count_type).itemsize if p.count_type else 0 for p in element.properties]
        positions, counts, end = list_positions(
            np.frombuffer(self._data, dtype=np.uint8),
            self._at,
            element.count,
            np.array(widths, dtype=np.int64),
            np.array(count_widths, dtype=np.int64),
            wanted,
            self._big,
        )
        if end == -1:
            raise self._truncated(element)
        if end == -2:
            raise corrupt(f"A list of {element.name!r} in the PLY file has a negative or senseless length.")
        self._at = int(end)
        return positions, counts


def _whole(values: NDArray[Any]) -> NDArray[np.int64]:
    with np.errstate(invalid="ignore"):
        whole = values.dtype.kind != "f" or ((np.abs(values) < 2.0**53) & (values == np.rint(values))).all()
    if not whole:
        raise corrupt("The PLY file names vertices by numbers that are not whole.")
    return values.astype(np.int64)


def _unstripped(items: NDArray[np.int64], counts: NDArray[np.int64], vertex_count: int) -> NDArray[np.int64]:
    """Triangles of strips; −1 begins a new one."""
    named = items != -1
    check_range(items[named], np.ones(int(named.sum()), dtype=np.int64), vertex_count)
    # the end of a list ends its strip too
    flat = np.insert(items, np.cumsum(counts), -1)
    if len(flat) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    windows = np.lib.stride_tricks.sliding_window_view(flat, 3)
    cuts = np.flatnonzero(flat == -1)
    place = np.arange(len(windows))
    begin = np.concatenate(([0], cuts + 1))[np.searchsorted(cuts, place, side="left")]
    # every second triangle of a strip runs the other way round
    turned = (place - begin) % 2 == 1
    triangles = np.where(turned[:, None], windows[:, [1, 0, 2]], windows)[(windows != -1).all(axis=1)]
    a, b, c = triangles.T
    return np.asarray(triangles[(a != b) & (b != c) & (c != a)])


def write_ply(
    mesh: TriangleMesh,
    path: Path | str,
    *,
    comments: Sequence[str] = ("coordinates: RAS, millimetres",),
    single: bool = False,
) -> None:
    """Write a binary little-endian PLY.

    Parameters
    ----------
    mesh
        Its vertices are written with all their digits.
    path
        File to write; the same mesh gives the same bytes.
    comments
        Lines for the header; give others where the coordinates are no millimetres in space.
    single
        Write float32 coordinates, for readers that know no doubles.
    """
    for comment in comments:
        if not re.fullmatch(r"[ -~]*", comment):
            raise ValueError(f"a comment must be one line of plain characters, not {comment!r}")
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {comment}" for comment in comments),
        f"element vertex {len(mesh.vertices)}",
        *(f"property {'float' if single else 'double'} {axis}" for axis in "xyz"),
        f"element face {len(mesh.faces)}",
        "property list uchar int vertex_indices",
        "end_header",
        "",
    ]
    rows = np.empty(len(mesh.faces), dtype=np.dtype([("count", "u1"), ("indices", "<i4", 3)]))
    rows["count"] = 3
    rows["indices"] = mesh.faces
    points = mesh.vertices.astype("<f4" if single else "<f8")
    Path(path).write_bytes("\n".join(header).encode() + points.tobytes() + rows.tobytes())

"""The arrays of a mesh that changes, as the compiled kernels see them.

A *half-edge* is an index ``h = 3·face + corner``: it runs from that corner of the face to the next one. The face on the
other side holds its *twin*, which runs the other way. A closed mesh has no half-edge without a twin, so no operation
has a special case for a border.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

# Columns of `MeshArrays.points`: x, y, z in RAS mm and
SCALE: Final = 3

# Columns of `MeshArrays.vertices`.
OUT: Final = 0
TOUCHED: Final = 1

# Values of ``vertices[:, TOUCHED]``.
UNTOUCHED: Final = 0
RELINKED: Final = 1
CREATED: Final = 2

# Columns of `MeshArrays.half_edges`.
ORIGIN: Final = 0
TWIN: Final = 1

# Columns of `MeshArrays.facets`: centroid, then
RADIUS: Final = 3
NORMAL: Final = 4
AREA: Final = 7
COPIED: Final = 8

# Columns of `MeshArrays.links`, which is the same memory.
AFTER: Final = 8
BEFORE: Final = 9
CELL: Final = 10
SKIP: Final = 11
STAMP: Final = 12
CORNER: Final = 13
RECORD: Final = 16

# Entries of `MeshArrays.layout`.
VERTEX_TOP: Final = 0
FACE_TOP: Final = 1
VERTEX_COUNT: Final = 2
FACE_COUNT: Final = 3
FREE_VERTEX: Final = 4
FREE_FACE: Final = 5
MASK: Final = 6
SHIFT: Final = 9
CARELESS: Final = 11
LAYOUT_ENTRIES: Final = 12

# Entries of `MeshArrays.bound`.
INVERSE_CELL: Final = 0
LARGEST_RADIUS: Final = 1
CLEARANCE: Final = 2
BOUND_ENTRIES: Final = 3

LARGEST_STAR: Final = 24
"""Faces that an operation may put in at once; operations on larger stars are refused."""


class MeshArrays(NamedTuple):
    """Storage with room to grow: ``V`` vertex slots and ``F`` face slots, of which some are free.

    Attributes
    ----------
    points : (V, 4) float64
        Position in RAS mm, and the target edge length there as a share of the mesh's. Every coordinate is a float32
        value, so writing a mesh in single precision loses nothing: the surface that was tested is the one stored.
    vertices : (V, 2) int32
        One half-edge that starts at the vertex, negative in a free slot (``−2 −`` the next free slot); and what
        operations did to it since that was last cleared.
    half_edges : (3F, 2) int32
        Vertex at which it starts, negative in a free face (the first one: ``−2 −`` the next free face); and its twin.
    facets : (F, 16) float32
        Centroid, radius about it, unit normal, area: what a search for contacts reads of a face, in one cache line with
        what `links` holds.
    links : (F, 16) int32
        The same memory. The next and the previous face in the same cell of the grid, and the cell (−1: none); 1 for a
        face that is about to be replaced and is no obstacle; stamp of the batch of moves in which the face last took
        part; its three vertices.
    former : (F, 4) float32
        Unit normal and area of the faces of the current batch of moves, before it.
    head : (C,) int32
        First face of each grid cell; −1 where it is empty.
    layout : (12,) int64
        Slots ever used and slots in use; first free slots; cells along each axis minus one (powers of two), and the
        shifts that combine the first two; 1 while operations are not tested against the faces around them.
    bound : (3,) float64
        1/cell size, largest face radius, clearance that faces without a common vertex keep (mm).
    patch : (24, 16) float64
        Faces that an operation wants to put in: three corners, the unit normal, centroid and radius about it.
    patch_ids : (24, 3) int32
        Their vertices.
    """

    points: Array
    vertices: Array
    half_edges: Array
    facets: Array
    links: Array
    former: Array
    head: Array
    layout: Array
    bound: Array
    patch: Array
    patch_ids: Array


class Cells(NamedTuple):
    """The faces in use, sorted by the cell of the grid that their centroids lie in: what is near lies side by side.

    Attributes
    ----------
    start : (C + 1,) int32
        Where the faces of each cell begin in the next two.
    records : (F, 8) float32
        The first columns of `MeshArrays.facets`, up to date; a face that moved stays in the cell it was sorted into.
    names : (F,) int32
        The faces' numbers.
    place : (F,) int32
        Where each face is in these.
    """

    start: Array
    records: Array
    names: Array
    place: Array


class Moves(NamedTuple):
    """What moved since the surface was last verified, and room for the verification.

    Attributes
    ----------
    old : (V, 3) float64
        Where those vertices were.
    state : (V,) int64
        The batch in which a vertex last moved; minus that where it was put back.
    movers, queue : (V,) int32
        The vertices that moved; those that were put back.
    found : (2, F) int32
        Room for two searches at once.
    wrong : (F, 2) int32
        Pairs of faces that touch; twice the same for one that has turned over.
    stars : (3F,) int32
        Vertices whose faces may touch each other.
    counts : (1,) int64
        Entries of `movers`.
    none : (0,) int8
        No vertices.
    """

    old: Array
    state: Array
    movers: Array
    queue: Array
    found: Array
    wrong: Array
    stars: Array
    counts: Array
    none: Array


def room_for_cells(cells: int, face_slots: int) -> Cells:
    """Return arrays for a grid of so many cells."""
    return Cells(
        start=np.zeros(cells + 1, dtype=np.int32),
        records=np.zeros((face_slots, COPIED), dtype=np.float32),
        names=np.zeros(face_slots, dtype=np.int32),
        place=np.zeros(face_slots, dtype=np.int32),
    )


def room_for_moves(vertex_slots: int, face_slots: int) -> Moves:
    """Return arrays in which nothing has moved."""
    return Moves(
        old=np.zeros((vertex_slots, 3)),
        state=np.zeros(vertex_slots, dtype=np.int64),
        movers=np.zeros(vertex_slots, dtype=np.int32),
        queue=np.zeros(vertex_slots, dtype=np.int32),
        found=np.zeros((2, face_slots), dtype=np.int32),
        wrong=np.zeros((face_slots, 2), dtype=np.int32),
        stars=np.zeros(3 * face_slots, dtype=np.int32),
        counts=np.zeros(1, dtype=np.int64),
        none=np.zeros(0, dtype=np.int8),
    )


def allocate(vertex_slots: int, face_slots: int) -> MeshArrays:
    """Return empty arrays; the grid gets its cells when it is built."""
    record = np.zeros((face_slots, RECORD), dtype=np.float32)
    arrays = MeshArrays(
        points=np.zeros((vertex_slots, 4)),
        vertices=np.full((vertex_slots, 2), -1, dtype=np.int32),
        half_edges=np.full((3 * face_slots, 2), -1, dtype=np.int32),
        facets=record,
        links=record.view(np.int32),
        former=np.zeros((face_slots, 4), dtype=np.float32),
        head=np.full(1, -1, dtype=np.int32),
        layout=np.zeros(LAYOUT_ENTRIES, dtype=np.int64),
        bound=np.ones(BOUND_ENTRIES),
        patch=np.zeros((LARGEST_STAR, 16)),
        patch_ids=np.zeros((LARGEST_STAR, 3), dtype=np.int32),
    )
    arrays.points[:, SCALE] = 1.0
    arrays.vertices[:, TOUCHED] = UNTOUCHED
    arrays.links[:, [AFTER, BEFORE, CELL, CORNER]] = -1
    arrays.layout[FREE_VERTEX] = arrays.layout[FREE_FACE] = -1
    return arrays


def grown(arrays: MeshArrays, vertex_slots: int, face_slots: int) -> MeshArrays:
    """Return larger arrays with the same content; indices keep their meaning."""
    larger = allocate(vertex_slots, face_slots)
    for name in ("points", "vertices", "half_edges", "links"):
        source = getattr(arrays, name)
        getattr(larger, name)[: len(source)] = source
    return larger._replace(head=arrays.head, layout=arrays.layout, bound=arrays.bound)

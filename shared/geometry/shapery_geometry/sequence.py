"""Mesh sequences: one connectivity, many frames.

`open_sequence` reads what all frames share and gives the frames one at a time, so that a sequence never has to fit into
memory; `read_sequence` loads it. A sequence is an npz file with ``vertices`` (frames, n, 3) and ``faces`` (m, 3), or a
folder or zip archive with one mesh per frame.
"""

from __future__ import annotations

import io
import re
import struct
import zipfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapery_contracts.archives import ArchiveLimits, open_archive
from shapery_contracts.errors import InvalidInput, LimitExceeded
from shapery_contracts.formats import AssetKind, sniff
from shapery_contracts.formats.model import corrupt
from shapery_contracts.formats.zipped import MESH_SUFFIXES, NpyHeader, parse_npy_header
from shapery_geometry.mesh import IntArray, TriangleMesh, checked_faces
from shapery_geometry.mesh_io.limits import MeshLimits
from shapery_geometry.mesh_io.polygons import PolygonMesh
from shapery_geometry.mesh_io.reading import read_polygons
from shapery_geometry.mesh_io.stl import welded_exactly
from shapery_geometry.topology import Topology

FrameArray = NDArray[np.float32] | NDArray[np.float64]

_NPY_HEADER: Final = 4096


@dataclass(frozen=True, slots=True)
class SequenceLimits:
    """Bounds that are checked before frames are loaded."""

    frames: int = 100_000
    bytes: int = 8 << 30
    """Of all frames' coordinates as they are stored, and of an archive when it is unpacked."""
    mesh: MeshLimits = field(default_factory=MeshLimits)
    """Of each frame."""

    def check(self, frames: int, vertices: int, item_bytes: int) -> None:
        """Refuse more with ``too_large``."""
        if frames > self.frames:
            raise LimitExceeded("too_large", f"The sequence has {frames} frames; at most {self.frames} are allowed.")
        self.mesh.check(vertices)
        needed = frames * vertices * 3 * item_bytes
        if needed > self.bytes:
            raise LimitExceeded(
                "too_large",
                f"The sequence of {frames} frames with {vertices} vertices takes {needed} bytes; "
                f"at most {self.bytes} are allowed.",
            )


@dataclass(frozen=True, eq=False, init=False)
class MeshSequence:
    """A mesh in motion, in memory.

    Parameters
    ----------
    vertices : (F, n, 3) float32 or float64
        At least one frame. Taken as it is where it is of one of these types (a memory map stays one) and made
        read-only; converted to float64 otherwise.
    faces : (m, 3) int32
        The same in all frames.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where a shape is wrong, a coordinate is not finite or an index is out of range.
    """

    vertices: FrameArray
    faces: IntArray

    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        frames = np.asanyarray(vertices)
        if frames.dtype not in (np.float32, np.float64):
            frames = frames.astype(np.float64)
        if frames.ndim != 3 or frames.shape[2] != 3 or not len(frames):
            raise InvalidInput(
                "invalid_mesh", f"The vertices of a sequence must have the shape (frames, n, 3), not {frames.shape}."
            )
        for number, frame in enumerate(frames):
            _check_finite(frame, number)
        frames = frames.view()
        frames.setflags(write=False)
        object.__setattr__(self, "vertices", frames)
        object.__setattr__(self, "faces", checked_faces(faces, frames.shape[1]))

    def __repr__(self) -> str:
        return f"MeshSequence({len(self)} frames, {self.vertex_count} vertices, {len(self.faces)} faces)"

    def __len__(self) -> int:
        return len(self.vertices)

    def __iter__(self) -> Iterator[TriangleMesh]:
        return map(self.frame, range(len(self)))

    @property
    def vertex_count(self) -> int:
        """Number of vertices of each frame."""
        return int(self.vertices.shape[1])

    @cached_property
    def topology(self) -> Topology:
        """What follows from the faces, shared by all frames."""
        return Topology(self.vertex_count, self.faces)

    def frame(self, index: int) -> TriangleMesh:
        """Return one frame as a mesh; negative indices count from the end."""
        mesh = TriangleMesh(self.vertices[index], self.faces)
        mesh.__dict__["topology"] = self.topology
        return mesh


@dataclass(frozen=True, eq=False)
class SequenceFile:
    """A sequence on disk whose header was read and whose connectivity is known."""

    frame_count: int
    vertex_count: int
    faces: IntArray
    """(m, 3) read-only."""
    dtype: np.dtype[Any]
    """float32 or float64: in what `frames` gives the coordinates."""
    names: tuple[str, ...]
    """The files of the frames in their order; empty where one file holds them all."""
    _frames: Callable[[], Iterator[FrameArray]]
    _mapped: Callable[[], FrameArray | None]

    def frames(self) -> Iterator[FrameArray]:
        """Yield the vertices (n, 3) of each frame, reading one at a time; each call starts anew.

        Raises
        ------
        InvalidInput
            ``inconsistent_sequence`` at the first frame of other connectivity, ``invalid_mesh`` at one with coordinates
            that are not finite, ``corrupt_file`` where the file breaks off.
        """
        for number, frame in enumerate(self._frames()):
            _check_finite(frame, number)
            yield frame

    def load(self) -> MeshSequence:
        """Load all frames; an npz file that is not compressed is mapped into memory and read as it is used."""
        mapped = self._mapped()
        if mapped is not None:
            return MeshSequence(mapped, self.faces)
        vertices = np.empty((self.frame_count, self.vertex_count, 3), dtype=self.dtype)
        for number, frame in enumerate(self.frames()):
            vertices[number] = frame
        return MeshSequence(vertices, self.faces)


def read_sequence(path: Path | str, *, limits: SequenceLimits | None = None) -> MeshSequence:
    """Load a sequence; see `open_sequence`."""
    return open_sequence(path, limits=limits).load()


def open_sequence(path: Path | str, *, limits: SequenceLimits | None = None) -> SequenceFile:
    """Open a sequence for reading.

    Parameters
    ----------
    path
        An npz file with ``vertices`` (frames, n, 3) and ``faces`` (m, 3); or a folder or zip archive with one OBJ, PLY,
        OFF, STL or GLB file per frame, taken in natural order of their names (frame2 before frame10). Other files
        beside the meshes, such as materials, are passed over. Polygons are cut in all frames as in the first.
    limits
        By default `SequenceLimits()`.

    Returns
    -------
    SequenceFile
        With what all frames share. Only the first frame was read.

    Raises
    ------
    InvalidInput
        ``wrong_input_kind``, ``empty_content``, ``inconsistent_sequence`` and whatever the readers of the files raise,
        then naming the file.
    LimitExceeded
        ``too_large``.
    """
    path = Path(path)
    limits = limits or SequenceLimits()
    if path.is_dir():
        return _open_folder(path, limits)
    with path.open("rb") as stream:
        found = sniff(stream, path.stat().st_size)
    if found.kind is not AssetKind.SEQUENCE:
        raise InvalidInput(
            "wrong_input_kind",
            f"The file is a {found.kind} ({found.format}), not a sequence.",
            "Give an npz file, or a folder or zip archive of meshes.",
        )
    return _open_npz(path, limits) if found.format == "npz" else _open_zip(path, limits)


def natural_key(name: str) -> tuple[tuple[tuple[int, int | str], ...], str]:
    """Return a key that sorts numbers within names by value: frame2 before frame10."""
    parts = re.split(r"([0-9]+)", name)
    key: list[tuple[int, int | str]] = [(0, int(p)) if p[0] in "0123456789" else (1, p.casefold()) for p in parts if p]
    # equal numbers written differently, and letters of either case, still need one order
    return tuple(key), name


def write_sequence_npz(
    path: Path | str,
    frames: Iterable[ArrayLike],
    faces: ArrayLike,
    *,
    shape: tuple[int, int],
    single: bool = True,
    compressed: bool = False,
) -> None:
    """Write a sequence as npz, frame by frame as they come.

    Parameters
    ----------
    path
        File to write; the same frames give the same bytes.
    frames
        (n, 3) coordinates of each frame.
    faces : (m, 3) int32
        The same in all frames.
    shape
        Number of frames and of vertices.
    single
        Write float32, else float64.
    compressed
        Pack the arrays, which makes the file smaller, slower to read and impossible to map into memory.

    Raises
    ------
    ValueError
        Where the frames are not as many or not as large as `shape` says.
    """
    frame_count, vertex_count = shape
    dtype = np.dtype("<f4" if single else "<f8")
    method = zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED
    with zipfile.ZipFile(path, "w", method) as archive:
        written = 0
        with archive.open("vertices.npy", "w", force_zip64=True) as entry:
            _npy_header(entry, dtype, (frame_count, vertex_count, 3))
            for frame in frames:
                array = np.ascontiguousarray(frame, dtype=dtype)
                if array.shape != (vertex_count, 3) or written >= frame_count:
                    raise ValueError(f"frame {written} of {frame_count} has the shape {array.shape}, not {shape[1:]}")
                entry.write(array.tobytes())
                written += 1
        if written != frame_count:
            raise ValueError(f"{written} frames came in place of {frame_count}")
        with archive.open("faces.npy", "w") as entry:
            indices = checked_faces(faces, vertex_count)
            _npy_header(entry, np.dtype("<i4"), indices.shape)
            entry.write(indices.astype("<i4").tobytes())


def _npy_header(entry: Any, dtype: np.dtype[Any], shape: tuple[int, ...]) -> None:
    header = {"descr": dtype.str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(entry, header)


def _check_finite(frame: FrameArray, number: int) -> None:
    if not np.isfinite(frame).all():
        bad = np.flatnonzero(~np.isfinite(frame).all(axis=1))
        raise InvalidInput(
            "invalid_mesh",
            f"In frame {number}, {len(bad)} of {len(frame)} vertices have coordinates that are not finite; "
            f"the first is vertex {bad[0]}.",
            "Remove or correct these frames.",
        )


# npz ------------------------------------------------------------------------------------------------------------------


def _open_npz(path: Path, limits: SequenceLimits) -> SequenceFile:
    bounds = ArchiveLimits(total_bytes=limits.bytes + (1 << 30))
    with path.open("rb") as stream:
        archive = open_archive(stream, bounds)
        header = parse_npy_header(archive.read("vertices.npy", _NPY_HEADER), "vertices.npy")
        frames, vertices, _ = header.shape
        if not frames:
            raise InvalidInput("empty_content", "The npz file holds no frame.")
        limits.check(frames, vertices, int(header.dtype[2:]))
        faces_header = parse_npy_header(archive.read("faces.npy", _NPY_HEADER), "faces.npy")
        limits.mesh.check(faces=faces_header.shape[0])
        faces = _npy_array(archive.read("faces.npy"), faces_header)
    if not len(faces):
        raise InvalidInput("empty_content", f"The npz file holds {frames} frames of points and no faces.")

    def read() -> Iterator[FrameArray]:
        with path.open("rb") as stream:
            archive = open_archive(stream, bounds)
            if header.fortran_order:
                yield from _native(_npy_array(archive.read("vertices.npy"), header))
                return
            size = vertices * 3 * int(header.dtype[2:])
            with archive.open("vertices.npy") as entry:
                entry.read(header.data_offset)
                for _ in range(frames):
                    frame = np.frombuffer(entry.read(size), dtype=header.dtype)
                    yield _native(frame.reshape(vertices, 3))
                # the checksum is verified at the end
                entry.read(1)

    return SequenceFile(
        frame_count=frames,
        vertex_count=vertices,
        faces=checked_faces(faces, vertices),
        dtype=np.dtype(np.float32 if header.dtype[1:] in ("f2", "f4") else np.float64),
        names=(),
        _frames=read,
        _mapped=lambda: _map(path, header),
    )


def _npy_array(data: bytes, header: NpyHeader) -> NDArray[Any]:
    values = np.frombuffer(data, dtype=header.dtype, offset=header.data_offset)
    return values.reshape(header.shape, order="F" if header.fortran_order else "C")


def _native(values: NDArray[Any]) -> FrameArray:
    # a signalling NaN is reported when the frame is checked
    with np.errstate(invalid="ignore"):
        if values.dtype.itemsize > 4:
            return np.ascontiguousarray(values, dtype=np.float64)
        return np.ascontiguousarray(values, dtype=np.float32)


def _map(path: Path, header: NpyHeader) -> FrameArray | None:
    """Map the vertices into memory where they stand in the file as they are needed."""
    if header.dtype not in ("<f4", "<f8") or header.fortran_order or not np.little_endian:
        return None
    with zipfile.ZipFile(path) as archive:
        entry = archive.getinfo("vertices.npy")
    if entry.compress_type != zipfile.ZIP_STORED:
        return None
    with path.open("rb") as stream:
        stream.seek(entry.header_offset)
        local = stream.read(30)
    if len(local) < 30:
        raise corrupt("The npz file ends before its vertices.")
    name_length, extra_length = struct.unpack_from("<2H", local, 26)
    offset = entry.header_offset + 30 + name_length + extra_length + header.data_offset
    dtype = np.float32 if header.dtype == "<f4" else np.float64
    mapped: FrameArray = np.memmap(path, dtype=dtype, mode="r", offset=offset, shape=header.shape)
    return mapped


# a mesh per frame -----------------------------------------------------------------------------------------------------


def _open_folder(path: Path, limits: SequenceLimits) -> SequenceFile:
    names = [p.name for p in path.iterdir() if p.is_file() and not p.name.startswith(".")]

    def load(name: str) -> bytes:
        size = (path / name).stat().st_size
        if size > limits.mesh.bytes:
            raise LimitExceeded("too_large", f"The file has {size} bytes; at most {limits.mesh.bytes} are allowed.")
        return (path / name).read_bytes()

    return _open_frames(names, lambda: (load(name) for name in _ordered(names, "folder")), "folder", limits)


def _open_zip(path: Path, limits: SequenceLimits) -> SequenceFile:
    bounds = ArchiveLimits(total_bytes=limits.bytes, entry_bytes=min(limits.mesh.bytes, limits.bytes))
    with path.open("rb") as stream:
        names = [entry.name for entry in open_archive(stream, bounds).entries]

    def load() -> Iterator[bytes]:
        with path.open("rb") as stream:
            archive = open_archive(stream, bounds)
            for name in _ordered(names, "zip archive"):
                yield archive.read(name)

    return _open_frames(names, load, "zip archive", limits)


def _ordered(names: list[str], where: str) -> list[str]:
    """Return the files that are frames, in their order."""
    suffixes: dict[str, int] = {}
    for name in names:
        suffix = Path(name).suffix.lower()
        if suffix in MESH_SUFFIXES:
            suffixes[suffix] = suffixes.get(suffix, 0) + 1
    if len(suffixes) > 1:
        counts = ", ".join(f"{count} {suffix}" for suffix, count in sorted(suffixes.items()))
        raise InvalidInput(
            "inconsistent_sequence",
            f"The {where} holds meshes of several formats ({counts}), so that it is unclear which are the frames.",
            "Leave one file for each frame.",
        )
    if not suffixes:
        raise InvalidInput(
            "empty_content",
            f"None of the {len(names)} files in the {where} has the ending of a mesh.",
            f"Name the frames {', '.join(f'*{s}' for s in MESH_SUFFIXES)}.",
        )
    return sorted((name for name in names if Path(name).suffix.lower() in suffixes), key=natural_key)


def _open_frames(
    names: list[str], load: Callable[[], Iterable[bytes]], where: str, limits: SequenceLimits
) -> SequenceFile:
    ordered = tuple(_ordered(names, where))
    first, is_stl = _frame(next(iter(load())), ordered[0], limits)
    weld = welded_exactly(first.vertices) if is_stl else None
    base = PolygonMesh.of_triangles(*weld) if weld else first
    try:
        faces = base.triangulated(limits.mesh).faces
    except InvalidInput as error:
        raise _named(error, ordered[0]) from error
    limits.check(len(ordered), len(base.vertices), 8)

    def read() -> Iterator[FrameArray]:
        for number, (name, data) in enumerate(zip(ordered, load(), strict=True)):
            mesh, _ = _frame(data, name, limits)
            _check_same(first, mesh, number, ordered)
            yield _unsplit(mesh.vertices, weld[1], number, ordered) if weld else mesh.vertices

    return SequenceFile(
        frame_count=len(ordered),
        vertex_count=len(base.vertices),
        faces=faces,
        dtype=np.dtype(np.float64),
        names=ordered,
        _frames=read,
        _mapped=lambda: None,
    )


def _frame(data: bytes, name: str, limits: SequenceLimits) -> tuple[PolygonMesh, bool]:
    try:
        mesh, found = read_polygons(io.BytesIO(data), len(data), limits.mesh, weld_stl=False)
    except (InvalidInput, LimitExceeded) as error:
        raise _named(error, name) from error
    return mesh, found.format == "stl"


def _named(error: InvalidInput | LimitExceeded, name: str) -> InvalidInput | LimitExceeded:
    return type(error)(error.code, f"In {name!r}: {error.message}", error.hint)


def _check_same(first: PolygonMesh, mesh: PolygonMesh, number: int, names: tuple[str, ...]) -> None:
    """Refuse a frame of other connectivity than the first."""
    here, there = f"frame {number} ({names[number]})", f"frame 0 ({names[0]})"
    for what, ours, theirs in (
        ("vertices", len(mesh.vertices), len(first.vertices)),
        ("faces", len(mesh.counts), len(first.counts)),
    ):
        if ours != theirs:
            raise _differs(f"The frames differ in connectivity: {here} has {ours} {what}, and {there} has {theirs}.")
    if not np.array_equal(mesh.counts, first.counts) or not np.array_equal(mesh.corners, first.corners):
        ends, face = np.cumsum(first.counts), int(np.argmax(mesh.counts != first.counts))
        if mesh.counts[face] == first.counts[face]:
            face = int(np.searchsorted(ends, np.argmax(mesh.corners != first.corners), side="right"))
        ours, theirs = (
            m.corners[int(ends[face] - first.counts[face]) :][: int(m.counts[face])].tolist()[:8] for m in (mesh, first)
        )
        raise _differs(f"The frames differ in connectivity: face {face} is {ours} in {here}, and {theirs} in {there}.")


def _unsplit(
    corners: NDArray[np.float64], faces: NDArray[np.int64], number: int, names: tuple[str, ...]
) -> NDArray[np.float64]:
    """Return the vertices of an STL frame whose corners are joined as in the first frame."""
    vertices = np.empty((int(faces.max()) + 1, 3))
    vertices[faces.reshape(-1)] = corners
    apart = (vertices[faces.reshape(-1)] != corners).any(axis=1)
    if apart.any():
        face = int(np.argmax(apart)) // 3
        raise _differs(
            f"The frames differ in connectivity: a corner of face {face}, which it shares with others in frame 0 "
            f"({names[0]}), lies apart from theirs in frame {number} ({names[number]})."
        )
    return vertices


def _differs(message: str) -> InvalidInput:
    return InvalidInput("inconsistent_sequence", message, "Export all frames with the same vertices and faces.")

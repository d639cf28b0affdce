"""Decoded motion as files for other programs: npz, a zip of meshes, an animated glTF scene."""

from __future__ import annotations

import json
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from shapery_contracts.errors import LimitExceeded
from shapery_contracts.motion import MotionFormat
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io.obj import write_obj
from shapery_geometry.mesh_io.ply import write_ply
from shapery_geometry.sequence import write_sequence_npz
from shapery_motion.playing import Motion, check_range

FILE_NAMES: Final[dict[MotionFormat, str]] = {
    "npz": "motion.npz",
    "obj": "motion.zip",
    "ply": "motion.zip",
    "glb": "motion.glb",
}
DEFAULT_FPS: Final = 30.0
GLB_BYTES: Final = (1 << 32) - (1 << 20)
"""A glTF binary counts its bytes with 32 bits."""

_EPOCH: Final = (1980, 1, 1, 0, 0, 0)
_FLOAT, _UINT, _ARRAY, _ELEMENTS = 5126, 5125, 34962, 34963


def export(
    motion: Motion,
    path: Path,
    form: MotionFormat,
    *,
    scratch: Path,
    first: int = 0,
    stop: int | None = None,
    on_progress: Callable[[float], None] = lambda _fraction: None,
) -> None:
    """Write frames of a motion to a file, one frame in memory at a time.

    Parameters
    ----------
    motion
        What to write.
    path
        The file; the same frames give the same bytes.
    form
        ``npz``, a zip of ``obj`` or ``ply`` files, or an animated ``glb``.
    scratch
        A folder for temporary files.
    first, stop
        The first frame, and the one after the last; by default all.
    on_progress
        Called with the fraction that is done.

    Raises
    ------
    InvalidInput
        ``invalid_params`` where the range holds no frame.
    LimitExceeded
        ``too_large`` for a glTF scene of more than four gigabytes.
    """
    stop = len(motion) if stop is None else min(stop, len(motion))
    check_range(first, stop, len(motion))
    count = stop - first

    def frames() -> Any:
        for number, frame in enumerate(motion.frames(first, stop)):
            on_progress(number / count)
            yield frame

    if form == "npz":
        shape = (count, motion.header.vertices)
        write_sequence_npz(path, frames(), motion.faces, shape=shape, single=not motion.header.double)
    elif form == "glb":
        _write_glb(motion, path, frames(), count, scratch)
    else:
        _write_zip(motion, path, form, frames(), first, stop, scratch)


def _write_zip(
    motion: Motion, path: Path, form: MotionFormat, frames: Any, first: int, stop: int, scratch: Path
) -> None:
    digits = max(4, len(str(stop - 1)))
    single = not motion.header.double
    with zipfile.ZipFile(path, "w") as archive:
        for number, frame in enumerate(frames, start=first):
            mesh = TriangleMesh(frame, motion.faces)
            file = scratch / f"frame.{form}"
            if form == "ply":
                write_ply(mesh, file, comments=(), single=single)
            else:
                write_obj(mesh, file)
            entry = zipfile.ZipInfo(f"frame{number:0{digits}d}.{form}", _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, file.read_bytes(), compresslevel=3)


def _write_glb(motion: Motion, path: Path, frames: Any, count: int, scratch: Path) -> None:
    """Write a scene whose mesh has a morph target for each frame after the first, weighted 1 at its time."""
    n, targets = motion.header.vertices, count - 1
    faces = motion.faces
    sizes = [12 * n] * count + [12 * len(faces), 4 * count, 4 * count * targets]
    if sum(sizes) > GLB_BYTES:
        raise LimitExceeded(
            "too_large",
            f"As a glTF scene the {count} frames take {sum(sizes)} bytes; at most {GLB_BYTES} can be.",
            "Export fewer frames, or another format.",
        )
    accessors: list[dict[str, Any]] = []
    views: list[dict[str, Any]] = []

    def add(size: int, component: int, kind: str, items: int, target: int | None = None, **more: Any) -> int:
        offset = views[-1]["byteOffset"] + views[-1]["byteLength"] if views else 0
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": size} | ({"target": target} if target else {}))
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": component, "count": items, "type": kind, **more}
        )
        return len(accessors) - 1

    binary = scratch / "scene.bin"
    fps = motion.header.fps or DEFAULT_FPS
    with binary.open("wb") as stream:
        base = np.zeros((n, 3), dtype="<f4")
        for number, frame in enumerate(frames):
            points = frame.astype("<f4")
            if number == 0:
                base = points
            else:
                points = points - base
            low, high = points.min(axis=0).tolist(), points.max(axis=0).tolist()
            add(12 * n, _FLOAT, "VEC3", n, _ARRAY, min=low, max=high)
            stream.write(points.tobytes())
        indices = add(12 * len(faces), _UINT, "SCALAR", 3 * len(faces), _ELEMENTS)
        stream.write(faces.astype("<u4").tobytes())
        primitive: dict[str, Any] = {"attributes": {"POSITION": 0}, "indices": indices, "mode": 4}
        name = motion.metadata.name or "motion"
        mesh: dict[str, Any] = {"name": name, "primitives": [primitive]}
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "Shapery"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"name": name, "mesh": 0}],
            "meshes": [mesh],
        }
        if targets:
            times = (np.arange(count) / fps).astype("<f4")
            time = add(4 * count, _FLOAT, "SCALAR", count, min=[0.0], max=[float(times[-1])])
            stream.write(times.tobytes())
            weights = add(4 * count * targets, _FLOAT, "SCALAR", count * targets)
            for number in range(count):
                row = np.zeros(targets, dtype="<f4")
                if number:
                    row[number - 1] = 1.0
                stream.write(row.tobytes())
            primitive["targets"] = [{"POSITION": k} for k in range(1, count)]
            mesh["weights"] = [0.0] * targets
            sampler = {"input": time, "output": weights, "interpolation": "LINEAR"}
            channel = {"sampler": 0, "target": {"node": 0, "path": "weights"}}
            document["animations"] = [{"name": name, "samplers": [sampler], "channels": [channel]}]
        length = stream.tell()
    document |= {"accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": length}]}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    with path.open("wb") as out, binary.open("rb") as body:
        out.write(struct.pack("<4s2L", b"glTF", 2, 12 + 8 + len(text) + 8 + length))
        out.write(struct.pack("<L4s", len(text), b"JSON") + text + struct.pack("<L4s", length, b"BIN\0"))
        while chunk := body.read(1 << 20):
            out.write(chunk)
    binary.unlink()

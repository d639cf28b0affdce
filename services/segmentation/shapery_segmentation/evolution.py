"""A surface as it grew, to be watched again: few frames, few triangles, one small file.

The file ``evolution.bin`` is described in ``api_schema/evolution.md``: a header in JSON, then the frames, their
vertices as 16-bit numbers.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_segmentation import _evolution_kernels as kernels
from shapery_segmentation.flow.params import FlowState

MAGIC = b"SHPEVO1\0"

MOST_FRAMES = 24
"""Of one object. Where there would be more, every second is dropped and only every second is taken from then on."""

FIRST_EVERY = 4
"""Iterations between two frames of a flow that is not long."""

MOST_VERTICES = 1200
"""Of one frame: enough to watch."""

MOST_AT_ONCE = 6000
"""Vertices of all surfaces that are shown together while the work goes on."""

LARGEST_FILE = 64 << 20
"""Bytes beyond which `read_evolution` refuses a file."""


@dataclass(frozen=True, eq=False)
class Frame:
    """One surface on its way.

    Parameters
    ----------
    object
        Number of the object in the report, from 1.
    stage, iteration
        Of the flow.
    mesh
        Coarse, RAS mm.
    """

    object: int
    stage: int
    iteration: int
    mesh: TriangleMesh


Show = Callable[[tuple[Frame, ...]], None]
"""Called with all surfaces as they are just now: one frame each, together at most about `MOST_AT_ONCE` vertices."""


class Scene:
    """What is seen while surfaces are recovered one after the other: those at rest, and the one that flows.

    Objects are numbered as they come to rest; the report numbers them by their confidence.

    Parameters
    ----------
    show
        Told of every change; None: nobody looks.
    """

    def __init__(self, show: Show | None = None) -> None:
        self._show = show
        self._resting: list[TriangleMesh] = []

    def moved(self, frame: Frame) -> None:
        """Show a surface that flows, in the place of the last one that did."""
        if self._show is not None:
            self._show((*self._at_rest(), replace(frame, object=len(self._resting) + 1)))

    def rested(self, mesh: TriangleMesh) -> None:
        """Keep a surface, coarse, that has come to rest."""
        if self._show is not None:
            self._resting.append(mesh)
            self._show(self._at_rest())

    def _at_rest(self) -> tuple[Frame, ...]:
        most = min(MOST_VERTICES, (MOST_AT_ONCE - MOST_VERTICES) // max(len(self._resting), 1))
        self._resting = [coarsened(mesh, most) for mesh in self._resting]
        return tuple(Frame(number, 0, 0, mesh) for number, mesh in enumerate(self._resting, start=1))


class Recorder:
    """Takes in a surface now and then while it flows, and shows it where somebody looks."""

    def __init__(self, scene: Scene | None = None) -> None:
        self._scene = scene or Scene()
        self._frames: list[Frame] = []
        self._every = FIRST_EVERY
        self._seen = 0

    def watch(self, state: FlowState) -> Frame | None:
        """Look at a flow after an iteration; returns the frame where one was kept."""
        self._seen += 1
        if (self._seen - 1) % self._every:
            return None
        if len(self._frames) >= MOST_FRAMES:
            self._frames = self._frames[::2]
            self._every *= 2
        self._frames.append(Frame(0, state.stage, state.iteration, coarsened(state.surface(), MOST_VERTICES)))
        self._scene.moved(self._frames[-1])
        return self._frames[-1]

    def frames(self, end: TriangleMesh) -> tuple[Frame, ...]:
        """Return what was kept, and the surface at rest."""
        last = self._frames[-1] if self._frames else Frame(0, 0, 0, end)
        rest = coarsened(end, MOST_VERTICES)
        self._scene.rested(rest)
        return (*self._frames, Frame(0, last.stage, last.iteration + 1, rest))


def numbered(frames: tuple[Frame, ...], number: int) -> tuple[Frame, ...]:
    """Return frames as those of the object with this number."""
    return tuple(replace(frame, object=number) for frame in frames)


def coarsened(mesh: TriangleMesh, most: int) -> TriangleMesh:
    """Return the mesh with the vertices of each cell of a grid drawn together into their mean, at most about `most`.

    Fast, and good enough to look at: faces that meet in one cell vanish, and so does the promise of a manifold.
    """
    if len(mesh.vertices) <= most:
        return mesh
    points, faces = np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.faces)
    # A surface of area A crosses about 1.7 A/c² cells of side c.
    side = float(np.sqrt(1.7 * kernels.surface_area(points, faces) / most))
    room = np.empty((2, 1 << (2 * most).bit_length()), dtype=np.int64)
    number = np.empty(len(points), dtype=np.int32)
    while (cells := kernels.number_cells(points, side, room[0], room[1], number, most)) > most:
        side *= 1.15
    means, kept = np.empty((cells, 3)), np.empty_like(faces)
    count = kernels.draw_together(points, faces, number, means, kept)
    return TriangleMesh(means, kept[:count])


def write_evolution(frames: tuple[Frame, ...], path: Path) -> None:
    """Write frames, sorted by object and iteration."""
    path.write_bytes(evolution_bytes(frames))


def evolution_bytes(frames: tuple[Frame, ...]) -> bytes:
    """Return what `write_evolution` writes."""
    origin, step = np.zeros(3), 1.0
    if frames:
        low = np.min([frame.mesh.vertices.min(axis=0) for frame in frames], axis=0)
        high = np.max([frame.mesh.vertices.max(axis=0) for frame in frames], axis=0)
        origin, step = low, max(float((high - low).max()) / 65535.0, 1e-9)
    told: list[dict[str, int]] = []
    body = bytearray()
    for frame in sorted(frames, key=lambda f: (f.object, f.iteration)):
        told.append(
            {
                "object": frame.object,
                "stage": frame.stage,
                "iteration": frame.iteration,
                "vertices": len(frame.mesh.vertices),
                "faces": len(frame.mesh.faces),
                "offset": len(body),
            }
        )
        places = np.rint((frame.mesh.vertices - origin) / step).clip(0, 65535).astype("<u2").tobytes()
        body += places + b"\0" * (-len(places) % 4) + frame.mesh.faces.astype("<u4").tobytes()
    header = json.dumps({"origin": [float(x) for x in origin], "step": step, "frames": told}).encode()
    header += b" " * (-(len(MAGIC) + 4 + len(header)) % 4)
    return MAGIC + struct.pack("<I", len(header)) + header + bytes(body)


def read_evolution(path: Path) -> tuple[Frame, ...]:
    """Read what `write_evolution` wrote.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` for anything else.
    """
    size = path.stat().st_size
    if size > LARGEST_FILE:
        raise InvalidInput("corrupt_file", f"{path.name} has {size} bytes: no evolution is as large.")
    data = path.read_bytes()
    begin = len(MAGIC) + 4
    if data[: len(MAGIC)] != MAGIC or len(data) < begin:
        raise InvalidInput("corrupt_file", f"{path.name} is no evolution of a surface.")
    body = begin + struct.unpack_from("<I", data, len(MAGIC))[0]
    try:
        header = json.loads(data[begin:body])
        origin, step = np.array(header["origin"], dtype=np.float64), float(header["step"])
        return tuple(_frame(data, body, told, origin, step) for told in header["frames"])
    except (KeyError, TypeError, ValueError) as error:
        raise InvalidInput("corrupt_file", f"{path.name} is damaged: {error}.") from error


def _frame(data: bytes, body: int, told: dict[str, int], origin: NDArray[np.float64], step: float) -> Frame:
    count, faces, at = int(told["vertices"]), int(told["faces"]), body + int(told["offset"])
    places = np.frombuffer(data, "<u2", 3 * count, at).reshape(-1, 3)
    at += (6 * count + 3) // 4 * 4
    corners = np.frombuffer(data, "<u4", 3 * faces, at).reshape(-1, 3)
    mesh = TriangleMesh(origin + step * places, corners.astype(np.int32))
    return Frame(int(told["object"]), int(told["stage"]), int(told["iteration"]), mesh)

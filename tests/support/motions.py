"""Mesh sequences for the tests of the codec: a sheet that waves, and what is difficult about others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.sequence import MeshSequence

Faces = NDArray[np.int32]
Frames = NDArray[np.float64]


def grid_faces(rows: int, columns: int) -> Faces:
    """Two triangles for each cell of a grid of vertices."""
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1)
    lower = np.stack((corner, corner + 1, corner + columns + 1), axis=1)
    upper = np.stack((corner, corner + columns + 1, corner + columns), axis=1)
    return np.concatenate((lower, upper)).astype(np.int32)


def waving(rows: int = 12, columns: int = 14, frames: int = 16) -> tuple[Frames, Faces]:
    """A sheet on which two waves run while it turns: not a low-dimensional motion."""
    y, x = (values.reshape(-1).astype(float) for values in np.mgrid[:rows, :columns])
    made = np.empty((frames, rows * columns, 3))
    for t in range(frames):
        z = np.sin(0.5 * x + 0.4 * t) + 0.6 * np.cos(0.7 * y - 0.3 * t + 0.2 * x)
        c, s = np.cos(0.1 * t), np.sin(0.1 * t)
        made[t] = np.stack((c * x - s * z, y, s * x + c * z), axis=1)
    return made, grid_faces(rows, columns)


def bodies(count: int = 41, frames: int = 8) -> tuple[Frames, Faces]:
    """Tetrahedra that tumble about, each on its own way, none connected to another."""
    rng = np.random.default_rng(5)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    made = np.empty((frames, 4 * count, 3))
    for k in range(count):
        axis, place, speed = rng.normal(size=3), rng.normal(size=3) * 10, rng.normal(size=3)
        for t in range(frames):
            turn = _rotation(axis * 0.2 * t)
            made[t, 4 * k : 4 * k + 4] = corners @ turn.T + place + speed * t
    return made, np.concatenate([faces + 4 * k for k in range(count)]).astype(np.int32)


def _rotation(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / max(angle, 1e-12)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def difficult_sequences() -> dict[str, MeshSequence]:
    """What an encoder meets in the wild, by name."""
    frames, faces = waving()
    single = frames.astype(np.float32)
    tumbling, separate = bodies()
    degenerate = np.concatenate((faces, [[3, 3, 4], [5, 5, 5], faces[0], faces[1][::-1]])).astype(np.int32)
    loose = np.concatenate((single, single[:, :3] + 40), axis=1)
    flipped = single.copy()
    flipped[::2, :, 2] *= -1
    fan = np.stack((np.zeros(60), np.arange(1, 61), np.arange(2, 62)), axis=1).astype(np.int32)
    wheel = np.random.default_rng(1).normal(size=(5, 62, 3)).astype(np.float32)
    return {
        "waving": MeshSequence(single, faces),
        "small sheet": MeshSequence(waving(9, 9, 12)[0].astype(np.float32), grid_faces(9, 9)),
        "double precision": MeshSequence(frames, faces),
        "41 components": MeshSequence(tumbling.astype(np.float32), separate),
        "degenerate and repeated faces": MeshSequence(single, degenerate),
        "unreferenced vertices": MeshSequence(loose, faces),
        "repeated frames": MeshSequence(single[[0, 1, 2, 1, 2, 0, 3, 3]], faces),
        "static": MeshSequence(np.repeat(single[:1], 6, axis=0), faces),
        "one frame": MeshSequence(single[:1], faces),
        "two frames": MeshSequence(single[:2], faces),
        "one triangle": MeshSequence(single[:5, :3], np.array([[0, 1, 2]], dtype=np.int32)),
        "flips": MeshSequence(flipped, faces),
        "far from the origin": MeshSequence(frames + 1e6, faces),
        "noise around a hub": MeshSequence(wheel, fan),
        "a point that moves": MeshSequence(np.arange(12.0).reshape(4, 1, 3), np.array([[0, 0, 0]], dtype=np.int32)),
    }

"""Whether parts that are matched are the same: on poses of one body, whose vertices correspond by their numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.retrieval.features import cached, keep
from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval.arg import Arg
from shapery_retrieval.describe import describe
from shapery_retrieval.matching import match

KEYS = ("right", "as_good", "carried", "overlapping", "repeatable")
SETS = ("cat-poses", "lion-poses", "horse-poses", "face-poses")


def posed(path: Path) -> list[tuple[Arg, list[NDArray[np.int64]], NDArray[np.float64]]]:
    """Return of each pose its graph, the part of each vertex on each level, and each vertex's share of the area."""
    with np.load(path) as stored:
        vertices, faces = stored["vertices"], stored["faces"]
    found = []
    for points in vertices:
        mesh = TriangleMesh(points, faces)
        kept = cached(mesh, "posed-")
        if not kept.exists():
            description = describe(mesh)
            labels = {
                f"labels{k}": description.labels_on(mesh, k) for k in range(1, len(description.decomposition.levels))
            }
            keep(kept, arg=np.frombuffer(description.arg.to_bytes(), dtype=np.uint8), **labels)
        with np.load(kept) as stored:
            arg = Arg.from_bytes(stored["arg"].tobytes())
            labels_by_level = [stored[f"labels{k}"] for k in range(1, len(arg.levels))]
        areas = np.bincount(mesh.faces.ravel(), np.repeat(mesh.face_areas, 3), len(mesh.vertices))
        found.append((arg, labels_by_level, areas / areas.sum()))
    return found


def correspondence(folder: Path) -> dict[str, Any]:
    """Match every pose of each set with every other one, and compare with what the vertices tell.

    Returns
    -------
    By set and level: ``right``, the share of the area of parts whose match is the part that most of their vertices lie
    in; ``as_good``, or a part that holds as many but for a tenth of the part; ``carried``, the share that the plan
    carries between the same two parts as the vertices, where a part may go to several; ``overlapping``, of parts whose
    match holds at least a quarter of their area or lies for a quarter in them, for borders of parts move with the pose;
    ``repeatable``, the share of the area that would stay in its part if every part were matched right.
    """
    rows: dict[str, Any] = {}
    for name in SETS:
        poses = posed(folder / f"{name}.npz")
        for level in range(1, len(poses[0][0].levels)):
            figures = [_compared(a, b, level) for i, a in enumerate(poses) for j, b in enumerate(poses) if i != j]
            mean = np.mean(figures, axis=0)
            rows[f"{name}, level {level}"] = dict(zip(KEYS, mean.tolist(), strict=True))
        print(name, rows, flush=True)
    return rows


def _compared(a: tuple[Any, ...], b: tuple[Any, ...], level: int) -> tuple[float, ...]:
    found = match(a[0], b[0]).levels[level]
    own, others, areas = a[1][level - 1], b[1][level - 1], a[2]
    shared = np.zeros((a[0].levels[level].parts, b[0].levels[level].parts))
    np.add.at(shared, (own, others), areas)
    size, there = shared.sum(axis=1), np.maximum(shared.sum(axis=0), 1e-12)
    chosen = np.array([j for _, j, _ in found.pairs()])
    carried = np.minimum(found.transport, shared).sum()
    every = np.arange(len(chosen))
    right = shared[every, chosen] >= shared.max(axis=1) - 1e-12
    as_good = shared[every, chosen] >= shared.max(axis=1) - 0.1 * size
    near = (shared[every, chosen] >= 0.25 * size) | (shared[every, chosen] >= 0.25 * there[chosen])
    return (
        float(size @ right),
        float(size @ (right | as_good)),
        float(carried),
        float(size @ (right | near)),
        float(shared.max(axis=1).sum()),
    )

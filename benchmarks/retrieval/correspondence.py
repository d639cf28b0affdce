"""Whether parts that are matched are the same: on poses of one body, whose vertices correspond by their numbers."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.retrieval.features import cached, keep
from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval.arg import Arg
from shapery_retrieval.describe import describe
from shapery_retrieval.matching import LevelMatch, match

KEYS = ("right", "as_good", "carried", "overlapping", "repeatable", "laid_right", "laid_area", "laid_parts")
SETS = ("cat-poses", "lion-poses", "horse-poses", "face-poses")


class Posed(NamedTuple):
    """A pose: its graph, the cell of each vertex, the part of each cell on each level, and shares of the area."""

    arg: Arg
    cells: NDArray[np.int64]
    parts: list[NDArray[np.int64]]
    areas: NDArray[np.float64]


def posed(path: Path) -> list[Posed]:
    """Return what is known of each pose of a set; areas are those of its vertices, in sum 1."""
    with np.load(path) as stored:
        vertices, faces = stored["vertices"], stored["faces"]
    found = []
    for points in vertices:
        mesh = TriangleMesh(points, faces)
        kept = cached(mesh, "cells-")
        if not kept.exists():
            description = describe(mesh)
            keep(
                kept,
                arg=np.frombuffer(description.arg.to_bytes(), dtype=np.uint8),
                cells=description.cells_on(mesh),
                parts=np.stack(description.decomposition.levels),
            )
        with np.load(kept) as stored:
            arg, cells, parts = Arg.from_bytes(stored["arg"].tobytes()), stored["cells"], list(stored["parts"])
        areas = np.bincount(mesh.faces.ravel(), np.repeat(mesh.face_areas, 3), len(mesh.vertices))
        found.append(Posed(arg, cells, parts, areas / areas.sum()))
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

    Of parts laid on the other pose with their own borders: ``laid_right``, the share of the area of parts most of whose
    vertices lie where they were laid; ``laid_area``, the share of the area that does; and ``laid_parts``, how many of
    them lie anywhere.
    """
    rows: dict[str, Any] = {}
    for name in SETS:
        poses = posed(folder / f"{name}.npz")
        levels = range(1, len(poses[0].arg.levels))
        pairs = [(a, b) for i, a in enumerate(poses) for j, b in enumerate(poses) if i != j]
        mean = np.mean([_compared(a, b, levels) for a, b in pairs], axis=0)
        for level, figures in zip(levels, mean.tolist(), strict=True):
            rows[f"{name}, level {level}"] = dict(zip(KEYS, figures, strict=True))
        print(name, rows, flush=True)
    return rows


def _compared(a: Posed, b: Posed, levels: Iterable[int]) -> list[tuple[float, ...]]:
    found = match(a.arg, b.arg)
    cells = np.zeros((len(a.parts[0]), len(b.parts[0])))
    np.add.at(cells, (a.cells, b.cells), a.areas)
    finest = a.arg.levels[-1].parts
    figures = []
    for level in levels:
        there = b.parts[level]
        # of each part of the finest level, the one of this level that holds it
        within = np.full(finest + 1, -1)
        within[a.parts[-1]] = a.parts[level]
        figures.append(
            _of_parts(found.levels[level], _gathered(cells, a.parts[level], there))
            + _of_laid(_gathered(cells, a.parts[level], within[found.overlaid]))
        )
    return figures


def _gathered(cells: NDArray[np.float64], own: NDArray[np.int64], there: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k, l + 1) shares of the area by the part of either pose; in the last column of what is of part −1 there."""
    shared = np.zeros((int(own.max()) + 1, int(max(own.max(), there.max())) + 2))
    np.add.at(shared, (own[:, None], there[None]), cells)
    return shared


def _of_parts(found: LevelMatch, shared: NDArray[np.float64]) -> tuple[float, ...]:
    size, there = shared.sum(axis=1), np.maximum(shared.sum(axis=0), 1e-12)
    chosen = np.array([j for _, j, _ in found.pairs()])
    every = np.arange(len(chosen))
    right = shared[every, chosen] >= shared.max(axis=1) - 1e-12
    as_good = shared[every, chosen] >= shared.max(axis=1) - 0.1 * size
    near = (shared[every, chosen] >= 0.25 * size) | (shared[every, chosen] >= 0.25 * there[chosen])
    return (
        float(size @ right),
        float(size @ (right | as_good)),
        float(np.minimum(found.transport, shared[:, : found.transport.shape[1]]).sum()),
        float(size @ (right | near)),
        float(shared.max(axis=1).sum()),
    )


def _of_laid(shared: NDArray[np.float64]) -> tuple[float, ...]:
    there = np.diag(shared)
    right = there >= shared.max(axis=1) - 1e-12
    return float(shared.sum(axis=1) @ right), float(there.sum()), float((shared[:, :-1].sum(axis=0) > 0).sum())

"""Meshes that break mesh code, and a scan of 100,000 faces: whether they are indexed, in what time and memory."""

from __future__ import annotations

import multiprocessing
import resource
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from shapery_contracts.errors import UserError
from shapery_geometry.decimation import decimate
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io import read_mesh
from shapery_retrieval.describe import describe

SCAN_FACES = 100_000


def difficult(folder: Path, motion: Path) -> dict[str, Any]:
    """Index every file of a folder, and scans made from two motions, each in a process of its own.

    Returns
    -------
    By name the outcome, the faces, the wall and CPU seconds, reading included, and the peak memory in MiB, of which
    some 300 are the libraries' own.
    """
    made = {path.name: partial(read_mesh, path) for path in sorted(folder.iterdir())}
    made |= {f"scan of {name}": partial(_scan, motion / f"{name}.npz") for name in ("crane", "face-poses")}
    with multiprocessing.get_context("fork").Pool(1, maxtasksperchild=1) as pool:
        rows = {}
        for name, make in made.items():
            rows[name] = pool.apply(_indexed, (make, name.startswith("scan of ")))
            print(name, rows[name], flush=True)
    return rows


def _indexed(make: partial[TriangleMesh], prepared: bool) -> dict[str, Any]:
    """Index a mesh; what is `prepared` is made before the clock runs."""
    began, cpu = time.perf_counter(), time.process_time()
    faces = 0
    try:
        mesh = make()
        faces = len(mesh.faces)
        if prepared:
            began, cpu = time.perf_counter(), time.process_time()
        found = describe(mesh)
        done = ", ".join(f"{step.replace('_', ' ')} {count}" for step, count in found.normalised.changes)
        outcome = f"{found.arg.levels[-1].parts} parts" + (f" ({done})" if done else "")
    except UserError as error:
        outcome = f"refused: {error.message}"
    return {
        "outcome": outcome,
        "faces": faces,
        "seconds": time.perf_counter() - began,
        "cpu_seconds": time.process_time() - cpu,
        "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10,
    }


def _scan(path: Path) -> TriangleMesh:
    """Make of the first frame of a motion a mesh of about 100,000 faces with noise of a 5,000th of the diagonal."""
    with np.load(path) as stored:
        mesh = TriangleMesh(stored["vertices"][0], stored["faces"])
    while len(mesh.faces) < SCAN_FACES:
        mesh = _subdivided(mesh)
    mesh = decimate(mesh, SCAN_FACES)
    noise = np.random.default_rng(0).normal(size=mesh.vertices.shape) * mesh.diagonal / 5000 / 3**0.5
    return mesh.with_vertices(mesh.vertices + noise)


def _subdivided(mesh: TriangleMesh) -> TriangleMesh:
    """Cut every face in four by the middles of its sides."""
    ab, bc, ca = mesh.topology.face_edges.T.astype(np.int64) + len(mesh.vertices)
    a, b, c = mesh.faces.T.astype(np.int64)
    points = np.concatenate((mesh.vertices, mesh.vertices[mesh.edges].mean(axis=1)))
    corners = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return TriangleMesh(points, np.concatenate([np.stack(corner, axis=1) for corner in corners]))

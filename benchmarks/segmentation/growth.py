"""How time and memory grow: with the volume, from 64³ to 512³ voxels, and with the surface, from 10³ to 10⁶ faces.

    python -m benchmarks.segmentation.growth volume|flow|peer|faces NUMBER

Each measurement is a process of its own and prints one line of JSON.

``volume``  a whole head (files aside) of so many voxels a side through `segment`: what the working grid makes of it
``flow``    the normal flow on one ball of 12 mm in a volume of so many voxels of 1 mm a side
``peer``    ITK's ThresholdSegmentationLevelSet on the same
``faces``   the normal flow on a ball of 20 mm, its edge length chosen so that it ends with so many faces
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from typing import Any

import numpy as np

from benchmarks.segmentation.cases import ROOT
from benchmarks.segmentation.ours import ONE_THREAD

SIDES = (64, 128, 256, 512)
FACES = (1_000, 10_000, 100_000, 1_000_000)
HEAD_MM = 192.0


def measure(what: str, number: int, time_limit: float) -> dict[str, Any]:
    """Run one measurement in a process of its own; one that takes too long is said to be late."""
    command = [sys.executable, "-m", "benchmarks.segmentation.growth", what, str(number)]
    try:
        done = subprocess.run(
            command, cwd=ROOT, env=os.environ | ONE_THREAD, capture_output=True, text=True, check=True,
            timeout=time_limit,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return {"what": what, "number": number, "late": True}
    row: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return row | {"what": what, "number": number, "late": False}


def _ball(side: int, radius: float) -> tuple[Any, Any, Any]:
    """Return a field that is 4 in a ball and −4 outside, its affine, and a seed surface of 0.7 of its radius."""
    from shapery_geometry.mesh import TriangleMesh
    from shapery_segmentation.seeding.ball import surface_of

    axis = np.arange(side, dtype=np.float32) - (side - 1) / 2
    square = axis**2
    field = np.sqrt(square[:, None, None] + square[:, None] + square)
    np.subtract(np.float32(radius), field, out=field)
    np.clip(field, -4.0, 4.0, out=field)
    affine = np.eye(4)
    affine[:3, 3] = -(side - 1) / 2
    around = slice(side // 2 - 24, side // 2 + 24)
    inside = field[around, around, around] > 0.3 * radius
    if radius * 0.3 >= 4.0:
        part = axis[around]
        inside = part[:, None, None] ** 2 + part[:, None] ** 2 + part**2 < (0.7 * radius) ** 2
    corner = affine.copy()
    corner[:3, 3] += around.start
    seed: TriangleMesh = surface_of(inside, corner)
    return field, affine, seed


def _run(what: str, number: int) -> dict[str, Any]:
    if what == "volume":
        return _volume(number)
    if what == "peer":
        return _peer(number)
    from shapery_segmentation.flow.normal import NormalFlowParams, normal_flow

    field, affine, seed = _ball(64 if what == "faces" else number, 20.0 if what == "faces" else 12.0)
    edges: tuple[float, ...] = (1.5, 1.0)
    if what == "faces":
        edge = float(np.sqrt(4 * np.pi * 20.0**2 / (number * np.sqrt(3) / 4)))
        # Coarser stages first, as long as they move in larger steps.
        edges = tuple(sorted({edge * 2**k for k in range(8) if edge * 2**k <= 2.0} | {edge}, reverse=True))
    params = NormalFlowParams(edge_lengths=edges)
    small = _ball(48, 8.0)
    normal_flow(small[0], None, small[1], small[2], threshold=2.0)  # loads the kernels
    base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    result = normal_flow(field, None, affine, seed, params, threshold=1.0)
    return {
        "cpu_seconds": time.process_time() - start,
        "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "before_mib": base / 1024,
        "faces": len(result.mesh.faces),
        "iterations": result.iterations,
    }


def _volume(side: int) -> dict[str, Any]:
    from shapery_geometry.volume import Volume
    from shapery_segmentation import segment
    from shapery_segmentation.phantoms import head_phantom
    from shapery_segmentation.warm import warm

    warm()
    drawn = min(side, 256)
    spacing = HEAD_MM / drawn
    phantom = head_phantom(np.random.default_rng(7), (drawn,) * 3, (spacing,) * 3)
    factor = side // drawn
    volumes = []
    for volume in (phantom.post, phantom.pre):
        data = volume.data
        for axis in range(3):
            data = np.repeat(data, factor, axis) if factor > 1 else data
        affine = volume.affine.copy()
        affine[:3, :3] /= factor
        volumes.append(Volume(data, affine))
    base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wall, start = time.perf_counter(), time.process_time()
    result = segment(*volumes)
    return {
        "cpu_seconds": time.process_time() - start,
        "wall_seconds": time.perf_counter() - wall,
        "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "before_mib": base / 1024,
        "objects": len(result.report.objects),
    }


def _peer(side: int) -> dict[str, Any]:
    from benchmarks.segmentation.peers import PEERS, threshold_level_set
    from shapery_geometry.rasterize import rasterize
    from shapery_geometry.volume import Volume

    field, affine, surface = _ball(side, 12.0)
    seed = rasterize(surface, Volume(field, affine))
    allowed = np.ones(field.shape, dtype=np.bool_)
    base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    setting = PEERS["threshold_level_set"][2][0] | {"lower": 1.0}
    _, iterations = threshold_level_set(field, seed, allowed, 1.0, setting)
    return {
        "cpu_seconds": time.process_time() - start,
        "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "before_mib": base / 1024,
        "iterations": iterations,
    }


if __name__ == "__main__":
    print(json.dumps(_run(sys.argv[1], int(sys.argv[2]))))

"""How cost grows with frames, vertices and faces, on a swaying sphere with a rough surface."""

from __future__ import annotations

import json
import time
from typing import Any

import numpy as np

from benchmarks.motion.case import RESULTS
from shapery_contracts.motion import MotionEncodeParams
from shapery_geometry.mesh import icosphere
from shapery_geometry.sequence import MeshSequence
from shapery_motion import encode, open_motion

KEPT = RESULTS / "motion" / "growth.json"
SIZES = ((3, 32), (4, 32), (5, 32), (4, 64), (4, 128))
"""Subdivisions and frames."""


def swaying(subdivisions: int, frames: int) -> MeshSequence:
    """Return a sphere that bends, stretches and ripples."""
    ball = icosphere(subdivisions=subdivisions)
    x, y, z = ball.vertices.T
    moved = np.empty((frames, len(x), 3), dtype=np.float32)
    for t in range(frames):
        bend, ripple = 0.4 * np.sin(0.15 * t), 0.03 * np.sin(0.3 * t + 6 * x + 4 * y)
        moved[t] = np.stack((x + bend * np.sin(2 * z) + ripple * x, y + ripple * y, z - bend * x * x), axis=1)
    return MeshSequence(moved, ball.faces)


def measure() -> None:
    """Encode and decode all sizes; keep what it took."""
    rows: list[dict[str, Any]] = []
    encode(swaying(2, 8), MotionEncodeParams())  # compiles
    for subdivisions, frames in SIZES:
        sequence = swaying(subdivisions, frames)
        start = time.process_time()
        encoding = encode(sequence, MotionEncodeParams())
        encoded = time.process_time() - start
        start = time.process_time()
        motion = open_motion(encoding.data)
        motion.frame(0)
        opened = time.process_time() - start
        for _ in motion.frames():
            pass
        decoded = time.process_time() - start
        rows.append(
            {
                "frames": frames,
                "vertices": sequence.vertex_count,
                "faces": len(sequence.faces),
                "bytes": len(encoding.data),
                "connectivity_bits_per_vertex": 8 * encoding.parts["connectivity"] / sequence.vertex_count,
                "encode_cpu_seconds": encoded,
                "open_cpu_seconds": opened,
                "decode_cpu_seconds": decoded,
            }
        )
        KEPT.parent.mkdir(parents=True, exist_ok=True)
        KEPT.write_text(json.dumps(rows, indent=1) + "\n")

"""What the platform is given to show."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from shapery_client import Client
from shapery_contracts.states import JobState
from shapery_geometry.mesh import icosphere
from shapery_geometry.mesh_io import write_mesh
from shapery_geometry.sequence import write_sequence_npz
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import write_nifti

FPS = 60


def ball(frames: int) -> tuple[Any, Any]:
    """Return a ball of 10,000 vertices that is dented in another way in each frame: (frames, n, 3) and (m, 3)."""
    polar = np.repeat(np.linspace(0.02, np.pi - 0.02, 100), 100)
    around = np.tile(np.arange(100) * 2 * np.pi / 100, 100)
    rest = np.stack((np.sin(polar) * np.cos(around), np.cos(polar), np.sin(polar) * np.sin(around)), axis=1)
    t = np.arange(frames)[:, None] / frames
    size = 1 + 0.12 * np.sin(5 * polar + 2 * np.pi * t) * np.cos(3 * around - 4 * np.pi * t)
    at = (np.arange(99)[:, None] * 100 + np.arange(100)).reshape(-1)
    beside = (np.arange(99)[:, None] * 100 + (np.arange(100) + 1) % 100).reshape(-1)
    quads = (np.stack((at, beside, at + 100), axis=1), np.stack((beside, beside + 100, at + 100), axis=1))
    return (rest * size[..., None]).astype(np.float32), np.concatenate(quads).astype(np.int32)


def shells(size: int, path: Path) -> None:
    """Write an ellipsoid of shells and a bright ball, with noise: `size` voxels along each axis, signed 16-bit."""
    rng = np.random.default_rng(0)
    at = np.linspace(-1, 1, size, dtype=np.float32)
    data = np.empty((size, size, size), dtype=np.int16)
    for index, x in enumerate(at):
        away = np.sqrt((x / 0.8) ** 2 + (at[:, None] / 0.9) ** 2 + (at / 0.85) ** 2)
        ball = (x - 0.3) ** 2 + (at[:, None] - 0.1) ** 2 + (at + 0.1) ** 2 < 0.15**2
        plane = np.where(away < 1, 600 + 200 * np.cos(9 * away), 20) + 400 * ball
        data[index] = np.maximum(plane + rng.normal(0, 12, plane.shape), 0)
    write_nifti(Volume(data, np.diag([230 / size, 230 / size, 230 / size, 1.0])), path)


def fine(path: Path) -> Path:
    """Write a ball of 1.3 million faces, as STL: each face has corners of its own."""
    write_mesh(icosphere(subdivisions=8), path)
    return path


def fill(client: Client, folder: Path, *, large: bool) -> dict[str, str]:
    """Give the platform something to show, also a `large` volume; ids by name."""
    head = folder / "head"
    coarse = ["--shape", "100", "120", "100", "--spacing", "1.6", "1.6", "1.6"]
    subprocess.run(
        [sys.executable, "-m", "shapery_segmentation.phantoms", str(head), "--seed", "7", *coarse], check=True
    )
    write_sequence_npz(folder / "ball.npz", *ball(120), shape=(120, 10_000))
    write_mesh(icosphere(subdivisions=3), folder / "ball.ply")
    post, pre = client.upload(head / "post.nii.gz"), client.upload(head / "pre.nii.gz")
    sequence, mesh = client.upload(folder / "ball.npz"), client.upload(folder / "ball.ply")
    jobs = {
        "segmentation": client.submit("segmentation", {"post": post.id, "pre": pre.id}),
        "motion": client.submit("motion-encode", {"sequence": sequence.id}, {"kg": 0.5, "preset": "fast", "fps": FPS}),
        "index": client.submit("shape-index", {"mesh": mesh.id}),
    }
    if large:
        shells(512, folder / "large.nii.gz")
        volume = client.upload(folder / "large.nii.gz")
        jobs["large"] = client.submit("segmentation", {"post": volume.id})
    ended = {name: client.wait(job.id) for name, job in jobs.items()}
    failed = {name: job.error for name, job in ended.items() if job.state != JobState.SUCCEEDED}
    if failed:
        raise RuntimeError(f"not ready to be looked at: {failed}")
    return {name: str(job.id) for name, job in ended.items()}

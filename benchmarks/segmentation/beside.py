"""The peers on the same cases, from the same seeds, on four inputs.

``whole``
    The calibrated difference Z = (post − (a·pre + b)) / MAD of the whole brain, as one would make it without us, and a
    ball of 3 mm around the point that our automatic search starts from: what a user's click would be.
``plain``
    The same, not over the whole brain but in the box of our flow and 16 voxels around it, which spares the peers time
    and farther leaks.
``plain from our seed``
    The same, from our flow's own seed surface, which has passed the gate and is near the border already.
``ours``
    The very arrays that our flow gets: the smoothed partial difference around the object, where the object may lie at
    all (the density gate), and the seed surface.
"""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from benchmarks.segmentation.cache import Cache, digest, digest_arrays
from benchmarks.segmentation.cases import ROOT, Case
from benchmarks.segmentation.flows import recorded
from benchmarks.segmentation.ours import ONE_THREAD, agreement
from benchmarks.segmentation.peers import PEERS
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume
from shapery_segmentation import segment
from shapery_segmentation.brain import Brain, find_brain
from shapery_segmentation.calibration import calibrate
from shapery_segmentation.labels import fill_enclosed, fill_indentations

INPUTS = {
    "whole": "the plain calibrated difference of the whole brain, a ball as seed",
    "plain": "the plain calibrated difference around the object, a ball as seed",
    "plain from our seed": "the plain calibrated difference around the object, our seed surface",
    "ours": "our input, leak gate and seed surface",
}

AROUND = 16
"""Voxels around the box of our flow."""

SEED_RADIUS = 3.0
"""mm of the ball."""

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Start:
    """What a peer begins with: part of the working grid, one per object."""

    box: tuple[slice, slice, slice]
    field: NDArray[np.float32]
    seed: BoolArray
    allowed: BoolArray


@dataclass(frozen=True)
class Prepared:
    """A case ready for the peers."""

    case: Case
    brain: Brain
    post: Volume
    starts: dict[str, list[Start]]
    flow_cpu_seconds: float


def prepare(case: Case) -> Prepared:
    """Run our own segmentation once and note what each of its flows began with."""
    post = read_volume(case.post)
    pre = read_volume(case.pre) if case.pre is not None else None
    with mock.patch.dict(os.environ, ONE_THREAD), recorded() as flows:
        found = segment(post, pre)
    brain = find_brain(pre if pre is not None else post, post)
    grid = brain.grid
    calibration = calibrate(brain, post, pre)
    plain = calibration.field
    if pre is not None:
        residual = grid.sample(post) - np.float32(calibration.slope) * grid.sample(pre) - np.float32(calibration.offset)
        known = np.isfinite(residual) & brain.mask
        centre = float(np.median(residual[known]))
        mad = float(np.median(np.abs(residual[known] - centre)))
        plain = np.where(known, (residual - np.float32(centre)) / np.float32(mad), np.float32(0)).astype(np.float32)
    starts: dict[str, list[Start]] = {name: [] for name in INPUTS}
    whole = tuple(slice(0, n) for n in grid.shape)
    boxes: list[tuple[slice, slice, slice]] = []
    for flow in flows:
        corner = np.rint(np.linalg.solve(grid.affine[:3, :3], flow.affine[:3, 3] - grid.affine[:3, 3])).astype(int)
        box = tuple(slice(int(c), int(c) + n) for c, n in zip(corner, flow.field.shape, strict=True))
        seed = rasterize(flow.seed, Volume(flow.field, flow.affine)) & flow.allowed
        starts["ours"].append(Start(box, flow.field, seed, flow.allowed))
        around = tuple(
            slice(max(b.start - AROUND, 0), min(b.stop + AROUND, n)) for b, n in zip(box, grid.shape, strict=True)
        )
        wide = np.zeros(grid.shape, dtype=np.bool_)
        wide[box] = seed
        starts["plain from our seed"].append(Start(around, plain[around], wide[around], brain.mask[around]))
        boxes.append(around)
    for item in found.report.objects:
        middle = np.linalg.solve(grid.affine[:3, :3], np.asarray(item.seed) - grid.affine[:3, 3])
        near = sum((axis - m) ** 2 for axis, m in zip(np.ogrid[whole], middle, strict=True))
        ball = np.asarray(near <= (SEED_RADIUS / grid.spacing) ** 2) & brain.mask
        # An object's seed lies in the box of its flow; flows that led to no object have none.
        box = max(boxes, key=lambda b, ball=ball: np.count_nonzero(ball[b]))
        starts["plain"].append(Start(box, plain[box], ball[box], brain.mask[box]))
        starts["whole"].append(Start(whole, plain, ball, brain.mask))
    return Prepared(case, brain, post, starts, sum(flow.cpu_seconds for flow in flows))


def measure(
    prepared: Prepared, given: str, peers: Sequence[str], cache: Cache, time_limit: float
) -> dict[str, list[dict[str, Any]]]:
    """Return for each of `peers` a row per setting: agreement with the reference, CPU seconds, or that it was late."""
    starts = prepared.starts[given]
    asked = [(peer, number) for peer in peers for number in range(len(PEERS[peer][2]))]
    grid = prepared.brain.grid

    def run() -> dict[str, list[dict[str, Any]]]:
        rows = {
            key: {"setting": PEERS[key[0]][2][key[1]], "cpu_seconds": 0.0, "peak_mib": 0.0, "late": False}
            for key in asked
        }
        found = {key: np.zeros(grid.shape, dtype=np.bool_) for key in asked}
        for start in starts:
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                np.savez(
                    folder / "input.npz", field=start.field, seed=start.seed, allowed=start.allowed,
                    spacing=grid.spacing,
                )  # fmt: skip
                for key, line in zip(asked, _lines(folder, asked, time_limit), strict=True):
                    row = rows[key]
                    row["cpu_seconds"] += line["cpu_seconds"]
                    row["peak_mib"] = max(row["peak_mib"], line["peak_mib"])
                    row["late"] |= line["late"]
                    if not line["late"]:
                        found[key][start.box] |= np.load(folder / f"{key[0]}-{key[1]}.npy")
        reference = read_volume(prepared.case.reference).data
        for key, row in rows.items():
            mask = found[key]
            core = fill_enclosed(mask, grid.spacing) | mask
            core |= fill_indentations(core, grid.spacing)
            row["enhancing"] = agreement(
                grid.to_source(mask), np.isin(reference, prepared.case.enhancing), prepared.post
            )
            row["core"] = agreement(grid.to_source(core), np.isin(reference, prepared.case.core), prepared.post)
        return {peer: [rows[key] for key in asked if key[0] == peer] for peer in peers}

    arrays = [part for start in starts for part in (start.field, start.seed, start.allowed)]
    key = digest(asked, time_limit, digest_arrays(*arrays), (Path(__file__).parent / "peers.py").read_text())
    result: dict[str, list[dict[str, Any]]] = cache.get(f"peers {prepared.case.name} {given}", key, run)
    return result


def _lines(folder: Path, asked: Sequence[tuple[str, int]], time_limit: float) -> list[dict[str, Any]]:
    """Run all settings; one that takes longer than the limit is ended, and the rest goes on in another process."""
    lines: list[dict[str, Any]] = []
    while len(lines) < len(asked):
        rest = [f"{peer}:{number}" for peer, number in asked[len(lines) :]]
        process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.segmentation.peers", str(folder), *rest],
            cwd=ROOT, env=os.environ | ONE_THREAD, stdout=subprocess.PIPE, bufsize=0,
        )  # fmt: skip
        assert process.stdout is not None
        with process, selectors.DefaultSelector() as ready:
            ready.register(process.stdout, selectors.EVENT_READ)
            while len(lines) < len(asked):
                began = time.monotonic()
                text = process.stdout.readline() if ready.select(time_limit) else None
                if text is None:
                    process.kill()
                    spent = time.monotonic() - began
                    lines.append({"cpu_seconds": spent, "iterations": 0, "peak_mib": 0.0, "late": True})
                    break
                if not text:
                    raise RuntimeError(f"the peers ended without a word at {asked[len(lines)]}")
                lines.append(json.loads(text))
    return lines

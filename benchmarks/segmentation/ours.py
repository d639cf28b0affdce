"""Cases from files to files in a process of its own: what a user waits for, and what it costs.

    python -m benchmarks.segmentation.ours      reads a line of JSON per case, prints one

The kernels are loaded by a small run first, as in a worker that has run before.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.segmentation.cases import ROOT, Case
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mask_metrics import mask_metrics
from shapery_geometry.mesh_io import read_mesh
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume

ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA", "MKL")}
"""The environment of what is compared with peers. Whole cases run as users run them, on two threads where it helps."""

RUNS = 3
"""Of each case: the speed of a machine that others use varies by a third."""


class Ours:
    """The process, started when the first case is asked for."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def measure(self, case: Case, folder: Path) -> dict[str, Any]:
        """Run a case and compare its labels with the reference."""
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "benchmarks.segmentation.ours"],
                cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            )  # fmt: skip
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        out = folder / "out"
        files = {"out": str(out), "post": str(case.post), "pre": str(case.pre) if case.pre is not None else None}
        self._process.stdin.write(json.dumps(files) + "\n")
        self._process.stdin.flush()
        text = self._process.stdout.readline()
        if not text:
            raise RuntimeError(f"the process ended without a word at {case.name}")
        return compared(json.loads(text), case, out)

    def close(self) -> None:
        """End the process."""
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.close()
            self._process.wait()


def compared(row: dict[str, Any], case: Case, out: Path) -> dict[str, Any]:
    """Return what a run told, and how its labels agree with the reference."""
    labels, reference = read_volume(out / "labels.nii.gz"), read_volume(case.reference).data
    for item in row["objects"]:
        # Counted anew, exactly, on the file as it was written.
        item["self_intersections"] = len(self_intersections(read_mesh(out / item["surface"])))
    truth = np.isin(reference, case.core)
    return row | {
        "name": case.name,
        "group": case.group,
        "weak": case.weak,
        "enhancing": agreement(labels.data == 1, np.isin(reference, case.enhancing), labels),
        "core": agreement(np.isin(labels.data, (1, 2)), truth, labels),
        "false_objects": sum(is_false(item["centroid"], item["volume_mm3"], truth, labels) for item in row["objects"]),
    }


def agreement(found: NDArray[np.bool_], reference: NDArray[np.bool_], grid: Volume) -> dict[str, float | None]:
    """Return all measures of agreement; those that are not finite become null."""
    measured = asdict(mask_metrics(found, reference, grid.spacing))
    return {key: value if isfinite(value) else None for key, value in measured.items()}


def is_false(centroid: list[float], volume: float, core: NDArray[np.bool_], grid: Volume) -> bool:
    """Tell whether an object lies off the tumor: no core within the radius of the object's ball around its centre."""
    index = np.rint(grid.to_index(np.asarray(centroid))).astype(int)
    reach = np.maximum(np.ceil((3 * volume / (4 * np.pi)) ** (1 / 3) / np.array(grid.spacing)), 1).astype(int)
    box = tuple(slice(max(i - r, 0), i + r + 1) for i, r in zip(index, reach, strict=True))
    return not bool(core[box].any())


def run(out: Path, post_path: Path, pre_path: Path | None) -> dict[str, Any]:
    """Run one case in this process, `RUNS` times: results are the same, of what it takes the medians count."""
    from benchmarks.segmentation.flows import recorded
    from shapery_segmentation import segment, write_outputs

    forget_peak()
    times = []
    for _ in range(RUNS):
        wall, cpu = time.perf_counter(), time.process_time()
        post = read_volume(post_path)
        pre = read_volume(pre_path) if pre_path is not None else None
        with recorded() as flows:
            result = segment(post, pre)
        write_outputs(result, out)
        times.append(
            {
                "wall_seconds": time.perf_counter() - wall,
                "cpu_seconds": time.process_time() - cpu,
                "flow_cpu_seconds": sum(call.cpu_seconds for call in flows),
                "flow_watched_seconds": sum(call.watched_seconds for call in flows),
            }
        )
    report = result.report.model_dump(mode="json")
    return {
        "objects": report["objects"],
        "alignments": report["alignments"],
        "stages": {stage["name"]: stage["seconds"] for stage in report["stages"]},
        "warnings": report["warnings"],
        "flow_iterations": [call.iterations for call in flows],
        "peak_mib": peak_mib(),
    } | {name: median(each[name] for each in times) for name in times[0]}


def forget_peak() -> None:
    """Let the peak of resident memory begin anew, where the system can."""
    clear = Path("/proc/self/clear_refs")
    if clear.exists():
        clear.write_text("5")


def peak_mib() -> float:
    """Return the peak of resident memory since `forget_peak`."""
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM"):
                return float(line.split()[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> None:
    """Run the cases that are asked for on the standard input."""
    from shapery_segmentation.warm import warm

    warm()
    for line in sys.stdin:
        given = json.loads(line)
        row = run(Path(given["out"]), Path(given["post"]), Path(given["pre"]) if given["pre"] else None)
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()

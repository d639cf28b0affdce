"""One case from files to files in a process of its own: what a user waits for, and what it costs.

    python -m benchmarks.segmentation.ours OUT POST [PRE]

The kernels are loaded by a small run first, as in a worker that has run before. Prints one line of JSON.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.segmentation.cases import ROOT, Case
from shapery_geometry.mask_metrics import mask_metrics
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume

ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA", "MKL")}


def measure(case: Case, folder: Path) -> dict[str, Any]:
    """Run a case in a process of its own and compare its labels with the reference."""
    out = folder / "out"
    files = [case.post] + ([case.pre] if case.pre is not None else [])
    command = [sys.executable, "-m", "benchmarks.segmentation.ours", str(out), *map(str, files)]
    done = subprocess.run(command, cwd=ROOT, env=os.environ | ONE_THREAD, capture_output=True, text=True, check=True)
    row: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    labels, reference = read_volume(out / "labels.nii.gz"), read_volume(case.reference).data
    truth = np.isin(reference, case.core)
    row |= {
        "name": case.name,
        "group": case.group,
        "weak": case.weak,
        "enhancing": agreement(labels.data == 1, np.isin(reference, case.enhancing), labels),
        "core": agreement(np.isin(labels.data, (1, 2)), truth, labels),
        "false_objects": sum(_false(item["centroid"], item["volume_mm3"], truth, labels) for item in row["objects"]),
    }
    return row


def agreement(found: NDArray[np.bool_], reference: NDArray[np.bool_], grid: Volume) -> dict[str, float | None]:
    """Return all measures of agreement; those that are not finite become null."""
    measured = asdict(mask_metrics(found, reference, grid.spacing))
    return {key: value if isfinite(value) else None for key, value in measured.items()}


def _false(centroid: list[float], volume: float, core: NDArray[np.bool_], grid: Volume) -> bool:
    """Tell whether an object lies off the tumor: no core within the radius of the object's ball around its centre."""
    index = np.rint(grid.to_index(np.asarray(centroid))).astype(int)
    reach = np.maximum(np.ceil((3 * volume / (4 * np.pi)) ** (1 / 3) / np.array(grid.spacing)), 1).astype(int)
    box = tuple(slice(max(i - r, 0), i + r + 1) for i, r in zip(index, reach, strict=True))
    return not bool(core[box].any())


def main(out: Path, post_path: Path, pre_path: Path | None) -> None:
    """Run one case in this process."""
    from benchmarks.segmentation.flows import recorded
    from shapery_segmentation import segment, write_outputs
    from shapery_segmentation.warm import warm

    warm()
    base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wall, cpu = time.perf_counter(), time.process_time()
    post = read_volume(post_path)
    pre = read_volume(pre_path) if pre_path is not None else None
    with recorded() as flows:
        result = segment(post, pre)
    write_outputs(result, out)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    report = result.report.model_dump(mode="json")
    print(
        json.dumps(
            {
                "objects": report["objects"],
                "stages": {stage["name"]: stage["seconds"] for stage in report["stages"]},
                "warnings": report["warnings"],
                "wall_seconds": wall,
                "cpu_seconds": cpu,
                "flow_cpu_seconds": sum(call.cpu_seconds for call in flows),
                "flow_iterations": [call.iterations for call in flows],
                "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
                "warm_mib": base / 1024,
            }
        )
    )


if __name__ == "__main__":
    given = [Path(text) for text in sys.argv[1:]]
    main(given[0], given[1], given[2] if len(given) > 2 else None)

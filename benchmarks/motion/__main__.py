"""``python -m benchmarks.motion``: measure, and write ``benchmarks/results/motion*``.

Every sequence and method is measured in a process of its own, one after the other, and what was measured is kept in
``benchmarks/results/motion/`` at once: a run that was stopped goes on where it was. ``--again`` forgets what is kept of
the methods and sequences asked for. A fresh checkout begins with what ``benchmarks/results/motion.json`` tells.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.motion import chapter, decoding, growth, report
from benchmarks.motion.case import DATA, RESULTS, ROOT, TARGETS, Case, Method, load
from benchmarks.motion.ours import affine_points, file, spectral_points
from benchmarks.motion.quantised import delta_lzma, delta_parallelogram, delta_zstd, draco
from benchmarks.motion.subspaces import clustered_pca, shape_pca, trajectory_pca
from shapery_motion.errors import sequence_errors
from shapery_motion.warm import warm

KEPT = RESULTS / "motion"
TOLD = 0.1
"""KG error at which the report tells times and memory."""
PARTS = ("rates", "decoding", "growth", "chapter")
SEQUENCES = ("crane", "chickenCrossing", "horse-gallop", "pdance", "pcow", "mmface4d-3k")

METHODS: dict[str, Method] = {
    "trajectory": lambda case, kg: file(
        case, kg, profile="trajectory", keep=decoding.place_of(case.name) if kg == TOLD else None
    ),
    "trajectory-fast": lambda case, kg: file(case, kg, profile="trajectory", preset="fast"),
    "gradient": lambda case, kg: file(case, kg, profile="gradient"),
    "clustered-pca": lambda case, kg: clustered_pca(case, kg, plain=True),
    "clustered-pca-strong": clustered_pca,
    "trajectory-pca": trajectory_pca,
    "shape-pca": shape_pca,
    "delta-parallelogram": delta_parallelogram,
    "delta-lzma": delta_lzma,
    "delta-zstd": delta_zstd,
    "draco": draco,
}
BASELINES: dict[str, Callable[[Case], Any]] = {
    "spectral-positions": lambda case: spectral_points(case, (100, 300), "positions"),
    "spectral-differences": lambda case: spectral_points(case, (100, 300), "differences"),
    "affine-clusters": lambda case: affine_points(case, (16, 64, 256)),
    "text": chapter.text_points,
}


def measured(case: Case, method: Method, kg: float) -> dict[str, Any]:
    """Run a method at one target."""
    start = time.process_time()
    coded = method(case, kg)
    total = time.process_time() - start
    if coded is None:
        return {"reached": False}
    # single precision, as the files give it and as the originals are
    decoded = coded.decoded.astype(np.float32)
    errors = sequence_errors(case.frames.astype(np.float32), decoded, case.faces)
    count = len(case.frames)
    decode = 0.0 if math.isnan(coded.decode_seconds) else coded.decode_seconds
    return {
        "reached": True,
        "bits": 8 * coded.motion_bytes / case.numbers,
        "motion_bytes": coded.motion_bytes,
        "connectivity_bytes": coded.connectivity_bytes,
        **errors.summary(),
        "encode_cpu_seconds_per_frame": (total - decode) / count,
        "decode_cpu_seconds_per_frame": decode / count,
        "settings": coded.settings,
    }


def child(name: str, method: str, targets: list[float]) -> None:
    """Measure one method on one sequence, and keep each result at once."""
    case = load(name)
    place = KEPT / f"{name}.{method}.json"
    kept: dict[str, Any] = json.loads(place.read_text()) if place.exists() else {"points": {}}
    # In a worker kernels are loaded once, not with every file.
    warm()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    if method in BASELINES:
        kept["points"] = BASELINES[method](case)
    else:
        # the one whose times and memory are told has a process that nothing was done in before
        for kg in sorted(targets, key=lambda kg: kg != TOLD):
            if str(kg) not in kept["points"]:
                kept["points"][str(kg)] = measured(case, METHODS[method], kg)
                if kg == TOLD or "peak_megabytes_above_input" not in kept:
                    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
                    kept["peak_megabytes_above_input"] = (peak - before) / 1024
                place.write_text(json.dumps(kept, indent=1) + "\n")
    place.write_text(json.dumps(kept, indent=1) + "\n")


def complete(name: str, method: str, targets: list[float]) -> bool:
    """Whether all that is asked for is kept already."""
    place = KEPT / f"{name}.{method}.json"
    if not place.exists():
        return False
    points = json.loads(place.read_text())["points"]
    return bool(points) and (method in BASELINES or all(str(kg) in points for kg in targets))


def main() -> None:
    """Measure what is asked for, and write the report on all that is kept."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sequences", default=",".join(SEQUENCES), help="names of the shared data, by commas")
    parser.add_argument("--methods", default=",".join([*METHODS, *BASELINES]))
    parser.add_argument("--targets", default=",".join(map(str, TARGETS)), help="KG errors in percent")
    parser.add_argument("--again", action="store_true", help="measure anew what was measured before")
    parser.add_argument("--parts", default=",".join(PARTS), help="what to measure: any of these, by commas")
    parser.add_argument("--report", action="store_true", help="measure nothing, write the report only")
    parser.add_argument("--child", nargs=2, metavar=("SEQUENCE", "METHOD"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    targets = [float(kg) for kg in options.targets.split(",")]
    KEPT.mkdir(parents=True, exist_ok=True)
    if options.child:
        name, method = options.child
        child(name, method, targets)
        return
    report.restore(KEPT)
    if not (options.report or DATA.is_dir()):
        raise SystemExit("the shared data is not beside this checkout (set SHAPERY_TEST_DATA to its folder)")
    parts = set() if options.report else set(options.parts.split(","))
    if not parts <= set(PARTS):
        parser.error(f"parts are {', '.join(PARTS)}")
    if "rates" in parts:
        for name in options.sequences.split(","):
            for method in options.methods.split(","):
                if options.again:
                    (KEPT / f"{name}.{method}.json").unlink(missing_ok=True)
                if complete(name, method, targets):
                    continue
                print(name, method, flush=True)
                command = [sys.executable, "-m", "benchmarks.motion", "--targets", options.targets]
                subprocess.run([*command, "--child", name, method], check=True)
    if "decoding" in parts and (options.again or not decoding.KEPT.exists()):
        print("decoding", flush=True)
        decoding.measure(options.sequences.split(","))
    if "growth" in parts and (options.again or not growth.KEPT.exists()):
        print("growth", flush=True)
        growth.measure()
    if "chapter" in parts and (options.again or not chapter.complete()):
        print("chapter 5", flush=True)
        chapter.measure()
    if not any(KEPT.glob("*.*.json")):
        raise SystemExit(f"nothing is kept in {KEPT.relative_to(ROOT)} to report on")
    report.write(KEPT)


if __name__ == "__main__":
    main()

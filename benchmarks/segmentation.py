"""Segmentation of the real cases beside the checkout, with the default setting: agreement with the expert, and cost.

    python -m benchmarks.segmentation

Writes ``benchmarks/results/segmentation.json`` and ``.md``. Each case runs through the library in this process after
a warm-up, from the raw files, with no option but the two volumes.
"""

from __future__ import annotations

import json
import os
import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np

from shapery_geometry.mask_metrics import mask_metrics
from shapery_geometry.volume_io import read_volume
from shapery_segmentation import segment
from shapery_segmentation.warm import warm

ROOT = Path(__file__).resolve().parent.parent
DATA = Path(os.environ.get("SHAPERY_TEST_DATA", ROOT.parent / "shared" / "data")) / "volumes"
RESULTS = Path(__file__).resolve().parent / "results"


def enhancing_label(case: str) -> int:
    """Return the expert's label of the enhancing tumor: 3 since 2023, 4 before."""
    return 3 if case.startswith("tumor_brats23") else 4


def run(case: Path) -> dict[str, Any]:
    """Segment one case and compare it with the expert."""
    wall, cpu = time.perf_counter(), time.process_time()
    post, pre = read_volume(case / "t1c.nii.gz"), read_volume(case / "t1.nii.gz")
    found = segment(post, pre)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    expert, labels = read_volume(case / "seg.nii.gz").data, found.labels.data
    enhancing = enhancing_label(case.name)
    spacing = tuple(float(step) for step in post.spacing)
    et = mask_metrics(labels == 1, expert == enhancing, spacing)
    tc = mask_metrics(np.isin(labels, (1, 2)), np.isin(expert, (1, enhancing)), spacing)
    return {
        "case": case.name,
        "expert_voxels": int((expert == enhancing).sum()),
        "objects": len(found.report.objects),
        "confidence": [item.confidence for item in found.report.objects],
        "self_intersections": sum(item.self_intersections for item in found.report.objects),
        "enhancing": {"iou": et.iou, "dice": et.dice, "assd_mm": et.assd_mm, "hd95_mm": et.hd95_mm},
        "core": {"iou": tc.iou, "dice": tc.dice, "assd_mm": tc.assd_mm, "hd95_mm": tc.hd95_mm},
        "wall_seconds": wall,
        "cpu_seconds": cpu,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Return the results as Markdown."""
    lines = [
        "# Segmentation of real cases, default setting",
        "",
        "IoU with the expert's mask; distances in mm. In a case without enhancing tumor there is nothing to overlap:",
        "what counts is that no object is found.",
        "",
        "| case | expert voxels | objects | enhancing IoU | core IoU | ASSD | HD95 | self-int. | wall s | CPU s |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        et, tc = row["enhancing"], row["core"]
        lines.append(
            f"| {row['case']} | {row['expert_voxels']} | {row['objects']} | {et['iou']:.3f} | {tc['iou']:.3f} "
            f"| {et['assd_mm']:.2f} | {et['hd95_mm']:.2f} | {row['self_intersections']} "
            f"| {row['wall_seconds']:.2f} | {row['cpu_seconds']:.2f} |"
        )
    lines += ["", f"Median CPU seconds of a case: {statistics.median(row['cpu_seconds'] for row in rows):.2f}."]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run every case that is there."""
    cases = sorted(path.parent for path in DATA.glob("tumor_brats*/seg.nii.gz"))
    if not cases:
        raise SystemExit(f"no cases in {DATA.name}: put the data beside the checkout, or set SHAPERY_TEST_DATA")
    warm()
    rows = []
    for case in cases:
        rows.append(run(case))
        print(f"{case.name}: {rows[-1]['objects']} objects, enhancing IoU {rows[-1]['enhancing']['iou']:.3f}")
    (RESULTS / "segmentation.json").write_text(json.dumps(rows, indent=1) + "\n")
    (RESULTS / "segmentation.md").write_text(table(rows))


if __name__ == "__main__":
    main()

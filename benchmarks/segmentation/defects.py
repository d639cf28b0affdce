"""What aging (S5) and geometric interpolation (S8) earn where the data are not all there: blobs with a known border."""

from __future__ import annotations

from dataclasses import replace
from statistics import mean
from typing import Any, get_args

import numpy as np

from benchmarks.segmentation.cache import Cache
from benchmarks.segmentation.tables import Row, shown, table
from shapery_geometry.mask_metrics import intersection_over_union
from shapery_geometry.mesh import icosphere
from shapery_geometry.rasterize import rasterize
from shapery_segmentation.flow.interpolation import WORTHWHILE
from shapery_segmentation.flow.normal import NormalFlowParams, normal_flow
from shapery_segmentation.phantoms.blob import Defect, defective_blob

SEEDS = range(5)
"""Other shape, other noise, other places that are lost."""

FLOWS: dict[str, dict[str, Any]] = {
    "the default": {},
    "no damping, steps of half an edge, rest after eight iterations": {"damping": 1.0, "step": 0.5, "window": 8},
}

LEFT_OUT: dict[str, dict[str, Any]] = {
    "nothing": {},
    "S5": {"aging_limit": None},
    "S8": {"interpolation_share": None},
    "both": {"aging_limit": None, "interpolation_share": None},
}


def measure(defect: Defect, seed: int) -> list[Row]:
    """Return a row per flow and per part that is left out."""
    phantom = defective_blob(np.random.default_rng(seed), defect)
    field = np.asarray(phantom.volume.data)
    base = NormalFlowParams(threshold_share=None, edge_lengths=(2.0, 1.3), interpolation_share=WORTHWHILE)
    rows = []
    for flow, changes in FLOWS.items():
        for left_out, off in LEFT_OUT.items():
            found = normal_flow(
                field, None, phantom.volume.affine, icosphere(phantom.center, 7.0, 2), replace(base, **changes, **off),
                threshold=0.0,
            )  # fmt: skip
            off_by = np.abs(phantom.distance(found.mesh.vertices))
            rows.append(
                {
                    "defect": defect,
                    "flow": flow,
                    "left_out": left_out,
                    "iou": intersection_over_union(rasterize(found.mesh, phantom.volume), phantom.truth.data),
                    "distance": float(off_by.mean()),
                    "distance95": float(np.percentile(off_by, 95)),
                    "iterations": found.iterations,
                    "oscillations": found.oscillations,
                    "interpolations": found.interpolations,
                }
            )
    return rows


def measured(cache: Cache, key: str) -> list[Row]:
    """Return what `section` shows."""
    return [
        row
        for defect in get_args(Defect)
        for seed in SEEDS
        for row in cache.get(f"defect {defect} {seed}", key, lambda d=defect, s=seed: measure(d, s))
    ]


def section(rows: list[Row]) -> list[str]:
    """Return the lines of the page."""
    lines = [
        "",
        "## Where the data are not all there",
        "",
        f"Blobs of 16 mm with a known border, means over {len(SEEDS)} shapes and noises. Noise: SNR 1.2. Gap: in a",
        "cone from the middle the border is lost. Stripes: two of seven slices are lost. Patches: three tenths of the",
        "volume are. What is lost is as likely inside as outside; the SNR is 5 but for noise.",
    ]
    for flow in FLOWS:
        cells = []
        for defect in get_args(Defect):
            for left_out in LEFT_OUT:
                chosen = [r for r in rows if (r["flow"], r["defect"], r["left_out"]) == (flow, defect, left_out)]

                def over(what: str, chosen: list[Row] = chosen) -> float:
                    return mean(float(row[what]) for row in chosen)

                cells.append(
                    [
                        defect,
                        left_out,
                        shown(over("iou")),
                        shown(over("distance"), 2),
                        shown(over("distance95"), 2),
                        shown(over("iterations"), 0),
                        shown(over("oscillations"), 0),
                        shown(over("interpolations"), 1),
                    ]
                )
        head = (
            "lost", "left out", "IoU", "mean distance mm", "95 % of it below", "iterations",
            "oscillating, all iterations", "interpolations",
        )  # fmt: skip
        lines += ["", f"**{flow[0].upper()}{flow[1:]}**", "", *table(head, cells)]
    return lines

"""What damping, aging (S5) and geometric interpolation (S8) earn on whole cases: each flow with and without them."""

from __future__ import annotations

from dataclasses import asdict, replace
from statistics import mean
from typing import Any

import numpy as np

from benchmarks.segmentation.cases import Case
from benchmarks.segmentation.flows import recorded
from benchmarks.segmentation.tables import Row, shown, table
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume
from shapery_segmentation import segment
from shapery_segmentation.flow.ablation import COMBINATIONS, ablate
from shapery_segmentation.flow.interpolation import WORTHWHILE

SETTINGS: dict[str, dict[str, Any]] = {
    "the default": {},
    "steps of half an edge, rest after eight iterations": {"step": 0.5, "window": 8},
}
"""Parameters of the flow that are measured: ours, where vertices oscillate little because they take small steps and
sleep soon, and one as explicit flows usually are."""


def measure(case: Case) -> list[Row]:
    """Return, for every flow of a case, a row per combination of what is left out."""
    post = read_volume(case.post)
    pre = read_volume(case.pre) if case.pre is not None else None
    reference = read_volume(case.reference)
    truth = reference.with_data(np.isin(reference.data, case.enhancing).astype(np.float32))
    with recorded() as flows:
        segment(post, pre)
    rows: list[Row] = []
    for number, flow in enumerate(flows, start=1):
        there = np.nan_to_num(truth.resampled_to(Volume(flow.field, flow.affine)).data) > 0.5
        for setting, changes in SETTINGS.items():
            params = replace(flow.params, interpolation_share=WORTHWHILE, **changes)
            measured = ablate(flow.field, flow.allowed, flow.affine, flow.seed, there, params, threshold=flow.threshold)
            named = {"flow": f"{case.name}, {number}", "setting": setting, "vertices": flow.vertices}
            rows += [named | asdict(row) for row in measured]
    return rows


def ablation_table(by_case: dict[str, list[Row]], setting: str) -> list[str]:
    """Return the means over all flows with one setting, a line per combination."""
    rows = [row for of_case in by_case.values() for row in of_case if row["setting"] == setting]
    lines = []
    for without in COMBINATIONS:
        chosen = [row for row in rows if tuple(row["without"]) == without]

        def over(what: str, chosen: list[Row] = chosen) -> float:
            return mean(float(row[what]) for row in chosen)

        lines.append(
            [
                ", ".join(without) or "nothing",
                shown(over("iou"), 4),
                shown(over("iterations"), 1),
                f"{sum(row['converged'] for row in chosen)}/{len(chosen)}",
                shown(over("oscillating"), 0),
                shown(over("oscillations"), 0),
                shown(over("aged"), 0),
                shown(over("interpolations"), 1),
                shown(over("cpu_seconds"), 2),
            ]
        )
    head = (
        "left out", "IoU", "iterations", "converged", "most oscillating vertices", "oscillating, all iterations",
        "aged", "interpolations", "CPU s",
    )  # fmt: skip
    return table(head, lines)


def by_flow_table(by_case: dict[str, list[Row]], setting: str) -> list[str]:
    """Return flow by flow what leaving out either part, or both, does without damping, as in the dissertation."""
    shown_combinations: dict[tuple[str, ...], str] = {
        ("damping",): "both",
        ("damping", "aging"): "without S5",
        ("damping", "interpolation"): "without S8",
        ("damping", "aging", "interpolation"): "without both",
    }
    found: dict[str, dict[tuple[str, ...], Row]] = {}
    for rows in by_case.values():
        for row in (row for row in rows if row["setting"] == setting):
            found.setdefault(row["flow"], {})[tuple(row["without"])] = row
    lines: list[list[str]] = []
    for name, combinations in found.items():
        cells: list[Any] = [combinations[key] for key in shown_combinations]
        lines.append(
            [name, str(cells[0]["vertices"])]
            + [f"{shown(c['iou'])} / {c['iterations']} / {c['oscillations']}" for c in cells]
        )
    return table(("flow", "vertices", *shown_combinations.values()), lines)

"""The one page of results: every part as it was last measured, each with the machine that it was measured on."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from statistics import mean
from typing import Any

from benchmarks.segmentation import ablation, defects, settings, tables, variants, vessels
from benchmarks.segmentation.cases import MEASURED_MM3, VISIBLE_MM3

Results = dict[str, Any]

PARTS = ("real", "variants", "peers", "settings", "ablation", "defects", "phantoms", "vessels", "growth")
"""In the order in which they are measured and shown."""


def read(path: Path) -> Results:
    """Return what was measured before; nothing where there is no such file."""
    results: Results = json.loads(path.read_text()) if path.exists() else {}
    return results


def merged(before: Results, now: Results) -> Results:
    """Return earlier results with the parts that were measured again replaced.

    Peers are kept run by run, because only times of one run can be compared: a run takes the place of those before it
    whose peers, inputs and cases it has all measured, too.
    """
    both = before | now
    if "peers" in now:
        new = now["peers"][0]
        left = [
            run
            for run in before.get("peers", [])
            if not all(set(of(run)) <= set(of(new)) for of in (lambda r: r["peers"], lambda r: r["rows"], _names))
        ]
        both["peers"] = [new, *left]
    both["measured"] = before.get("measured", {}) | now["measured"]
    return {key: both[key] for key in ("measured", *PARTS) if key in both}


def counts(row: dict[str, Any]) -> bool:
    """Return whether a case counts in the means."""
    return bool(row["group"] == "real" and row["enhancing"]["reference_mm3"] >= MEASURED_MM3)


def document(results: Results) -> str:
    """Return the Markdown page."""
    real = results.get("real", [])
    text = [
        "# Segmentation",
        "",
        "Made by `make bench-segmentation`, or part by part by `python -m benchmarks.segmentation --part …`: automatic",
        "seeds, one default setting for all cases, from files to files, kernels loaded. ASSD, HD95 and the volume's",
        "difference are of the enhancing part. Where the expert marked no enhancing tumor there is nothing to",
        "overlap: what counts is that no object is found. The expert's core includes tumor that does not enhance,",
        "which the method cannot see by its nature. Times of whole cases are medians of three runs on two",
        "threads; peers, and what is compared with them, have one. Under load CPU seconds rise, too: compare times",
        "within a part.",
        "",
        *_machines(results),
    ]
    for group in dict.fromkeys(row["group"] for row in real):
        text += ["", f"## {group[0].upper()}{group[1:]} cases", ""]
        text += tables.cases_table([row for row in real if row["group"] == group])
    counted = [row for row in real if counts(row)]
    clear = [row["name"] for row in counted if not row["weak"]]
    if counted:
        text += ["", f"Means over the cases with at least {MEASURED_MM3 / 1000:.0f} ml of enhancing tumor:", ""]
        text += tables.means(counted)
    if "settings" in results and clear:
        loco = tables.held_out(results["settings"], [row["name"] for row in counted])
        text += [
            "",
            "Leave one case out: each case with the setting (share of the median, weight of the curvature; "
            f"{len(settings.SETTINGS)} combinations) that is best on the others: enhancing IoU "
            f"{mean(loco[name] for name in clear):.3f} clear, {mean(loco.values()):.3f} all. By case: "
            + ", ".join(f"{name} {value:.3f}" for name, value in loco.items())
            + ".",
        ]
    if "variants" in results:
        text += variants.section(results["variants"], MEASURED_MM3, VISIBLE_MM3)
    if "peers" in results:
        text += [
            "",
            "## Beside peers",
            "",
            "Every peer runs from the same seeds with a grid of settings; shown is the setting that is best on these",
            "very cases, which favours it, and beside it what is left when each case's setting is chosen on the",
            "others. CPU seconds are of the method alone, mean over cases; ours is that of the flow in the same run.",
            "On the whole brain a peer runs as without us. In the other tables it works in the box of our flow, with",
            "16 voxels around it on the plain difference: this spares it time and leaks.",
        ]
        for run in results["peers"]:
            text += _beside(run)
    if "ablation" in results:
        text += _ablation(results["ablation"])
    if "defects" in results:
        text += defects.section(results["defects"])
    if "phantoms" in results:
        text += ["", "## Phantoms", "", "Heads with known truth, as the real cases are done:", ""]
        text += tables.cases_table(results["phantoms"]["heads"])
        text += ["", "Blobs with a known border, through the general mode from a seed in their middle:", ""]
        text += tables.blobs_table(results["phantoms"]["blobs"])
    if "vessels" in results:
        text += ["", *vessels.section(results["vessels"])]
    if "growth" in results:
        text += ["", "## Growth", "", *tables.growth_table(results["growth"])]
    return "\n".join(text) + "\n"


def _machines(results: Results) -> list[str]:
    rows = [
        (
            part,
            str(machine["cpus"]),
            machine["python"],
            f"{machine['load_at_start']:.1f}",
            f"{machine['load_at_end']:.1f}",
        )
        for part in PARTS
        if part in results and (machine := results["measured"].get(part)) is not None
    ]
    return tables.table(("part", "CPUs", "Python", "load at its start", "at its end"), rows)


def _names(run: dict[str, Any]) -> list[str]:
    """Return the cases that all peers of a run were measured on, in their order."""
    every = [of_peer for of_input in run["rows"].values() for of_peer in of_input.values()]
    return [row["name"] for row in run["ours"] if all(row["name"] in of_peer for of_peer in every)]


def _beside(run: dict[str, Any]) -> list[str]:
    names = _names(run)
    ours = {row["name"]: row for row in run["ours"] if row["name"] in names}
    machine = run["machine"]
    text = [
        "",
        f"### {len(run['peers'])} peer{'s' if len(run['peers']) > 1 else ''} on {', '.join(names)}",
        "",
        f"Load {machine['load_at_start']:.1f} at the start and {machine['load_at_end']:.1f} at the end.",
        *tables.peers_table(ours, run["rows"], names, [name for name in names if not ours[name]["weak"]]),
    ]
    if all("threshold_level_set" in of_input for of_input in run["rows"].values()):
        text += ["", *tables.ratio_lines(ours, run["rows"], names)]
    return text


def _ablation(by_case: dict[str, Sequence[dict[str, Any]]]) -> list[str]:
    text = [
        "",
        "## What the parts of the flow earn",
        "",
        "The flows of all cases with an object, from the same seed surfaces, means over them; IoU is of the voxels",
        "inside the surface with the enhancing tumor. Damping is ours: without it, as in the dissertation, aging (S5)",
        "has more to do. Interpolation (S8) is for data that are not all there, and measured on such below; tumors are",
        "done without it. Model selection (S9) is measured on vessels.",
    ]
    for setting in ablation.SETTINGS:
        text += [
            "",
            f"**{setting[0].upper()}{setting[1:]}**",
            "",
            *ablation.ablation_table({name: list(rows) for name, rows in by_case.items()}, setting),
            "",
            "Flow by flow, all without damping: IoU / iterations / oscillating vertices over all iterations.",
            "",
            *ablation.by_flow_table({name: list(rows) for name, rows in by_case.items()}, setting),
        ]
    return text

"""Measure, and write ``benchmarks/results/segmentation.json`` and ``.md``, or a part of it under another name."""

from __future__ import annotations

import argparse
import json
import os
import platform
import tempfile
from collections.abc import Sequence
from pathlib import Path
from statistics import mean
from typing import Any

import benchmarks.segmentation as package
from benchmarks.segmentation import ablation, beside, blobs, growth, ours, settings, tables
from benchmarks.segmentation.cache import Cache, digest, digest_sources
from benchmarks.segmentation.cases import DATA, MEASURED_MM3, ROOT, Case, head_cases, real_cases
from benchmarks.segmentation.peers import PEERS

RESULTS = ROOT / "benchmarks" / "results"
PARTS = ("real", "peers", "settings", "ablation", "phantoms", "growth")
OUR_SOURCES = (ROOT / "services" / "segmentation" / "shapery_segmentation",)


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(prog="benchmarks.segmentation", description=package.__doc__)
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the real volumes")
    parser.add_argument("--part", nargs="*", choices=PARTS, default=list(PARTS), help="what to measure")
    parser.add_argument("--only", nargs="*", default=[], help="parts of the names of the cases to measure")
    parser.add_argument("--peer", nargs="*", choices=list(PEERS), default=list(PEERS), help="peers to measure")
    parser.add_argument("--beside", nargs="*", default=[], help="parts of the names of the cases to run peers on")
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "shapery-bench-segmentation")
    parser.add_argument("--time-limit", type=float, default=180.0, help="seconds for one setting of one peer")
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--name", default="segmentation", help="of the files with the results, without ending")
    given = parser.parse_args()
    cache = Cache(given.cache)
    real = [case for case in real_cases(given.data) if _wanted(case, given.only)] if given.data.is_dir() else []
    if not real:
        print(f"no real cases in {given.data.name}: put the data beside the checkout, or set SHAPERY_TEST_DATA")
    key = digest(digest_sources(*OUR_SOURCES), (Path(__file__).parent / "ours.py").read_text())
    process = ours.Ours()
    results: dict[str, Any] = {"machine": _machine(), "parts": given.part}
    if "real" in given.part or "peers" in given.part:
        results["real"] = [_ours(case, process, cache, key) for case in real]
    counted = [c for c, row in zip(real, results.get("real", []), strict=False) if _counts(row)]
    if "peers" in given.part and counted:
        results["peers"] = _peers([c for c in counted if _wanted(c, given.beside)], given.peer, cache, given.time_limit)
    if "settings" in given.part and counted:
        results["settings"] = {c.name: cache.get(f"settings {c.name}", key, lambda c=c: _settings(c)) for c in counted}
    heads = []
    if "phantoms" in given.part or "ablation" in given.part:
        heads = [case for case in head_cases(given.cache) if _wanted(case, given.only)]
    if "ablation" in given.part:
        rows = {c.name: cache.get(f"ablation {c.name}", key, lambda c=c: _ablation(c)) for c in [*real, *heads]}
        results["ablation"] = {name: of_case for name, of_case in rows.items() if of_case}
    if "phantoms" in given.part:
        results["blobs"] = [cache.get(f"blob {name}", key, lambda n=name: blobs.measure(n)) for name in blobs.BLOBS]
        results["phantoms"] = [_ours(case, process, cache, key) for case in heads]
    process.close()
    if "growth" in given.part:
        results["growth"] = _growth(cache, key, given.time_limit)
    results["machine"]["load_at_end"] = os.getloadavg()[0]
    given.results.mkdir(parents=True, exist_ok=True)
    (given.results / f"{given.name}.json").write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n")
    (given.results / f"{given.name}.md").write_text(document(results))


def _wanted(case: Case, parts: Sequence[str]) -> bool:
    return not parts or any(part in case.name for part in parts)


def _counts(row: dict[str, Any]) -> bool:
    return row["group"] == "real" and row["enhancing"]["reference_mm3"] >= MEASURED_MM3


def _ours(case: Case, process: ours.Ours, cache: Cache, key: str) -> dict[str, Any]:
    def run() -> dict[str, Any]:
        with tempfile.TemporaryDirectory() as folder:
            return process.measure(case, Path(folder))

    row: dict[str, Any] = cache.get(f"ours {case.name}", key, run)
    found = tables.shown(row["enhancing"]["iou"]), tables.shown(row["core"]["iou"])
    print(f"{case.name}: {len(row['objects'])} objects, IoU enhancing {found[0]}, core {found[1]}", flush=True)
    return row


def _peers(cases: Sequence[Case], peers: Sequence[str], cache: Cache, time_limit: float) -> dict[str, Any]:
    rows: dict[str, Any] = {given: {peer: {} for peer in peers} for given in beside.INPUTS}
    for case in cases:
        prepared = beside.prepare(case)
        for given in beside.INPUTS:
            for peer, measured in beside.measure(prepared, given, peers, cache, time_limit).items():
                rows[given][peer][case.name] = measured
                best = max(row["enhancing"]["iou"] or 0.0 for row in measured)
                print(f"{case.name}, {given}: {peer} at best {best:.3f}", flush=True)
    return rows


def _settings(case: Case) -> list[dict[str, Any]]:
    print(f"{case.name}: {len(settings.SETTINGS)} settings of ours", flush=True)
    return settings.measure(case)


def _ablation(case: Case) -> list[dict[str, Any]]:
    print(f"{case.name}: flows with and without their parts", flush=True)
    return ablation.measure(case)


def _growth(cache: Cache, key: str, time_limit: float) -> list[dict[str, Any]]:
    asked = [(what, side) for what in ("volume", "flow", "peer") for side in growth.SIDES]
    asked += [("faces", count) for count in growth.FACES]
    rows = []
    for what, number in asked:
        rows.append(
            cache.get(
                f"growth {what} {number}", key, lambda w=what, n=number: growth.measure(w, n, max(time_limit, 600.0))
            )
        )
        print(f"{what} {number}: {rows[-1].get('cpu_seconds', 'too late')}", flush=True)
    return rows


def _machine() -> dict[str, Any]:
    return {"cpus": os.cpu_count(), "python": platform.python_version(), "load_at_start": os.getloadavg()[0]}


def document(results: dict[str, Any]) -> str:
    """Return the Markdown page."""
    machine, parts = results["machine"], results.get("parts", PARTS)
    command = "make bench-segmentation"
    if set(parts) != set(PARTS):
        command = f"python -m benchmarks.segmentation --part {' '.join(parts)}"
    text = [
        "# Segmentation",
        "",
        f"Made by `{command}`: automatic seeds, one default setting for all cases, from files to files,",
        "one thread, kernels loaded. ASSD, HD95 and the volume's difference are of the enhancing part. Where the",
        "expert marked no enhancing tumor there is nothing to overlap: what counts is that no object is found. The",
        "expert's core includes tumor that does not enhance, which the method cannot see by its nature.",
        "",
        f"{machine['cpus']} CPUs, load {machine['load_at_start']:.1f} at the start and {machine['load_at_end']:.1f}",
        f"at the end, Python {machine['python']}. Under load CPU seconds rise too; compare ratios within this run.",
    ]
    real = results.get("real", [])
    for group in dict.fromkeys(row["group"] for row in real):
        text += ["", f"## {group[0].upper()}{group[1:]} cases", ""]
        text += tables.cases_table([row for row in real if row["group"] == group])
    counted = [row for row in real if _counts(row)]
    names = [row["name"] for row in counted]
    clear = [row["name"] for row in counted if not row["weak"]]
    if counted:
        text += ["", f"Means over the cases with at least {MEASURED_MM3 / 1000:.0f} ml of enhancing tumor:", ""]
        text += tables.means(counted)
    if "settings" in results:
        loco = tables.held_out(results["settings"], names)
        text += [
            "",
            "Leave one case out: each case with the setting (share of the median, weight of the curvature; "
            f"{len(settings.SETTINGS)} combinations) that is best on the others: enhancing IoU "
            f"{mean(loco[name] for name in clear):.3f} clear, {mean(loco.values()):.3f} all. By case: "
            + ", ".join(f"{name} {value:.3f}" for name, value in loco.items())
            + ".",
        ]
    if "peers" in results:
        by_name = {row["name"]: row for row in counted}
        compared = [
            name for name in names if all(name in row for rows in results["peers"].values() for row in rows.values())
        ]
        left_out = [name for name in names if name not in compared]
        text += [
            "",
            "## Beside peers",
            "",
            "Every peer runs from the same seeds with a grid of settings; shown is the setting that is best on these",
            "very cases, which favours it, and beside it what is left when each case's setting is chosen on the",
            "others. CPU seconds are of the method alone, mean over cases; ours is that of the flow. Peers work in the",
            "box of our flow, with 16 voxels around it on the plain difference: this spares them time and leaks.",
            *([f"Left out here: {', '.join(left_out)}."] if left_out else []),
            *tables.peers_table(
                {name: by_name[name] for name in compared},
                results["peers"],
                compared,
                [name for name in compared if name in clear],
            ),
            "",
        ]
        if all("threshold_level_set" in rows for rows in results["peers"].values()):
            text += tables.ratio_lines(by_name, results["peers"], compared)
    if "ablation" in results:
        text += [
            "",
            "## What the parts of the flow earn",
            "",
            "The flows of all cases with an object, from the same seed surfaces, means over them; IoU is of the voxels",
            "inside the surface with the enhancing tumor. Damping is ours: without it, as in the dissertation, aging",
            "(S5) and interpolation (S8) have more to do. Model selection (S9) is measured in `vessels.md`.",
        ]
        for setting in ablation.SETTINGS:
            text += [
                "",
                f"**{setting[0].upper()}{setting[1:]}**",
                "",
                *ablation.ablation_table(results["ablation"], setting),
                "",
                "Flow by flow, all without damping: IoU / iterations / oscillating vertices over all iterations.",
                "",
                *ablation.by_flow_table(results["ablation"], setting),
            ]
    if "phantoms" in results:
        text += ["", "## Phantoms", "", "Heads with known truth, as the real cases are done:", ""]
        text += tables.cases_table(results["phantoms"])
        text += ["", "Blobs with a known border, through the general mode from a seed in their middle:", ""]
        text += tables.blobs_table(results["blobs"])
    if "growth" in results:
        text += ["", "## Growth", "", *tables.growth_table(results["growth"])]
    return "\n".join(text) + "\n"


if __name__ == "__main__":
    main()

"""Measure all or some parts, and bring ``benchmarks/results/segmentation.json`` and ``.md`` up to date."""

from __future__ import annotations

import argparse
import json
import os
import platform
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import benchmarks.segmentation as package
from benchmarks.segmentation import (
    ablation,
    beside,
    blobs,
    defects,
    growth,
    ours,
    page,
    settings,
    tables,
    variants,
    vessels,
)
from benchmarks.segmentation.cache import Cache, digest, digest_sources
from benchmarks.segmentation.cases import DATA, ROOT, Case, head_cases, real_cases
from benchmarks.segmentation.peers import PEERS

RESULTS = ROOT / "benchmarks" / "results"
_WITH_HEADS = ("ablation", "phantoms")
OUR_SOURCES = (ROOT / "services" / "segmentation" / "shapery_segmentation",)


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(prog="benchmarks.segmentation", description=package.__doc__)
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the real volumes")
    parser.add_argument("--part", nargs="*", choices=page.PARTS, default=list(page.PARTS), help="what to measure")
    parser.add_argument("--only", nargs="*", default=[], help="parts of the names of the cases to measure")
    parser.add_argument("--peer", nargs="*", choices=list(PEERS), default=list(PEERS), help="peers to measure")
    parser.add_argument("--input", nargs="*", choices=list(beside.INPUTS), default=list(beside.INPUTS),
                        help="what the peers are given")  # fmt: skip
    parser.add_argument("--beside", nargs="*", default=[], help="parts of the names of the cases to run peers on")
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "shapery-bench-segmentation")
    parser.add_argument("--time-limit", type=float, default=180.0, help="seconds for one setting of one peer")
    parser.add_argument("--results", type=Path, default=RESULTS)
    given = parser.parse_args()
    cache = Cache(given.cache)
    real = [case for case in real_cases(given.data) if _wanted(case, given.only)] if given.data.is_dir() else []
    if not real:
        print(f"no real cases in {given.data.name}: put the data beside the checkout, or set SHAPERY_TEST_DATA")
    key = digest(digest_sources(*OUR_SOURCES), (Path(__file__).parent / "ours.py").read_text())
    path = given.results / "segmentation.json"
    given.results.mkdir(parents=True, exist_ok=True)
    for part in page.PARTS:
        if part not in given.part:
            continue
        machine = _machine()
        measured = _measured(part, given, real, cache, key)
        machine["load_at_end"] = os.getloadavg()[0]
        if measured is None:
            continue
        if part == "peers":
            measured = [measured | {"machine": machine}]
        # Part by part, so that what was measured stays when the next is stopped.
        results = page.merged(page.read(path), {part: measured, "measured": {part: machine}})
        path.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n")
        path.with_suffix(".md").write_text(page.document(results))


def _measured(part: str, given: argparse.Namespace, real: Sequence[Case], cache: Cache, key: str) -> Any:
    """Return the results of one part; None where there is nothing to measure."""
    if part == "growth":
        return _growth(cache, key, given.time_limit)
    if part == "vessels":
        return vessels.measured(cache, digest(key, Path(vessels.__file__).read_text()))
    if part == "defects":
        return defects.measured(cache, digest(key, Path(defects.__file__).read_text()))
    if part == "variants":
        return variants.measured(list(real), cache, digest(key, Path(variants.__file__).read_text())) or None
    heads = [case for case in head_cases(given.cache) if _wanted(case, given.only)] if part in _WITH_HEADS else []
    if part == "ablation":
        rows = {c.name: cache.get(f"ablation {c.name}", key, lambda c=c: _ablation(c)) for c in [*real, *heads]}
        return {name: of_case for name, of_case in rows.items() if of_case}
    process = ours.Ours()
    try:
        if part == "phantoms":
            small = [cache.get(f"blob {name}", key, lambda n=name: blobs.measure(n)) for name in blobs.BLOBS]
            return {"blobs": small, "heads": [_ours(case, process, cache, key) for case in heads]}
        found = [_ours(case, process, cache, key) for case in real]
    finally:
        process.close()
    if part == "real" or not found:
        return found or None
    counted = [case for case, row in zip(real, found, strict=True) if page.counts(row)]
    if part == "settings":
        return {c.name: cache.get(f"settings {c.name}", key, lambda c=c: _settings(c)) for c in counted} or None
    beside_ours = [case for case in counted if _wanted(case, given.beside)]
    names = {case.name for case in beside_ours}
    return {
        "peers": given.peer,
        "ours": [row for row in found if row["name"] in names],
        "rows": _peers(beside_ours, given.peer, given.input, cache, given.time_limit),
    }


def _wanted(case: Case, parts: Sequence[str]) -> bool:
    return not parts or any(part in case.name for part in parts)


def _ours(case: Case, process: ours.Ours, cache: Cache, key: str) -> dict[str, Any]:
    def run() -> dict[str, Any]:
        with tempfile.TemporaryDirectory() as folder:
            return process.measure(case, Path(folder))

    row: dict[str, Any] = cache.get(f"ours {case.name}", key, run)
    found = tables.shown(row["enhancing"]["iou"]), tables.shown(row["core"]["iou"])
    print(f"{case.name}: {len(row['objects'])} objects, IoU enhancing {found[0]}, core {found[1]}", flush=True)
    return row


def _peers(
    cases: Sequence[Case], peers: Sequence[str], inputs: Sequence[str], cache: Cache, time_limit: float
) -> dict[str, Any]:
    rows: dict[str, Any] = {given: {peer: {} for peer in peers} for given in inputs}
    for case in cases:
        prepared = beside.prepare(case)
        for given in inputs:
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


if __name__ == "__main__":
    main()

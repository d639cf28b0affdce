"""The report: ``motion.json``, ``motion.md`` and the plots, from what was measured."""

from __future__ import annotations

import json
import statistics
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from benchmarks.motion.case import RESULTS
from benchmarks.motion.chapter import TEXT_TABLE
from benchmarks.motion.pictures import errors_over_clusters, rate_distortion
from shapery_motion.errors import dissertation_bits

PLAYED = 10_000
"""Vertices that figures of decoding are scaled to."""
Measured = dict[str, dict[str, Any]]
"""What is kept, by sequence and method."""

TEXTS = ("spectral-positions", "spectral-differences", "affine-clusters", "text")
"""Methods whose points are not at targets."""
ORDER = (
    "trajectory", "trajectory-fast", "gradient", "clustered-pca-strong", "clustered-pca", "trajectory-pca", "shape-pca",
    "delta-parallelogram", "delta-lzma", "delta-zstd", "draco",
)  # fmt: skip
NAMES = {
    "trajectory": "**ours** (`trajectory`, file)",
    "trajectory-fast": "ours, preset `fast` (file)",
    "gradient": "dissertation's (`gradient`, file)",
    "clustered-pca-strong": "clustered PCA, best K, with all of ours that fits it",
    "clustered-pca": "clustered PCA, best K, as published",
    "trajectory-pca": "trajectory PCA + parallelogram",
    "shape-pca": "shape PCA + prediction in time",
    "delta-parallelogram": "quantise + delta + parallelogram",
    "delta-lzma": "quantise + delta + lzma",
    "delta-zstd": "quantise + delta + zstd",
    "draco": "Draco, frame by frame, with its connectivity",
}

PREFACE = """\
`make bench-motion` writes this. Every method codes the same frames to the same KG error (100·‖A − Ã‖/‖A − E(A)‖ with
E(A) each frame's centroid), and all bytes are real: ours and the dissertation's are motion files, container included;
the PCA peers are coded by one adaptive range coder, with the parallelogram inside clusters, bases predicted in time,
fields fitted anew to the rounded bases, and the step bisected to the error. That makes them stronger than the published
methods they stand for, but for the clustered PCA that is marked as published, which has none of this. Where the
dissertation's profile takes as much as quantising with delta and parallelogram, it stored all frames by themselves,
because no prediction reached the error for less. Times are CPU seconds on one core of a busy machine, with kernels
loaded: compare them with each other only. All files of ours are of version 1.3, made by one and the same encoder.

The clustered PCA "with all of ours that fits it" is no published method: it has our predictions in space and time, our
fitting to rounded bases and our range coder, and tells what of our gain they make. What the goal of at most 0.55 of
clustered PCA is about is the published one.

![KG error over bits](motion-rate.png)
""".splitlines()

WHY = f"""\
The text's errors for bodies (1e-5 … 2e-4 of an edge) are not reached in any setting: not with any member in place of
the least squares, not with the key frame one frame away, not with 1,024 clusters. The method itself is exact: with
every face its own cluster the frames come back to 1e-9. What is lost is lost in clustering: the matrices of a cluster
err alike over whole limbs, and the Poisson system adds these errors up from face to face into a drift of low frequency,
which Eq. 5.12 counts in full. (Anchors spread over the mesh, which the profile uses and the text has not, take most of
it away.) An error of 1e-5 of an edge is of the size of single precision's spacing in these files. The text's 0.01 for a
face is approached where each frame is predicted from the one before it. Its rate for bodies follows from Eq. 5.11
({dissertation_bits(256, 20000, 10002):.2f} bits), its 20.29 bits for the face does not
({dissertation_bits(64, 3000, 1500):.2f}).
""".splitlines()


def write(kept: Path) -> None:
    """Write the report on everything that is kept in a folder."""
    found: Measured = {}
    for place in sorted(kept.glob("*.*.json")):
        name, method = place.name.removesuffix(".json").split(".", 1)
        found.setdefault(name, {})[method] = json.loads(place.read_text())
    found = dict(sorted(found.items(), key=lambda item: (item[0] != "crane", item[0].lower())))
    decoding = _read(kept / "decoding.json") or {}
    growth = _read(kept / "growth.json") or []
    figures = _read(kept / "figures.json") or {}
    (RESULTS / "motion.json").write_text(
        json.dumps({"sequences": found, "decoding": decoding, "growth": growth, "figures": figures}, indent=1) + "\n"
    )
    lines = ["# Motion: rate and distortion, and the tables of chapter 5", "", *PREFACE, ""]
    for section in (_rates, _ratio, _errors, _costs):
        lines += section(found)
    lines += _decoding(decoding) + _growth(growth) + _chapter(found, figures)
    (RESULTS / "motion.md").write_text("\n".join(lines).rstrip() + "\n")
    rate_distortion(RESULTS / "motion-rate.png", _curves(found))
    over = {name: _over_clusters(methods["text"]["points"]) for name, methods in found.items() if "text" in methods}
    if over:
        errors_over_clusters(RESULTS / "motion-figure-5-8.png", over)


def restore(kept: Path) -> None:
    """Fill an empty folder of what is kept from the report in `motion.json`: a fresh checkout has the latter alone."""
    told = _read(RESULTS / "motion.json")
    if told is None or any(kept.glob("*.json")):
        return
    parts = {
        f"{name}.{method}": found for name, methods in told["sequences"].items() for method, found in methods.items()
    }
    for name, found in {**parts, **{part: told.get(part) for part in ("decoding", "growth", "figures")}}.items():
        if found:
            (kept / f"{name}.json").write_text(json.dumps(found, indent=1) + "\n")


def _read(place: Path) -> Any:
    return json.loads(place.read_text()) if place.exists() else None


def _targets(found: Measured) -> list[str]:
    names = {kg for methods in found.values() for method, kept in methods.items() if method not in TEXTS
             for kg in kept["points"]}  # fmt: skip
    return sorted(names, key=float)


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> list[str]:
    head = list(head)
    return [_row(head), _row(["---"] * len(head)), *(_row(row) for row in rows), ""]


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _point(found: Measured, name: str, method: str, kg: str) -> dict[str, Any] | None:
    point: dict[str, Any] | None = found[name].get(method, {}).get("points", {}).get(kg)
    return point if point and point.get("reached") else None


def _rates(found: Measured) -> list[str]:
    lines = ["## Bits per vertex and frame, connectivity apart", ""]
    names = list(found)
    for kg in _targets(found):
        rows = []
        for method in ORDER:
            points = [_point(found, name, method, kg) for name in names]
            if any(points):
                rows.append([NAMES[method], *(f"{point['bits']:.3f}" if point else "–" for point in points)])
        lines += [f"KG error {kg} %", "", *_table(["method", *names], rows)]
    rows = []
    for name in names:
        for kg in _targets(found):
            point = _point(found, name, "trajectory", kg)
            if point:
                numbers = 8 * point["motion_bytes"] / point["bits"]
                whole = 8 * (point["motion_bytes"] + point["connectivity_bytes"]) / numbers
                rows.append([name, kg, f"{point['bits']:.3f}", f"{whole:.3f}", str(point["connectivity_bytes"])])
    if rows:
        lines += ["Together with the connectivity, ours:", ""]
        lines += _table(["sequence", "KG %", "motion", "with connectivity", "connectivity, bytes"], rows)
    if not any("draco" in methods and any(_reached(methods["draco"])) for methods in found.values()):
        lines += [
            "Draco is left out: its package (DracoPy) is not installed here. With it, `make bench-motion` runs it.",
            "",
        ]
    return lines


def _reached(kept: dict[str, Any]) -> list[bool]:
    return [bool(point.get("reached")) for point in kept["points"].values()]


def _ratio(found: Measured) -> list[str]:
    rows = []
    for peer in ("clustered-pca", "clustered-pca-strong"):
        for kg in _targets(found):
            ratios = {}
            for name in found:
                ours, theirs = _point(found, name, "trajectory", kg), _point(found, name, peer, kg)
                if ours and theirs:
                    ratios[name] = ours["bits"] / theirs["bits"]
            if ratios:
                cells = [f"{ratios[name]:.3f}" if name in ratios else "–" for name in found]
                rows.append([NAMES[peer], kg, *cells, f"**{statistics.mean(ratios.values()):.3f}**"])
    return ["## Ours over clustered PCA", "", *_table(["peer", "KG %", *found, "mean"], rows)] if rows else []


def _errors(found: Measured) -> list[str]:
    lines = ["## What the same KG error looks like", ""]
    lines += [
        "At KG 0.1 %: Eq. 5.12 in mean edges, the largest error as a fraction of the diagonal, normals and dihedral"
    ]
    lines += ["angles in degrees.", ""]
    rows = []
    for name in found:
        for method in ORDER:
            point = _point(found, name, method, "0.1")
            if point:
                rows.append([
                    name, NAMES[method], f"{point['kg_percent']:.4f}", f"{point['prediction']:.4f}",
                    f"{point['largest_fraction']:.2e}", f"{point['normal_degrees']:.2f}",
                    f"{point['dihedral_degrees']:.2f}",
                ])  # fmt: skip
    return lines + _table(["sequence", "method", "KG %", "Eq. 5.12", "largest", "normals", "dihedral"], rows)


def _costs(found: Measured) -> list[str]:
    rows = []
    for name in found:
        for method in ORDER:
            point = _point(found, name, method, "0.1")
            if point:
                encode, decode = point["encode_cpu_seconds_per_frame"], point["decode_cpu_seconds_per_frame"]
                opened = point["settings"].get("open_seconds")
                rows.append([
                    name, NAMES[method], f"{1000 * encode:.1f}", f"{1000 * decode:.3f}",
                    f"{opened:.2f}" if opened is not None else "–",
                    f"{found[name][method]['peak_megabytes_above_input']:.0f}",
                ])  # fmt: skip
    head = ["sequence", "method", "encode, ms a frame", "decode, ms a frame", "first frame, s", "peak MB above input"]
    note = [
        "At KG 0.1 %, CPU time on one core. Encoding includes the proof on the decoded file; decoding the opening.",
        "",
    ]
    return ["## Time and memory", "", *note, *_table(head, rows), *_slowest(found)]


def _slowest(found: Measured) -> list[str]:
    """Tell the slowest encodings of ours at any error, and what the fast preset loses at the most."""
    lines = []
    for method, called in (("trajectory", "the default"), ("trajectory-fast", "the preset `fast`")):
        rates = [
            (1 / point["encode_cpu_seconds_per_frame"], name, kg)
            for name in found
            for kg in _targets(found)
            if (point := _point(found, name, method, kg))
        ]
        if rates:
            rate, name, kg = min(rates)
            lines.append(f"The slowest encoding with {called}: {rate:.1f} frames/s, {name} at {kg} %;")
            rate, name, _ = min((one for one in rates if one[2] == "0.1"), default=(rate, name, kg))
            lines.append(f"at 0.1 %: {rate:.1f} frames/s, {name}.")
    losses = [
        (fast["bits"] / slow["bits"] - 1, name, kg)
        for name in found
        for kg in _targets(found)
        if (fast := _point(found, name, "trajectory-fast", kg)) and (slow := _point(found, name, "trajectory", kg))
    ]
    if losses:
        loss, name, kg = max(losses)
        lines.append(f"The most that `fast` loses: {100 * loss:.1f} %, {name} at {kg} %.")
    return [*lines, ""]


def _decoding(found: dict[str, Any]) -> list[str]:
    if not found:
        return []
    rows = [
        [
            name, str(row["vertices"]), f"{row['first_cpu_seconds']:.3f}", f"{1 / row['frame_cpu_seconds']:,.0f}",
            f"{row['vertices'] / (PLAYED * row['frame_cpu_seconds']):,.0f}",
            f"{1000 * row['longest_frame_cpu_seconds']:.2f}", f"{row['browser']['first_cpu_seconds']:.2f}",
            f"{row['browser']['first_seconds']:.2f}" if "first_seconds" in row["browser"] else "–",
            f"{row['vertices'] / (PLAYED * row['browser']['frame_cpu_seconds']):,.0f}",
        ]
        for name, row in found["sequences"].items()
    ]  # fmt: skip
    head = ["sequence", "vertices", "first frame, s", "frames/s", f"frames/s at {PLAYED:,} vertices",
            "longest random access, ms", "browser: first frame, s", "by the clock, s",
            f"browser: frames/s at {PLAYED:,} vertices"]  # fmt: skip
    few, many = found["memory"]
    return [
        "## Opening and playing",
        "",
        "Files of the default setting (KG 0.1 %) in Python, CPU time on one core: opening up to the first frame, then",
        "frames of the open group in random order; scaled, as if the time of a frame were in proportion to its",
        f"vertices. The browser is Chromium {found['browser']} with the dashboard's decoder, processor time of the",
        "page's main thread; its first frame runs a script that is not compiled yet.",
        "",
        *_table(head, rows),
        f"Memory: a process that decodes one group of {few['frames']} frames of {few['sequence']} holds at the most",
        f"{few['peak_megabytes']:.1f} MB, the interpreter and its libraries included; one that decodes all",
        f"{many['frames']} frames, in such groups, {many['peak_megabytes']:.1f} MB.",
        "",
        "Connectivity of all meshes of the data, the order of vertices kept:",
        "",
        *_table(["mesh", "bits a vertex"], [[name, f"{bits:.1f}"] for name, bits in found["connectivity"].items()]),
    ]


def _growth(rows: list[dict[str, Any]]) -> list[str]:
    if not rows:
        return []
    cells = [
        [
            str(row["frames"]), str(row["vertices"]), str(row["faces"]), str(row["bytes"]),
            f"{row['connectivity_bits_per_vertex']:.1f}", f"{row['encode_cpu_seconds']:.1f}",
            f"{row['open_cpu_seconds']:.2f}", f"{row['decode_cpu_seconds']:.2f}",
        ]
        for row in rows
    ]  # fmt: skip
    head = [
        "frames",
        "vertices",
        "faces",
        "bytes",
        "connectivity, bits a vertex",
        "encode s",
        "first frame s",
        "decode s",
    ]
    return ["## Growth", "", "A swaying sphere at the default setting, CPU seconds.", "", *_table(head, cells)]


def _chapter(found: Measured, figures: dict[str, Any]) -> list[str]:
    texts = {name: methods["text"]["points"] for name, methods in found.items() if "text" in methods}
    lines = ["## Chapter 5, as written", ""]
    if texts:
        lines += ["### Table 5.1: prediction error (Eq. 5.12)", ""]
        lines += ["256 clusters (64 for the face, as in the text), 12 frames evenly over each sequence. The text's own"]
        quoted = ", ".join(f"{name} {value:g}" for name, value in TEXT_TABLE.items())
        lines += [f"figures: {quoted}.", ""]
        rows = []
        for name, points in texts.items():
            count = 64 if "face" in name else 256
            first = _select(points, count)
            member = _select(points, 256, representative="member")
            adjacent = _select(points, 256, key_frame="the one before")
            rows.append([
                name, str(count), _number(first, "prediction"), _number(first, "kg_percent"),
                _number(member, "prediction"), _number(adjacent, "prediction"),
                f"{first['bits']:.2f}" if first else "–",
                f"{first['bits_of_eq_5_11']:.2f}" if first else "–",
            ])  # fmt: skip
        head = ["sequence", "clusters", "key frame 0", "KG %", "any member, 256", "key frame one before, 256",
                "bits, coded", "bits, Eq. 5.11"]  # fmt: skip
        lines += [*_table(head, rows), *WHY, ""]
        lines += ["### Table 5.2: time for one frame, CPU seconds", ""]
        lines += ["The text: 109–189 s to encode and 20–25 s to decode a body, 12 s and 0.3 s for the face (2011).", ""]
        rows = []
        for name, points in texts.items():
            first = _select(points, 64 if "face" in name else 256)
            rows.append(
                [name, _number(first, "encode_cpu_seconds_per_frame"), _number(first, "decode_cpu_seconds_per_frame")]
            )
        lines += _table(["sequence", "encode", "decode"], rows)
        lines += [
            "### Fig. 5.8: error over the number of clusters",
            "",
            "![Eq. 5.12 over clusters](motion-figure-5-8.png)",
            "",
        ]
        counts = sorted({count for points in texts.values() for count, _ in _over_clusters(points)})
        rows = []
        for name, points in texts.items():
            errors = dict(_over_clusters(points))
            rows.append([name, *(f"{errors[count]:.4f}" if count in errors else "–" for count in counts)])
        lines += _table(["sequence", *(str(int(count)) for count in counts)], rows)
        lines += [
            "The text calls the error proportional to the number of clusters. It falls with them, and more slowly.",
            "",
        ]
    return lines + _pictures(figures) + _baselines(found)


def _pictures(figures: dict[str, Any]) -> list[str]:
    if not figures:
        return []
    near, far = figures["frames"]
    lines = [f"### Figs 5.1–5.3, on {figures['sequence']}", "", "Errors by Eq. 5.12 in mean edge lengths.", ""]
    rows = [
        [name, f"{figures[key][0]:.4f}", f"{figures[key][1]:.4f}"]
        for name, key in (
            ("256 affine vertex clusters (Fig. 5.3)", "affine_256"),
            ("256 gradient clusters", "gradient_256"),
        )
    ]
    spectral = figures.get("spectral", {})
    count = figures.get("coefficients")
    for name, key in (("positions (Fig. 5.1)", "positions"), ("differences (Fig. 5.2)", "differences")):
        if spectral:
            rows.append([f"first {count} coefficients of the {name}", f"{spectral[f'near_{key}']:.4f}",
                         f"{spectral[f'far_{key}']:.4f}"])  # fmt: skip
    lines += _table(["prediction", f"frame {near}", f"frame {far}"], rows)
    if spectral:
        lines += [
            f"The key frame itself is recovered from {count} coefficients to {spectral['key_positions']:.4f}.",
            "",
        ]
        lines += ["![Fig. 5.1](motion-figure-5-1.png)", "", "![Fig. 5.2](motion-figure-5-2.png)", ""]
    return [*lines, "![Fig. 5.3](motion-figure-5-3.png)", ""]


def _baselines(found: Measured) -> list[str]:
    rows = []
    for name, methods in found.items():
        for method in TEXTS:
            for point in methods.get(method, {}).get("points", []):
                setting = (
                    f"{point['coefficients']} coefficients"
                    if "coefficients" in point
                    else f"{point['clusters']} clusters"
                )
                if method == "text":
                    setting += "" if point["representative"] == "least_squares" else ", any member"
                    setting += "" if point["key_frame"] == "the first" else ", key frame one before"
                rows.append([name, method, setting, f"{point['bits']:.2f}", f"{point['kg_percent']:.3f}"])
    if not rows:
        return []
    note = ["Bits of a predicted frame; the key frame, the connectivity and the basis are not counted.", ""]
    head = ["sequence", "method", "setting", "bits per vertex", "KG %"]
    return ["### The dissertation's method and its baselines: rate and distortion", "", *note, *_table(head, rows)]


def _select(points: list[dict[str, Any]], clusters: int, **wanted: str) -> dict[str, Any] | None:
    wanted = {"representative": "least_squares", "key_frame": "the first", **wanted}
    for point in points:
        if point["clusters"] == clusters and all(point[key] == value for key, value in wanted.items()):
            return point
    return None


def _number(point: dict[str, Any] | None, key: str) -> str:
    return f"{point[key]:.4f}" if point else "–"


def _over_clusters(points: list[dict[str, Any]]) -> list[tuple[float, float]]:
    return [
        (point["clusters"], point["prediction"])
        for point in points
        if point["representative"] == "least_squares" and point["key_frame"] == "the first"
    ]


def _curves(found: Measured) -> dict[str, dict[str, list[tuple[float, float]]]]:
    curves: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for name, methods in found.items():
        curves[name] = {}
        for method in (*ORDER, *TEXTS):
            points = methods.get(method, {}).get("points")
            if not points:
                continue
            listed = points.values() if isinstance(points, dict) else points
            pairs = [
                (float(point["kg_percent"]), float(point["bits"]))
                for point in listed
                if point.get("reached", True) and point.get("representative", "least_squares") == "least_squares"
                and point.get("key_frame", "the first") == "the first"
            ]  # fmt: skip
            if pairs:
                curves[name][method] = pairs
    return curves

"""The results as Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from statistics import mean
from typing import Any

from benchmarks.segmentation.beside import INPUTS
from benchmarks.segmentation.cases import MEASURED_MM3
from benchmarks.segmentation.peers import PEERS

Row = dict[str, Any]


def shown(value: float | None, digits: int = 3) -> str:
    """Return a number, or a dash where there is none."""
    return "–" if value is None else f"{value:.{digits}f}"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a table."""
    return [f"| {' | '.join(head)} |", "|" + "---|" * len(head), *(f"| {' | '.join(row)} |" for row in rows)]


def cases_table(rows: Sequence[Row]) -> list[str]:
    """Return the counterpart of Table 3.1: every case with all measures."""
    head = (
        "case", "expert ml", "IoU enh.", "IoU core", "Dice enh.", "Dice core", "ASSD mm", "HD95 mm", "vol. diff.",
        "objects (confidence)", "false", "self-int.", "flow CPU s", "CPU s", "wall s", "peak MiB",
    )  # fmt: skip
    lines = []
    for row in rows:
        e, c = row["enhancing"], row["core"]
        none = not e["reference_mm3"]
        found = ", ".join(f"{item['confidence']:.2f}" for item in row["objects"]) or "none"
        lines.append(
            [
                row["name"],
                shown(e["reference_mm3"] / 1000, 1),
                "–" if none else shown(e["iou"]),
                "–" if none else shown(c["iou"]),
                "–" if none else shown(e["dice"]),
                "–" if none else shown(c["dice"]),
                shown(e["assd_mm"], 2),
                shown(e["hd95_mm"], 2),
                shown(e["volume_difference"], 2),
                found,
                str(row["false_objects"]),
                str(sum(item["self_intersections"] for item in row["objects"])),
                shown(row["flow_cpu_seconds"], 2),
                shown(row["cpu_seconds"], 2),
                shown(row["wall_seconds"], 2),
                f"{row['peak_mib']:.0f}",
            ]
        )
    return table(head, lines)


def means(rows: Sequence[Row]) -> list[str]:
    """Return the means over the cases that count."""
    counted = [row for row in rows if row["enhancing"]["reference_mm3"] >= MEASURED_MM3]
    lines = []
    for title, chosen in (
        ("clear enhancement", [row for row in counted if not row["weak"]]),
        ("all", counted),
    ):
        if chosen:
            lines.append(
                [
                    f"{title} ({len(chosen)})",
                    *(
                        shown(mean(row[part][what] or 0.0 for row in chosen))
                        for part, what in (("enhancing", "iou"), ("core", "iou"), ("enhancing", "dice"))
                    ),
                    shown(finite_mean([row["enhancing"]["assd_mm"] for row in chosen]), 2),
                    shown(finite_mean([row["enhancing"]["hd95_mm"] for row in chosen]), 2),
                ]
            )
    return table(("mean over cases", "IoU enh.", "IoU core", "Dice enh.", "ASSD mm", "HD95 mm"), lines)


def finite_mean(values: Sequence[float | None]) -> float | None:
    """Return the mean of the values that are there."""
    there = [value for value in values if value is not None]
    return mean(there) if there else None


def best_setting(by_case: dict[str, list[Row]], names: Sequence[str]) -> int:
    """Return the number of the setting with the best mean enhancing IoU over some cases."""
    count = len(next(iter(by_case.values())))
    return max(range(count), key=lambda n: mean(by_case[name][n]["enhancing"]["iou"] or 0.0 for name in names))


def held_out(by_case: dict[str, list[Row]], names: Sequence[str]) -> dict[str, float]:
    """Return each case's enhancing IoU with the setting that is best on the other cases."""
    found = {}
    for name in names:
        others = [other for other in names if other != name]
        number = best_setting(by_case, others) if others else 0
        found[name] = by_case[name][number]["enhancing"]["iou"] or 0.0
    return found


def peers_table(
    ours: dict[str, Row], peers: dict[str, dict[str, dict[str, list[Row]]]], names: Sequence[str], clear: Sequence[str]
) -> list[str]:
    """Return ours and each peer at its best setting, on each input, as means over cases."""

    def row(title: str, value: Callable[[str], Row], loco: dict[str, float] | None, late: int) -> list[str]:
        def over(chosen: Sequence[str], part: str) -> str:
            return shown(mean(value(name)[part]["iou"] or 0.0 for name in chosen)) if chosen else "–"

        return [
            title,
            over(clear, "enhancing"),
            over(names, "enhancing"),
            over(clear, "core"),
            over(names, "core"),
            shown(finite_mean([value(name)["enhancing"]["assd_mm"] for name in names]), 2),
            shown(finite_mean([value(name)["enhancing"]["hd95_mm"] for name in names]), 2),
            "–" if loco is None else shown(mean(loco.values())),
            shown(mean(value(name)["method_seconds"] for name in names), 2),
            str(late),
        ]

    head = (
        "method", f"IoU enh., clear {len(clear)}", f"IoU enh., all {len(names)}", "IoU core, clear", "IoU core, all",
        "ASSD mm", "HD95 mm", "IoU enh., leave one case out", "CPU s", "too late",
    )  # fmt: skip
    lines: list[str] = []
    mine = {name: r | {"method_seconds": r["flow_cpu_seconds"]} for name, r in ours.items()}
    for given, title in ((given, title) for given, title in INPUTS.items() if given in peers):
        lines += ["", f"**Peers on {title}**", ""]
        body = [row("Shapery (default)", mine.__getitem__, None, 0)]
        for peer, (label, _, _) in PEERS.items():
            if peer not in peers[given]:
                continue
            by_case = peers[given][peer]
            number = best_setting(by_case, names)
            late = sum(by_case[name][number]["late"] for name in names)
            setting = ", ".join(f"{k} {v:g}" for k, v in by_case[names[0]][number]["setting"].items())
            chosen = {name: by_case[name][number] for name in names}
            with_time = {name: r | {"method_seconds": r["cpu_seconds"]} for name, r in chosen.items()}
            body.append(row(f"{label}: {setting}", with_time.__getitem__, held_out(by_case, names), late))
        lines += table(head, body)
    return lines


def ratio_lines(
    ours: dict[str, Row], peers: dict[str, dict[str, dict[str, list[Row]]]], names: Sequence[str]
) -> list[str]:
    """Return how many times the CPU of our flow the level set takes, on each input."""
    lines = []
    for given, title in ((given, title) for given, title in INPUTS.items() if given in peers):
        by_case = peers[given]["threshold_level_set"]
        number = best_setting(by_case, names)
        theirs = mean(by_case[name][number]["cpu_seconds"] for name in names)
        flow = mean(ours[name]["flow_cpu_seconds"] for name in names)
        watched = mean(ours[name].get("flow_watched_seconds", ours[name]["flow_cpu_seconds"]) for name in names)
        each = mean(by_case[name][number]["cpu_seconds"] / max(ours[name]["flow_cpu_seconds"], 1e-6) for name in names)
        lines.append(
            [
                title,
                shown(theirs, 2),
                shown(flow, 2),
                shown(watched, 2),
                shown(theirs / flow, 1),
                shown(theirs / watched, 1),
                shown(each, 1),
            ]
        )
    return table(
        (
            "ThresholdSegmentationLevelSet on",
            "its CPU s",
            "our flow's CPU s",
            "with frames kept",
            "ratio of means",
            "with frames kept",
            "mean ratio",
        ),
        lines,
    )


def blobs_table(rows: Sequence[Row]) -> list[str]:
    """Return how each blob was recovered."""
    lines = [
        [row["name"], "refused", *["–"] * 6]
        if row["refused"]
        else [
            row["name"],
            shown(row["iou"]),
            shown(row["dice"]),
            shown(row["assd_mm"], 2),
            shown(row["hd95_mm"], 2),
            row["polarity"],
            str(row["self_intersections"]),
            shown(row["cpu_seconds"], 2),
        ]
        for row in rows
    ]
    return table(("blob", "IoU", "Dice", "ASSD mm", "HD95 mm", "taken for", "self-int.", "CPU s"), lines)


def growth_table(rows: Sequence[Row]) -> list[str]:
    """Return how time and memory grow."""
    titles = {
        "volume": "whole head, voxels a side",
        "flow": "normal flow on a ball of 12 mm, voxels a side",
        "peer": "ThresholdSegmentationLevelSet on the same, voxels a side",
        "faces": "normal flow on a ball of 20 mm, faces aimed at",
    }
    lines = [
        [
            titles[row["what"]],
            f"{row['number']:,}",
            "too late" if row["late"] else shown(row["cpu_seconds"], 2),
            "–" if row["late"] else f"{row['peak_mib']:.0f}",
            "–" if row["late"] else f"{row['before_mib']:.0f}",
            f"{row['faces']:,}" if "faces" in row else "–",
        ]
        for row in rows
    ]
    return table(("what", "size", "CPU s", "peak MiB", "of which before it began", "faces"), lines)

"""The results as Markdown."""

from __future__ import annotations

from typing import Any

from benchmarks.retrieval.aims import aims
from benchmarks.retrieval.correspondence import KEYS as CORRESPONDENCE
from benchmarks.retrieval.growth import row_of

KEYS = ("nn", "ft", "st", "map", "dcg")
HEAD = ["| method | NN | FT | ST | mAP | DCG |", "|---|---|---|---|---|---|"]


def report(found: dict[str, Any]) -> str:
    """Return what has been measured so far."""
    lines = [
        "# Retrieval", "",
        "One setting for every set. Words, spreads, axes, landmarks and typical patches, which is all that is fitted,",
        "come from shapes that the project generates itself: no figure here is of a bank that anything was fitted to.",
        "That nothing is made for one kind of shape is shown by the classes, taken by halves (1, 3, 5, … and",
        "2, 4, 6, …; those that bend at joints and those that do not) by fives, and by the poses, another bank.", "",
        *aims(found), "",
    ]  # fmt: skip
    if "watertight" in found:
        lines += ["## 400 watertight models, leave one out", "", *_table(found["watertight"]), ""]
        lines += ["FT is the precision where it equals recall. The dissertation's Table 4.1: FV1 0.600, FV2 0.628.", ""]
        for name in ("retrieval_precision_recall", "retrieval_classes"):
            lines += [f"![{name}]({name}.png)", ""]
        for title, rows in found["splits"].items():
            lines += [f"## {title[0].upper()}{title[1:]}", "", *_table(rows), ""]
        classes = found["first_tier_by_class"]
        lines += ["## First tier by class", "", "| class | " + " | ".join(classes) + " |", "|---" * 4 + "|"]
        for name in next(iter(classes.values())):
            lines.append(f"| {name} | " + " | ".join(f"{values[name]:.2f}" for values in classes.values()) + " |")
        lines.append("")
    if "poses" in found:
        lines += ["## Poses: every class is one moving body", "", *_table(found["poses"]), ""]
    if "robustness" in found:
        lines += ["## Worn queries against the bank as it is", "", *_table(found["robustness"]), ""]
    for title, rows in found.get("partial", {}).items():
        lines += [f"## Parts as queries, cut off by a random plane: {title}", "", *_table(rows), ""]
    if "correspondence" in found:
        lines += [
            "## Matched parts of poses whose vertices correspond", "",
            "Shares of the area. Right: matched with the part that most of the vertices lie in. As good: or with one",
            "that holds as many but for a tenth of the part, for borders move with the pose, and two may be right.",
            "Carried: by the plan, between the same two parts as by the vertices, where a part may go to several.",
            "Overlapping: a quarter of either lies in the other. Repeatable: what stays in its part if every part is",
            "matched right.", "",
            "The last three are of a pose's parts as they lie on the other, with their own borders. Laid right: the",
            "share of the area of parts most of whose vertices lie where they were laid. Laid area: the share of the",
            "area that does. Laid parts: how many lie anywhere.", "",
            "| poses | right | as good | carried | overlapping | repeatable | laid right | laid area | laid parts |",
            "|---" * 9 + "|",
        ]  # fmt: skip
        for name, row in found["correspondence"].items():
            figures = " | ".join(f"{row[key]:.{1 if key == 'laid_parts' else 3}f}" for key in CORRESPONDENCE)
            lines.append(f"| {name} | {figures} |")
        lines.append("")
    if "index_cpu_seconds" in found:
        stages = found["index_cpu_seconds"]
        lines += ["## Cost in CPU seconds", "", "| | s |", "|---|---|"]
        lines += [f"| indexing: {name} | {seconds:.3f} |" for name, seconds in stages.items()]
        lines += [f"| indexing: all | {sum(stages.values()):.3f} |"]
        lines += [f"| bank of 400: {name} | {seconds:.4f} |" for name, seconds in found["query_cpu_seconds"].items()]
        lines += ["", f"A graph takes {found['arg_kilobytes']:.1f} kB.", ""] if "arg_kilobytes" in found else [""]
    if "difficult" in found:
        lines += [
            "## Difficult meshes, and scans of 100,000 faces", "",
            "Time and peak memory of a process of its own that has loaded the libraries and kernels.", "",
            "| mesh | faces | s | CPU s | MiB | outcome |", "|---|---|---|---|---|---|",
        ]  # fmt: skip
        for name, row in found["difficult"].items():
            spent = f"{row['seconds']:.2f} | {row['cpu_seconds']:.2f} | {row['peak_mib']:.0f}"
            lines.append(f"| {name} | {row['faces']:,} | {spent} | {row['outcome']} |")
        lines.append("")
    if "growth" in found:
        lines += [
            "## Growth", "",
            "CPU milliseconds of a query in a bank of real graphs moved to fill it, and the share of its twenty best",
            "that a search finds in which every shape is matched part by part, on scales of the whole bank.", "",
            "| shapes | vector | candidates | match | query | matched | kept of exhaustive | vectors, MiB |",
            "|---" * 8 + "|", *(row_of(row) for row in found["growth"]), "",
        ]  # fmt: skip
    if "parts_growth" in found:
        lines += [
            "## Parts in banks that grow", "",
            "Halves of shapes as queries, in banks of shapes that are joined of halves of two real ones. Of the twenty",
            "best of a search that looks at all shapes: how many are among the 1,200 nearest by the vectors of",
            "parts, how many are found there; what the twenty found score in the former search, over its own; how",
            "often the best is the same; the median rank by vector of the twenty; CPU milliseconds of a scan of",
            "vectors, and of comparing patches.", "",
            "| shapes | among 1,200 | found | score | best | rank | scan | compare |", "|---" * 8 + "|",
        ]  # fmt: skip
        for row in found["parts_growth"]:
            kept = (
                f"{row['among']:.1%} | {row['kept']:.1%} | {row['score']:.3f} | {row['first']:.0%} | {row['rank']:,.0f}"
            )
            lines.append(f"| {row['size']:,} | {kept} | {1000 * row['scan']:.1f} | {1000 * row['compare']:.1f} |")
        largest = found["parts_growth"][-1]
        lines += ["", f"By the class of the half, among {largest['size']:,}:", ""]
        lines += ["| half of a | among 1,200 | found | score | rank |", "|---" * 5 + "|"]
        for name, row in largest["queries"].items():
            figures = f"{row['among']:.0%} | {row['kept']:.0%} | {row['score']:.3f} | {row['rank']:,.0f}"
            lines.append(f"| {name} | {figures} |")
        lines.append("")
    if "postgres" in found:
        row = found["postgres"]
        used = f" and {row['processor_ms']:.0f} ms of the processor's" if "processor_ms" in row else ""
        told = (
            f"{row['size']:,} shapes in PostgreSQL with 32 MB of buffers, HNSW over 16-bit vectors of "
            f"{row['index_megabytes']:.0f} MiB, built in {row['index_s']:.0f} s. Six hundred candidates for each of "
            f"{row['queries']} queries came in {row['median_ms']:.0f} ms (median; p95 {row['p95_ms']:.0f} ms) of wall "
            f"time{used}; {row['recall']:.1%} of them were the exact ones, and {row['twenty_best']:.2%} of the "
            "twenty best were found."
        )
        if "parts_recall" in row:
            told += (
                f" Of the candidates for parts {row['parts_recall']:.1%} were the exact ones; they came in "
                f"{row['parts_median_ms']:.0f} ms."
            )
        lines += ["## Candidates by pgvector", "", told, ""]
    return "\n".join(lines)


def _table(rows: dict[str, Any]) -> list[str]:
    lines = list(HEAD)
    for name, row in rows.items():
        count = f" ({row['queries']} queries)" if "queries" in row else ""
        count = f" ({row['queries']} queries, {row['refused']} refused)" if row.get("refused") else count
        lines.append(f"| {name}{count} | " + " | ".join(f"{row[key]:.3f}" for key in KEYS) + " |")
    return lines

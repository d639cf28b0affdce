"""What retrieval should reach, beside what was measured."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

PURE, RERANKED, PARTS = "whole score, pure query", "whole score, re-ranked", "ARG alone, on local scales"
UNWORN = "as they are"
HARDER = ("five holes", "cropped to 70 %", "an eighth of the faces")
"""Wear that is measured and for which there is no aim."""
Found = dict[str, Any]


class Aim(NamedTuple):
    """One figure, its bound, and whether it is the least that is allowed or the most."""

    what: str
    bound: float
    least: bool
    measured: Callable[[Found], float]
    form: str = ".3f"


def _figure(table: str, method: str, key: str) -> Callable[[Found], float]:
    return lambda found: float(found[table][method][key])


def _level(*numbers: int, key: str = "right") -> Callable[[Found], float]:
    ends = tuple(f"level {number}" for number in numbers)

    def mean(found: Found) -> float:
        rows = [row[key] for name, row in found["correspondence"].items() if name.endswith(ends)]
        return float(sum(rows) / len(rows))

    return mean


def _loss(found: Found) -> float:
    rows = found["robustness"]
    return float(max(rows[UNWORN]["ft"] - row["ft"] for name, row in rows.items() if name not in HARDER))


def _of_five(found: Found) -> float:
    rows = found["splits"]["five shapes per class"]
    return float(rows[RERANKED]["ft"] - rows[PURE]["ft"])


def _halves(found: Found) -> float:
    return min(
        float(rows[method]["ft"] - bound)
        for title, rows in found["splits"].items()
        if title.startswith("classes ")
        for method, bound in ((PURE, 0.82), (RERANKED, 0.93))
    )


def _scans(found: Found) -> Iterator[Found]:
    return (row for name, row in found["difficult"].items() if name.startswith("scan"))


def _most(rows: Iterable[Found], key: str) -> float:
    return float(max(row[key] for row in rows))


def _grown(found: Found) -> Found:
    """Return the row of the bank of a hundred thousand."""
    return next(dict(row) for row in found["growth"] if row["size"] == 100_000)


AIMS = (
    Aim("graph below the root alone, on local scales, FT", 0.78, True, _figure("watertight", PARTS, "ft")),
    Aim("pure query, NN", 0.98, True, _figure("watertight", PURE, "nn")),
    Aim("pure query, FT", 0.82, True, _figure("watertight", PURE, "ft")),
    Aim("pure query, mAP", 0.88, True, _figure("watertight", PURE, "map")),
    Aim("re-ranked, FT", 0.93, True, _figure("watertight", RERANKED, "ft")),
    Aim("re-ranked, mAP", 0.95, True, _figure("watertight", RERANKED, "map")),
    Aim("either half of the classes: FT beyond these bounds, the least", 0.0, True, _halves, "+.3f"),
    Aim("classes of five: FT that re-ranking adds", 0.0, True, _of_five, "+.3f"),
    Aim("poses, which are a purely non-rigid bank, pure query, FT", 0.96, True, _figure("poses", PURE, "ft")),
    Aim("poses, re-ranked, FT", 0.99, True, _figure("poses", RERANKED, "ft")),
    Aim(
        "FT lost to noise of 0.3 %, to a quarter of the faces, isotropic remeshing, turning, scaling or mirroring",
        0.03, False, _loss,
    ),
    Aim(
        "half of a surface as the query, NN", 0.85, True,
        lambda found: min(row["50% of the surface"]["nn"] for row in found["partial"].values()),
    ),
    Aim("area whose part is matched right, over both levels", 0.85, True, _level(1, 2)),
    Aim("the same of 16 parts", 0.85, True, _level(1)),
    Aim("the same of 32 parts", 0.85, True, _level(2)),
    Aim("of 32 parts, or with a part that is as good but for a tenth", 0.85, True, _level(2, key="as_good")),
    Aim("of 32 parts, laid on the other with their own borders", 0.85, True, _level(2, key="laid_right")),
    Aim("indexing 2,500 vertices, CPU s", 0.6, False, lambda found: sum(found["index_cpu_seconds"].values()), ".2f"),
    Aim("indexing a scan of 100,000 faces, CPU s", 3.0, False, lambda f: _most(_scans(f), "cpu_seconds"), ".2f"),
    Aim(
        "query against 400 shapes, CPU ms", 15, False,
        lambda found: 1000 * found["query_cpu_seconds"]["query"], ".1f",
    ),
    Aim("query against 100,000, CPU ms", 100, False, lambda found: 1000 * _grown(found)["query"], ".1f"),
    Aim("of its twenty best, those of an exhaustive search", 0.97, True, lambda found: _grown(found)["agreement"]),
    Aim("difficult meshes: the longest, s", 10, False, lambda f: _most(f["difficult"].values(), "seconds"), ".1f"),
    Aim("difficult meshes: most memory, MiB", 2048, False, lambda f: _most(f["difficult"].values(), "peak_mib"), ".0f"),
    Aim(
        "over HTTP, 400 shapes, by a stored one: 95th percentile, ms", 150, False,
        lambda found: found["http"]["by stored shape"]["p95_ms"], ".0f",
    ),
)  # fmt: skip


def aims(found: Found) -> list[str]:
    """Return a table of the aims for which there are figures."""
    lines = ["| | should be | is | |", "|---|---|---|---|"]
    for aim in AIMS:
        try:
            value = aim.measured(found)
        except KeyError:  # not measured yet
            continue
        met = value >= aim.bound if aim.least else value <= aim.bound
        sign = "≥" if aim.least else "≤"
        lines.append(f"| {aim.what} | {sign} {aim.bound:g} | {value:{aim.form}} | {'' if met else '**missed**'} |")
    return lines

"""``python -m benchmarks.retrieval [--meshes N] [--queries N]``: writes results/retrieval.{json,md} and two plots.

Features are kept in a folder outside the repository (``SHAPERY_BENCH_CACHE``), so that a second run costs seconds.
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.retrieval.costs import index_profile, query_cost
from benchmarks.retrieval.features import Features, features_of, part_of
from benchmarks.retrieval.growth import growth
from benchmarks.retrieval.measures import class_matrix, measure, per_query, precision_recall, relevance
from benchmarks.retrieval.plots import draw_class_matrix, draw_precision_recall
from benchmarks.retrieval.scores import all_methods
from benchmarks.retrieval.variants import VARIANTS, cropped
from shapery_contracts.errors import UserError
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io import read_mesh
from shapery_retrieval.search import Searcher
from shapery_retrieval.warm import warm

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("SHAPERY_TEST_DATA", ROOT.parent / "shared" / "data"))
RESULTS = ROOT / "benchmarks" / "results"
CLASSES = (
    "human", "cup", "glasses", "airplane", "ant", "chair", "octopus", "table", "teddy", "hand",
    "plier", "fish", "bird", "spring", "armadillo", "bust", "mech", "bearing", "vase", "fourleg",
)  # fmt: skip
POSES = ("cat-poses", "lion-poses", "horse-poses", "face-poses", "crane", "pdance", "pcow", "chickenCrossing")
SHOWN = ("D2", "quantiles of the HKS", "FV1, hierarchy", "FV2, hierarchy", "ARG alone (parts and relations)",
         "whole score, pure query", "whole score, re-ranked")  # fmt: skip


def watertight(per_class: int) -> tuple[list[Features], np.ndarray, list[int]]:
    """Return the features of the first shapes of each class, their classes, and their numbers."""
    numbers = [20 * c + i + 1 for c in range(20) for i in range(per_class)]
    features = [features_of(f"{n}.ply", mesh_of(n)) for n in numbers]
    return features, np.array([(n - 1) // 20 for n in numbers]), numbers


def mesh_of(number: int) -> TriangleMesh:
    """Read a mesh of the watertight set."""
    return read_mesh(DATA / "meshes" / "watertight" / f"{number}.ply")


def poses(per_set: int) -> tuple[list[Features], np.ndarray]:
    """Return features of frames of the motion sets: one class per set, all non-rigid."""
    features, labels = [], []
    for label, name in enumerate(POSES):
        with np.load(DATA / "motion" / f"{name}.npz") as stored:
            vertices, faces = stored["vertices"], stored["faces"]
        for frame in np.unique(np.linspace(0, len(vertices) - 1, per_set).astype(int)):
            features.append(features_of(f"{name} {frame}", TriangleMesh(vertices[frame], faces)))
            labels.append(label)
    return features, np.array(labels)


def table(features: list[Features], labels: np.ndarray) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Measure every method."""
    matrices = all_methods(features)
    return {name: vars(measure(scores, labels)) for name, scores in matrices.items()}, matrices


def robustness(features: list[Features], labels: np.ndarray, numbers: list[int], queries: int) -> dict[str, Any]:
    """Search with worn versions of some shapes, the shapes themselves left out of the bank."""
    bank = {str(n): item.arg for n, item in zip(numbers, features, strict=True)}
    label_of = dict(zip(bank, labels.tolist(), strict=True))
    searcher = Searcher.of(bank)
    chosen = numbers[:: max(1, len(numbers) // queries)]
    rows: dict[str, Any] = {}
    for name, wear in {"as they are": lambda mesh, _rng: mesh, **VARIANTS}.items():
        relevant, refused = [], 0
        for number in chosen:
            try:
                arg = features_of(f"{number}, {name}", wear(mesh_of(number), np.random.default_rng(number))).arg
            except UserError:
                refused += 1
                continue
            hits = searcher.search(arg, limit=len(bank), exclude=str(number)).hits
            relevant.append([label_of[hit.shape_id] == label_of[str(number)] for hit in hits])
        found = per_query(np.array(relevant))
        row = {key: float(values.mean()) for key, values in found.items()}
        rows[name] = {**row, "queries": len(relevant), "refused": refused}
    return rows


def partial_queries(features: list[Features], labels: np.ndarray, numbers: list[int], queries: int) -> dict[str, Any]:
    """Search with parts of some shapes, cut off by a random plane; the shapes themselves are left out of the bank."""
    bank = {str(n): item.arg for n, item in zip(numbers, features, strict=True)}
    label_of = dict(zip(bank, labels.tolist(), strict=True))
    searcher = Searcher.of(bank)
    chosen = numbers[:: max(1, len(numbers) // queries)]
    rows: dict[str, Any] = {}
    for share in (0.7, 0.5, 0.3):
        relevant = []
        for number in chosen:
            arg, hypotheses = part_of(cropped(share)(mesh_of(number), np.random.default_rng(number)))
            answer = searcher.search(arg, limit=len(bank), exclude=str(number), partial=True, hypotheses=hypotheses)
            relevant.append([label_of[hit.shape_id] == label_of[str(number)] for hit in answer.hits])
        measured = per_query(np.array(relevant))
        rows[f"{share:.0%} of the surface"] = {key: float(values.mean()) for key, values in measured.items()}
        print(share, rows[f"{share:.0%} of the surface"], flush=True)
    return rows


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--meshes", type=int, default=20, help="shapes per class of the watertight set")
    parser.add_argument("--poses", type=int, default=9, help="frames per motion set")
    parser.add_argument("--queries", type=int, default=20, help="shapes that are worn")
    parser.add_argument("--growth", type=int, default=5, help="the largest bank has ten to this power shapes")
    options = parser.parse_args()
    RESULTS.mkdir(exist_ok=True)
    warm()
    features, labels, numbers = watertight(options.meshes)
    found, matrices = table(features, labels)
    names = CLASSES
    curves = {name: precision_recall(relevance(matrices[name], labels)) for name in SHOWN}
    draw_precision_recall(curves, RESULTS / "retrieval_precision_recall.png")
    pure = matrices["whole score, pure query"]
    draw_class_matrix(class_matrix(pure, labels), names, RESULTS / "retrieval_classes.png")
    by_class = {
        key: {
            name: [float(per_query(relevance(matrices[key], labels))["ft"][labels == c].mean())]
            for c, name in enumerate(names)
        }
        for key in ("ARG alone (parts and relations)", "whole score, pure query", "whole score, re-ranked")
    }
    even, odd = np.isin(labels, np.unique(labels)[::2]), np.isin(labels, np.unique(labels)[1::2])
    splits = {
        title: table([f for f, use in zip(features, keep, strict=True) if use], labels[keep])[0]
        for title, keep in (("classes 1, 3, 5, …", even), ("classes 2, 4, 6, …", odd))
    }
    few = np.array([(n - 1) % 20 < 5 for n in numbers])
    splits["five shapes per class"] = table([f for f, use in zip(features, few, strict=True) if use], labels[few])[0]
    result: dict[str, Any] = {
        "watertight": found,
        "first_tier_by_class": by_class,
        "splits": splits,
        "arg_kilobytes": float(np.mean([len(item.arg.to_bytes()) for item in features])) / 1000,
    }
    if options.poses:
        result["poses"] = table(*poses(options.poses))[0]
    if options.queries:
        result["robustness"] = robustness(features, labels, numbers, options.queries)
        result["partial"] = partial_queries(features, labels, numbers, 2 * options.queries)
    result["index_cpu_seconds"] = index_profile([mesh_of(n) for n in numbers[:: max(1, len(numbers) // 10)]])
    result["query_cpu_seconds"] = query_cost(features)
    result["growth"] = growth(features, [10**k for k in range(2, options.growth + 1)])

    (RESULTS / "retrieval.json").write_text(json.dumps(result, indent=2))
    (RESULTS / "retrieval.md").write_text(report(result, len(features)))
    print((RESULTS / "retrieval.md").read_text())


def report(result: dict[str, Any], count: int) -> str:
    """Return the results as Markdown."""
    head = "| method | NN | FT | ST | mAP | DCG |\n|---|---|---|---|---|---|"

    def rows(found: dict[str, Any]) -> list[str]:
        return [
            f"| {name} | " + " | ".join(f"{row[key]:.3f}" for key in ("nn", "ft", "st", "map", "dcg")) + " |"
            for name, row in found.items()
        ]

    lines = [f"# Retrieval: {count} watertight models, leave one out", "", head, *rows(result["watertight"])]
    lines += ["", "FT is the precision where it equals recall. The dissertation's Table 4.1: FV1 0.600, FV2 0.628."]
    for title in ("retrieval_precision_recall", "retrieval_classes"):
        lines += ["", f"![{title}]({title}.png)"]
    for title, found in result["splits"].items():
        lines += ["", f"## {title[0].upper()}{title[1:]}", "", head, *rows(found)]
    if "poses" in result:
        lines += ["", "## Poses: every class is one moving body", "", head, *rows(result["poses"])]
    if "robustness" in result:
        lines += ["", "## Worn queries against the bank as it is", "", head, *rows(result["robustness"])]
    if "partial" in result:
        lines += [
            "",
            "## Parts, cut off by a random plane, as queries of unknown size",
            "",
            head,
            *rows(result["partial"]),
        ]
    classes = result["first_tier_by_class"]
    lines += ["", "## First tier by class", "", "| class | " + " | ".join(classes) + " |", "|---" * 4 + "|"]
    for name in next(iter(classes.values())):
        lines.append(f"| {name} | " + " | ".join(f"{values[name][0]:.2f}" for values in classes.values()) + " |")
    lines += ["", "## Cost in CPU seconds", "", "| | s |", "|---|---|"]
    lines += [f"| indexing: {name} | {seconds:.3f} |" for name, seconds in result["index_cpu_seconds"].items()]
    lines += [f"| bank of {count}: {name} | {seconds:.4f} |" for name, seconds in result["query_cpu_seconds"].items()]
    lines += ["", f"A graph takes {result['arg_kilobytes']:.1f} kB.", "", "## Growth", ""]
    stages = ("vector", "candidates", "match", "query")
    lines += [
        "CPU seconds of a query in a bank of real graphs moved to fill it, and the share of the twenty best of a search"
    ]
    lines += ["in which every shape is matched part by part.", ""]
    lines += [f"| shapes | {' | '.join(stages)} | matched | kept of exhaustive | vectors, MiB |", "|---" * 8 + "|"]
    for row in result["growth"]:
        costs = " | ".join(f"{row[stage]:.4f}" for stage in stages)
        rest = f"{row['compared']:.0f} | {row['agreement']:.3f} | {row['vector_megabytes']:.1f}"
        lines.append(f"| {row['size']} | {costs} | {rest} |")
    if "growth_of_vectors" not in result:
        return "\n".join(lines) + "\n"
    vectors = result["growth_of_vectors"]
    lines += ["", f"Candidates alone among {vectors['size']} vectors: {vectors['candidates']:.3f} s of CPU, "]
    lines[-1] += f"{vectors['megabytes']:.0f} MiB."
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()

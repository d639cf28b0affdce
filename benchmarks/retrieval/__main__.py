"""``python -m benchmarks.retrieval [PART…]``: writes results/retrieval.{json,md} and two plots.

Each part is written as soon as it is measured, and those not asked for are kept, so that it goes on where it was
stopped. Features are kept in a folder outside the repository (``SHAPERY_BENCH_CACHE``): a second run costs seconds.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.retrieval.correspondence import correspondence
from benchmarks.retrieval.costs import index_profile, query_cost
from benchmarks.retrieval.difficult import difficult
from benchmarks.retrieval.features import Features, features_of, part_of
from benchmarks.retrieval.growth import growth
from benchmarks.retrieval.measures import class_matrix, measure, per_query, precision_recall, relevance
from benchmarks.retrieval.parts import partial_queries
from benchmarks.retrieval.parts_growth import Query, kept_of_exhaustive
from benchmarks.retrieval.peers import peer_matrices, peers_of
from benchmarks.retrieval.plots import draw_class_matrix, draw_precision_recall
from benchmarks.retrieval.report import report
from benchmarks.retrieval.scores import all_methods, own_methods
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
PER_CLASS = 20
POSES = ("cat-poses", "lion-poses", "horse-poses", "face-poses", "crane", "pdance", "pcow", "chickenCrossing")
FRAMES = 9
PURE, RERANKED, PARTS = "whole score, pure query", "whole score, re-ranked", "ARG alone (parts and relations)"
SHOWN = ("D2", "spherical harmonics", "aligned depth buffers, Fourier", "bag of 64 HKS words", "FV1, hierarchy",
         "FV2, hierarchy", PARTS, PURE, RERANKED)  # fmt: skip

Found = dict[str, Any]


def mesh_of(number: int) -> TriangleMesh:
    """Read a mesh of the watertight set."""
    return read_mesh(DATA / "meshes" / "watertight" / f"{number}.ply")


NUMBERS = list(range(1, PER_CLASS * len(CLASSES) + 1))
LABELS = np.repeat(np.arange(len(CLASSES)), PER_CLASS)


@cache
def watertight() -> list[Features]:
    """Return the features of all shapes."""
    return [features_of(f"{n}.ply", mesh_of(n)) for n in NUMBERS]


@cache
def posed_meshes() -> tuple[list[TriangleMesh], np.ndarray]:
    """Return frames of the motion sets: one class per set, all non-rigid."""
    meshes, labels = [], []
    for label, name in enumerate(POSES):
        with np.load(DATA / "motion" / f"{name}.npz") as stored:
            vertices, faces = stored["vertices"], stored["faces"]
        for frame in np.unique(np.linspace(0, len(vertices) - 1, FRAMES).astype(int)):
            meshes.append(TriangleMesh(vertices[frame], faces))
            labels.append(label)
    return meshes, np.array(labels)


@cache
def posed() -> list[Features]:
    """Return the features of the frames."""
    return [features_of(f"frame {i}", mesh) for i, mesh in enumerate(posed_meshes()[0])]


def measured(matrices: dict[str, np.ndarray], labels: np.ndarray) -> Found:
    """Measure methods by their score matrices."""
    return {name: vars(measure(scores, labels)) for name, scores in matrices.items()}


def tables() -> Found:
    """Table 4.1, Figs 4.8 and 4.9: every method on the watertight set, beside peers, and on halves of it by classes."""
    features = watertight()
    matrices = all_methods(features)
    peers = peer_matrices([peers_of(mesh_of(n)) for n in NUMBERS])
    matrices = {"D2": matrices["D2"], **peers, **matrices}
    curves = {name: precision_recall(relevance(matrices[name], LABELS)) for name in SHOWN}
    draw_precision_recall(curves, RESULTS / "retrieval_precision_recall.png", others=SHOWN[:4], relevant=PER_CLASS - 1)
    draw_class_matrix(class_matrix(matrices[PURE], LABELS), CLASSES, RESULTS / "retrieval_classes.png")
    by_class = {
        key: {
            name: float(per_query(relevance(matrices[key], LABELS))["ft"][c == LABELS].mean())
            for c, name in enumerate(CLASSES)
        }
        for key in (PARTS, PURE, RERANKED)
    }
    moving = np.isin([CLASSES[label] for label in LABELS], (
        "human", "glasses", "ant", "octopus", "teddy", "hand", "plier", "spring", "armadillo", "fourleg",
    ))  # fmt: skip
    splits = {}
    for title, keep in {
        "classes 1, 3, 5, …": LABELS % 2 == 0,
        "classes 2, 4, 6, …": LABELS % 2 == 1,
        "the ten classes that bend at joints": moving,
        "the other ten classes": ~moving,
        "five shapes per class": np.arange(len(LABELS)) % PER_CLASS < 5,
    }.items():
        some = [item for item, use in zip(features, keep, strict=True) if use]
        splits[title] = measured(own_methods(some), LABELS[keep])
    return {
        "watertight": measured(matrices, LABELS),
        "first_tier_by_class": by_class,
        "splits": splits,
        "arg_kilobytes": float(np.mean([len(item.arg.to_bytes()) for item in features])) / 1000,
    }


def poses() -> Found:
    """Banks of bodies that move."""
    return {"poses": measured(all_methods(posed()), posed_meshes()[1])}


def robustness() -> Found:
    """Search with worn versions of two shapes of each class, the shapes themselves left out of the bank."""
    bank = {str(n): item.arg for n, item in zip(NUMBERS, watertight(), strict=True)}
    label_of = dict(zip(bank, LABELS.tolist(), strict=True))
    searcher = Searcher.of(bank)
    rows: Found = {}
    for name, wear in {"as they are": lambda mesh, _rng: mesh, **VARIANTS}.items():
        relevant, refused = [], 0
        for number in NUMBERS[::10]:
            try:
                arg = features_of(f"{number}, {name}", wear(mesh_of(number), np.random.default_rng(number))).arg
            except UserError:
                refused += 1
                continue
            hits = searcher.search(arg, limit=len(bank), exclude=str(number)).hits
            relevant.append([label_of[hit.shape_id] == label_of[str(number)] for hit in hits])
        row = {key: float(values.mean()) for key, values in per_query(np.array(relevant)).items()}
        rows[name] = {**row, "queries": len(relevant), "refused": refused}
        print(name, rows[name], flush=True)
    return {"robustness": rows}


def parts() -> Found:
    """Parts of shapes as queries: of the set that the features of patches were chosen on, of others, and of poses."""
    bank = {f"{n:03d}": item.arg for n, item in zip(NUMBERS, watertight(), strict=True)}
    meshes, labels = posed_meshes()
    frames = {f"{i:03d}": item.arg for i, item in enumerate(posed())}
    queries = {n - 1: mesh_of(n) for n in NUMBERS}
    others = [place for place in range(len(NUMBERS)) if place % 10 == 5]
    return {
        "partial": {
            "forty shapes that nothing was chosen on": partial_queries(bank, LABELS, queries, others, 1000),
            "two frames of each motion": partial_queries(
                frames, labels, dict(enumerate(meshes)), list(range(2, len(meshes), FRAMES // 2)), 0
            ),
            "forty shapes that features of patches were chosen on": partial_queries(
                bank, LABELS, queries, list(range(0, len(NUMBERS), 10)), 1
            ),
        }
    }


def costs() -> Found:
    """CPU seconds of indexing by stage, and of queries."""
    profile = index_profile([mesh_of(n) for n in NUMBERS[::40]])
    return {"index_cpu_seconds": profile, "query_cpu_seconds": query_cost(watertight())}


def bank_growth() -> Found:
    """Search in banks of a hundred to a million shapes."""
    return {"growth": growth([item.arg for item in watertight()], [10**k for k in range(2, 7)])}


def halves() -> dict[str, Query]:
    """Return halves of ten shapes as queries, by the names of their classes."""
    return {
        CLASSES[LABELS[n - 1]]: part_of(cropped(0.5)(mesh_of(n), np.random.default_rng(999 + n)))
        for n in NUMBERS[5::40]
    }


def parts_growth() -> Found:
    """Search with halves of shapes in banks of a hundred to a hundred thousand."""
    sizes = [10**k for k in range(2, 6)]
    return {"parts_growth": kept_of_exhaustive([item.arg for item in watertight()], halves(), sizes)}


def on_pgvector() -> Found:
    """Candidates by pgvector."""
    from benchmarks.retrieval.postgres import on_postgres

    return {"postgres": on_postgres([item.arg for item in watertight()], [*halves().values()], 100_000)}


PARTS_OF_IT: dict[str, Callable[[], Found]] = {
    "tables": tables,
    "poses": poses,
    "robustness": robustness,
    "parts": parts,
    "correspondence": lambda: {"correspondence": correspondence(DATA / "motion")},
    "costs": costs,
    "difficult": lambda: {"difficult": difficult(DATA / "meshes" / "difficult", DATA / "motion")},
    "growth": bank_growth,
    "parts-growth": parts_growth,
    "postgres": on_pgvector,
}


def write_page() -> None:
    """Write the page from what has been measured so far; searches over HTTP are `benchmarks.search_over_http`'s."""
    found = json.loads((RESULTS / "retrieval.json").read_text())
    over_http = RESULTS / "search_over_http.json"
    if over_http.exists():
        found["http"] = json.loads(over_http.read_text())
    (RESULTS / "retrieval.md").write_text(report(found))


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS_OF_IT)}; by default all")
    options = parser.parse_args()
    unknown = set(options.parts) - set(PARTS_OF_IT)
    if unknown:
        parser.error(f"there is no part {', '.join(sorted(unknown))}")
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / "retrieval.json"
    warm()
    for name in options.parts or PARTS_OF_IT:
        found = PARTS_OF_IT[name]()
        known = json.loads(path.read_text()) if path.exists() else {}
        path.write_text(json.dumps({**known, **found}, indent=1) + "\n")
        write_page()
        print(f"{name} is measured", flush=True)


if __name__ == "__main__":
    main()

"""Vessels and bleedings beside peers, and what model selection earns.

Everything runs on generated phantoms with known truth. Peers get the true polarity, the true seed (the part of their
result that overlaps the truth most), and for each case the setting that is best for it; ours gets the volume alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from statistics import mean
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation
from skimage.filters import frangi

from benchmarks.segmentation.cache import Cache
from benchmarks.segmentation.tables import shown, table
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mask_metrics import dice, intersection_over_union, mask_metrics
from shapery_geometry.mesh import icosphere
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.flow.selection import SelectionParams, selected_flow
from shapery_segmentation.flow.tangential import TangentialFlowParams, seed_triangle, tangential_flow
from shapery_segmentation.labels import MICROHEMORRHAGE, OBJECT, VESSEL
from shapery_segmentation.microhemorrhage import find_microhemorrhages
from shapery_segmentation.phantoms import VesselPhantom, tube_phantom, vessel_tree_phantom
from shapery_segmentation.vessels import segment_vessels
from shapery_segmentation.vessels.border import find_border
from shapery_segmentation.vessels.evidence import gather_evidence
from shapery_segmentation.vessels.tracking import relative_box, seed_voxel

BoolArray = NDArray[np.bool_]
Row = dict[str, Any]

LEVELS = np.linspace(0.2, 0.8, 25)
"""Thresholds that are tried, as shares of the way from tissue to vessel (of the largest response for Frangi)."""


def phantoms() -> dict[str, VesselPhantom]:
    """Return the phantoms by name: SNR 10 and a 40 % bias field unless they say otherwise."""
    spacing = np.diag([0.8, 0.8, 1.4, 1.0])
    oblique = spacing.copy()
    oblique[:3, :3] = Rotation.from_euler("xyz", [10, 20, 30], degrees=True).as_matrix() @ spacing[:3, :3]
    kinds: tuple[Literal["bright"], Literal["dark"]] = ("bright", "dark")
    cases = {
        f"tube {radius:g} mm {polarity}": tube_phantom(
            np.random.default_rng(1), radius=radius, bend=5.0, polarity=polarity, bias=0.4
        )
        for radius in (1.5, 3.0)
        for polarity in kinds
    }
    for number in range(6):
        polarity = kinds[(number + 1) % 2]
        cases[f"tree {number} {polarity}"] = vessel_tree_phantom(
            np.random.default_rng(number), polarity=polarity, bias=0.4, tumor_radius=9.0, microhemorrhages=3
        )
    cases["tree 1 bright, SNR 5"] = vessel_tree_phantom(np.random.default_rng(1), bias=0.4, snr=5.0)
    for name, affine in (("0.8 × 0.8 × 1.4 mm", spacing), ("the same, oblique", oblique)):
        cases[f"tree 3 bright, {name}"] = vessel_tree_phantom(
            np.random.default_rng(3), (120, 120, 70), affine, least_radius=2.1, bias=0.4
        )
    return cases


def measure(name: str, phantom: VesselPhantom) -> Row:
    """Return what ours and the peers reach on one phantom."""
    truth = phantom.truth.data == VESSEL
    tumor = phantom.truth.data == OBJECT
    start = time.process_time()
    found = segment_vessels(phantom.volume, around=tumor if tumor.any() else None)
    seconds = time.process_time() - start
    metrics = mask_metrics(found.mask, truth, phantom.volume.spacing)
    drawn = phantom.centerline[phantom.volume.contains(phantom.centerline)]
    middle = np.concatenate([b.points for b in found.branches]) if found.branches else np.full((1, 3), np.inf)
    voxel = max(phantom.volume.spacing)
    row: Row = {
        "name": name,
        "polarity_found": found.polarity == phantom.polarity,
        "iou": metrics.iou,
        "assd_mm": metrics.assd_mm,
        "hd95_mm": metrics.hd95_mm,
        "centerline_recall": float(np.mean(cKDTree(middle).query(drawn)[0] < voxel)),
        "centerline_precision": float(np.mean(cKDTree(drawn).query(middle)[0] < voxel)),
        "branches": len(phantom.branches),
        "branches_reached": reached(phantom, found.mask),
        "models": [tree.model for tree in found.trees],
        "self_intersections": sum(len(self_intersections(s)) for s in found.surfaces),
        "closed": all(s.closed and s.manifold and s.oriented for s in found.surfaces),
        "seconds": seconds,
        "peers": {peer: best(run(phantom, truth), truth) for peer, run in PEERS.items()},
    }
    bled = phantom.truth.data == MICROHEMORRHAGE
    if bled.any():
        start = time.process_time()
        result = find_microhemorrhages(phantom.volume, vessels=found.mask, tumor=tumor, polarity=found.polarity)
        row |= {
            "bleedings_dice": dice(result.mask, bled),
            "bleedings": len(result.clusters),
            "bleedings_seconds": time.process_time() - start,
        }
    return row


def reached(phantom: VesselPhantom, mask: BoolArray) -> int:
    """Return how many branches have their last point inside `mask`."""
    ends = phantom.volume.to_index(np.array([branch.points[-1] for branch in phantom.branches]))
    index = np.clip(np.rint(ends), 0, np.array(mask.shape) - 1).astype(int)
    return int(mask[tuple(index.T)].sum())


def thresholds(phantom: VesselPhantom, truth: BoolArray, sigma: float = 0.0) -> list[BoolArray]:
    """Return what one threshold for the whole volume gives, for many thresholds: region growing from a true seed."""
    values = _bright(phantom)
    if sigma:
        values = ndimage.gaussian_filter(values, sigma)
    low, high = float(np.median(values[~truth])), float(np.median(values[truth]))
    return [_component(values > low + level * (high - low), truth) for level in LEVELS]


def vesselness(phantom: VesselPhantom, truth: BoolArray) -> list[BoolArray]:
    """Return what Frangi's filter gives, for many thresholds."""
    response: NDArray[np.float64] = frangi(  # type: ignore[no-untyped-call]
        _bright(phantom), sigmas=(1, 1.5, 2, 3, 4), black_ridges=False
    )
    top = float(np.percentile(response[truth], 90))
    return [_component(response > level * top, truth) for level in np.geomspace(0.002, 1.0, 25)]


PEERS: dict[str, Callable[[VesselPhantom, BoolArray], list[BoolArray]]] = {
    "region growing": thresholds,
    "the same, smoothed": lambda phantom, truth: thresholds(phantom, truth, 0.7),
    "Frangi": vesselness,
}


def best(results: list[BoolArray], truth: BoolArray) -> float:
    """Return the largest intersection over union."""
    return max(intersection_over_union(result, truth) for result in results)


def selection_ablation(numbers: tuple[int, ...] = (0, 1, 2)) -> list[Row]:
    """Return what each flow alone, and the model selection, make of a small ball in a branching tree (S9).

    The field is the same; surfaces are measured as the flows leave them, before they are fitted to the wall.
    """
    rows: list[Row] = []
    for number in numbers:
        phantom = vessel_tree_phantom(np.random.default_rng(number), bias=0.4)
        truth = phantom.truth.data == VESSEL
        grid = Volume(np.ascontiguousarray(phantom.volume.data, dtype=np.float32), phantom.volume.affine)
        evidence = gather_evidence(grid.data, grid.spacing, "bright")
        border = find_border(evidence, evidence.seeds, most=truth.size)
        field = relative_box(evidence, border, grid)
        center = field.affine[:3, :3] @ seed_voxel(field.depth > 0, field.depth) + field.affine[:3, 3]
        ball = icosphere(center, 1.0, 2)
        for name in ("normal flow alone", "model selection", "tangential flow alone"):
            start = time.process_time()
            if name == "tangential flow alone":
                triangle = seed_triangle(field.values, field.affine, center, edge_length=0.8)
                if triangle is None:
                    continue
                grown = tangential_flow(field.values, field.affine, triangle, TangentialFlowParams(edge_length=0.8))
                mesh, iterations, rounds = grown.mesh, 0, grown.rounds
            else:
                params = SelectionParams(edge_length=0.8, switch=name == "model selection")
                chosen = selected_flow(field.values, field.affine, ball, params)
                mesh, iterations = chosen.mesh, chosen.iterations
                rounds = chosen.tangential.rounds if chosen.tangential is not None else 0
            seconds = time.process_time() - start
            inside = rasterize(mesh, grid) if mesh.closed else np.zeros(grid.shape, dtype=np.bool_)
            rows.append(
                {
                    "phantom": f"tree {number}",
                    "flow": name,
                    "iou": intersection_over_union(inside, truth),
                    "branches": len(phantom.branches),
                    "branches_reached": reached(phantom, inside),
                    "iterations": iterations,
                    "rounds": rounds,
                    "vertices": len(mesh.vertices),
                    "self_intersections": len(self_intersections(mesh)),
                    "seconds": seconds,
                }
            )
    return rows


def section(results: dict[str, Any]) -> list[str]:
    """Return the lines of the page that tell of vessels."""
    rows, ablation = results["phantoms"], results["selection"]
    lines = [
        "## Vessels and bleedings on phantoms",
        "",
        "SNR 10 and a 40 % bias field unless the name says otherwise; radii fall to 1.5 mm. Ours: one setting,",
        "automatic seeds and polarity. Peers: the true polarity, a true seed, and the best of 25 thresholds for each",
        "case. Centerlines count within one voxel.",
        "",
    ]
    head = (
        "phantom", "IoU", *(f"{peer} IoU" for peer in PEERS), "ASSD mm", "HD95 mm", "centerline recall", "precision",
        "branches reached", "bleedings Dice", "flow", "self-int.", "CPU s",
    )  # fmt: skip
    lines += table(
        head,
        [
            [
                row["name"],
                shown(row["iou"]),
                *(shown(row["peers"][peer]) for peer in PEERS),
                shown(row["assd_mm"], 2),
                shown(row["hd95_mm"], 2),
                shown(row["centerline_recall"]),
                shown(row["centerline_precision"]),
                f"{row['branches_reached']}/{row['branches']}",
                shown(row.get("bleedings_dice")),
                ", ".join(row["models"]),
                str(row["self_intersections"]),
                shown(row["seconds"], 2),
            ]
            for row in rows
        ],
    )
    peers = ", ".join(f"{peer} {shown(mean(r['peers'][peer] for r in rows))}" for peer in PEERS)
    lines += ["", f"Mean IoU: ours {shown(mean(r['iou'] for r in rows))}, {peers}.", "", "### Model selection (S9)", ""]
    lines += table(
        ("phantom", "flow", "IoU", "branches reached", "iterations", "rounds", "vertices", "self-int.", "CPU s"),
        [
            [
                row["phantom"],
                row["flow"],
                shown(row["iou"]),
                f"{row['branches_reached']}/{row['branches']}",
                str(row["iterations"]),
                str(row["rounds"]),
                str(row["vertices"]),
                str(row["self_intersections"]),
                shown(row["seconds"], 2),
            ]
            for row in ablation
        ],
    )
    return lines


def measured(cache: Cache, key: str) -> dict[str, Any]:
    """Return what `section` shows."""
    # Once before, so that no case pays for loading what was compiled.
    segment_vessels(tube_phantom(np.random.default_rng(0), (36, 36, 36)).volume)
    selection_ablation((0,))
    rows = []
    for name, phantom in phantoms().items():
        rows.append(cache.get(f"vessels {name}", key, lambda n=name, p=phantom: measure(n, p)))
        print(f"{name}: IoU {shown(rows[-1]['iou'])}", flush=True)
    return {"phantoms": rows, "selection": cache.get("vessels selection", key, selection_ablation)}


def _bright(phantom: VesselPhantom) -> NDArray[np.float32]:
    values = np.asarray(phantom.volume.data, dtype=np.float32)
    return values if phantom.polarity == "bright" else -values


def _component(mask: BoolArray, truth: BoolArray) -> BoolArray:
    """Return the connected part that holds most of the truth."""
    labels, count = ndimage.label(mask, np.ones((3, 3, 3)))
    counts = np.bincount(labels[truth], minlength=count + 1)
    counts[0] = 0
    return np.asarray(labels == counts.argmax()) if counts.any() else np.zeros(mask.shape, dtype=np.bool_)

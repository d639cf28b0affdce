"""What is told of a segmentation: ``report.json``, and the files beside it."""

from __future__ import annotations

import json
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shapery_contracts.segmentation import Microhemorrhage, SegmentedObject, SegmentedVessel
from shapery_geometry.concurrent import both
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import TriangleMesh

if TYPE_CHECKING:
    from shapery_segmentation.objects import Recovered
    from shapery_segmentation.pipeline import Segmentation
    from shapery_segmentation.surroundings import Surroundings
    from shapery_segmentation.vessels import VesselTree

COLORS = (
    (0.89, 0.35, 0.26, 1.0),
    (0.96, 0.65, 0.14, 1.0),
    (0.46, 0.72, 0.32, 1.0),
    (0.24, 0.56, 0.80, 1.0),
    (0.60, 0.40, 0.76, 1.0),
)
"""sRGB and opacity of the objects in the scene, in turn."""

VESSEL_COLOR, BLEEDING_COLOR = (0.30, 0.45, 0.85, 1.0), (0.55, 0.10, 0.10, 1.0)
"""The same of vessels and of microhemorrhages."""

BLEEDING_SURFACE, EVOLUTION = "surfaces/microhemorrhages.ply", "evolution.bin"
"""Names below the output folder."""


def describe(item: Recovered, number: int, voxel_mm3: float) -> SegmentedObject:
    """Return the report's entry of one object."""
    surface = item.surface
    volume = float(np.count_nonzero(item.inside)) * voxel_mm3
    return SegmentedObject(
        label=number,
        seed=[float(x) for x in item.seed],
        seeded_by=item.seeded_by,
        confidence=round(item.confidence, 4),
        volume_mm3=float(surface.volume),
        core_volume_mm3=volume + float(np.count_nonzero(item.enclosed)) * voxel_mm3,
        area_mm2=surface.area,
        centroid=[float(x) for x in surface.centroid],
        vertices=len(surface.vertices),
        faces=len(surface.faces),
        closed=surface.closed,
        genus=surface.genus,
        self_intersections=item.self_intersections,
        threshold=item.threshold,
        iterations=item.iterations,
        converged=item.converged,
        surface=surface_name(number),
        polarity=item.polarity,
        seed_volume_mm3=item.seed_mm3,
        notes=list(item.notes),
    )


def describe_surroundings(around: Surroundings) -> dict[str, Any]:
    """Return the fields of the report that tell of vessels and bleedings."""
    bleedings = around.bleedings.clusters if around.bleedings is not None else ()
    return {
        "vessels": [_vessel(tree, number) for number, tree in enumerate(around.vessels.trees, start=1)],
        "vessel_polarity": around.vessels.polarity,
        "microhemorrhages": [
            Microhemorrhage(volume_mm3=cluster.volume_mm3, centroid=list(cluster.centroid), voxels=cluster.voxels)
            for cluster in bleedings
        ],
    }


def _vessel(tree: VesselTree, number: int) -> SegmentedVessel:
    surface = tree.surface
    least, largest = tree.radius_range_mm
    return SegmentedVessel(
        label=number,
        length_mm=tree.length_mm,
        mean_radius_mm=tree.mean_radius_mm,
        least_radius_mm=least,
        largest_radius_mm=largest,
        volume_mm3=tree.volume_mm3,
        area_mm2=surface.area,
        branches=len(tree.branches),
        forks=tree.forks,
        vertices=len(surface.vertices),
        faces=len(surface.faces),
        closed=surface.closed,
        genus=surface.genus,
        self_intersections=len(self_intersections(surface)),
        surface=f"surfaces/vessel-{number}.ply",
    )


def surface_name(number: int) -> str:
    """Return the name of an object's surface below the output folder."""
    return f"surfaces/{number}.ply"


@cache
def versions() -> dict[str, str]:
    """Return the versions of the parts that a result depends on."""
    found = {}
    for name in ("shapery-segmentation", "shapery-geometry", "numpy", "scipy", "numba"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # a source tree that was never installed
            found[name] = "unknown"
    return found


def write_outputs(segmentation: Segmentation, folder: Path) -> None:
    """Write labels, surfaces, scene and report into `folder`.

    Parameters
    ----------
    segmentation
        The result of `segment`.
    folder
        Created if it is missing. Files of these names in it are replaced: ``labels.nii.gz``, ``surface.ply`` (all
        objects in one), ``surfaces/<n>.ply``, ``surfaces/vessel-<n>.ply`` and ``surfaces/microhemorrhages.ply`` (one
        per structure), ``scene.glb`` (all structures), ``evolution.bin`` (see `shapery_segmentation.evolution`; where
        there are objects), ``report.json``.
    """
    # Imported here: writers are not needed to segment.
    from shapery_geometry.volume_io import write_nifti
    from shapery_segmentation.evolution import write_evolution

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    both(
        lambda: _write_surfaces(segmentation, folder),
        lambda: write_nifti(segmentation.labels, folder / "labels.nii.gz", description="Shapery segmentation"),
    )
    if segmentation.evolution:
        write_evolution(segmentation.evolution, folder / EVOLUTION)
    write_report(segmentation, folder)


def _write_surfaces(segmentation: Segmentation, folder: Path) -> None:
    from shapery_geometry.mesh_io import write_ply, write_scene_glb

    write_ply(joined(segmentation.surfaces), folder / "surface.ply")
    (folder / "surfaces").mkdir(exist_ok=True)
    scene: list[tuple[str, TriangleMesh, tuple[float, float, float, float]]] = []
    for item, surface in zip(segmentation.report.objects, segmentation.surfaces, strict=True):
        write_ply(surface, folder / item.surface)
        scene.append((f"object {item.label}", surface, COLORS[(item.label - 1) % len(COLORS)]))
    for vessel, surface in zip(segmentation.report.vessels, segmentation.vessel_surfaces, strict=True):
        write_ply(surface, folder / vessel.surface)
        scene.append((f"vessel {vessel.label}", surface, VESSEL_COLOR))
    if segmentation.bleeding_surface is not None:
        write_ply(segmentation.bleeding_surface, folder / BLEEDING_SURFACE)
        scene.append(("microhemorrhages", segmentation.bleeding_surface, BLEEDING_COLOR))
    write_scene_glb(scene, folder / "scene.glb")


def write_report(segmentation: Segmentation, folder: Path) -> None:
    """Write ``report.json`` alone."""
    text = json.dumps(segmentation.report.model_dump(mode="json"), indent=2, ensure_ascii=False)
    (folder / "report.json").write_text(text + "\n", encoding="utf-8")


def joined(surfaces: tuple[TriangleMesh, ...]) -> TriangleMesh:
    """Return several surfaces as one mesh of several components."""
    if not surfaces:
        return TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32))
    offsets = np.cumsum([0] + [len(s.vertices) for s in surfaces[:-1]])
    faces = [s.faces + int(o) for s, o in zip(surfaces, offsets, strict=True)]
    return TriangleMesh(np.concatenate([s.vertices for s in surfaces]), np.concatenate(faces))

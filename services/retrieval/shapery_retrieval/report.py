"""What indexing leaves behind: the graph, a mesh and pictures for viewers, and the report."""

from __future__ import annotations

import json
from pathlib import Path

from shapery_contracts.retrieval import IndexStage, LevelSummary, MeshChange, ShapeIndexResult
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io import write_scene_glb
from shapery_geometry.repair import mesh_report
from shapery_retrieval.arg import Arg
from shapery_retrieval.coverage import coverage_of
from shapery_retrieval.describe import Description
from shapery_retrieval.normalise import cleaned, web_mesh
from shapery_retrieval.pose import Pose, pose_of
from shapery_retrieval.preview import png_bytes, preview
from shapery_retrieval.vector import vector_of

_COLOUR = (0.62, 0.72, 0.82, 1.0)


def level_summaries(arg: Arg) -> list[LevelSummary]:
    """Return the parts of every level, their areas, parents and neighbours."""
    summaries = []
    for number, level in enumerate(arg.levels):
        touching = [(i, j) for i in range(level.parts) for j in range(i + 1, level.parts) if level.adjacency[i, j]]
        summaries.append(
            LevelSummary(
                level=number,
                parts=level.parts,
                masses=[round(float(mass), 6) for mass in level.masses],
                parents=level.parents.tolist() if number else [],
                edges=touching,
            )
        )
    return summaries


def write_outputs(mesh: TriangleMesh, found: Description, folder: Path, preview_size: int) -> ShapeIndexResult:
    """Write all artifacts into a folder and return the report, which is one of them.

    Parameters
    ----------
    mesh
        As it was read.
    found
        Its description.
    folder
        Must exist.
    preview_size
        Side of the picture in pixels.
    """
    data = found.arg.to_bytes()
    (folder / "shape.arg").write_bytes(data)
    shown, pose = write_views(mesh, found, folder)
    (folder / "preview.png").write_bytes(png_bytes(preview(shown, preview_size, pose=pose)))
    state = mesh_report(cleaned(mesh).mesh)
    result = ShapeIndexResult(
        index_version=found.arg.index_version,
        vector=vector_of(found.arg).tolist(),
        part_vector=coverage_of(found.arg).tolist(),
        arg_bytes=len(data),
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
        components=found.normalised.components,
        closed=state.closed,
        oriented=state.oriented,
        genus=state.genus,
        area=mesh.area,
        bounding_box=mesh.bounding_box.tolist(),
        changes=[MeshChange(name=name, count=count) for name, count in found.normalised.changes],
        levels=level_summaries(found.arg),
        stages=[IndexStage(name=name, seconds=round(value, 4)) for name, value in found.seconds.items()],
        warnings=_warnings(found, state.closed),
    )
    write_report(result, folder)
    return result


def write_views(mesh: TriangleMesh, found: Description, folder: Path) -> tuple[TriangleMesh, Pose]:
    """Write ``mesh.glb`` and ``components.json``; return what is shown, and its pose.

    The latter holds for each vertex of the former its part on each level, and the cell that it lies in: that of the
    nearest sample, of which parts consist. It also tells how the shape stands.
    """
    shown = web_mesh(mesh)
    write_scene_glb([("shape", shown, _COLOUR)], folder / "mesh.glb")
    cells = found.cells_on(shown)
    pose = pose_of(shown)
    components = {
        "vertices": len(shown.vertices),
        "pose": {"frame": pose.frame.round(9).tolist(), "towards": pose.towards.round(9).tolist()},
        "levels": [{"level": k, "labels": of[cells].tolist()} for k, of in enumerate(found.decomposition.levels)],
        "cells": cells.tolist(),
    }
    (folder / "components.json").write_text(json.dumps(components, separators=(",", ":")))
    return shown, pose


def write_report(result: ShapeIndexResult, folder: Path) -> None:
    """Write ``report.json``."""
    (folder / "report.json").write_text(result.model_dump_json(indent=2))


def _warnings(found: Description, closed: bool) -> list[str]:
    changes = dict(found.normalised.changes)
    warnings = []
    if not closed:
        warnings.append("The surface is open: its thickness is a guess where rays leave it through a hole.")
    if "link_components" in changes:
        warnings.append(
            f"The mesh has {found.normalised.components} components; they were compared as one shape, "
            "joined where they are nearest."
        )
    if "leave_out_specks" in changes:
        warnings.append(f"{changes['leave_out_specks']} components too small to matter were left out.")
    return warnings

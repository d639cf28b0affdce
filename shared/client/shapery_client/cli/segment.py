"""``shapery segment``: tumor surfaces from volumes, here or on a server."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from shapery_client.cli._output import JsonOption, print_json, print_table, stage_bar, stderr, stdout
from shapery_client.cli._server import KeyOption, OptionalServerOption, connect, upload_paths
from shapery_contracts.errors import InvalidInput
from shapery_contracts.segmentation import SegmentationParams, SegmentationResult

DEFAULTS = SegmentationParams()


def segment(
    post: Annotated[Path, typer.Option(help="T1 volume after contrast: a file, or a folder of DICOM slices.")],
    out: Annotated[Path, typer.Option(help="Folder for labels, surfaces, scene and report.")],
    pre: Annotated[Path | None, typer.Option(help="T1 volume before contrast.")] = None,
    seed: Annotated[
        list[str] | None,
        typer.Option(help="A point X,Y,Z in RAS mm to start from; repeat for several. By default found by itself."),
    ] = None,
    max_objects: Annotated[int, typer.Option(min=1, max=64, help="Report at most this many objects.")] = (
        DEFAULTS.max_objects
    ),
    edge_length: Annotated[float | None, typer.Option(help="Edge length of the final mesh in mm.")] = None,
    smoothing: Annotated[float, typer.Option(min=0, max=1, help="Weight of the curvature term.")] = DEFAULTS.smoothing,
    random_seed: Annotated[int, typer.Option(min=0, help="Seed of the random generator.")] = DEFAULTS.random_seed,
    server: OptionalServerOption = None,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Recover enhancing tumors: labels.nii.gz, surface.ply, surfaces/, scene.glb and report.json."""
    params: dict[str, Any] = {
        "seeds": [_point(text) for text in seed or []],
        "max_objects": max_objects,
        "edge_length": edge_length,
        "smoothing": smoothing,
        "random_seed": random_seed,
    }
    inputs = {"post": post} | ({"pre": pre} if pre is not None else {})
    if server is None:
        from shapery_client._local import run_locally

        with stage_bar("segment") as bar:
            found = run_locally("segmentation", inputs, params, out, bar.update)
        result = SegmentationResult.model_validate(found.model_dump())
    else:
        result = _on_server(server, api_key, inputs, params, out)
    if json:
        print_json(result)
    else:
        show_result(result, out)


def _on_server(
    server: str, api_key: str | None, inputs: dict[str, Path], params: dict[str, Any], out: Path
) -> SegmentationResult:
    with connect(server, api_key) as client:
        assets = {name: [asset.id for asset in upload_paths(client, path)] for name, path in inputs.items()}
        job = client.submit("segmentation", assets, params)
        stderr.print(f"[dim]job {job.id}[/]")
        with stage_bar("segment") as bar:
            job = client.wait(job.id, on_event=lambda event: bar.update(event.stage, event.fraction, event.message))
        client.download(job, out)
    return SegmentationResult.model_validate(job.result)


def show_result(result: SegmentationResult, out: Path) -> None:
    """Print the objects that were found, as a table."""
    rows = [
        (
            item.label,
            f"{item.confidence:.2f}",
            f"{item.volume_mm3 / 1000:.2f}",
            f"{item.core_volume_mm3 / 1000:.2f}",
            f"{item.area_mm2 / 100:.1f}",
            ", ".join(f"{value:.0f}" for value in item.centroid),
            item.faces,
            item.self_intersections,
        )
        for item in result.objects
    ]
    columns = ("object", "confidence", "volume ml", "core ml", "area cm²", "centre RAS mm", "faces", "self-inters.")
    print_table(columns, rows, "No enhancing tumor was found.")
    for warning in result.warnings:
        stderr.print(f"[yellow]note[/] {warning}")
    stdout.print(f"[dim]{sum(stage.seconds for stage in result.stages):.1f} s, written to[/] {out}")


def _point(text: str) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 3:
        raise InvalidInput(
            "invalid_params", f"--seed {text!r} is not of the form X,Y,Z.", "For example --seed 12,-30,8.5."
        )
    return values

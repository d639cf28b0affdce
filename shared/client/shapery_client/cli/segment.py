"""``shapery segment``: surfaces of tumors, vessels and other objects from volumes, here or on a server."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from shapery_client.cli._following import follow
from shapery_client.cli._output import JsonOption, print_json, print_table, stage_bar, stderr, stdout
from shapery_client.cli._server import KeyOption, OptionalServerOption, connect, upload_paths
from shapery_contracts.errors import InvalidInput
from shapery_contracts.segmentation import SegmentationParams, SegmentationResult

DEFAULTS = SegmentationParams()


def segment(
    post: Annotated[Path, typer.Option(help="T1 volume after contrast: a file, or a folder of DICOM slices.")],
    out: Annotated[Path, typer.Option(help="Folder for labels, surfaces, scene and report.")],
    pre: Annotated[Path | None, typer.Option(help="T1 volume before contrast.")] = None,
    vessels: Annotated[Path | None, typer.Option(help="Volume that shows vessels: SWI, MRA or CTA.")] = None,
    mode: Annotated[
        str, typer.Option(help="tumor; object, for whatever --seed or --box points at in any volume; or auto.")
    ] = DEFAULTS.mode,
    seed: Annotated[
        list[str] | None,
        typer.Option(help="A point X,Y,Z in RAS mm to start from; repeat for several. By default found by itself."),
    ] = None,
    box: Annotated[
        str | None, typer.Option(help="X0,Y0,Z0,X1,Y1,Z1 in RAS mm: the object lies between these corners.")
    ] = None,
    polarity: Annotated[str, typer.Option(help="How vessels show: bright, dark, or auto.")] = DEFAULTS.polarity,
    vessel_seed: Annotated[
        list[str] | None, typer.Option(help="A point X,Y,Z in RAS mm in a vessel; repeat for several.")
    ] = None,
    microhemorrhages: Annotated[
        str, typer.Option(help="How bleedings show: bright, dark, auto (dark beside dark vessels), or off.")
    ] = DEFAULTS.microhemorrhages,
    register: Annotated[bool, typer.Option(help="Move volumes that do not lie on the one after contrast.")] = (
        DEFAULTS.register_volumes
    ),
    topology: Annotated[
        str, typer.Option(help="preserve (the genus of the seed) or adaptive (surfaces merge and split).")
    ] = DEFAULTS.topology,
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
    """Recover tumors, vessels or any object: labels.nii.gz, surface.ply, surfaces/, scene.glb and report.json."""
    params: dict[str, Any] = {
        "mode": mode,
        "seeds": [_numbers(text, "--seed", "X,Y,Z", "12,-30,8.5") for text in seed or []],
        "box": None if box is None else _numbers(box, "--box", "X0,Y0,Z0,X1,Y1,Z1", "-20,-60,0,30,-10,45"),
        "polarity": polarity,
        "vessel_seeds": [_numbers(text, "--vessel-seed", "X,Y,Z", "12,-30,8.5") for text in vessel_seed or []],
        "microhemorrhages": microhemorrhages,
        "register_volumes": register,
        "topology": topology,
        "max_objects": max_objects,
        "edge_length": edge_length,
        "smoothing": smoothing,
        "random_seed": random_seed,
    }
    given = {"post": post, "pre": pre, "vessels": vessels}
    inputs = {name: path for name, path in given.items() if path is not None}
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
        job = follow(client, job, "segment")
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
    if result.vessels:
        print_table(
            ("vessel", "length mm", "radius mm", "from", "to", "branches", "forks", "volume ml"),
            [
                (
                    item.label,
                    f"{item.length_mm:.0f}",
                    f"{item.mean_radius_mm:.2f}",
                    f"{item.least_radius_mm:.2f}",
                    f"{item.largest_radius_mm:.2f}",
                    item.branches,
                    item.forks,
                    f"{item.volume_mm3 / 1000:.2f}",
                )
                for item in result.vessels
            ],
            "",
        )
    if result.microhemorrhages:
        total = sum(item.volume_mm3 for item in result.microhemorrhages)
        stdout.print(f"{len(result.microhemorrhages)} microhemorrhages, {total:.0f} mm³ together")
    for item in result.objects:
        for note in item.notes:
            stderr.print(f"[yellow]object {item.label}[/] {note}")
    for warning in result.warnings:
        stderr.print(f"[yellow]note[/] {warning}")
    stdout.print(f"[dim]{sum(stage.seconds for stage in result.stages):.1f} s, written to[/] {out}")


def _numbers(text: str, option: str, form: str, example: str) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != form.count(",") + 1:
        raise InvalidInput(
            "invalid_params", f"{option} {text!r} is not of the form {form}.", f"For example {option} {example}."
        )
    return values

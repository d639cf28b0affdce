"""``shapery encode``, ``decode`` and ``info``: mesh sequences into motion files and back, here or on a server."""

from __future__ import annotations

import shutil
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic import BaseModel

from shapery_client.cli._following import follow
from shapery_client.cli._output import JsonOption, print_json, print_table, stage_bar, stderr, stdout
from shapery_client.cli._server import KeyOption, OptionalServerOption, connect, upload_paths
from shapery_contracts.errors import InvalidInput, Unavailable
from shapery_contracts.motion import (
    DEFAULT_KG,
    MotionDecodeResult,
    MotionEncodeResult,
    MotionInfo,
)

FORMATS = {".npz": "npz", ".zip": "ply", ".glb": "glb"}
"""What `decode` writes by the ending of its output; a zip may also hold OBJ files."""


def encode(
    sequence: Annotated[Path, typer.Argument(help="An npz file, or a folder or zip of OBJ, PLY, OFF or STL frames.")],
    out: Annotated[Path, typer.Option(help="The motion file to write (.smc).")],
    kg: Annotated[float | None, typer.Option(help=f"Bound on the KG error in percent [default: {DEFAULT_KG}].")] = None,
    rmse: Annotated[float | None, typer.Option(help="Bound on the RMS error in mean edge lengths.")] = None,
    max_error: Annotated[
        float | None, typer.Option(help="Bound on the largest error as a fraction of the bounding box's diagonal.")
    ] = None,
    preset: Annotated[str, typer.Option(help="default, or fast.")] = "default",
    profile: Annotated[str, typer.Option(help="trajectory, or gradient (the dissertation's).")] = "trajectory",
    clusters: Annotated[int | None, typer.Option(help="Number of clusters; by default chosen.")] = None,
    key_frame: Annotated[list[int] | None, typer.Option(help="A key frame (gradient); repeat for several.")] = None,
    group_frames: Annotated[int | None, typer.Option(help="Most frames that are decoded as a whole.")] = None,
    fps: Annotated[float | None, typer.Option(help="Frames per second, for players.")] = None,
    unit: Annotated[str, typer.Option(help="Unit of the coordinates, for viewers.")] = "",
    name: Annotated[str, typer.Option(help="What the motion is called; by default as its file.")] = "",
    report: Annotated[Path | None, typer.Option(help="Also write a folder with the report and its pictures.")] = None,
    server: OptionalServerOption = None,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Compress a mesh sequence. Every bound that is given is met by the decoded file."""
    params: dict[str, Any] = {
        "kg": kg,
        "rmse": rmse,
        "max_error": max_error,
        "preset": preset,
        "profile": profile,
        "clusters": clusters,
        "key_frames": key_frame or [],
        "group_frames": group_frames,
        "fps": fps,
        "unit": unit,
        "name": name or sequence.stem,
    }
    with tempfile.TemporaryDirectory(prefix=".shapery-", dir=_folder_of(out)) as work:
        found = _run("motion-encode", {"sequence": sequence}, params, Path(work), server, api_key, "encode")
        result = MotionEncodeResult.model_validate(found.model_dump())
        if report is not None:
            report.mkdir(parents=True, exist_ok=True)
            for extra in sorted(Path(work).iterdir()):
                if extra.is_file() and extra.name != result.file:
                    shutil.move(extra, report / extra.name)
        shutil.move(Path(work) / result.file, out)
    if json:
        print_json(result)
        return
    total = max(result.bytes, 1)
    rows = [(part, size, f"{100 * size / total:.1f} %") for part, size in result.parts.items()]
    print_table(("part", "bytes", "share"), rows, "")
    for warning in result.warnings:
        stderr.print(f"[yellow]note[/] {warning}")
    stdout.print(
        f"{result.frames} frames of {result.vertices} vertices in {result.bytes} bytes: "
        f"{result.motion_bits_per_vertex_frame:.3f} bits per vertex and frame, connectivity apart"
    )
    errors = result.errors
    stdout.print(
        f"KG error {errors.kg_percent:.4g} %, RMS {errors.rmse_edges:.4g} edges, "
        f"largest {errors.largest_fraction:.3g} of the diagonal"
    )
    stdout.print(f"[dim]{sum(stage.seconds for stage in result.stages):.1f} s, written to[/] {out}")


def decode(
    motion: Annotated[Path, typer.Argument(help="A motion file (.smc).")],
    out: Annotated[Path, typer.Option(help="What to write: .npz, .zip (of PLY files), or .glb (animated).")],
    frames: Annotated[str, typer.Option(help="A range FIRST:STOP; by default all frames.")] = "",
    format: Annotated[  # noqa: A002 - it is the option's name
        str, typer.Option(help="npz, obj, ply or glb; by default by the ending of --out.")
    ] = "",
    server: OptionalServerOption = None,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Turn a motion file into frames for other programs."""
    form = format or FORMATS.get(out.suffix.lower(), "")
    if not form:
        raise InvalidInput(
            "invalid_params",
            f"The ending of {out.name!r} does not tell what to write.",
            f"End it in {', '.join(FORMATS)}, or give --format.",
        )
    params: dict[str, Any] = {"format": form} | _range(frames)
    with tempfile.TemporaryDirectory(prefix=".shapery-", dir=_folder_of(out)) as work:
        found = _run("motion-decode", {"motion": motion}, params, Path(work), server, api_key, "decode")
        result = MotionDecodeResult.model_validate(found.model_dump())
        shutil.move(Path(work) / result.file, out)
    if json:
        print_json(result)
    else:
        stdout.print(f"{result.frames} frames of {result.vertices} vertices, {result.bytes} bytes")
        stdout.print(f"[dim]{sum(stage.seconds for stage in result.stages):.1f} s, written to[/] {out}")


def info(
    motion: Annotated[Path, typer.Argument(help="A motion file (.smc).")],
    json: JsonOption = False,
) -> None:
    """Tell what a motion file holds: bytes by part, errors met. Compares every checksum."""
    if not motion.is_file():
        raise InvalidInput("missing_input", f"The file {motion} does not exist.")
    try:
        inspection: Any = import_module("shapery_motion.inspection")
    except ModuleNotFoundError as error:
        raise Unavailable(
            "missing_dependency", "The service that reads motion files is not installed here.",
            "Install the package shapery-motion.",
        ) from error  # fmt: skip
    found: MotionInfo = inspection.info(motion)
    if json:
        print_json(found)
        return
    print_table(("section", "bytes"), list(found.sections.items()), "")
    title = f"{found.name}: " if found.name else ""
    stdout.print(
        f"{title}{found.frames} frames of {found.vertices} vertices and {found.faces} faces, profile {found.profile}, "
        f"{len(found.groups)} {'group' if len(found.groups) == 1 else 'groups'}, {found.bytes} bytes"
    )
    stdout.print(
        f"{found.bits_per_vertex_frame:.3f} bits per vertex and frame, {found.motion_bits_per_vertex_frame:.3f} "
        f"without the connectivity, which takes {found.connectivity_bits_per_vertex:.1f} bits a vertex"
    )
    for title, values in (("asked", found.bounds), ("met", found.errors)):
        stdout.print(f"{title}: " + (", ".join(f"{key} {value:.4g}" for key, value in values.items()) or "nothing"))


def _run(
    kind: str,
    inputs: dict[str, Path],
    params: dict[str, Any],
    work: Path,
    server: str | None,
    api_key: str | None,
    title: str,
) -> BaseModel:
    from shapery_contracts.kinds import get_kind

    if server is None:
        from shapery_client._local import run_locally

        with stage_bar(title) as bar:
            return run_locally(kind, inputs, params, work, bar.update)
    with connect(server, api_key) as client:
        assets = {name: [asset.id for asset in upload_paths(client, path)] for name, path in inputs.items()}
        job = client.submit(kind, assets, params)
        stderr.print(f"[dim]job {job.id}[/]")
        job = follow(client, job, title)
        client.download(job, work)
    return get_kind(kind).result.model_validate(job.result)


def _folder_of(out: Path) -> Path:
    out.parent.mkdir(parents=True, exist_ok=True)
    return out.parent


def _range(frames: str) -> dict[str, int]:
    if not frames:
        return {}
    first, colon, stop = frames.partition(":")
    try:
        if not colon:
            return {"first": int(first), "stop": int(first) + 1}
        return {"first": int(first or 0)} | ({"stop": int(stop)} if stop else {})
    except ValueError:
        raise InvalidInput(
            "invalid_params", f"--frames {frames!r} is not of the form FIRST:STOP.", "For example --frames 10:20."
        ) from None

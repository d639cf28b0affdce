"""``shapery index``, ``search`` and ``matrix``: a bank of shapes in one file, or on a server."""

from __future__ import annotations

import os
from pathlib import Path
from types import ModuleType
from typing import Annotated, Literal

import typer

from shapery_client.cli._bank_server import index_on_server, search_on_server
from shapery_client.cli._following import missing_workers_told
from shapery_client.cli._output import REFUSED, JsonOption, print_json, print_table, stage_bar, stderr, stdout
from shapery_client.cli._server import KeyOption, OptionalServerOption, connect
from shapery_client.cli.collections import LabelOption, parse_labels
from shapery_contracts.errors import InvalidInput, Unavailable
from shapery_contracts.retrieval import DEFAULT_COLLECTION, ShapeFilter, ShapeSearchParams, ShapeSearchResult
from shapery_contracts.shapes import SearchAnswer

BankOption = Annotated[Path, typer.Option(help="The file that holds the bank.")]
OptionalBankOption = Annotated[
    Path | None, typer.Option("--bank", help="The file that holds the bank; without, give --server.")
]
DEFAULTS = ShapeSearchParams()


def index(
    meshes: Annotated[list[Path], typer.Argument(help="Meshes: OBJ, PLY, STL, OFF or GLB; of folders all in them.")],
    bank: OptionalBankOption = None,
    jobs: Annotated[int, typer.Option(min=0, help="Processes that work side by side; 0: one per processor.")] = 0,
    collection: Annotated[str, typer.Option(help="On a server: the collection, made where there is none.")] = (
        DEFAULT_COLLECTION
    ),
    label: LabelOption = None,
    server: OptionalServerOption = None,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Describe meshes by their graphs and put them into a bank. What is in it already, unchanged, is passed over.

    With --server each becomes a shape of a collection; there a shape of the same name and bytes is what is passed over.
    """
    if bank is None:
        with (
            connect(_needed(server), api_key) as client,
            stage_bar("index") as bar,
            missing_workers_told(client, "shape-index", bar),
        ):
            outcomes = index_on_server(
                client, meshes, collection, parse_labels(label), lambda f, text: bar.update("", f, text)
            )
        where = f"in the collection {collection!r}"
    else:
        work = _service()
        processes = jobs or os.cpu_count() or 1
        with stage_bar("index") as bar:
            outcomes = work.index_files(meshes, bank, processes, lambda f, text: bar.update("", f, text))
        where = f"the bank at {bank} holds {work.count(bank)} shapes"
    refused = [outcome for outcome in outcomes if outcome["error"] is not None]
    if json:
        print_json(outcomes)
    else:
        for outcome in refused:
            stderr.print(f"[bold red]refused[/] {outcome['name']}: ", end="")
            stderr.print(outcome["error"]["message"], markup=False, soft_wrap=True)
        added = sum(outcome["indexed"] for outcome in outcomes)
        unchanged = len(outcomes) - added - len(refused)
        stdout.print(f"{added} indexed, {unchanged} unchanged, {len(refused)} refused; {where}.", markup=False)
    if refused:
        raise typer.Exit(REFUSED)


def search(
    mesh: Annotated[
        str, typer.Argument(help="The mesh to query by, or a shape of the bank: its name, on a server its id.")
    ],
    bank: OptionalBankOption = None,
    limit: Annotated[int, typer.Option(min=1, max=200, help="How many shapes at most.")] = DEFAULTS.limit,
    partial: Annotated[bool, typer.Option(help="The query may be a part of what is looked for.")] = False,
    rerank: Annotated[bool, typer.Option(help="Let the order follow how the found resemble each other, too.")] = False,
    collection: Annotated[str | None, typer.Option(help="On a server: only shapes of this collection.")] = None,
    label: LabelOption = None,
    part: Annotated[
        list[int] | None,
        typer.Option(min=0, help="Search with this part of the query's finest level alone; repeat for several."),
    ] = None,
    region: Annotated[
        Path | None,
        typer.Option(help="Search with some faces of the query alone: a text file of their numbers, from 0."),
    ] = None,
    server: OptionalServerOption = None,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Find the shapes of a bank that resemble a mesh, or contain a region of one."""
    faces = None if region is None else _face_numbers(region)
    mode: Literal["global", "partial"] = "partial" if partial else "global"
    result: ShapeSearchResult | SearchAnswer
    if bank is None:
        labels = parse_labels(label)
        with connect(_needed(server), api_key) as client:
            result = search_on_server(
                client,
                mesh,
                mode=mode,
                collection=collection,
                labels=labels,
                limit=limit,
                rerank=rerank,
                parts=part,
                region=faces,
            )
        names = {hit.shape_id: f"{hit.shape_id}  {hit.shape.name}" for hit in result.hits}
    else:
        only = ShapeFilter(collection=collection, labels=parse_labels(label))
        params = ShapeSearchParams(mode=mode, limit=limit, rerank=rerank, parts=part or None, region=faces, filter=only)
        result = ShapeSearchResult.model_validate(_service().search(mesh, bank, params))
        names = {hit.shape_id: hit.shape_id for hit in result.hits}
    if json:
        print_json(result)
        return
    rows = [
        (place, names[hit.shape_id], f"{hit.score:.4f}", hit.level, " ".join(f"{s:.3f}" for s in hit.level_scores))
        for place, hit in enumerate(result.hits, start=1)
    ]
    print_table(("rank", "shape", "score", "best level", "scores by level"), rows, "There is no such shape.")


def matrix(
    bank: BankOption,
    out: Annotated[Path, typer.Option(help="The npz file to write: names (n,) and scores (n, n).")],
    rerank: Annotated[bool, typer.Option(help="Re-rank over the whole bank.")] = False,
) -> None:
    """Score every shape of a bank against every other; each row is a pure query, higher is more alike."""
    work = _service()
    count = work.write_matrix(bank, out, rerank=rerank)
    stdout.print(f"{count} × {count} scores, written to {out}", markup=False)


def _face_numbers(path: Path) -> list[int]:
    try:
        numbers = [int(word) for word in path.read_text().replace(",", " ").split()]
    except (OSError, ValueError) as error:
        raise InvalidInput("invalid_params", f"{path} is no list of the numbers of faces: {error}.") from error
    if not numbers or min(numbers) < 0:
        raise InvalidInput("invalid_params", f"{path} names no faces, or one below 0.")
    return numbers


def _needed(server: str | None) -> str:
    if server is None:
        raise InvalidInput(
            "missing_input", "There is no bank to work on.", "Name a file with --bank, or a server with --server."
        )
    return server


def _service() -> ModuleType:
    try:
        from shapery_retrieval import commands
    except ModuleNotFoundError as error:
        raise Unavailable(
            "missing_dependency",
            "The service that compares shapes is not installed here.",
            "Install the package shapery-retrieval.",
        ) from error
    return commands

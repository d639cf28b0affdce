"""``shapery index``, ``search`` and ``matrix``: a bank of shapes in one file."""

from __future__ import annotations

import os
from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from shapery_client.cli._output import REFUSED, JsonOption, print_json, print_table, stage_bar, stderr, stdout
from shapery_contracts.errors import InvalidInput, Unavailable
from shapery_contracts.retrieval import ShapeSearchParams, ShapeSearchResult

BankOption = Annotated[Path, typer.Option(help="The file that holds the bank.")]
DEFAULTS = ShapeSearchParams()


def index(
    meshes: Annotated[list[Path], typer.Argument(help="Meshes: OBJ, PLY, STL, OFF or GLB; of folders all in them.")],
    bank: BankOption,
    jobs: Annotated[int, typer.Option(min=0, help="Processes that work side by side; 0: one per processor.")] = 0,
    json: JsonOption = False,
) -> None:
    """Describe meshes by their graphs and put them into a bank. What is in it already, unchanged, is passed over."""
    work = _service()
    with stage_bar("index") as bar:
        outcomes = work.index_files(meshes, bank, jobs or os.cpu_count() or 1, lambda f, text: bar.update("", f, text))
    refused = [outcome for outcome in outcomes if outcome["error"] is not None]
    if json:
        print_json(outcomes)
    else:
        for outcome in refused:
            stderr.print(f"[bold red]refused[/] {outcome['name']}: ", end="")
            stderr.print(outcome["error"]["message"], markup=False, soft_wrap=True)
        added = sum(outcome["indexed"] for outcome in outcomes)
        stdout.print(
            f"{added} indexed, {len(outcomes) - added - len(refused)} unchanged, {len(refused)} refused; "
            f"the bank at {bank} holds {work.count(bank)} shapes."
        )
    if refused:
        raise typer.Exit(REFUSED)


def search(
    mesh: Annotated[Path, typer.Argument(help="The mesh to query by.")],
    bank: BankOption,
    limit: Annotated[int, typer.Option(min=1, max=200, help="How many shapes at most.")] = DEFAULTS.limit,
    partial: Annotated[bool, typer.Option(help="The query may be a part of what is looked for.")] = False,
    rerank: Annotated[bool, typer.Option(help="Let the order follow how the found resemble each other, too.")] = False,
    json: JsonOption = False,
) -> None:
    """Find the shapes of a bank that resemble a mesh."""
    work = _service()
    if not mesh.is_file():
        raise InvalidInput("missing_input", f"The file for 'mesh', {mesh}, does not exist.")
    params = ShapeSearchParams(mode="partial" if partial else "global", limit=limit, rerank=rerank)
    result: ShapeSearchResult = work.search_file(mesh, bank, params)
    if json:
        print_json(result)
        return
    rows = [
        (place, hit.shape_id, f"{hit.score:.4f}", hit.level, " ".join(f"{score:.3f}" for score in hit.level_scores))
        for place, hit in enumerate(result.hits, start=1)
    ]
    print_table(("rank", "shape", "score", "best level", "scores by level"), rows, "The bank is empty.")


def matrix(
    bank: BankOption,
    out: Annotated[Path, typer.Option(help="The npz file to write: names (n,) and scores (n, n).")],
    rerank: Annotated[bool, typer.Option(help="Re-rank over the whole bank.")] = False,
) -> None:
    """Score every shape of a bank against every other; each row is a pure query, higher is more alike."""
    work = _service()
    count = work.write_matrix(bank, out, rerank=rerank)
    stdout.print(f"{count} × {count} scores, written to {out}", markup=False)


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

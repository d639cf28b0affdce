"""``shapery batch``: many items in one request."""

from __future__ import annotations

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any
from uuid import UUID

import typer

from shapery_client.cli._following import missing_workers_told
from shapery_client.cli._output import JOB_FAILED, JsonOption, print_json, print_table, stage_bar
from shapery_client.cli._server import DEFAULT_SERVER, KeyOption, ServerOption, connect, upload_paths
from shapery_client.cli.jobs import parse_params
from shapery_contracts.api import BatchEvent, BatchItem, BatchView
from shapery_contracts.errors import InvalidInput
from shapery_contracts.states import JobState

if TYPE_CHECKING:
    from shapery_client import Client

app = typer.Typer(help="Submit, watch and fetch many jobs at once.", no_args_is_help=True)
BatchArgument = Annotated[UUID, typer.Argument(help="The batch's id.", metavar="BATCH")]


@app.command()
def submit(
    items: Annotated[
        Path,
        typer.Argument(
            help='NDJSON, one item a line: {"inputs": {NAME: ASSET or PATH or list of them}, "params": {…}}. '
            "Paths are uploaded, relative to this file."
        ),
    ],
    kind: Annotated[str, typer.Option(help="The job kind.")] = "segmentation",
    params: Annotated[str, typer.Option(help="Parameters for all items, as JSON.")] = "{}",
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Submit a batch; local files that its items name are uploaded first."""
    shared = parse_params(params)
    with connect(server, api_key) as client:
        known: dict[Path, list[UUID]] = {}
        parsed = [
            _item(client, line, number, items.parent, known)
            for number, line in enumerate(items.read_text("utf-8").splitlines(), start=1)
            if line.strip()
        ]
        if not parsed:
            raise InvalidInput("validation_failed", f"{items} holds no items.", "Write one JSON object a line.")
        batch = client.submit_batch(kind, parsed, shared)
    show_batch(batch, json)


@app.command()
def show(
    batch: BatchArgument, server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False
) -> None:
    """Show a batch's counts."""
    with connect(server, api_key) as client:
        show_batch(client.batch(batch), json)


@app.command()
def watch(
    batch: BatchArgument, server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False
) -> None:
    """Show a batch's progress until all jobs have ended; exit code 5 if some did not succeed."""
    with (
        connect(server, api_key) as client,
        stage_bar(str(batch)[-12:]) as bar,
        missing_workers_told(client, client.batch(batch).kind, bar),
    ):

        def show_event(event: BatchEvent) -> None:
            total = sum(event.counts.values())
            ended = sum(count for state, count in event.counts.items() if state.terminal)
            bar.update(_counts(event.counts), ended / max(total, 1), "")

        ended = client.wait_batch(batch, on_event=show_event)
    show_batch(ended, json)
    if ended.counts.get(JobState.SUCCEEDED, 0) != ended.total:
        raise typer.Exit(JOB_FAILED)


@app.command()
def results(
    batch: BatchArgument,
    out: Annotated[Path | None, typer.Option("--out", help="Also fetch each item's files into DIR/INDEX/.")] = None,
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
) -> None:
    """Print each item's job as a line of JSON, in the order of the items."""
    with connect(server, api_key) as client:
        for item in client.batch_results(batch):
            typer.echo(item.model_dump_json())
            if out is not None and item.job.state is JobState.SUCCEEDED and not item.job.expired:
                client.download(item.job, out / f"{item.index:05d}")


@app.command()
def cancel(
    batch: BatchArgument, server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False
) -> None:
    """Cancel what has not ended."""
    with connect(server, api_key) as client:
        show_batch(client.cancel_batch(batch), json)


@app.command()
def retry(
    batch: BatchArgument, server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False
) -> None:
    """Run the failed and crashed items again, and only those."""
    with connect(server, api_key) as client:
        show_batch(client.retry_batch(batch), json)


def show_batch(batch: BatchView, json: bool) -> None:
    """Print a batch for people or for programs."""
    if json:
        print_json(batch)
        return
    rows = [
        ("batch", batch.id),
        ("kind", batch.kind),
        ("items", batch.total),
        ("states", _counts(batch.counts)),
        ("created", f"{batch.created_at:%Y-%m-%d %H:%M:%S} UTC"),
    ]
    print_table(("", ""), rows, "")


def _counts(counts: dict[JobState, int]) -> str:
    return ", ".join(f"{count} {state}" for state, count in counts.items() if count)


def _item(client: Client, line: str, number: int, folder: Path, known: dict[Path, list[UUID]]) -> BatchItem:
    try:
        raw: Any = json_module.loads(line)
        inputs = {
            name: [
                found
                for value in (values if isinstance(values, list) else [values])
                for found in _assets(client, str(value), folder, known)
            ]
            for name, values in raw["inputs"].items()
        }
        return BatchItem(inputs=inputs, params=raw.get("params", {}))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InvalidInput(
            "validation_failed", f"Line {number} is not an item: {error}.", 'Write {"inputs": {NAME: ASSET or PATH}}.'
        ) from error


def _assets(client: Client, value: str, folder: Path, known: dict[Path, list[UUID]]) -> list[UUID]:
    try:
        return [UUID(value)]
    except ValueError:
        path = (folder / value).resolve()
    if path not in known:
        known[path] = [asset.id for asset in upload_paths(client, path)]
    return known[path]

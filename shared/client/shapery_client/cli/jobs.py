"""``shapery jobs``: list, watch, cancel, retry and fetch jobs."""

from __future__ import annotations

import json as json_module
from itertools import islice
from pathlib import Path
from typing import Annotated, Any
from uuid import UUID

import typer

from shapery_client.cli._following import follow
from shapery_client.cli._output import JsonOption, print_json, print_table, stdout
from shapery_client.cli._server import DEFAULT_SERVER, KeyOption, ServerOption, connect
from shapery_contracts.api import JobOrder, JobView
from shapery_contracts.errors import InvalidInput
from shapery_contracts.states import JobState

app = typer.Typer(help="List, watch, cancel, retry and fetch jobs.", no_args_is_help=True)
JobArgument = Annotated[UUID, typer.Argument(help="The job's id.", metavar="JOB")]


@app.command("list")
def list_jobs(
    state: Annotated[JobState | None, typer.Option(help="Only jobs in this state.")] = None,
    kind: Annotated[str | None, typer.Option(help="Only jobs of this kind.")] = None,
    name: Annotated[str | None, typer.Option(help="Only jobs with this text in their name.")] = None,
    order: Annotated[JobOrder, typer.Option(help="By what, upwards; downwards with a minus.")] = "-created",
    limit: Annotated[int, typer.Option(min=1, help="How many at the most.")] = 20,
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """List jobs, newest first if no other order is asked for."""
    asked = {"state": state, "kind": kind, "name": name, "order": order}
    filters = {key: value for key, value in asked.items() if value is not None}
    with connect(server, api_key) as client:
        found = list(islice(client.jobs(**filters), limit))
    if json:
        print_json(found)
        return
    rows = [
        (job.id, job.name, job.kind, job.state, f"{job.fraction:.0%}", f"{job.created_at:%Y-%m-%d %H:%M}", _reason(job))
        for job in found
    ]
    print_table(("job", "name", "kind", "state", "done", "created (UTC)", ""), rows, "There are no such jobs.")


@app.command()
def submit(
    kind: Annotated[str, typer.Argument(help="The job kind.")],
    inputs: Annotated[
        list[str], typer.Option("--input", help="An input as NAME=ASSET; repeat a name to give several assets.")
    ],
    params: Annotated[str, typer.Option(help="Parameters as JSON.")] = "{}",
    idempotency_key: Annotated[str | None, typer.Option(help="Repeating it never makes a second job.")] = None,
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Submit a job on assets that are uploaded already."""
    named: dict[str, list[str]] = {}
    for item in inputs:
        name, equals, asset = item.partition("=")
        if not equals:
            raise InvalidInput("bad_request", f"--input {item!r} is not of the form NAME=ASSET.")
        named.setdefault(name, []).append(asset)
    with connect(server, api_key) as client:
        job = client.submit(kind, named, parse_params(params), idempotency_key=idempotency_key)
    show_job(job, json)


@app.command()
def show(
    job: JobArgument, server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False
) -> None:
    """Show a job as it is now."""
    with connect(server, api_key) as client:
        show_job(client.job(job), json)


@app.command()
def watch(
    job: JobArgument, server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False
) -> None:
    """Show a job's progress until it has ended; exit code 5 if it did not succeed."""
    with connect(server, api_key) as client:
        ended = follow(client, client.job(job), str(job)[-12:])
    show_job(ended, json)


@app.command()
def cancel(
    job: JobArgument, server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False
) -> None:
    """Cancel a job."""
    with connect(server, api_key) as client:
        show_job(client.cancel(job), json)


@app.command()
def retry(
    job: JobArgument, server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False
) -> None:
    """Run a failed, crashed or cancelled job again."""
    with connect(server, api_key) as client:
        show_job(client.retry(job), json)


@app.command()
def download(
    job: JobArgument,
    out: Annotated[Path, typer.Option("--out", help="Folder for the files.")],
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Fetch the files that a job made."""
    with connect(server, api_key) as client:
        paths = client.download(client.job(job), out)
    if json:
        print_json([str(path) for path in paths])
    else:
        for path in paths:
            stdout.print(str(path), markup=False)


def parse_params(text: str) -> dict[str, Any]:
    """Return the parameters in a JSON object."""
    try:
        value = json_module.loads(text)
    except ValueError as error:
        raise InvalidInput("invalid_params", f"--params is not JSON: {error}.") from error
    if not isinstance(value, dict):
        raise InvalidInput("invalid_params", "--params must be a JSON object.", 'For example {"max_objects": 2}.')
    return value


def show_job(job: JobView, json: bool) -> None:
    """Print a job for people or for programs."""
    if json:
        print_json(job)
        return
    rows: list[tuple[str, object]] = [
        ("job", job.id),
        ("kind", job.kind),
        ("state", job.state),
        ("created", f"{job.created_at:%Y-%m-%d %H:%M:%S} UTC"),
    ]
    if not job.state.terminal:
        rows.append(("progress", f"{job.fraction:.0%} {job.stage} {job.message}".strip()))
    if job.error:
        rows.append(("error", f"{job.error.message} {job.error.hint} ({job.error.code})"))
    rows += [("artifact", f"{artifact.name} ({artifact.size} bytes)") for artifact in job.artifacts]
    if job.expired:
        rows.append(("expired", "its files were removed"))
    elif job.expires_at:
        rows.append(("expires", f"{job.expires_at:%Y-%m-%d %H:%M} UTC"))
    print_table(("", ""), rows, "")


def _reason(job: JobView) -> str:
    if job.error:
        return job.error.message
    return "" if job.state.terminal else job.stage  # an ended job keeps the last stage it told of

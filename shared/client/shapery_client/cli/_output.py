"""What the commands print: results on standard output, progress and errors on standard error."""

from __future__ import annotations

import json
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from pydantic import BaseModel
from rich.console import Console
from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TimeElapsedColumn, TransferSpeedColumn
from rich.table import Table

from shapery_client._errors import ApiError, ConnectionFailed, JobEndedBadly, TransferError
from shapery_contracts.errors import UserError

FAULT, REFUSED, NO_ANSWER, JOB_FAILED = 1, 3, 4, 5

JsonOption = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]

stderr = Console(stderr=True, highlight=False)
stdout = Console(highlight=False, width=None if sys.stdout.isatty() else 200, soft_wrap=not sys.stdout.isatty())


def print_json(value: Any) -> None:
    """Print models, or lists of them, as JSON."""
    typer.echo(json.dumps(_plain(value), indent=2, ensure_ascii=False))


def _plain(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value


def print_table(columns: Sequence[str], rows: Sequence[Sequence[object]], empty: str) -> None:
    """Print a table, or the sentence `empty` where there are no rows."""
    if not rows:
        stdout.print(empty)
        return
    table = Table(box=None, pad_edge=False, header_style="bold")
    for index, column in enumerate(columns):
        # The first column is what one copies into the next command: it stays whole.
        table.add_column(column, overflow="fold", no_wrap=index == 0)
    for row in rows:
        table.add_row(*(str(cell) for cell in row))
    stdout.print(table)


class StageBar:
    """A progress bar whose text names the stage."""

    def __init__(self, progress: Progress, title: str) -> None:
        self._progress = progress
        self._task = progress.add_task(title, total=1.0, note="")

    def update(self, stage: str, fraction: float, message: str) -> None:
        """Show where the work is."""
        self._progress.update(self._task, completed=fraction)
        self.note(" · ".join(part for part in (stage, message) if part))

    def note(self, text: str) -> None:
        """Show `text` beside the bar, until the next update."""
        self._progress.update(self._task, note=text)


@contextmanager
def stage_bar(title: str) -> Iterator[StageBar]:
    """Show a bar for work in stages."""
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=32),
        TextColumn("{task.percentage:>3.0f}%"),
        TimeElapsedColumn(),
        TextColumn("[dim]{task.fields[note]}"),
        console=stderr,
    ) as progress:
        yield StageBar(progress, title)


@contextmanager
def transfer_bar() -> Iterator[Progress]:
    """Show bars for files on their way."""
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=32),
        DownloadColumn(binary_units=True),
        TransferSpeedColumn(),
        TimeElapsedColumn(),
        console=stderr,
    ) as progress:
        yield progress


def report_error(error: Exception) -> int:
    """Print what went wrong and return the exit code for it.

    With ``--json`` the error is also a JSON document on standard output, so that a script need not read sentences.
    """
    code, message, hint, status = _describe(error)
    if "--json" in sys.argv:
        print_json({"error": {"code": code, "message": message, "hint": hint}})
    if status == FAULT:
        stderr.print("".join(traceback.format_exception(error)), style="dim", markup=False)
    stderr.print("[bold red]error[/] ", end="")
    stderr.print(message, markup=False, soft_wrap=True)
    if hint:
        stderr.print(hint, markup=False, soft_wrap=True)
    return status


def _describe(error: Exception) -> tuple[str, str, str, int]:
    if isinstance(error, UserError):
        return error.code, error.message, error.hint, REFUSED
    if isinstance(error, ApiError):
        status = FAULT if error.status >= 500 else REFUSED
        return error.code, error.problem.detail, error.problem.hint, status
    if isinstance(error, ConnectionFailed):
        return "service_unavailable", str(error), "", NO_ANSWER
    if isinstance(error, TransferError):
        return "corrupt_file", str(error), "", REFUSED
    if isinstance(error, JobEndedBadly):
        told = error.job.error
        return (told.code, told.message, told.hint, JOB_FAILED) if told else ("conflict", str(error), "", JOB_FAILED)
    if isinstance(error, OSError) and error.filename is not None:
        return "bad_request", f"{error.filename}: {error.strerror}.", "", REFUSED
    return "internal_error", f"{type(error).__name__}: {error}", "This is a fault of ours; please report it.", FAULT

"""The very handler that a worker runs, run here: no server, no queue, no database."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from shapery_contracts.errors import InvalidInput, Unavailable
from shapery_contracts.handler import AnyHandler
from shapery_contracts.kinds import get_kind
from shapery_contracts.retrieval import ShapeBank

Report = Callable[[str, float, str], None]
"""Called with the stage, the fraction done in [0, 1], and a message."""


class LocalContext:
    """A `shapery_contracts.handler.JobContext` without a platform: an interrupt from the keyboard stops the work."""

    def __init__(self, output: Path, scratch: Path, report: Report) -> None:
        self.output = output
        self.scratch = scratch
        self.bank: ShapeBank | None = None
        self._report = report
        self._stage = ""

    def stage(self, name: str, fraction: float, message: str = "") -> None:
        """Show that a stage begins."""
        self._stage = name
        self._report(name, fraction, message)

    def progress(self, fraction: float, message: str = "") -> None:
        """Show how far the work is."""
        self._report(self._stage, fraction, message)

    def preview(self, make: Callable[[], bytes]) -> None:
        """Do nothing: nobody looks."""

    def check_cancelled(self) -> None:
        """Do nothing: the interpreter raises `KeyboardInterrupt` by itself."""


def load_handler(kind: str) -> AnyHandler:
    """Return the handler of a job kind from the services installed here.

    Raises
    ------
    Unavailable
        The service that has it is not installed.
    """
    for entry in entry_points(group="shapery.jobs", name=kind):
        handler: AnyHandler = entry.load()()
        return handler
    service = get_kind(kind).service
    raise Unavailable(
        "missing_dependency",
        f"The service that runs {kind!r} is not installed here.",
        f"Install the package shapery-{service}, or give --server to have a server do it.",
    )


def run_locally(
    kind: str, inputs: Mapping[str, Path], params: Mapping[str, Any], output: Path, report: Report
) -> BaseModel:
    """Run a job here and put its artifacts into `output`.

    They are written beside it first and moved at the end, so that an interrupted run leaves an earlier result whole.

    Raises
    ------
    UserError
        What the user can mend: a parameter, an input.
    """
    spec = get_kind(kind)
    try:
        valid = spec.params.model_validate(dict(params))
    except ValidationError as error:
        raise InvalidInput("invalid_params", "; ".join(_sentences(error)) + ".") from error
    for name, path in inputs.items():
        if not path.exists():
            raise InvalidInput("missing_input", f"The file for {name!r}, {path}, does not exist.")
    handler = load_handler(kind)
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".shapery-", dir=output) as work:
        made, scratch = Path(work, "output"), Path(work, "scratch")
        made.mkdir()
        scratch.mkdir()
        result: BaseModel = handler.run(valid, inputs, LocalContext(made, scratch, report))
        for source in sorted(path for path in made.rglob("*") if path.is_file()):
            target = output / source.relative_to(made)
            target.parent.mkdir(parents=True, exist_ok=True)
            source.replace(target)
    return result


def _sentences(error: ValidationError) -> list[str]:
    return [f"{'.'.join(str(part) for part in item['loc']) or 'params'}: {item['msg']}" for item in error.errors()]

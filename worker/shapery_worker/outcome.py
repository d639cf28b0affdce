"""How a handler's process ended, as it writes it down for its watcher: JSON, checked when read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

MAX_OUTCOME_BYTES = 16 << 20
"""A result is shown by the API and kept in a row of the database; what is larger belongs into an artifact."""


class _Outcome(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Succeeded(_Outcome):
    """The handler returned a result; its files lie in the output folder."""

    type: Literal["succeeded"] = "succeeded"
    result: dict[str, Any]


class Failed(_Outcome):
    """The handler raised a `UserError`."""

    type: Literal["failed"] = "failed"
    code: str
    message: str
    hint: str = ""


class Stopped(_Outcome):
    """The handler saw that its job was cancelled."""

    type: Literal["stopped"] = "stopped"


class Broken(_Outcome):
    """The handler raised anything else; the traceback went to the log."""

    type: Literal["broken"] = "broken"
    reason: str


Outcome = Succeeded | Failed | Stopped | Broken
_ADAPTER: TypeAdapter[Outcome] = TypeAdapter(Annotated[Outcome, Field(discriminator="type")])


def write_outcome(path: Path, outcome: Outcome) -> None:
    """Write `outcome` to `path`, at once or not at all."""
    data = outcome.model_dump_json().encode()
    if len(data) > MAX_OUTCOME_BYTES:
        raise ValueError(f"the result takes {len(data)} bytes as JSON, more than {MAX_OUTCOME_BYTES}")
    temporary = path.with_suffix(".part")
    temporary.write_bytes(data)
    temporary.replace(path)


def read_outcome(path: Path) -> Outcome:
    """Read what `write_outcome` wrote.

    Raises
    ------
    FileNotFoundError
        The process ended before it could say how.
    ValueError
        The file does not hold an outcome.
    """
    return _ADAPTER.validate_json(path.read_bytes())

"""``shapery up``: the whole platform on this machine."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from shapery_contracts.errors import Unavailable


def up(
    home: Annotated[
        Path | None, typer.Option(help="Folder for everything the platform keeps.", envvar="SHAPERY_HOME")
    ] = None,
    host: Annotated[str | None, typer.Option(help="Address to listen on.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 takes a free one.")] = None,
) -> None:
    """Start the whole platform on this machine and run it until interrupted."""
    if importlib.util.find_spec("shapery_worker") is None or importlib.util.find_spec("shapery_gateway") is None:
        raise Unavailable(
            "missing_dependency",
            "The platform is not installed here, only its client.",
            "Install shapery-gateway and shapery-worker, or give other commands the --server that runs it.",
        )
    arguments = [sys.executable, "-m", "shapery_worker", "up"]
    for name, value in (("--home", home), ("--host", host), ("--port", port)):
        if value is not None:
            arguments += [name, str(value)]
    # The supervisor takes this process's place, so that signals reach it directly.
    os.execv(sys.executable, arguments)  # noqa: S606 - the interpreter that runs this very program

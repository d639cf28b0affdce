"""The ``shapery`` command.

Exit codes: 0 done; 1 a fault of ours; 2 wrong usage; 3 the input or the request was refused; 4 the server does not
answer; 5 the job did not succeed; 130 interrupted.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

import typer

from shapery_client.cli._output import report_error

_COMMANDS = {
    "up": ("up", "up"),
    "segment": ("segment", "segment"),
    "index": ("shapes", "index"),
    "search": ("shapes", "search"),
    "matrix": ("shapes", "matrix"),
    "encode": ("motion", "encode"),
    "decode": ("motion", "decode"),
    "info": ("motion", "info"),
    "upload": ("upload", "upload"),
}
"""Module and function of each command, in the order of the help."""

_GROUPS = {
    "jobs": ("jobs", "app"),
    "batch": ("batch", "app"),
    "collections": ("collections", "collections_app"),
    "shapes": ("collections", "shapes_app"),
    "keys": ("keys", "app"),
}
"""Module and application of each group of commands."""


def application(asked: str | None = None) -> typer.Typer:
    """Return the command line; with the one command or group of that name alone, which is loaded faster than all."""
    app = typer.Typer(
        name="shapery",
        help="Recover shapes: surfaces in volumes, shapes in a bank, motions in mesh sequences.",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    alone = asked in _COMMANDS or asked in _GROUPS
    for name, place in _COMMANDS.items():
        if name == asked or not alone:
            app.command(name)(_loaded(*place))
    for name, place in _GROUPS.items():
        if name == asked or not alone:
            app.add_typer(_loaded(*place), name=name)
    app.callback(invoke_without_command=True)(root)
    return app


def _loaded(module: str, name: str) -> Any:
    return getattr(import_module(f"{__name__}.{module}"), name)


def root(
    context: typer.Context,
    version: bool = typer.Option(False, "--version", help="Print the version and leave."),
) -> None:
    """Recover shapes: surfaces in volumes, shapes in a bank, motions in mesh sequences."""
    if version:
        from importlib.metadata import version as installed

        typer.echo(f"shapery {installed('shapery-client')}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit


def __getattr__(name: str) -> Any:
    if name == "app":
        return application()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def main() -> None:
    """Run the command line; every error becomes a sentence and an exit code."""
    try:
        application(sys.argv[1] if len(sys.argv) > 1 else None)()
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:  # the outermost border: nothing above could say it better
        sys.exit(report_error(error))

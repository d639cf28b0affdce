"""The ``shapery`` command.

Exit codes: 0 done; 1 a fault of ours; 2 wrong usage; 3 the input or the request was refused; 4 the server does not
answer; 5 the job did not succeed; 130 interrupted.
"""

from __future__ import annotations

import sys

import typer

from shapery_client.cli import batch, collections, jobs, keys, motion, segment, shapes, up, upload
from shapery_client.cli._output import report_error

app = typer.Typer(
    name="shapery",
    help="Recover shapes: surfaces in volumes, shapes in a bank, motions in mesh sequences.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("up")(up.up)
app.command("segment")(segment.segment)
app.command("index")(shapes.index)
app.command("search")(shapes.search)
app.command("matrix")(shapes.matrix)
app.command("encode")(motion.encode)
app.command("decode")(motion.decode)
app.command("info")(motion.info)
app.command("upload")(upload.upload)
app.add_typer(jobs.app, name="jobs")
app.add_typer(batch.app, name="batch")
app.add_typer(collections.collections_app, name="collections")
app.add_typer(collections.shapes_app, name="shapes")
app.add_typer(keys.app, name="keys")


@app.callback(invoke_without_command=True)
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


def main() -> None:
    """Run the command line; every error becomes a sentence and an exit code."""
    try:
        app()
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:  # the outermost border: nothing above could say it better
        sys.exit(report_error(error))

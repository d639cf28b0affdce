"""``shapery upload``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from shapery_client.cli._output import JsonOption, print_json, print_table
from shapery_client.cli._server import DEFAULT_SERVER, KeyOption, ServerOption, connect, upload_paths


def upload(
    paths: Annotated[list[Path], typer.Argument(help="Files, or folders of files.", metavar="PATH…")],
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Upload files; one that was cut off goes on where it stopped."""
    with connect(server, api_key) as client:
        assets = [asset for path in paths for asset in upload_paths(client, path)]
    if json:
        print_json(assets)
    else:
        print_table(
            ("asset", "kind", "format", "bytes", "file"),
            [(a.id, a.kind, a.format, a.size, a.filename) for a in assets],
            "nothing was uploaded",
        )

"""The options that name a server, and the client made of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shapery_client.cli._output import transfer_bar
from shapery_contracts.errors import InvalidInput

if TYPE_CHECKING:
    from shapery_client import Client
    from shapery_contracts.api import AssetView

DEFAULT_SERVER = "http://127.0.0.1:8000"

ServerOption = Annotated[str, typer.Option("--server", envvar="SHAPERY_SERVER", help="Address of the server.")]
OptionalServerOption = Annotated[
    str | None,
    typer.Option("--server", envvar="SHAPERY_SERVER", help="Have a server do it; without, it is done here."),
]
KeyOption = Annotated[
    str | None,
    typer.Option("--api-key", envvar="SHAPERY_API_KEY", help="API key; better given in the environment."),
]


def connect(server: str, api_key: str | None) -> Client:
    """Return a client for `server`."""
    from shapery_client import Client

    return Client(server, api_key=api_key)


def upload_paths(client: Client, path: Path) -> list[AssetView]:
    """Upload a file, or every file of a folder (a DICOM series), with a bar for each file or for the folder."""
    if path.is_dir():
        files = sorted(item for item in path.iterdir() if item.is_file() and not item.name.startswith("."))
        if not files:
            raise InvalidInput("missing_input", f"The folder {path} holds no files.")
    elif path.is_file():
        files = [path]
    else:
        raise InvalidInput("missing_input", f"{path} does not exist.", "Give the path of a file or of a folder.")
    total = sum(item.stat().st_size for item in files)
    assets = []
    with transfer_bar() as bars:
        task = bars.add_task(path.name, total=total)
        before = 0
        for item in files:
            base = before

            def advance(sent: int, _: int, base: int = base) -> None:
                bars.update(task, completed=base + sent)

            assets.append(client.upload(item, progress=advance))
            before += item.stat().st_size
    return assets

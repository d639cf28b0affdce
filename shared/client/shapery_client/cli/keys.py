"""``shapery keys``: make, list and revoke API keys."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Annotated
from uuid import UUID

import typer

from shapery_client.cli._output import JsonOption, print_json, print_table, stdout
from shapery_client.cli._server import DEFAULT_SERVER, KeyOption, ServerOption, connect
from shapery_contracts.api import Scope

app = typer.Typer(help="Make, list and revoke API keys.", no_args_is_help=True)


@app.command()
def create(
    name: Annotated[str, typer.Argument(help="What the key is for.")],
    scope: Annotated[list[Scope], typer.Option(help="What it may do; repeat for several.")] = [  # noqa: B006 - read only
        Scope.READ,
        Scope.WRITE,
    ],
    days: Annotated[int | None, typer.Option(min=1, help="Days until it expires; by default it does not.")] = None,
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Make an API key; its secret is shown this once."""
    expires = datetime.now(UTC) + timedelta(days=days) if days else None
    with connect(server, api_key) as client:
        key = client.create_key(name, scope, expires)
    if json:
        print_json(key)
        return
    stdout.print(key.secret, markup=False)
    stdout.print("[dim]Keep it: it is not shown again.[/]")


@app.command("list")
def list_keys(server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False) -> None:
    """List the API keys."""
    with connect(server, api_key) as client:
        found = list(client.keys())
    if json:
        print_json(found)
        return
    rows = [
        (
            key.id,
            key.name,
            key.prefix,
            " ".join(key.scopes),
            f"{key.expires_at:%Y-%m-%d}" if key.expires_at else "never",
        )
        for key in found
    ]
    print_table(("key", "name", "prefix", "scopes", "expires"), rows, "There are no API keys.")


@app.command()
def revoke(
    key: Annotated[UUID, typer.Argument(help="The key's id.")],
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
) -> None:
    """Revoke an API key at once."""
    with connect(server, api_key) as client:
        client.revoke_key(key)
    stdout.print("revoked")

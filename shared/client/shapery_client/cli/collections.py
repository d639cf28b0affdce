"""``shapery collections`` and ``shapery shapes``: what the shape database of a server holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated
from uuid import UUID

import typer

from shapery_client.cli._output import JsonOption, print_json, print_table, stdout
from shapery_client.cli._server import DEFAULT_SERVER, KeyOption, ServerOption, connect
from shapery_contracts.errors import InvalidInput
from shapery_contracts.shapes import ShapeOrder

collections_app = typer.Typer(help="Make, list and delete collections of shapes on a server.", no_args_is_help=True)
shapes_app = typer.Typer(help="List, show, fetch and delete shapes of a server.", no_args_is_help=True)

CollectionArgument = Annotated[UUID, typer.Argument(help="The collection's id.", metavar="COLLECTION")]
ShapeArgument = Annotated[UUID, typer.Argument(help="The shape's id.", metavar="SHAPE")]
LabelOption = Annotated[
    list[str] | None, typer.Option("--label", help="A label NAME:VALUE; repeat for several.", metavar="NAME:VALUE")
]


def parse_labels(texts: list[str] | None) -> dict[str, str]:
    """Return labels given as NAME:VALUE."""
    labels: dict[str, str] = {}
    for text in texts or []:
        name, colon, value = text.partition(":")
        if not name or not colon:
            raise InvalidInput("invalid_params", f"--label {text!r} is not of the form NAME:VALUE.")
        labels[name] = value
    return labels


@collections_app.command("list")
def list_collections(
    server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None, json: JsonOption = False
) -> None:
    """List the collections."""
    with connect(server, api_key) as client:
        found = list(client.collections())
    if json:
        print_json(found)
        return
    rows = [(item.id, item.name, item.shapes, item.outdated or "", item.description) for item in found]
    print_table(("collection", "name", "shapes", "outdated", "description"), rows, "There are no collections.")


@collections_app.command()
def create(
    name: Annotated[str, typer.Argument(help="Its name.")],
    description: Annotated[str, typer.Option(help="What is in it.")] = "",
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Make a collection."""
    with connect(server, api_key) as client:
        made = client.create_collection(name, description)
    if json:
        print_json(made)
    else:
        stdout.print(str(made.id))


@collections_app.command("delete")
def delete_collection(
    collection: CollectionArgument,
    shapes: Annotated[bool, typer.Option("--shapes", help="Delete the shapes in it, too.")] = False,
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
) -> None:
    """Delete a collection."""
    with connect(server, api_key) as client:
        client.delete_collection(collection, shapes=shapes)
    stdout.print("deleted")


@collections_app.command()
def reindex(
    collection: CollectionArgument,
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """Index the shapes again that an older version has indexed."""
    with connect(server, api_key) as client:
        batch = client.reindex_collection(collection)
    if json:
        print_json(batch)
    else:
        stdout.print(f"{batch.total} shapes are indexed again; follow them with: shapery batch watch {batch.id}")


@shapes_app.command("list")
def list_shapes(
    collection: Annotated[str | None, typer.Option(help="Only shapes of the collection of this name.")] = None,
    label: LabelOption = None,
    name: Annotated[str | None, typer.Option(help="Only shapes with this text in their name.")] = None,
    outdated: Annotated[bool, typer.Option("--outdated", help="Only those that an older version has indexed.")] = False,
    order: Annotated[ShapeOrder, typer.Option(help="By what, upwards; downwards with a minus.")] = "-created",
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
    json: JsonOption = False,
) -> None:
    """List the shapes."""
    with connect(server, api_key) as client:
        labels = parse_labels(label)
        found = list(client.shapes(collection=collection, labels=labels, name=name, outdated=outdated, order=order))
    if json:
        print_json(found)
        return
    rows = [
        (
            shape.id,
            shape.name,
            shape.collection,
            shape.vertices,
            shape.faces,
            " ".join(f"{key}:{value}" for key, value in shape.labels.items()),
            "outdated" if shape.outdated else "",
        )
        for shape in found
    ]
    print_table(("shape", "name", "collection", "vertices", "faces", "labels", ""), rows, "There are no shapes.")


@shapes_app.command()
def show(shape: ShapeArgument, server: ServerOption = DEFAULT_SERVER, api_key: KeyOption = None) -> None:
    """Show everything that is known of a shape, as JSON."""
    with connect(server, api_key) as client:
        print_json(client.shape(shape))


@shapes_app.command()
def fetch(
    shape: ShapeArgument,
    out: Annotated[Path, typer.Option(help="Folder for the files.")],
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
) -> None:
    """Write a shape's graph, web mesh, picture and parts into a folder."""
    with connect(server, api_key) as client:
        out.mkdir(parents=True, exist_ok=True)
        (out / "shape.arg").write_bytes(client.shape_file(shape, "arg"))
        (out / "mesh.glb").write_bytes(client.shape_file(shape, "mesh.glb"))
        (out / "preview.png").write_bytes(client.shape_file(shape, "preview.png"))
        (out / "components.json").write_bytes(client.shape_file(shape, "components"))
    stdout.print(f"written to {out}", markup=False)


@shapes_app.command("delete")
def delete_shapes(
    shapes: Annotated[list[UUID], typer.Argument(help="Ids of shapes.", metavar="SHAPE…")],
    server: ServerOption = DEFAULT_SERVER,
    api_key: KeyOption = None,
) -> None:
    """Delete shapes; the meshes that they were made of stay."""
    with connect(server, api_key) as client:
        for shape in shapes:
            client.delete_shape(shape)
    stdout.print("deleted")

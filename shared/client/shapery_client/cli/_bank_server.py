"""``shapery index`` and ``shapery search`` with ``--server``: the same over HTTP."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import UUID

from shapery_client._errors import ApiError
from shapery_client.cli._output import transfer_bar
from shapery_contracts.api import BatchEvent, BatchItem
from shapery_contracts.errors import InvalidInput

if TYPE_CHECKING:
    from shapery_client import Client
    from shapery_contracts.shapes import SearchAnswer

MESH_SUFFIXES = frozenset({".obj", ".ply", ".stl", ".off", ".glb"})
_AT_ONCE = 1000
"""Files of one batch: while it is worked on, the next ones are uploaded."""

Outcome = dict[str, Any]


def index_on_server(
    client: Client,
    paths: Sequence[Path],
    collection: str,
    labels: dict[str, str],
    on_progress: Callable[[float, str], None],
) -> list[Outcome]:
    """Upload files, index them as batches, and return for each its name, whether it was indexed, and the error.

    A mesh of which the collection has a shape already, of the same name and the same bytes, is passed over.
    """
    everything = mesh_files(paths)
    there = _already_there(client, everything, collection)
    files = [path for path in everything if path not in there]
    params = {"collection": collection, "labels": labels}
    batches: list[tuple[UUID, Sequence[Path]]] = []
    outcomes: list[Outcome] = [{"name": path.name, "indexed": False, "error": None} for path in there]
    for begin in range(0, len(files), _AT_ONCE):
        some = files[begin : begin + _AT_ONCE]
        items = [
            BatchItem(inputs={"mesh": asset}, params={"name": path.name})
            for path, asset in zip(some, _upload(client, some), strict=True)
        ]
        batches.append((client.submit_batch("shape-index", items, params).id, some))
    done = 0
    for batch_id, sent in batches:

        def tell(event: BatchEvent, before: int = done) -> None:
            ended = before + sum(count for state, count in event.counts.items() if state.terminal)
            on_progress(ended / len(files), f"{ended} of {len(files)}")

        client.wait_batch(batch_id, on_event=tell)
        done += len(sent)
        for path, result in zip(sent, client.batch_results(batch_id), strict=True):
            error = result.job.error
            outcomes.append(
                {
                    "name": path.name,
                    "indexed": result.job.result is not None,
                    "error": None if error is None else error.model_dump(),
                }
            )
    return outcomes


def _already_there(client: Client, files: Sequence[Path], collection: str) -> list[Path]:
    """Return the files that shapes of a collection were made of by this index version."""
    names = {path.name for path in files}
    known: dict[str, list[UUID]] = {}
    try:
        for shape in client.shapes(collection=collection):
            if shape.name in names and not shape.outdated:
                known.setdefault(shape.name, []).append(shape.asset_id)
    except ApiError as error:
        if error.status == HTTPStatus.NOT_FOUND:
            return []  # the collection is made by the first job
        raise
    found = []
    for path in files:
        if path.name in known:
            content = hashlib.sha256(path.read_bytes()).hexdigest()
            if any(_hash_of(client, asset) == content for asset in known[path.name]):
                found.append(path)
    return found


def _hash_of(client: Client, asset: UUID) -> str | None:
    """Return the hash of an asset, or None where it was deleted."""
    try:
        return client.asset(asset).sha256
    except ApiError as error:
        if error.status == HTTPStatus.NOT_FOUND:
            return None
        raise


def search_on_server(client: Client, query: str, **request: Any) -> SearchAnswer:
    """Search by a file, which is uploaded, or by the id of a stored shape."""
    path = Path(query)
    if path.is_file():
        return client.search(asset=_upload(client, [path])[0], **request)
    try:
        shape = UUID(query)
    except ValueError:
        raise InvalidInput(
            "missing_input", f"{query} is neither a file nor the id of a shape.", "`shapery shapes list` shows ids."
        ) from None
    return client.search(shape=shape, **request)


def mesh_files(paths: Sequence[Path]) -> list[Path]:
    """Return files as they are given, and of folders the meshes in them."""
    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            files += sorted(p for p in path.rglob("*") if p.is_file() and p.suffix.lower() in MESH_SUFFIXES)
        elif path.is_file():
            files.append(path)
        else:
            raise InvalidInput("missing_input", f"The file {path} does not exist.")
    if not files:
        raise InvalidInput("missing_input", "There are no meshes in the folders given.")
    return list(dict.fromkeys(files))


def _upload(client: Client, files: Sequence[Path]) -> list[UUID]:
    total = sum(path.stat().st_size for path in files)
    ids = []
    with transfer_bar() as bars:
        task = bars.add_task("upload", total=total)
        sent = 0
        for path in files:
            ids.append(client.upload(path).id)
            sent += path.stat().st_size
            bars.update(task, completed=sent)
    return ids

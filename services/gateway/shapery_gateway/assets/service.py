"""Takes files in, lists them and gives them out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import aclosing
from uuid import UUID

from fastapi import Request
from sqlalchemy.orm import Session

from shapery_contracts.api import AssetOrder, AssetView, Page
from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats import AssetKind
from shapery_gateway.assets.multipart import MultipartFile, blocks
from shapery_gateway.backend import Backend
from shapery_gateway.http.content import Content
from shapery_gateway.problems import ProblemError
from shapery_platform import assets
from shapery_platform.keys import Principal
from shapery_platform.storage import BlobWriter, ObjectStore, StoredObjectMissing, object_key

BLOCK = 1 << 20
"""Bytes handed to storage at a time."""


async def receive(backend: Backend, caller: Principal, request: Request) -> AssetView:
    """Store the file of a multipart body as it arrives, and make an asset of it.

    Raises
    ------
    ProblemError, UserError
        The body is malformed or too large, or its file is of no known format; nothing is kept then.
    """
    form = MultipartFile(request.headers.get("content-type", ""))
    limit = backend.settings.max_upload_bytes
    writer = await backend.run_storage(backend.store.writer)
    try:
        async with (
            aclosing(request.stream()) as body,
            aclosing(form.content(body)) as pieces,
            aclosing(blocks(pieces, BLOCK)) as incoming,
        ):
            async for block in incoming:
                if writer.size + len(block) > limit:
                    raise ProblemError("request_too_large", f"The file has more than {limit} bytes.")
                await backend.run_storage(writer.write, block)
                backend.metrics.upload_bytes.inc(len(block))
        return await backend.run_storage(_finish, backend, caller, writer, form.filename)
    finally:
        writer.discard()


def _finish(backend: Backend, caller: Principal, writer: BlobWriter, filename: str) -> AssetView:
    blob = writer.finish()
    # Read before the session opens: storage may be slow, and the database must not wait for it.
    found = assets.inspect(backend.store, blob.sha256, blob.size)
    with backend.database.session() as session:
        asset = assets.create_from_upload(
            session, backend.store, backend.settings, caller.owner, blob.sha256, blob.size, filename, found
        )
        return assets.view(asset)


def get(session: Session, caller: Principal, asset_id: UUID) -> AssetView:
    """Return an asset of the caller."""
    return assets.view(assets.get(session, caller.owner, asset_id))


def list_assets(
    session: Session, caller: Principal, cursor: str | None, limit: int, kind: AssetKind | None, order: AssetOrder
) -> Page[AssetView]:
    """Return a page of the caller's assets, newest first."""
    found, following = assets.list_assets(session, caller.owner, cursor, limit, kind, order)
    return Page(items=[assets.view(asset) for asset in found], next_cursor=following)


def delete(session: Session, caller: Principal, asset_id: UUID) -> None:
    """Delete an asset of the caller."""
    assets.delete(session, caller.owner, asset_id)


def content(backend: Backend, caller: Principal, asset_id: UUID) -> Content:
    """Return an asset's bytes, to be read after the session is closed: a slow download holds no connection."""
    with backend.database.session(readonly=True) as session:
        asset = get(session, caller, asset_id)
    return stored_content(backend.store, asset.sha256, asset.size, asset.media_type, asset.filename)


def stored_content(store: ObjectStore, sha256: str, size: int, media_type: str, filename: str) -> Content:
    """Return stored bytes as they are given out.

    Raises
    ------
    InvalidInput
        ``gone`` where the bytes were removed after their row was read.
    """
    key = object_key(sha256)
    if store.size(key) != size:
        raise InvalidInput("gone", "The bytes are no longer stored.")

    def read(start: int, stop: int) -> Iterator[bytes]:
        try:
            return store.iter_range(key, start, stop)
        except StoredObjectMissing:
            raise InvalidInput("gone", "The bytes are no longer stored.") from None

    return Content(sha256, size, media_type, filename, read)

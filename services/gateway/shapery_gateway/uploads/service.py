"""Takes resumable uploads in: streams bodies to staging, keeps what arrived, makes the asset at the end."""

from __future__ import annotations

from contextlib import aclosing
from uuid import UUID

from anyio import CancelScope
from fastapi import Request
from sqlalchemy.orm import Session
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from shapery_gateway.backend import Backend
from shapery_gateway.problems import ProblemError
from shapery_gateway.uploads.headers import (
    CONTENT_TYPE,
    format_metadata,
    http_date,
    parse_checksum,
    parse_count,
    parse_length,
    parse_metadata,
)
from shapery_platform import uploads
from shapery_platform.keys import Principal
from shapery_platform.uploads import UploadState, UploadWriter

BLOCK = 1 << 20
"""Bytes gathered before a thread writes them: a hop per packet would cost more than the write."""


async def create(backend: Backend, caller: Principal, request: Request, prefix: str) -> dict[str, str]:
    """Begin an upload, take in what the request's body brings, and return the headers of the answer."""
    headers = request.headers
    if "upload-concat" in headers:
        raise ProblemError("bad_request", "The extension 'concatenation' of tus is not spoken here.")
    length = parse_length(headers.get("upload-length"), headers.get("upload-defer-length"))
    metadata = parse_metadata(headers.get("upload-metadata"))
    has_body = _media_type(request) == CONTENT_TYPE
    if has_body:
        parse_checksum(headers.get("upload-checksum"))  # refused before the upload exists

    def begin() -> UploadState:
        with backend.database.session() as session:
            return uploads.create(session, backend.staging, backend.settings, caller.owner, length, metadata)

    state = await backend.run_storage(begin)
    location = {"Location": f"{prefix}/{state.id}"}
    if has_body:
        return {**location, **await _take_in(backend, caller, request, state.id, 0, None)}
    return {**location, **await _finish_if_complete(backend, caller, state)}


async def append(backend: Backend, caller: Principal, request: Request, upload_id: UUID) -> dict[str, str]:
    """Take in the body of a PATCH, and return the headers of the answer."""
    if _media_type(request) != CONTENT_TYPE:
        raise ProblemError(
            "unsupported_media_type", f"The bytes of an upload are sent as {CONTENT_TYPE}.", "Set the Content-Type."
        )
    offset = parse_count("Upload-Offset", request.headers.get("upload-offset"))
    if offset is None:
        raise ProblemError("bad_request", "The header Upload-Offset is missing.", "HEAD tells where to continue.")
    length = parse_count("Upload-Length", request.headers.get("upload-length"))
    return await _take_in(backend, caller, request, upload_id, offset, length)


def standing(session: Session, caller: Principal, upload_id: UUID) -> dict[str, str]:
    """Return the headers that tell where an upload stands."""
    state = uploads.get(session, caller.owner, upload_id)
    headers = {"Cache-Control": "no-store", **_progress(state)}
    if state.length is None:
        headers["Upload-Defer-Length"] = "1"
    else:
        headers["Upload-Length"] = str(state.length)
    if state.metadata:
        headers["Upload-Metadata"] = format_metadata(state.metadata)
    return headers


def terminate(backend: Backend, caller: Principal, upload_id: UUID) -> None:
    """Give up an upload of the caller."""
    uploads.terminate(backend.database, backend.staging, caller.owner, upload_id)


async def _take_in(
    backend: Backend, caller: Principal, request: Request, upload_id: UUID, offset: int, length: int | None
) -> dict[str, str]:
    checksum = parse_checksum(request.headers.get("upload-checksum"))

    def begin() -> UploadWriter:
        return uploads.open_patch(
            backend.database,
            backend.staging,
            backend.settings,
            caller.owner,
            upload_id,
            offset,
            length=length,
            checksum=checksum,
        )

    writer = await backend.run_storage(begin)
    try:
        await _write_body(backend, request, writer)
        state = await backend.run_storage(writer.finish)
    finally:
        # Harmless after `finish`. Otherwise what arrived becomes durable, and the lock goes, even while the server
        # is shutting down and cancels this request.
        with CancelScope(shield=True):
            await backend.run_storage(writer.interrupt)
    return await _finish_if_complete(backend, caller, state)


async def _write_body(backend: Backend, request: Request, writer: UploadWriter) -> None:
    gathered: list[bytes] = []
    count = 0

    async def write() -> None:
        nonlocal gathered, count
        block, size = b"".join(gathered), count
        gathered, count = [], 0
        await backend.run_storage(writer.write, block)
        backend.metrics.upload_bytes.inc(size)

    try:
        async with aclosing(request.stream()) as body:
            async for data in body:
                gathered.append(data)
                count += len(data)
                if count >= BLOCK:
                    await write()
    except (ClientDisconnect, HTTPException):
        # The connection broke or fell silent: the client continues after what arrived, so nothing of it is dropped.
        if count:
            await write()
        raise
    if count:
        await write()


async def _finish_if_complete(backend: Backend, caller: Principal, state: UploadState) -> dict[str, str]:
    headers = _progress(state)
    if state.complete and state.asset_id is None:
        asset = await backend.run_storage(
            uploads.finish,
            backend.database,
            backend.staging,
            backend.store,
            backend.settings,
            caller.owner,
            state.id,
        )
        headers["Upload-Asset-Id"] = str(asset.id)
    return headers


def _progress(state: UploadState) -> dict[str, str]:
    headers = {"Upload-Offset": str(state.offset)}
    if state.asset_id is not None:
        headers["Upload-Asset-Id"] = str(state.asset_id)
    elif not state.complete:
        headers["Upload-Expires"] = http_date(state.expires_at)
    return headers


def _media_type(request: Request) -> str:
    return request.headers.get("content-type", "").partition(";")[0].strip().lower()

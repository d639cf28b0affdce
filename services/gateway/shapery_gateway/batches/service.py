"""Creates, shows, cancels and retries batches, and streams their results."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import aclosing
from uuid import UUID

from anyio.to_thread import run_sync
from fastapi import Request
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError
from sqlalchemy.orm import Session

from shapery_contracts.api import BatchCreate, BatchHeader, BatchItem, BatchOrder, BatchView, Page
from shapery_gateway import outbox
from shapery_gateway.backend import Backend
from shapery_gateway.batches.ndjson import MEDIA_TYPE, read_batch
from shapery_gateway.http.storable import refuse_unstorable
from shapery_gateway.problems import ProblemError
from shapery_platform import batches
from shapery_platform.keys import Principal


async def create(backend: Backend, caller: Principal, request: Request, idempotency_key: str | None) -> BatchView:
    """Create a batch from a JSON or NDJSON body, or return the one that was created with the same key."""
    header, items = await _read(backend, request)

    def store() -> BatchView:
        with backend.database.session() as session:
            batch, created = batches.create(session, backend.settings, caller.owner, header, items, idempotency_key)
            if created:
                outbox.defer_dispatch(session)
            view = batches.view(session, batch)
            entries = outbox.deferred(session)
        backend.outbox.put(entries)
        return view

    return await run_sync(store)


async def _read(backend: Backend, request: Request) -> tuple[BatchHeader, list[BatchItem]]:
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if media_type in {MEDIA_TYPE, "application/ndjson", "application/jsonl"}:
        async with aclosing(request.stream()) as stream:
            return await read_batch(stream, backend.settings.max_batch_items)
    if media_type != "application/json":
        raise ProblemError(
            "unsupported_media_type", f"A batch is sent as application/json or {MEDIA_TYPE}, not {media_type[:80]!r}."
        )
    try:
        whole = BatchCreate.model_validate_json(await request.body())
    except ValidationError as error:
        faults = error.errors(include_url=False, include_input=False, include_context=False)
        raise RequestValidationError([{**fault, "loc": ("body", *fault["loc"])} for fault in faults]) from None
    for index, item in enumerate([whole.params, *(item.params for item in whole.items)]):
        refuse_unstorable(item, f"Item {index - 1}" if index else "params")
    return BatchHeader(kind=whole.kind, params=whole.params), whole.items


def get(session: Session, caller: Principal, batch_id: UUID) -> BatchView:
    """Return a batch of the caller."""
    return batches.view(session, batches.get(session, caller.owner, batch_id))


def list_batches(
    session: Session, caller: Principal, cursor: str | None, limit: int, order: BatchOrder
) -> Page[BatchView]:
    """Return a page of the caller's batches, newest first."""
    found, following = batches.list_batches(session, caller.owner, cursor, limit, order)
    return Page(items=found, next_cursor=following)


def cancel(session: Session, caller: Principal, batch_id: UUID) -> BatchView:
    """Cancel what has not ended of a batch."""
    return batches.view(session, batches.cancel(session, caller.owner, batch_id))


def retry(session: Session, caller: Principal, batch_id: UUID) -> BatchView:
    """Queue the failed and crashed jobs of a batch again."""
    if batches.retry_failed(session, caller.owner, batch_id):
        outbox.defer_dispatch(session)
    return get(session, caller, batch_id)


def events_are_over(backend: Backend, caller: Principal, batch_id: UUID, after: int) -> bool:
    """Tell whether a batch of the caller has ended, and its last event is not after `after`."""
    with backend.database.session(readonly=True) as session:
        event = batches.event(session, caller.owner, batch_id)
        return event.finished and after >= event.seq


def check_exists(backend: Backend, caller: Principal, batch_id: UUID) -> None:
    """Raise ``not_found`` before an answer begins that could no longer say so."""
    with backend.database.session(readonly=True) as session:
        batches.get(session, caller.owner, batch_id)


def results(backend: Backend, caller: Principal, batch_id: UUID) -> Iterator[bytes]:
    """Yield the results in the order of the items, one JSON object per line; a slow reader holds no connection."""
    index = -1
    while True:
        with backend.database.session(readonly=True) as session:
            page = batches.results_page(session, caller.owner, batch_id, index)
        if not page:
            return
        yield b"".join(result.model_dump_json().encode() + b"\n" for result in page)
        index = page[-1].index

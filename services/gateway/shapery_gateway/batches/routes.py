"""``/v1/batches``."""

from __future__ import annotations

from typing import Annotated, Any
from uuid import UUID

from anyio.to_thread import run_sync
from fastapi import APIRouter, Query, Request, Response
from starlette.responses import StreamingResponse

from shapery_contracts.api import BatchOrder, BatchView, Page
from shapery_gateway.batches import service
from shapery_gateway.batches.ndjson import MEDIA_TYPE
from shapery_gateway.dependencies import BackendDep, Cursor, Limit, Reader, ReadSession, Writer, WriteSession
from shapery_gateway.http.documentation import event_stream
from shapery_gateway.http.parameters import IdempotencyKey, LastEvent
from shapery_gateway.jobs.routes import CREATION_PROBLEMS
from shapery_gateway.openapi import COMMON_PROBLEMS, problems

router = APIRouter(prefix="/v1/batches", tags=["batches"])

_LOCATION: dict[str, Any] = {"Location": {"description": "The batch's address.", "schema": {"type": "string"}}}
_LINES = """\
{"kind": "segmentation", "params": {}}
{"inputs": {"post": "01890a5d-ac96-774b-bcce-b302099a8057"}}
{"inputs": {"post": "01890a5d-ac96-774b-bcce-b302099a8058"}, "params": {"max_objects": 2}}
"""
_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            "application/json": {"schema": {"$ref": "#/components/schemas/BatchCreate"}},
            MEDIA_TYPE: {
                "schema": {
                    "type": "string",
                    "description": "The first line is a `BatchHeader`, every further line a `BatchItem`.",
                },
                "example": _LINES,
            },
        },
    }
}


@router.post(
    "",
    operation_id="createBatch",
    summary="Ask for many jobs",
    status_code=202,
    openapi_extra=_BODY,
    responses={
        202: {"headers": _LOCATION},
        **problems(*COMMON_PROBLEMS, *CREATION_PROBLEMS, "too_large", "unsupported_media_type", "request_timeout"),
    },
)
async def create_batch(
    backend: BackendDep,
    caller: Writer,
    request: Request,
    response: Response,
    idempotency_key: IdempotencyKey = None,
) -> BatchView:
    """Create all jobs, or none where an item is not valid. As NDJSON the items may come as they are made."""
    batch = await service.create(backend, caller, request, idempotency_key)
    response.headers["Location"] = f"/v1/batches/{batch.id}"
    return batch


@router.get("", operation_id="listBatches", summary="List your batches", responses=problems(*COMMON_PROBLEMS))
def list_batches(
    session: ReadSession,
    caller: Reader,
    cursor: Cursor = None,
    limit: Limit = 50,
    order: Annotated[BatchOrder, Query(description="By what, upwards; downwards with a minus.")] = "-created",
) -> Page[BatchView]:
    """Newest first, if no other order is asked for."""
    return service.list_batches(session, caller, cursor, limit, order)


@router.get(
    "/{batch_id}",
    operation_id="getBatch",
    summary="How a batch is",
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def get_batch(session: ReadSession, caller: Reader, batch_id: UUID) -> BatchView:
    """How many of its jobs are in which state; the jobs themselves: `GET /v1/jobs?batch_id=…`."""
    return service.get(session, caller, batch_id)


@router.get(
    "/{batch_id}/events",
    operation_id="streamBatchEvents",
    summary="Follow a batch",
    response_class=Response,
    responses={
        **event_stream(
            "Server-sent events: `id` is the sequence number, `event` is `counts`, `data` a `BatchEvent`. "
            "The stream ends when all jobs have.",
            "BatchEvent",
        ),
        **problems(*COMMON_PROBLEMS, "not_found", "service_unavailable"),
    },
)
async def stream_batch_events(backend: BackendDep, caller: Reader, batch_id: UUID, after: LastEvent) -> Response:
    """How the batch stands, and then each change of its counts."""
    if await run_sync(service.events_are_over, backend, caller, batch_id, after):
        return Response(status_code=204)
    return backend.batch_events.open(batch_id, after)


@router.get(
    "/{batch_id}/results",
    operation_id="streamBatchResults",
    summary="The jobs of a batch",
    response_class=Response,
    responses={
        200: {
            "description": "One `BatchResult` per line, in the order of the items, also of jobs that have not ended.",
            "content": {MEDIA_TYPE: {"schema": {"type": "string"}}},
        },
        **problems(*COMMON_PROBLEMS, "not_found"),
    },
)
def stream_batch_results(backend: BackendDep, caller: Reader, batch_id: UUID) -> Response:
    """Streamed as NDJSON, however many there are."""
    service.check_exists(backend, caller, batch_id)
    return StreamingResponse(service.results(backend, caller, batch_id), media_type=MEDIA_TYPE)


@router.post(
    "/{batch_id}/cancel",
    operation_id="cancelBatch",
    summary="Cancel a batch",
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def cancel_batch(session: WriteSession, caller: Writer, batch_id: UUID) -> BatchView:
    """Cancel what has not ended: what waits ends at once, what runs within a second or two."""
    return service.cancel(session, caller, batch_id)


@router.post(
    "/{batch_id}/retry",
    operation_id="retryBatch",
    summary="Run what failed of a batch again",
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def retry_batch(session: WriteSession, caller: Writer, batch_id: UUID) -> BatchView:
    """Only the jobs that failed or crashed."""
    return service.retry(session, caller, batch_id)

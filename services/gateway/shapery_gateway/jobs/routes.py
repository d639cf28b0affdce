"""``/v1/jobs``."""

from __future__ import annotations

from typing import Annotated, Any
from uuid import UUID

from anyio.to_thread import run_sync
from fastapi import APIRouter, Body, Query, Request, Response

from shapery_contracts.api import JobCreate, JobOrder, JobView, Page
from shapery_contracts.states import JobState
from shapery_gateway.dependencies import BackendDep, Cursor, Limit, Reader, ReadSession, Writer, WriteSession
from shapery_gateway.http.content import content_response
from shapery_gateway.http.documentation import (
    BINARY,
    CONTENT_PARAMETERS,
    CONTENT_PROBLEMS,
    CONTENT_RESPONSES,
    event_stream,
)
from shapery_gateway.http.parameters import MAX_SEQ, IdempotencyKey, LastEvent
from shapery_gateway.jobs import service
from shapery_gateway.openapi import COMMON_PROBLEMS, problems

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

PREVIEW_NUMBER = "Shapery-Preview"
_NOT_KEPT = {"Cache-Control": "no-store"}

_LOCATION: dict[str, Any] = {"Location": {"description": "The job's address.", "schema": {"type": "string"}}}
_EXAMPLES: Any = {
    "segmentation": {
        "summary": "Segment a tumor from two volumes",
        "value": {
            "kind": "segmentation",
            "inputs": {
                "post": "01890a5d-ac96-774b-bcce-b302099a8057",
                "pre": "01890a5d-ac96-774b-bcce-b302099a8058",
            },
            "params": {},
        },
    }
}
CREATION_PROBLEMS = (
    "bad_request",
    "not_found",
    "idempotency_conflict",
    "request_too_large",
    "validation_failed",
    "unknown_job_kind",
    "invalid_params",
    "missing_input",
    "wrong_input_kind",
)


@router.post(
    "",
    operation_id="createJob",
    summary="Ask for a job",
    status_code=202,
    responses={202: {"headers": _LOCATION}, **problems(*COMMON_PROBLEMS, *CREATION_PROBLEMS)},
)
def create_job(
    backend: BackendDep,
    session: WriteSession,
    caller: Writer,
    request: Annotated[JobCreate, Body(openapi_examples=_EXAMPLES)],
    response: Response,
    idempotency_key: IdempotencyKey = None,
) -> JobView:
    """Queue a job, which can be followed at once. With an `Idempotency-Key` a repeated request makes no second one."""
    job = service.create(session, backend, caller, request, idempotency_key)
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    return job


@router.get("", operation_id="listJobs", summary="List your jobs", responses=problems(*COMMON_PROBLEMS))
def list_jobs(
    session: ReadSession,
    caller: Reader,
    cursor: Cursor = None,
    limit: Limit = 50,
    state: Annotated[JobState | None, Query(description="Only jobs in this state.")] = None,
    kind: Annotated[
        str | None, Query(max_length=64, pattern=r"^[a-z0-9-]+$", description="Only jobs of this kind.")
    ] = None,
    batch_id: Annotated[UUID | None, Query(description="Only jobs of this batch.")] = None,
    name: Annotated[
        str | None, Query(min_length=1, max_length=255, description="Only jobs with this text in their name.")
    ] = None,
    order: Annotated[JobOrder, Query(description="By what, upwards; downwards with a minus.")] = "-created",
) -> Page[JobView]:
    """Newest first, if no other order is asked for. Jobs that have not ended, or never began, took the least time."""
    return service.list_jobs(session, caller, cursor, limit, state, kind, batch_id, name, order)


@router.get(
    "/{job_id}", operation_id="getJob", summary="How a job is", responses=problems(*COMMON_PROBLEMS, "not_found")
)
def get_job(session: ReadSession, caller: Reader, job_id: UUID) -> JobView:
    """State, progress, result and artifacts of a job, or why it failed."""
    return service.get(session, caller, job_id)


@router.get(
    "/{job_id}/events",
    operation_id="streamJobEvents",
    summary="Follow a job",
    response_class=Response,
    responses={
        **event_stream(
            "Server-sent events: `id` is the sequence number, `event` is `state` or `progress`, `data` a `JobEvent`. "
            "The stream ends with the event of a terminal state.",
            "JobEvent",
        ),
        **problems(*COMMON_PROBLEMS, "not_found", "service_unavailable"),
    },
)
async def stream_job_events(backend: BackendDep, caller: Reader, job_id: UUID, after: LastEvent) -> Response:
    """Everything that happened after the event that `Last-Event-ID` (or `after`) names, then what happens.

    A comment comes every 15 seconds in which nothing does.
    """
    if await run_sync(service.events_are_over, backend, caller, job_id, after):
        return Response(status_code=204)
    return backend.job_events.open(job_id, after)


@router.post(
    "/{job_id}/cancel",
    operation_id="cancelJob",
    summary="Cancel a job",
    responses=problems(*COMMON_PROBLEMS, "not_found", "invalid_transition"),
)
def cancel_job(session: WriteSession, caller: Writer, job_id: UUID) -> JobView:
    """End a queued job at once, a running one within a second or two."""
    return service.cancel(session, caller, job_id)


@router.post(
    "/{job_id}/retry",
    operation_id="retryJob",
    summary="Run a job again",
    responses=problems(*COMMON_PROBLEMS, "not_found", "invalid_transition", "input_expired"),
)
def retry_job(session: WriteSession, caller: Writer, job_id: UUID) -> JobView:
    """For a job that failed, crashed or was cancelled."""
    return service.retry(session, caller, job_id)


@router.get(
    "/{job_id}/preview",
    operation_id="getJobPreview",
    summary="How a running job's result looks so far",
    response_class=Response,
    responses={
        200: {
            "description": "The newest preview. Of a segmentation: `evolution.bin` with one frame per object.",
            "content": {"application/octet-stream": BINARY},
            "headers": {
                PREVIEW_NUMBER: {
                    "description": "Its number: send it as `after` the next time.",
                    "schema": {"type": "integer"},
                }
            },
        },
        204: {"description": "Nothing is newer than `after`, or the job does not run: look at its results."},
        **problems(*COMMON_PROBLEMS, "not_found"),
    },
)
def get_job_preview(
    session: ReadSession,
    caller: Reader,
    job_id: UUID,
    after: Annotated[int, Query(ge=0, le=MAX_SEQ, description="Number of the preview that one has already.")] = 0,
) -> Response:
    """Events and the job itself tell the number of the newest (`preview`), so that nobody asks in vain."""
    found = service.preview(session, caller, job_id, after)
    if found is None:
        return Response(status_code=204, headers=_NOT_KEPT)
    headers = {**_NOT_KEPT, PREVIEW_NUMBER: str(found.number)}
    return Response(found.data, headers=headers, media_type="application/octet-stream")


@router.get(
    "/{job_id}/artifacts/{name:path}",
    operation_id="getArtifact",
    summary="A file that a job made",
    response_class=Response,
    openapi_extra={"parameters": CONTENT_PARAMETERS},
    responses={**CONTENT_RESPONSES, **problems(*COMMON_PROBLEMS, *CONTENT_PROBLEMS)},
)
@router.head("/{job_id}/artifacts/{name:path}", response_class=Response, include_in_schema=False)
def get_artifact(backend: BackendDep, caller: Reader, request: Request, job_id: UUID, name: str) -> Response:
    """In whole or in part (`Range`). Results have an expiry (`expires_at` of the job); afterwards: 410."""
    return content_response(request, service.artifact(backend, caller, job_id, name))

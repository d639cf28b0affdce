"""Searches: asked of a resident process where that suffices, of a job where it does not."""

from __future__ import annotations

import time
from typing import Any
from uuid import UUID

import anyio
from anyio.to_thread import run_sync
from sqlalchemy.orm import Session

from shapery_contracts.api import JobCreate, JobView, Scope
from shapery_contracts.errors import InvalidInput, Unavailable
from shapery_contracts.retrieval import ShapeFilter, ShapeSearchParams
from shapery_contracts.shapes import SearchAnswer, SearchRequest
from shapery_contracts.states import JobState
from shapery_gateway import outbox
from shapery_gateway.backend import Backend
from shapery_gateway.http.storable import refuse_unstorable
from shapery_gateway.problems import ProblemError
from shapery_gateway.shapes.service import mesh_of
from shapery_platform import collections, jobs, shapes
from shapery_platform.keys import Principal

KIND, SERVICE = "shape-search", "retrieval"
WAIT_SECONDS = 2.0
_LOOK_EVERY = 0.04


async def search(
    backend: Backend, caller: Principal, request: SearchRequest, wait: float, idempotency_key: str | None
) -> SearchAnswer | JobView:
    """Return what was found, or the job that searches where that takes longer than `wait` seconds.

    Raises
    ------
    UserError, ProblemError
        ``not_found``; ``conflict`` for a shape of an older index version; ``input_expired`` for a region of a shape
        whose mesh was deleted; what the job failed with; ``forbidden`` where a job is needed and the caller may not
        make one.
    """
    ends = time.monotonic() + wait
    refuse_unstorable([request.collection, request.labels], "The filter")
    await run_sync(_check, backend, caller, request)
    if request.shape_id is not None and request.region is None:
        if wait > 0 and (answer := await backend.ask(SERVICE, KIND, caller.owner, _params(request), wait)) is not None:
            if answer.code is not None:
                raise InvalidInput(answer.code, answer.message, answer.hint)
            if answer.result is not None:
                backend.metrics.searches.labels("resident").inc()
                return await run_sync(_answer, backend, caller, answer.result, None)
        if not caller.may(Scope.WRITE):
            raise Unavailable(
                "service_unavailable", "No process that answers searches is free.", "Ask again in a moment."
            )
    elif not caller.may(Scope.WRITE):
        raise ProblemError("forbidden", "A query by a mesh or a region of one makes a job, which needs 'write'.")
    job = await run_sync(_create, backend, caller, request, idempotency_key)
    while not job.state.terminal and time.monotonic() < ends:
        await anyio.sleep(_LOOK_EVERY)
        job = await run_sync(_job, backend, caller, job.id)
    backend.metrics.searches.labels("job" if job.state.terminal else "later").inc()
    return await _ended(backend, caller, job)


async def get(backend: Backend, caller: Principal, job_id: UUID) -> SearchAnswer | JobView:
    """Return what a search's job has found, or the job.

    Raises
    ------
    UserError
        ``not_found`` where it is no search of the caller; ``gone`` where its result has expired; what it failed with.
    """
    job = await run_sync(_job, backend, caller, job_id)
    if job.kind != KIND:
        raise InvalidInput("not_found", f"The job {job_id} is a {job.kind}, not a search.")
    if job.expired:
        raise InvalidInput("gone", f"The results of the search {job_id} have expired.", "Search again.")
    return await _ended(backend, caller, job)


async def _ended(backend: Backend, caller: Principal, job: JobView) -> SearchAnswer | JobView:
    if job.state is JobState.SUCCEEDED and job.result is not None:
        return await run_sync(_answer, backend, caller, job.result, job.id)
    if job.state is JobState.FAILED and job.error is not None:
        raise InvalidInput(job.error.code, job.error.message, job.error.hint)
    return job


def _check(backend: Backend, caller: Principal, request: SearchRequest) -> None:
    with backend.database.session(readonly=True) as session:
        if request.collection is not None:
            collections.named(session, caller.owner, request.collection)
        if request.shape_id is not None:
            shape = shapes.get(session, caller.owner, request.shape_id)
            if shapes.is_outdated(shape):
                raise InvalidInput(
                    "conflict",
                    f"The shape {shape.id} was indexed by an older version, and cannot be compared.",
                    f"Index it again: POST /v1/shapes/{shape.id}/reindex.",
                )


def _params(request: SearchRequest) -> dict[str, Any]:
    return ShapeSearchParams(
        shape_id=None if request.shape_id is None else str(request.shape_id),
        mode=request.mode,
        region=request.region,
        parts=request.parts,
        limit=request.limit,
        filter=ShapeFilter(collection=request.collection, labels=request.labels),
        rerank=request.rerank,
    ).model_dump(mode="json")


def _create(backend: Backend, caller: Principal, request: SearchRequest, idempotency_key: str | None) -> JobView:
    with backend.database.session() as session:
        inputs = _inputs(session, caller, request)
        job, created = jobs.create(
            session,
            backend.settings,
            caller.owner,
            JobCreate(kind=KIND, inputs=inputs, params=_params(request)),
            idempotency_key,
        )
        if created:
            outbox.defer(session, job)
        view = jobs.view(job)
        messages = outbox.deferred(session)
    backend.outbox.put(messages)
    return view


def _inputs(session: Session, caller: Principal, request: SearchRequest) -> dict[str, Any]:
    if request.asset_id is not None:
        return {"mesh": request.asset_id}
    if request.region is not None and request.shape_id is not None:
        return {"mesh": mesh_of(session, caller, request.shape_id)}
    return {}


def _job(backend: Backend, caller: Principal, job_id: UUID) -> JobView:
    with backend.database.session(readonly=True) as session:
        return jobs.view(jobs.get(session, caller.owner, job_id))


def _answer(backend: Backend, caller: Principal, result: dict[str, Any], job_id: UUID | None) -> SearchAnswer:
    ids = [UUID(hit["shape_id"]) for hit in result["hits"]]
    with backend.database.session(readonly=True) as session:
        there = shapes.some(session, caller.owner, ids)
        views = {shape_id: shapes.view(shape) for shape_id, shape in there.items()}
    hits = [
        {**hit, "shape": views[shape_id]}
        for shape_id, hit in zip(ids, result["hits"], strict=True)
        if shape_id in views
    ]
    return SearchAnswer.model_validate({**result, "hits": hits, "job_id": job_id})

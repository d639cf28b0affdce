"""Creates, shows, cancels and retries jobs, and gives out what they made."""

from __future__ import annotations

from pathlib import PurePosixPath
from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.api import JobCreate, JobOrder, JobView, Page
from shapery_contracts.errors import InvalidInput
from shapery_contracts.states import JobState
from shapery_gateway import outbox
from shapery_gateway.assets.service import stored_content
from shapery_gateway.backend import Backend
from shapery_gateway.http.content import Content
from shapery_gateway.http.storable import refuse_unstorable
from shapery_platform import jobs
from shapery_platform.keys import Principal


def create(
    session: Session, backend: Backend, caller: Principal, request: JobCreate, idempotency_key: str | None
) -> JobView:
    """Create a job, or return the one that was created with the same key."""
    refuse_unstorable(request.params, "params")
    job, created = jobs.create(session, backend.settings, caller.owner, request, idempotency_key)
    if created:
        outbox.defer(session, job)
    return jobs.view(job)


def get(session: Session, caller: Principal, job_id: UUID) -> JobView:
    """Return a job of the caller."""
    return jobs.view(jobs.get(session, caller.owner, job_id))


def list_jobs(
    session: Session,
    caller: Principal,
    cursor: str | None,
    limit: int,
    state: JobState | None,
    kind: str | None,
    batch_id: UUID | None,
    name: str | None,
    order: JobOrder,
) -> Page[JobView]:
    """Return a page of the caller's jobs."""
    refuse_unstorable(name, "The filter")
    found, following = jobs.list_jobs(session, caller.owner, cursor, limit, state, kind, batch_id, name, order)
    return Page(items=[jobs.view(job) for job in found], next_cursor=following)


def cancel(session: Session, caller: Principal, job_id: UUID) -> JobView:
    """Cancel a job of the caller."""
    return jobs.view(jobs.cancel(session, caller.owner, job_id))


def retry(session: Session, caller: Principal, job_id: UUID) -> JobView:
    """Queue a job of the caller again."""
    job = jobs.retry(session, caller.owner, job_id)
    outbox.defer(session, job)
    return jobs.view(job)


def events_are_over(backend: Backend, caller: Principal, job_id: UUID, after: int) -> bool:
    """Tell whether a job of the caller has ended, and its last event is not after `after`.

    Raises
    ------
    InvalidInput
        ``not_found``: the stream must not begin.
    """
    with backend.database.session(readonly=True) as session:
        job = jobs.get(session, caller.owner, job_id)
        return job.state.terminal and after >= job.event_seq


def preview(session: Session, caller: Principal, job_id: UUID, after: int) -> jobs.Preview | None:
    """Return the preview of a job of the caller if it is newer than `after`."""
    return jobs.preview(session, caller.owner, job_id, after)


def artifact(backend: Backend, caller: Principal, job_id: UUID, name: str) -> Content:
    """Return one artifact's bytes. The name is looked up among those the job has, and leads to no file by itself."""
    if "\0" in name or not name.isprintable():
        raise InvalidInput("not_found", f"The job {job_id} has no such artifact.")
    with backend.database.session(readonly=True) as session:
        found = jobs.artifact(session, caller.owner, job_id, name)
    return stored_content(backend.store, found.sha256, found.size, found.media_type, PurePosixPath(found.name).name)

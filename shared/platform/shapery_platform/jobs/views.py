"""Reading jobs: one, a page of them, their events and artifacts."""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import quote
from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.api import ArtifactView, JobErrorView, JobEvent, JobOrder, JobView
from shapery_contracts.errors import InvalidInput
from shapery_contracts.states import JobState
from shapery_platform.db.models import Job, JobArtifact
from shapery_platform.db.repositories import jobs as repository
from shapery_platform.paging import NEWEST_FIRST, checked_limit, cut_page, parse_sort


def get(session: Session, owner: str, job_id: UUID) -> Job:
    """Return a job of this owner, as it is now; raises ``not_found``."""
    job = repository.find(session, owner, job_id)
    if job is None:
        raise not_found(job_id)
    return job


def list_jobs(
    session: Session,
    owner: str,
    cursor: str | None = None,
    limit: int = 50,
    state: JobState | None = None,
    kind: str | None = None,
    batch_id: UUID | None = None,
    name: str | None = None,
    order: JobOrder = NEWEST_FIRST,
) -> tuple[list[Job], str | None]:
    """Return a page of jobs in an order, and the cursor of the next one; `name` is a text in their name.

    Jobs that have not ended, or never began, took less time than any other.
    """
    limit = checked_limit(limit)
    sort = parse_sort(cursor, order, repository.ORDERS)
    rows = repository.page(session, owner, sort, limit + 1, state=state, kind=kind, batch_id=batch_id, name=name)
    return cut_page(rows, limit, sort, repository.ORDERS)


def view(job: Job) -> JobView:
    """Return the representation that the API shows."""
    inputs: dict[str, list[UUID]] = {}
    for entry in job.inputs:
        inputs.setdefault(entry.name, []).append(entry.asset_id)
    error = None
    if job.error_code is not None:
        error = JobErrorView(code=job.error_code, message=job.error_message or "", hint=job.error_hint or "")
    return JobView(
        id=job.id,
        name=job.name,
        kind=job.kind,
        state=job.state,
        inputs=inputs,
        params=job.params,
        stage=job.stage,
        fraction=job.fraction,
        message=job.message,
        preview=job.preview,
        event=job.event_seq,
        attempt=job.attempt,
        error=error,
        result=job.result,
        artifacts=[
            ArtifactView(
                name=entry.name,
                size=entry.size,
                sha256=entry.sha256,
                media_type=entry.media_type,
                url=f"/v1/jobs/{job.id}/artifacts/{quote(entry.name)}",
            )
            for entry in job.artifacts
        ],
        batch_id=job.batch_id,
        created_at=job.created_at,
        started_at=job.started_at,
        finished_at=job.finished_at,
        expires_at=job.expires_at,
        expired=job.expired,
    )


def artifact(session: Session, owner: str, job_id: UUID, name: str) -> JobArtifact:
    """Return one artifact of a job; raises ``not_found``, or ``gone`` where it has expired."""
    found = repository.find_artifact(session, owner, job_id, name)
    if found is not None:
        return found
    job = get(session, owner, job_id)
    if job.expired:
        raise InvalidInput(
            "gone",
            f"The results of job {job_id} expired at {job.expires_at:%Y-%m-%d %H:%M} UTC.",
            "Create the job again to compute them anew.",
        )
    raise InvalidInput("not_found", f"The job {job_id} has no artifact {name!r}.")


@dataclass(frozen=True, slots=True)
class Preview:
    """How the result of a running job looks so far."""

    number: int
    """That of the event that told of it."""
    data: bytes


def preview(session: Session, owner: str, job_id: UUID, after: int = 0) -> Preview | None:
    """Return a running job's preview if its number is above `after`; raises ``not_found`` where there is no such job.

    None where nothing is new, nothing was shown yet, or the job does not run: then its results say more.
    """
    found = repository.find_preview(session, owner, job_id, after)
    if found is not None:
        return Preview(found.number, found.data)
    get(session, owner, job_id)
    return None


def events_after(session: Session, owner: str, job_id: UUID, seq: int = 0, limit: int = 500) -> list[JobEvent]:
    """Return the events of a job with a number above `seq`, at most `limit`.

    The number of an event never changes, but progress that was overtaken within its stage is not kept.
    """
    return [
        JobEvent(
            seq=event.seq,
            type="state" if event.type == "state" else "progress",
            job_id=job_id,
            state=event.state,
            stage=event.stage,
            fraction=event.fraction,
            message=event.message,
            preview=event.preview,
            at=event.at,
        )
        for event in repository.events_after(session, owner, job_id, seq, limit)
    ]


def not_found(job_id: UUID) -> InvalidInput:
    """Return the error for a job that does not exist for this owner."""
    return InvalidInput("not_found", f"There is no job {job_id}.")

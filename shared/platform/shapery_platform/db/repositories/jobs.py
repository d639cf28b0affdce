"""Queries about jobs.

State is written by `update_state` alone: the expected state, and where there is one the expected lease, are part of
its condition, so that of two writers one finds no row.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import Row, Select, delete, insert, or_, select, text, update
from sqlalchemy.orm import Session, raiseload

from shapery_contracts.states import JobState
from shapery_platform.db.models import IS_LIVE, WILL_EXPIRE, Asset, Job, JobArtifact, JobEvent, JobInput, JobPreview
from shapery_platform.paging import Columns, Sort, arranged

ORDERS: Columns = {"name": Job.name, "state": Job.state, "took": Job.took}

_STATE_COLUMNS = (
    Job.id,
    Job.owner,
    Job.kind,
    Job.service,
    Job.state,
    Job.lease,
    Job.attempt,
    Job.max_attempts,
    Job.result_ttl,
    Job.stage,
    Job.fraction,
    Job.message,
    Job.started_at,
)


def find(session: Session, owner: str, job_id: UUID) -> Job | None:
    """Return a job with its inputs and artifacts, as it is now."""
    return session.scalars(
        select(Job).where(Job.id == job_id, Job.owner == owner).execution_options(populate_existing=True)
    ).one_or_none()


def find_by_idempotency_key(session: Session, owner: str, key: str) -> Job | None:
    """Return the job that was created with this key."""
    return session.scalars(select(Job).where(Job.owner == owner, Job.idempotency_key == key)).one_or_none()


def page(
    session: Session,
    owner: str,
    sort: Sort,
    limit: int,
    *,
    state: JobState | None,
    kind: str | None,
    batch_id: UUID | None,
    name: str | None = None,
) -> Sequence[Job]:
    """Return jobs in an order."""
    # A batch's jobs are few among all those of its owner: a condition on the expression, which no index serves, keeps
    # SQLite from walking through the latter.
    query = select(Job).where((Job.owner if batch_id is None else Job.owner.concat("")) == owner)
    if state is not None:
        query = query.where(Job.state == state)
    if kind is not None:
        query = query.where(Job.kind == kind)
    if batch_id is not None:
        query = query.where(Job.batch_id == batch_id)
    if name is not None:
        query = query.where(Job.name.icontains(name, autoescape=True))
    return session.scalars(arranged(query, sort, Job.id, ORDERS).limit(limit)).all()


def add_all(session: Session, jobs: Sequence[Mapping[str, Any]], inputs: Sequence[Mapping[str, Any]]) -> None:
    """Insert jobs, their inputs and their first events."""
    session.execute(insert(Job), list(jobs))
    if inputs:
        session.execute(insert(JobInput), list(inputs))
    session.execute(
        insert(JobEvent),
        [
            {"job_id": job["id"], "seq": 1, "type": "state", "state": job["state"], "at": job["created_at"]}
            for job in jobs
        ],
    )


def lock(session: Session, job_id: UUID, *, owner: str | None = None, lease: UUID | None = None) -> Row[Any] | None:
    """Return what decides about a job's state and keep others from writing it until the transaction ends."""
    query = select(*_STATE_COLUMNS).where(Job.id == job_id)
    if owner is not None:
        query = query.where(Job.owner == owner)
    if lease is not None:
        query = query.where(Job.lease == lease)
    return session.execute(query.with_for_update()).one_or_none()


def waiting_attempt(session: Session, job_id: UUID) -> int | None:
    """Return how often a queued job was claimed before, or None where it is not queued."""
    return session.scalars(select(Job.attempt).where(Job.id == job_id, Job.state == JobState.QUEUED)).one_or_none()


def update_state(
    session: Session, job_id: UUID, expected: JobState, lease: UUID | None, values: Mapping[str, Any], at: datetime
) -> bool:
    """Write a new state and its event if the job still is in the expected state under the expected lease.

    What the work has shown so far goes with the lease.
    """
    condition = Job.lease.is_(None) if lease is None else Job.lease == lease
    ends = lease is not None and "lease" in values
    if ends:
        values = {**values, "preview": 0}
    row = session.execute(
        update(Job)
        .where(Job.id == job_id, Job.state == expected, condition)
        .values(**values, event_seq=Job.event_seq + 1)
        .returning(Job.event_seq, Job.state, Job.stage, Job.fraction, Job.message, Job.preview)
        .execution_options(synchronize_session=False)
    ).one_or_none()
    if row is None:
        return False
    if ends:
        session.execute(
            delete(JobPreview).where(JobPreview.job_id == job_id).execution_options(synchronize_session=False)
        )
    session.execute(
        insert(JobEvent),
        [
            {
                "job_id": job_id,
                "seq": row.event_seq,
                "type": "state",
                "state": row.state,
                "stage": row.stage,
                "fraction": row.fraction,
                "message": row.message,
                "preview": row.preview,
                "at": at,
            }
        ],
    )
    return True


def update_states(
    session: Session, condition: Collection[Any], expected: JobState, values: Mapping[str, Any], at: datetime
) -> list[UUID]:
    """Write a new state and its events for all jobs that meet `condition` and are in the expected state."""
    rows = session.execute(
        update(Job)
        .where(Job.state == expected, *condition)
        .values(**values, event_seq=Job.event_seq + 1)
        .returning(Job.id, Job.event_seq, Job.state, Job.stage, Job.fraction, Job.message, Job.preview)
        .execution_options(synchronize_session=False)
    ).all()
    if rows:
        session.execute(
            insert(JobEvent),
            [
                {
                    "job_id": row.id,
                    "seq": row.event_seq,
                    "type": "state",
                    "state": row.state,
                    "stage": row.stage,
                    "fraction": row.fraction,
                    "message": row.message,
                    "preview": row.preview,
                    "at": at,
                }
                for row in rows
            ],
        )
    return [row.id for row in rows]


def touch(session: Session, job_id: UUID, lease: UUID, at: datetime) -> JobState | None:
    """Record a heartbeat and return the job's state; None where the lease is lost."""
    return session.execute(
        update(Job)
        .where(Job.id == job_id, Job.lease == lease)
        .values(heartbeat_at=at)
        .returning(Job.state)
        .execution_options(synchronize_session=False)
    ).scalar_one_or_none()


def write_progress(
    session: Session,
    job_id: UUID,
    lease: UUID,
    stage: str,
    fraction: float,
    message: str,
    at: datetime,
    preview: bytes | None = None,
) -> JobState | None:
    """Record progress, which also is a heartbeat; None where the lease is lost.

    The event takes the place of the one before in the same stage, so that a job keeps one event per stage and state
    however long it runs. Whoever follows the stream sees each as it comes. A preview takes the place of the one before,
    too; its number is that of the event which tells of it.
    """
    row = session.execute(
        update(Job)
        .where(Job.id == job_id, Job.lease == lease)
        .values(
            stage=stage,
            fraction=fraction,
            message=message,
            heartbeat_at=at,
            event_seq=Job.event_seq + 1,
            preview=Job.preview if preview is None else Job.event_seq + 1,
        )
        .returning(Job.event_seq, Job.state, Job.preview)
        .execution_options(synchronize_session=False)
    ).one_or_none()
    if row is None:
        return None
    if preview is not None:
        _write_preview(session, job_id, row.preview, preview)
    session.execute(
        delete(JobEvent)
        .where(JobEvent.job_id == job_id, JobEvent.type == "progress", JobEvent.stage == stage)
        .execution_options(synchronize_session=False)
    )
    session.execute(
        insert(JobEvent),
        [
            {
                "job_id": job_id,
                "seq": row.event_seq,
                "type": "progress",
                "state": row.state,
                "stage": stage,
                "fraction": fraction,
                "message": message,
                "preview": row.preview,
                "at": at,
            }
        ],
    )
    state: JobState = row.state
    return state


def _write_preview(session: Session, job_id: UUID, number: int, data: bytes) -> None:
    # The job's row is locked: nobody else writes its preview meanwhile.
    changed = session.execute(
        update(JobPreview)
        .where(JobPreview.job_id == job_id)
        .values(number=number, data=data)
        .returning(JobPreview.job_id)
        .execution_options(synchronize_session=False)
    ).one_or_none()
    if changed is None:
        session.execute(insert(JobPreview), [{"job_id": job_id, "number": number, "data": data}])


def find_preview(session: Session, owner: str, job_id: UUID, after: int) -> Row[tuple[int, bytes]] | None:
    """Return number and bytes of a job's preview where its number is above `after`."""
    return session.execute(
        select(JobPreview.number, JobPreview.data)
        .join(Job, Job.id == JobPreview.job_id)
        .where(JobPreview.job_id == job_id, Job.owner == owner, JobPreview.number > after)
    ).one_or_none()


def add_artifacts(session: Session, rows: Iterable[Mapping[str, Any]]) -> None:
    """Insert artifacts."""
    if listed := list(rows):
        session.execute(insert(JobArtifact), listed)


def find_artifact(session: Session, owner: str, job_id: UUID, name: str) -> JobArtifact | None:
    """Return one artifact of a job."""
    return session.scalars(
        select(JobArtifact)
        .join(Job, Job.id == JobArtifact.job_id)
        .where(Job.id == job_id, Job.owner == owner, JobArtifact.name == name)
    ).one_or_none()


def inputs_with_assets(session: Session, job_id: UUID) -> Sequence[Row[tuple[str, Asset]]]:
    """Return the inputs of a job with their assets, also deleted ones, in their order."""
    return session.execute(
        select(JobInput.name, Asset)
        .join(Asset, Asset.id == JobInput.asset_id)
        .where(JobInput.job_id == job_id)
        .order_by(JobInput.name, JobInput.position)
    ).all()


def input_ids(job_ids: Collection[UUID]) -> Select[tuple[UUID]]:
    """Select the assets that these jobs read."""
    return select(JobInput.asset_id).where(JobInput.job_id.in_(job_ids)).distinct()


def events_after(session: Session, owner: str, job_id: UUID, seq: int, limit: int) -> Sequence[JobEvent]:
    """Return the events of a job with a number above `seq`."""
    return session.scalars(
        select(JobEvent)
        .join(Job, Job.id == JobEvent.job_id)
        .where(JobEvent.job_id == job_id, JobEvent.seq > seq, Job.owner == owner)
        .order_by(JobEvent.seq)
        .limit(limit)
    ).all()


def silent_since(session: Session, since: datetime, limit: int) -> Sequence[Row[Any]]:
    """Lock and return jobs whose worker was not heard of after `since`; those another reaper holds are left out."""
    return session.execute(
        select(*_STATE_COLUMNS)
        .where(text(IS_LIVE), Job.state.in_((JobState.RUNNING, JobState.CANCELLING)), Job.heartbeat_at < since)
        .order_by(Job.id)
        .limit(limit)
        .with_for_update(skip_locked=True)
    ).all()


def waiting(
    session: Session, service: str, limit: int, *, sent_before: datetime | None = None
) -> Sequence[Row[tuple[UUID, str, str]]]:
    """Return id, kind and service of queued jobs of a service that were not sent, or were sent before a time."""
    unsent = Job.enqueued_at.is_(None)
    return session.execute(
        select(Job.id, Job.kind, Job.service)
        .where(
            text(IS_LIVE),
            Job.state == JobState.QUEUED,
            Job.service == service,
            unsent if sent_before is None else or_(unsent, Job.enqueued_at < sent_before),
        )
        .order_by(Job.id)
        .limit(limit)
    ).all()


def mark_sent(session: Session, ids: Collection[UUID], at: datetime) -> None:
    """Record that messages were given to the queue."""
    session.execute(
        update(Job)
        .where(Job.id.in_(ids), Job.state == JobState.QUEUED)
        .values(enqueued_at=at)
        .execution_options(synchronize_session=False)
    )


def due_to_expire(session: Session, now: datetime, limit: int) -> Sequence[UUID]:
    """Lock and return jobs whose result shall go."""
    return session.scalars(
        select(Job.id)
        .where(text(WILL_EXPIRE), Job.expires_at <= now)
        .order_by(Job.expires_at)
        .limit(limit)
        .with_for_update(skip_locked=True)
    ).all()


def drop_results(session: Session, ids: Collection[UUID]) -> list[str]:
    """Remove result and artifacts of jobs, and return the hashes that were referred to."""
    hashes = session.scalars(delete(JobArtifact).where(JobArtifact.job_id.in_(ids)).returning(JobArtifact.sha256)).all()
    session.execute(
        update(Job)
        .where(Job.id.in_(ids))
        .values(result=None, expired=True)
        .execution_options(synchronize_session=False)
    )
    return sorted(set(hashes))


def slim() -> Select[tuple[Job]]:
    """Select jobs without loading inputs and artifacts."""
    return select(Job).options(raiseload("*"))


def params_of(job_id: UUID) -> Select[tuple[dict[str, Any]]]:
    """Select a job's parameters."""
    return select(Job.params).where(Job.id == job_id)

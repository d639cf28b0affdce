"""Queries about batches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import Row, Select, exists, func, insert, select
from sqlalchemy.orm import Session

from shapery_contracts.states import JobState
from shapery_platform.db.models import Asset, Batch, Job, JobInput
from shapery_platform.paging import Sort, arranged


def add(session: Session, values: Mapping[str, Any]) -> None:
    """Insert a batch."""
    session.execute(insert(Batch), [dict(values)])


def find(session: Session, owner: str, batch_id: UUID) -> Batch | None:
    """Return a batch."""
    return session.scalars(select(Batch).where(Batch.id == batch_id, Batch.owner == owner)).one_or_none()


def find_by_idempotency_key(session: Session, owner: str, key: str) -> Batch | None:
    """Return the batch that was created with this key."""
    return session.scalars(select(Batch).where(Batch.owner == owner, Batch.idempotency_key == key)).one_or_none()


def page(session: Session, owner: str, sort: Sort, limit: int) -> Sequence[Batch]:
    """Return batches in an order."""
    query = select(Batch).where(Batch.owner == owner)
    return session.scalars(arranged(query, sort, Batch.id).limit(limit)).all()


def counts(session: Session, batch_ids: Sequence[UUID]) -> Sequence[Row[Any]]:
    """Return per batch and state: number of jobs, the last time one ended, and the sum of their event numbers."""
    return session.execute(
        select(
            Job.batch_id,
            Job.state,
            func.count().label("jobs"),
            func.max(Job.finished_at).label("finished_at"),
            func.sum(Job.event_seq).label("events"),
        )
        .where(Job.batch_id.in_(batch_ids))
        .group_by(Job.batch_id, Job.state)
    ).all()


def jobs_after(session: Session, batch_id: UUID, index: int, limit: int) -> Sequence[Job]:
    """Return the jobs of a batch with an index above `index`, in order."""
    return session.scalars(
        select(Job)
        .where(Job.batch_id == batch_id, Job.batch_index > index)
        .order_by(Job.batch_index)
        .limit(limit)
        .execution_options(populate_existing=True)
    ).all()


def lock_jobs(session: Session, batch_id: UUID, states: Sequence[JobState]) -> None:
    """Lock the jobs of a batch that are in one of these states, in the order of their ids."""
    session.execute(
        select(Job.id).where(Job.batch_id == batch_id, Job.state.in_(states)).order_by(Job.id).with_for_update()
    ).all()


def lock_inputs(session: Session, batch_id: UUID, states: Sequence[JobState]) -> None:
    """Keep the inputs of these jobs from being deleted until the transaction ends."""
    ids: Select[tuple[UUID]] = (
        select(JobInput.asset_id)
        .join(Job, Job.id == JobInput.job_id)
        .where(Job.batch_id == batch_id, Job.state.in_(states))
        .distinct()
    )
    session.execute(select(Asset.id).where(Asset.id.in_(ids)).order_by(Asset.id).with_for_update(read=True)).all()


def has_deleted_input() -> Any:
    """Return the condition that an input of a job was deleted."""
    return exists(
        select(JobInput.job_id)
        .join(Asset, Asset.id == JobInput.asset_id)
        .where(JobInput.job_id == Job.id, Asset.deleted_at.is_not(None))
        .correlate(Job)
    )


def result_ttl(session: Session, batch_id: UUID) -> float:
    """Return the seconds that results stay; all jobs of a batch were promised the same."""
    return session.scalars(select(Job.result_ttl).where(Job.batch_id == batch_id).limit(1)).one()

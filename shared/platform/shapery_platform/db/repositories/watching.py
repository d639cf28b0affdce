"""Queries that are asked again and again while somebody watches: for everything that is watched, in one go."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TypeVar
from uuid import UUID

from sqlalchemy import and_, func, or_, select
from sqlalchemy.orm import Session

from shapery_contracts.states import JobState
from shapery_platform.db.models import Job, JobEvent

T = TypeVar("T")

_IDS_AT_ONCE = 500
_PAIRS_AT_ONCE = 100
_EVENTS_AT_ONCE = 5000


def last_events(session: Session, job_ids: Collection[UUID]) -> dict[UUID, int]:
    """Return the number of each job's last event; jobs that do not exist are missing."""
    found: dict[UUID, int] = {}
    for ids in _chunks(sorted(job_ids), _IDS_AT_ONCE):
        found.update(
            (row.id, row.event_seq) for row in session.execute(select(Job.id, Job.event_seq).where(Job.id.in_(ids)))
        )
    return found


def events_after(session: Session, after: Mapping[UUID, int]) -> Sequence[JobEvent]:
    """Return the events of each job with a number above the one given for it, in their order."""
    events: list[JobEvent] = []
    for pairs in _chunks(sorted(after.items()), _PAIRS_AT_ONCE):
        newer = or_(*(and_(JobEvent.job_id == job_id, JobEvent.seq > seq) for job_id, seq in pairs))
        events.extend(
            session.scalars(
                select(JobEvent).where(newer).order_by(JobEvent.job_id, JobEvent.seq).limit(_EVENTS_AT_ONCE)
            )
        )
    return events


def count_by_state(session: Session) -> dict[JobState, int]:
    """Return how many jobs are in each state, over all owners."""
    counts = dict.fromkeys(JobState, 0)
    counts.update(
        (row.state, row.jobs)
        for row in session.execute(select(Job.state, func.count().label("jobs")).group_by(Job.state))
    )
    return counts


def _chunks(items: Sequence[T], size: int) -> Iterator[Sequence[T]]:
    for begin in range(0, len(items), size):
        yield items[begin : begin + size]

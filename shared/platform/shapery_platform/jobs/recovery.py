"""What the reaper asks: jobs whose worker fell silent, and queued jobs whose message was lost."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from datetime import timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.states import JobState
from shapery_platform.db import database_now
from shapery_platform.db.repositories import jobs as repository
from shapery_platform.jobs.lifecycle import give_back
from shapery_platform.settings import Settings

_AT_ONCE = 500


@dataclass(frozen=True, slots=True)
class QueuedJob:
    """A job that waits for its message."""

    job_id: UUID
    kind: str
    service: str


def recover_lost(session: Session, settings: Settings) -> list[QueuedJob]:
    """Take running jobs from workers not heard of within the lease; return those to enqueue again.

    The others ended: as cancelled where that was asked for, as crashed after the bounded number of attempts.
    """
    now = database_now(session)
    queued = []
    for row in repository.silent_since(session, now - timedelta(seconds=settings.lease_seconds), _AT_ONCE):
        reason = f"its worker was not heard of for {settings.lease_seconds:g} s."
        if give_back(session, row, reason, "worker_lost", now) is JobState.QUEUED:
            queued.append(QueuedJob(row.id, row.kind, row.service))
    return queued


def queued_without_message(
    session: Session, service: str, limit: int, older_than: float | None = None
) -> list[QueuedJob]:
    """Return queued jobs of a service whose message was not sent yet.

    Parameters
    ----------
    older_than
        Also those whose message was sent that many seconds ago. Give it only where the service's queue is empty,
        which means that these messages are lost: a long queue is no loss.
    """
    before = None if older_than is None else database_now(session) - timedelta(seconds=older_than)
    rows = repository.waiting(session, service, limit, sent_before=before)
    return [QueuedJob(row.id, row.kind, row.service) for row in rows]


def mark_enqueued(session: Session, ids: Collection[UUID]) -> None:
    """Record that the messages of these jobs were given to the queue."""
    listed = sorted(ids)
    now = database_now(session)
    for begin in range(0, len(listed), _AT_ONCE):
        repository.mark_sent(session, listed[begin : begin + _AT_ONCE], now)

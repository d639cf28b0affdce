"""What event streams and metrics ask at short intervals: everything that is watched, in one go.

Ownership is checked when a stream begins; these functions trust the ids they are given.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.api import BatchEvent, JobEvent
from shapery_contracts.states import JobState
from shapery_platform.db.repositories import batches as batch_repository
from shapery_platform.db.repositories import watching as repository


def job_events(session: Session, after: Mapping[UUID, int]) -> dict[UUID, list[JobEvent]]:
    """Return what is new of each job since the event numbered `after`; jobs of which nothing is are missing.

    A number beyond the job's last event counts as that of the last.
    """
    last = repository.last_events(session, after.keys())
    changed = {job_id: seq for job_id, seq in after.items() if seq < last.get(job_id, 0)}
    found: dict[UUID, list[JobEvent]] = {}
    if not changed:
        return found
    for event in repository.events_after(session, changed):
        found.setdefault(event.job_id, []).append(
            JobEvent(
                seq=event.seq,
                type="state" if event.type == "state" else "progress",
                job_id=event.job_id,
                state=event.state,
                stage=event.stage,
                fraction=event.fraction,
                message=event.message,
                preview=event.preview,
                at=event.at,
            )
        )
    return found


def batch_events(session: Session, batch_ids: Collection[UUID]) -> dict[UUID, BatchEvent]:
    """Return the event that describes each batch as it is now; batches without jobs are missing."""
    seqs: dict[UUID, int] = {}
    counts: dict[UUID, dict[JobState, int]] = {}
    for row in batch_repository.counts(session, list(batch_ids)):
        seqs[row.batch_id] = seqs.get(row.batch_id, 0) + int(row.events)
        counts.setdefault(row.batch_id, dict.fromkeys(JobState, 0))[row.state] = row.jobs
    return {
        batch_id: BatchEvent(
            seq=seqs[batch_id],
            batch_id=batch_id,
            counts=found,
            finished=all(state.terminal for state, number in found.items() if number),
        )
        for batch_id, found in counts.items()
    }


def jobs_by_state(session: Session) -> dict[JobState, int]:
    """Return how many jobs are in each state, over all owners."""
    return repository.count_by_state(session)

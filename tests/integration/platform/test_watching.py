"""What event streams ask says the same as what is asked of one job or batch."""

from __future__ import annotations

from collections.abc import Callable
from uuid import UUID

from shapery_contracts.api import BatchHeader, BatchItem
from shapery_contracts.states import JobState
from shapery_platform import batches, jobs, watching
from shapery_platform.db import Database, new_id
from shapery_platform.db.repositories import watching as repository
from shapery_platform.jobs import ClaimedJob
from shapery_platform.settings import Settings


def test_events_of_many_jobs_are_those_of_each(
    database: Database, new_job: Callable[..., UUID], claimed: Callable[..., ClaimedJob]
) -> None:
    waiting, running = new_job(), claimed()
    with database.session() as session:
        jobs.report_progress(session, running.job_id, running.lease, "read", 0.2)
    nobody = new_id()
    with database.session(readonly=True) as session:
        for seq in range(5):
            found = watching.job_events(session, {waiting: seq, running.job_id: seq, nobody: seq})
            for job_id in (waiting, running.job_id):
                assert found.get(job_id, []) == jobs.events_after(session, "ann", job_id, seq)
            assert nobody not in found
        assert watching.job_events(session, {}) == {}


def test_events_of_many_batches_are_those_of_each(
    database: Database, settings: Settings, new_asset: Callable[..., UUID]
) -> None:
    asset_id = new_asset()
    made = []
    for size in (1, 3):
        with database.session() as session:
            items = [BatchItem(inputs={"post": asset_id})] * size
            made.append(batches.create(session, settings, "ann", BatchHeader(kind="segmentation"), items)[0].id)
    with database.session() as session:
        batches.cancel(session, "ann", made[0])
    nobody = new_id()
    with database.session(readonly=True) as session:
        found = watching.batch_events(session, [*made, nobody])
        assert found == {batch_id: batches.event(session, "ann", batch_id) for batch_id in made}
        assert [found[batch_id].finished for batch_id in made] == [True, False]


def test_jobs_of_all_owners_are_counted_by_state(
    database: Database, new_job: Callable[..., UUID], claimed: Callable[..., ClaimedJob]
) -> None:
    for owner in ("ann", "ann", "bob"):
        new_job(owner)
    claimed()
    with database.session(readonly=True) as session:
        counts = repository.count_by_state(session)
    assert counts == {**dict.fromkeys(JobState, 0), JobState.QUEUED: 3, JobState.RUNNING: 1}


def test_a_waiting_job_tells_how_often_it_was_tried(
    database: Database, new_job: Callable[..., UUID], claimed: Callable[..., ClaimedJob]
) -> None:
    fresh, job = new_job(), claimed()
    with database.session() as session:
        assert jobs.waiting_attempt(session, fresh) == 0
        assert jobs.waiting_attempt(session, job.job_id) is None, "it runs"
        assert jobs.crash_or_requeue(session, job.job_id, job.lease, "oops") is JobState.QUEUED
        assert jobs.waiting_attempt(session, job.job_id) == 1
        assert jobs.waiting_attempt(session, new_id()) is None

"""Workers, users and reapers on threads of their own, in an order that nobody chose."""

from __future__ import annotations

import itertools
import random
import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from uuid import UUID

import pytest
from sqlalchemy import select, update

from shapery_contracts.errors import UserError
from shapery_contracts.states import TRANSITIONS, JobState
from shapery_platform import jobs
from shapery_platform.db import Database
from shapery_platform.db.models import Job, JobArtifact, JobEvent
from shapery_platform.jobs import ClaimedJob, NewArtifact
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore

LEADS_TO = {(source, target) for (source, _), target in TRANSITIONS.items()}
JOBS, WORKERS, STEPS = 4, 3, 40


@pytest.mark.parametrize("seed", [1, 2])
def test_jobs_end_once_whoever_comes_between(
    database: Database, local_store: ObjectStore, settings: Settings, new_job: Callable[..., UUID], seed: int
) -> None:
    ids = [new_job() for _ in range(JOBS)]
    blobs = {(worker, n): local_store.put_bytes(b"%d %d" % (worker, n)) for worker in range(WORKERS) for n in range(2)}
    succeeded: list[tuple[UUID, int]] = []
    faults: list[BaseException] = []
    done = threading.Event()

    def work(worker: int) -> None:
        rng = random.Random(100 * seed + worker)
        held: list[ClaimedJob] = []
        for _ in range(STEPS):
            action = rng.choice(["claim", "claim", "beat", "succeed", "fail", "crash", "release", "stop", "progress"])
            with database.session() as session:
                if action == "claim":
                    job = jobs.claim(session, rng.choice(ids), f"worker-{worker}")
                    if job is not None:
                        held.append(job)
                    continue
                if not held:
                    continue
                # kept after it was used: a lease that was lost must do nothing
                job = rng.choice(held)
                if action == "beat":
                    jobs.heartbeat(session, job.job_id, job.lease)
                elif action == "progress":
                    jobs.report_progress(session, job.job_id, job.lease, "evolve", rng.random())
                elif action == "fail":
                    jobs.fail(session, job.job_id, job.lease, "no_object_found", "Nothing was found.")
                elif action == "crash":
                    jobs.crash_or_requeue(session, job.job_id, job.lease, "oops")
                elif action == "release":
                    jobs.release(session, job.job_id, job.lease)
                elif action == "stop":
                    jobs.stop(session, job.job_id, job.lease)
                else:
                    made = [NewArtifact(f"{n}", blobs[worker, n].sha256, blobs[worker, n].size) for n in range(2)]
                    if jobs.succeed(session, job.job_id, job.lease, {"by": worker}, made):
                        succeeded.append((job.job_id, worker))

    def use() -> None:
        rng = random.Random(1000 * seed)
        while not done.is_set():
            try:
                with database.session() as session:
                    rng.choice([jobs.cancel, jobs.retry, jobs.retry])(session, "ann", rng.choice(ids))
            except UserError as error:
                if error.code != "invalid_transition":
                    raise

    def reap() -> None:
        rng = random.Random(2000 * seed)
        while not done.is_set():
            past = datetime.now(UTC) - timedelta(minutes=1)
            with database.session() as session:
                session.execute(
                    update(Job).where(Job.id == rng.choice(ids), Job.lease.is_not(None)).values(heartbeat_at=past)
                )
            with database.session() as session:
                jobs.recover_lost(session, settings)

    def guarded(target: Callable[..., None], *args: int) -> threading.Thread:
        def run() -> None:
            try:
                target(*args)
            except BaseException as error:
                faults.append(error)

        thread = threading.Thread(target=run)
        thread.start()
        return thread

    disturbers = [guarded(use), guarded(reap), guarded(reap)]
    for thread in [guarded(work, worker) for worker in range(WORKERS)]:
        thread.join()
    done.set()
    for thread in disturbers:
        thread.join()

    assert faults == []
    assert len({job_id for job_id, _ in succeeded}) == len(succeeded), "no job succeeds twice"
    by = dict(succeeded)
    with database.session(readonly=True) as session:
        for job in session.scalars(select(Job)):
            assert (job.lease is not None) == (job.state in (JobState.RUNNING, JobState.CANCELLING))
            artifacts = session.scalars(select(JobArtifact.sha256).where(JobArtifact.job_id == job.id)).all()
            if job.state is JobState.SUCCEEDED:
                assert job.result == {"by": by[job.id]}
                assert sorted(artifacts) == sorted(blobs[by[job.id], n].sha256 for n in range(2))
            else:
                assert job.id not in by
                assert (artifacts, job.result) == ([], None)
            events = session.scalars(select(JobEvent).where(JobEvent.job_id == job.id).order_by(JobEvent.seq)).all()
            path = [entry.state for entry in events if entry.type == "state"]
            assert all(step in LEADS_TO for step in itertools.pairwise(path))
            assert path[-1] is job.state
            assert events[-1].seq == job.event_seq

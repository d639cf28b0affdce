"""Whatever workers, users and reapers do in whatever order, a job follows the table of transitions.

A model knows the state and the lease that each job must have. Workers keep leases they have lost, and use them.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path
from uuid import UUID

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    Bundle,
    RuleBasedStateMachine,
    consumes,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from sqlalchemy import event, select, update

from shapery_contracts.api import JobCreate
from shapery_contracts.errors import UserError
from shapery_contracts.formats import AssetKind, FileFormat
from shapery_contracts.states import TRANSITIONS, JobAction, JobState
from shapery_platform import assets, jobs
from shapery_platform.db import Database
from shapery_platform.db.models import Job, JobArtifact, JobEvent
from shapery_platform.jobs import ClaimedJob, NewArtifact
from shapery_platform.settings import Settings, load_settings
from shapery_platform.storage import ObjectStore
from shapery_platform.storage.opening import open_store
from tests.support.postgres import postgres_server

VOLUME = FileFormat(kind=AssetKind.VOLUME, format="nifti1", media_type="x/y", extension=".nii")
LEADS_TO = {(source, target) for (source, _), target in TRANSITIONS.items()}


@dataclass
class Expected:
    """What a job must look like."""

    state: JobState = JobState.QUEUED
    lease: UUID | None = None
    attempt: int = 0
    artifacts: set[str] = field(default_factory=set)


class JobLifecycle(RuleBasedStateMachine):
    """Jobs of one owner, and all who do something to them."""

    folder: Path
    database: Database
    store: ObjectStore
    settings: Settings
    asset_id: UUID

    created = Bundle("created")
    leases = Bundle("leases")

    def __init__(self) -> None:
        super().__init__()
        self.expected: dict[UUID, Expected] = {}
        self.results = 0

    def may(self, job_id: UUID, action: JobAction) -> JobState | None:
        return TRANSITIONS.get((self.expected[job_id].state, action))

    def end(self, job_id: UUID, state: JobState) -> None:
        self.expected[job_id].state = state
        self.expected[job_id].lease = None

    def holds(self, job: ClaimedJob) -> bool:
        return self.expected[job.job_id].lease == job.lease

    @precondition(lambda self: len(self.expected) < 3)
    @rule(target=created)
    def create(self) -> UUID:
        with self.database.session() as session:
            request = JobCreate(kind="segmentation", inputs={"post": self.asset_id})
            job, _ = jobs.create(session, self.settings, "ann", request)
        self.expected[job.id] = Expected()
        return job.id

    @rule(target=leases, job_id=created, worker=st.sampled_from(["one", "two", "three"]))
    def deliver(self, job_id: UUID, worker: str) -> ClaimedJob:
        """A message arrives, as often as the queue likes."""
        with self.database.session() as session:
            job = jobs.claim(session, job_id, worker)
        expected = self.expected[job_id]
        assert (job is not None) == (self.may(job_id, JobAction.CLAIM) is not None)
        if job is None:
            # a lease that nobody has: whoever uses it must get nowhere
            return ClaimedJob(job_id, UUID(int=1), "ann", "segmentation", "segmentation", {}, 1, 2)
        expected.state, expected.lease = JobState.RUNNING, job.lease
        expected.attempt += 1
        assert job.attempt == expected.attempt <= self.settings.max_attempts
        return job

    @rule(job=leases)
    def heartbeat(self, job: ClaimedJob) -> None:
        with self.database.session() as session:
            state = jobs.heartbeat(session, job.job_id, job.lease)
        assert state == (self.expected[job.job_id].state if self.holds(job) else None)

    @rule(job=leases, stage=st.sampled_from(["read", "evolve"]), fraction=st.floats(0, 1))
    def progress(self, job: ClaimedJob, stage: str, fraction: float) -> None:
        with self.database.session() as session:
            state = jobs.report_progress(session, job.job_id, job.lease, stage, fraction)
        assert state == (self.expected[job.job_id].state if self.holds(job) else None)

    @rule(job=leases)
    def succeed(self, job: ClaimedJob) -> None:
        self.results += 1
        blobs = [self.store.put_bytes(b"%d of result %d" % (number, self.results)) for number in range(2)]
        artifacts = [NewArtifact(f"{number}.ply", blob.sha256, blob.size) for number, blob in enumerate(blobs)]
        with self.database.session() as session:
            took = jobs.succeed(session, job.job_id, job.lease, {"result": self.results}, artifacts)
        assert took == (self.holds(job) and self.may(job.job_id, JobAction.SUCCEED) is not None)
        if took:
            self.end(job.job_id, JobState.SUCCEEDED)
            self.expected[job.job_id].artifacts = {blob.sha256 for blob in blobs}

    @rule(job=leases)
    def fail(self, job: ClaimedJob) -> None:
        with self.database.session() as session:
            took = jobs.fail(session, job.job_id, job.lease, "no_object_found", "Nothing was found.")
        assert took == (self.holds(job) and self.may(job.job_id, JobAction.FAIL) is not None)
        if took:
            self.end(job.job_id, JobState.FAILED)

    @rule(job=leases)
    def stop(self, job: ClaimedJob) -> None:
        with self.database.session() as session:
            took = jobs.stop(session, job.job_id, job.lease)
        assert took == (self.holds(job) and self.may(job.job_id, JobAction.STOP) is not None)
        if took:
            self.end(job.job_id, JobState.CANCELLED)

    @rule(job=leases)
    def break_off(self, job: ClaimedJob) -> None:
        with self.database.session() as session:
            state = jobs.crash_or_requeue(session, job.job_id, job.lease, "a fault of ours")
        assert state == (self.given_back(job.job_id) if self.holds(job) else None)
        if state is not None:
            self.end(job.job_id, state)

    @rule(job_id=created, by_reaper=st.booleans())
    def poison(self, job_id: UUID, by_reaper: bool) -> None:
        """A job that takes every worker along, as long as one takes it."""
        while self.may(job_id, JobAction.CLAIM) is not None:
            job = self.deliver(job_id, "victim")
            if by_reaper:
                self.reap({list(self.expected).index(job_id)})
            else:
                self.break_off(job)
        assert self.expected[job_id].state is not JobState.QUEUED

    @rule(job=leases)
    def release(self, job: ClaimedJob) -> None:
        with self.database.session() as session:
            state = jobs.release(session, job.job_id, job.lease)
        expected = self.expected[job.job_id]
        if not self.holds(job):
            assert state is None
        elif expected.state is JobState.CANCELLING:
            assert state is JobState.CANCELLED
            self.end(job.job_id, state)
        else:
            assert state is JobState.QUEUED
            self.end(job.job_id, state)
            expected.attempt -= 1

    def given_back(self, job_id: UUID) -> JobState:
        expected = self.expected[job_id]
        if expected.state is JobState.CANCELLING:
            return JobState.CANCELLED
        return JobState.QUEUED if expected.attempt < self.settings.max_attempts else JobState.CRASHED

    @rule(job_id=created)
    def cancel(self, job_id: UUID) -> None:
        target = self.may(job_id, JobAction.CANCEL)
        try:
            with self.database.session() as session:
                state = jobs.cancel(session, "ann", job_id).state
        except UserError as error:
            state = None if error.code == "invalid_transition" else JobState.CRASHED
        assert state is target
        if state is None:
            return
        self.expected[job_id].state = state

    @rule(job_id=created)
    def retry(self, job_id: UUID) -> None:
        target = self.may(job_id, JobAction.RETRY)
        try:
            with self.database.session() as session:
                state = jobs.retry(session, "ann", job_id).state
        except UserError as error:
            state = None if error.code == "invalid_transition" else JobState.CRASHED
        assert state is target
        if state is None:
            return
        self.expected[job_id].state = state
        self.expected[job_id].attempt = 0

    @rule(silent=st.sets(st.integers(0, 5)))
    def reap(self, silent: set[int]) -> None:
        """Some workers fall silent, and the reaper comes."""
        chosen = [job_id for number, job_id in enumerate(self.expected) if number in silent]
        past = datetime.now(UTC) - timedelta(hours=5)
        with self.database.session() as session:
            session.execute(update(Job).where(Job.id.in_(chosen), Job.lease.is_not(None)).values(heartbeat_at=past))
        with self.database.session() as session:
            queued = {entry.job_id for entry in jobs.recover_lost(session, self.settings)}
        for job_id in chosen:
            if self.expected[job_id].lease is not None:
                state = self.given_back(job_id)
                self.end(job_id, state)
                assert (job_id in queued) == (state is JobState.QUEUED)
                queued.discard(job_id)
        assert queued == set()

    @rule(job=consumes(leases))
    def forget(self, job: ClaimedJob) -> None:
        """A worker is gone for good."""

    @invariant()
    def rows_are_as_expected(self) -> None:
        with self.database.session(readonly=True) as session:
            columns = (Job.id, Job.state, Job.lease, Job.attempt, Job.result)
            rows = session.execute(select(*columns).where(Job.id.in_(self.expected))).all()
            found = {row.id: row for row in rows}
            artifacts: dict[UUID, set[str]] = {}
            query = select(JobArtifact.job_id, JobArtifact.sha256).where(JobArtifact.job_id.in_(self.expected))
            for entry in session.execute(query):
                artifacts.setdefault(entry.job_id, set()).add(entry.sha256)
        assert found.keys() == self.expected.keys()
        for job_id, expected in self.expected.items():
            row = found[job_id]
            assert (row.state, row.lease, row.attempt) == (expected.state, expected.lease, expected.attempt)
            assert (row.lease is not None) == (row.state in (JobState.RUNNING, JobState.CANCELLING))
            assert (row.result is not None) == (row.state is JobState.SUCCEEDED)
            assert artifacts.get(job_id, set()) == expected.artifacts
            assert bool(expected.artifacts) == (row.state is JobState.SUCCEEDED)

    def teardown(self) -> None:
        """Every path that was taken is one of the table."""
        if not self.expected:
            return
        with self.database.session(readonly=True) as session:
            for job_id, expected in self.expected.items():
                events = session.scalars(select(JobEvent).where(JobEvent.job_id == job_id).order_by(JobEvent.seq)).all()
                assert [entry.seq for entry in events] == sorted({entry.seq for entry in events})
                path = [entry.state for entry in events if entry.type == "state"]
                assert path[0] is JobState.QUEUED
                assert path[-1] is expected.state
                assert all(step in LEADS_TO for step in pairwise(path))


def prepared(url: str, folder: Path) -> type[JobLifecycle]:
    """Return the machine over a migrated database."""
    # nobody falls silent but those whom the test makes so; few attempts, so that they are used up
    own = load_settings(home=folder, database_url=url, min_free_bytes=0, lease_seconds=3600, max_attempts=2)
    database = Database(url)
    database.migrate()
    if database.dialect == "sqlite":
        event.listen(database.engine, "connect", lambda connection, _: connection.execute("PRAGMA synchronous = OFF"))
        database.engine.dispose()
    store = open_store(own, database)
    blob = store.put_bytes(b"voxels")
    with database.session() as session:
        asset = assets.create_from_upload(session, store, own, "ann", blob.sha256, blob.size, "x", VOLUME)
    found = {"folder": folder, "database": database, "store": store, "settings": own, "asset_id": asset.id}
    return type("PreparedJobLifecycle", (JobLifecycle,), found)


@pytest.fixture
def folder() -> Iterator[Path]:
    path = Path(tempfile.mkdtemp(prefix="shapery-lifecycle-"))
    yield path
    shutil.rmtree(path)


def run(machine: type[JobLifecycle], examples: int) -> None:
    limits = settings(
        max_examples=examples,
        stateful_step_count=30,
        deadline=None,
        # a path of 30 steps is read more quickly than it is shortened over a database
        phases=(Phase.explicit, Phase.reuse, Phase.generate),
        suppress_health_check=list(HealthCheck),
    )
    try:
        run_state_machine_as_test(machine, settings=limits)
    finally:
        machine.database.dispose()


@pytest.mark.slow
def test_jobs_follow_the_table_on_sqlite(folder: Path) -> None:
    run(prepared(f"sqlite:///{folder}/shapery.db", folder), 30)


@pytest.mark.server
def test_jobs_follow_the_table_on_postgresql(folder: Path) -> None:
    with postgres_server() as server:
        run(prepared(server.create_database(), folder), 10)

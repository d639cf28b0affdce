"""What happens to a job between its claim and its end, on both databases."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Any
from uuid import UUID, uuid4

import pytest
from sqlalchemy import update

from shapery_contracts.api import JobEvent, JobView
from shapery_contracts.errors import UserError
from shapery_contracts.states import JobState
from shapery_platform import jobs
from shapery_platform.db import Database
from shapery_platform.db.models import Job, JobArtifact
from shapery_platform.jobs import ClaimedJob, NewArtifact
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore


def states(listed: list[JobEvent]) -> list[str]:
    return [event.state.value for event in listed if event.type == "state"]


def fall_silent(database: Database, job: ClaimedJob, seconds: float = 60.0) -> None:
    with database.session() as session:
        past = datetime.now(UTC) - timedelta(seconds=seconds)
        session.execute(update(Job).where(Job.id == job.job_id).values(heartbeat_at=past))


# --- the work


def test_a_job_from_claim_to_result(
    database: Database,
    local_store: ObjectStore,
    settings: Settings,
    claimed: Callable[..., ClaimedJob],
    view: Callable[..., JobView],
    events: Callable[..., list[JobEvent]],
) -> None:
    job = claimed()
    assert [entry.filename for entry in job.inputs["post"]] == ["head.nii"]
    assert local_store.exists(job.inputs["post"][0].key)
    for stage, fraction, message in (("read", 0.1, ""), ("evolve", 0.4, "10,000 faces"), ("evolve", 0.7, "done\0")):
        with database.session() as session:
            state = jobs.report_progress(session, job.job_id, job.lease, stage, fraction, message)
            assert state is JobState.RUNNING
    shown = view(job.job_id)
    assert (shown.state, shown.stage, shown.fraction, shown.message) == (JobState.RUNNING, "evolve", 0.7, "done")
    blob = local_store.put_bytes(b"labels")
    with database.session() as session:
        artifacts = [NewArtifact("surfaces/1.ply", blob.sha256, blob.size, "model/ply")]
        assert jobs.succeed(session, job.job_id, job.lease, {"objects": [1]}, artifacts)
    shown = view(job.job_id)
    assert (shown.state, shown.fraction, shown.result) == (JobState.SUCCEEDED, 1.0, {"objects": [1]})
    assert [(entry.name, entry.sha256, entry.size) for entry in shown.artifacts] == [
        ("surfaces/1.ply", blob.sha256, blob.size)
    ]
    assert shown.artifacts[0].url == f"/v1/jobs/{job.job_id}/artifacts/surfaces/1.ply"
    assert shown.finished_at is not None
    assert shown.expires_at == shown.finished_at + timedelta(seconds=settings.result_ttl)
    listed = events(job.job_id)
    assert [event.seq for event in listed] == sorted({event.seq for event in listed})
    assert states(listed) == ["queued", "running", "succeeded"]
    # progress that was overtaken within its stage is not kept, the path of stages is
    assert [(event.stage, event.fraction) for event in listed if event.type == "progress"] == [
        ("read", 0.1),
        ("evolve", 0.7),
    ]
    assert events(job.job_id, listed[-2].seq) == listed[-1:]
    assert events(job.job_id, listed[-1].seq) == []


def test_one_of_many_workers_gets_a_job(database: Database, new_job: Callable[..., UUID]) -> None:
    job_id = new_job()
    barrier = threading.Barrier(8)
    got: list[ClaimedJob | None] = []

    def work(number: int) -> None:
        barrier.wait()
        with database.session() as session:
            got.append(jobs.claim(session, job_id, f"worker-{number}"))

    threads = [threading.Thread(target=work, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(got) == 8
    assert sum(job is not None for job in got) == 1


def test_nothing_is_done_without_the_lease(
    database: Database, local_store: ObjectStore, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    job = claimed()
    blob = local_store.put_bytes(b"wrong")
    before = view(job.job_id)
    with database.session() as session:
        wrong = uuid4()
        assert jobs.heartbeat(session, job.job_id, wrong) is None
        assert jobs.report_progress(session, job.job_id, wrong, "evolve", 0.5) is None
        assert not jobs.succeed(session, job.job_id, wrong, {}, [NewArtifact("a", blob.sha256, blob.size)])
        assert not jobs.fail(session, job.job_id, wrong, "internal_error", "")
        assert not jobs.stop(session, job.job_id, wrong)
        assert jobs.crash_or_requeue(session, job.job_id, wrong, "") is None
        assert jobs.release(session, job.job_id, wrong) is None
    assert view(job.job_id) == before


def test_a_failure_tells_its_reason_and_can_be_retried(
    database: Database, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    job = claimed()
    with database.session() as session:
        assert jobs.fail(session, job.job_id, job.lease, "no_object_found", "Nothing found\0.", "Give a seed.")
    shown = view(job.job_id)
    assert shown.state is JobState.FAILED
    assert shown.error is not None
    assert (shown.error.code, shown.error.message, shown.error.hint) == (
        "no_object_found",
        "Nothing found.",
        "Give a seed.",
    )
    assert shown.expires_at is not None
    with database.session() as session:
        jobs.retry(session, "ann", job.job_id)
    shown = view(job.job_id)
    assert (shown.state, shown.error, shown.attempt) == (JobState.QUEUED, None, 0)
    assert shown.started_at is shown.finished_at is shown.expires_at is None
    with database.session() as session:
        again = jobs.claim(session, job.job_id, "worker-2")
        assert again is not None
        assert again.lease != job.lease
        assert jobs.heartbeat(session, job.job_id, job.lease) is None


@pytest.mark.parametrize("result", [{"x": float("inf")}, {"x": {1, 2}}])
def test_a_result_that_is_not_json_is_a_defect_and_changes_nothing(
    database: Database, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView], result: dict[str, Any]
) -> None:
    job = claimed()
    with pytest.raises((ValueError, TypeError)), database.session() as session:
        jobs.succeed(session, job.job_id, job.lease, result, [])
    assert view(job.job_id).state is JobState.RUNNING


@pytest.mark.parametrize("names", [[""], ["/etc/passwd"], ["../x"], ["a/../../x"], ["a" * 256], ["a", "a"], ["a\0"]])
def test_artifacts_need_names_of_their_own(
    database: Database, claimed: Callable[..., ClaimedJob], names: list[str]
) -> None:
    job = claimed()
    with pytest.raises(ValueError, match="artifact"), database.session() as session:
        jobs.succeed(session, job.job_id, job.lease, {}, [NewArtifact(name, "a" * 64, 1) for name in names])


def test_unregistered_error_codes_are_a_defect(database: Database, claimed: Callable[..., ClaimedJob]) -> None:
    job = claimed()
    with pytest.raises(ValueError, match="unregistered"), database.session() as session:
        jobs.fail(session, job.job_id, job.lease, "out_of_luck", "")


# --- cancel


def test_a_waiting_job_is_cancelled_at_once(
    database: Database, new_job: Callable[..., UUID], view: Callable[..., JobView]
) -> None:
    job_id = new_job()
    with database.session() as session:
        assert jobs.cancel(session, "ann", job_id).state is JobState.CANCELLED
    assert view(job_id).finished_at is not None
    with database.session() as session:
        assert jobs.claim(session, job_id, "worker") is None
        with pytest.raises(UserError) as error:
            jobs.cancel(session, "ann", job_id)
        assert error.value.code == "invalid_transition"


def test_a_running_job_is_cancelled_when_its_worker_has_stopped(
    database: Database,
    local_store: ObjectStore,
    claimed: Callable[..., ClaimedJob],
    view: Callable[..., JobView],
    events: Callable[..., list[JobEvent]],
) -> None:
    job = claimed()
    with database.session() as session:
        assert not jobs.stop(session, job.job_id, job.lease), "nobody has cancelled"
    with database.session() as session:
        assert jobs.cancel(session, "ann", job.job_id).state is JobState.CANCELLING
    with database.session() as session:
        assert jobs.cancel(session, "ann", job.job_id).state is JobState.CANCELLING, "twice is no error"
    blob = local_store.put_bytes(b"too late")
    with database.session() as session:
        assert jobs.heartbeat(session, job.job_id, job.lease) is JobState.CANCELLING
        assert not jobs.succeed(session, job.job_id, job.lease, {}, [NewArtifact("a", blob.sha256, blob.size)])
        assert not jobs.fail(session, job.job_id, job.lease, "internal_error", "")
        assert jobs.stop(session, job.job_id, job.lease)
    shown = view(job.job_id)
    assert (shown.state, shown.artifacts, shown.result) == (JobState.CANCELLED, [], None)
    assert states(events(job.job_id)) == ["queued", "running", "cancelling", "cancelled"]


@pytest.mark.parametrize("action", ["retry", "cancel"])
def test_what_the_table_does_not_allow(
    database: Database, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView], action: str
) -> None:
    job = claimed()
    if action == "cancel":
        with database.session() as session:
            assert jobs.succeed(session, job.job_id, job.lease, {}, [])
    before = view(job.job_id)
    with database.session() as session, pytest.raises(UserError) as error:
        getattr(jobs, action)(session, "ann", job.job_id)
    assert error.value.code == "invalid_transition"
    assert view(job.job_id) == before


# --- lost workers


def test_a_silent_worker_loses_its_job_to_another(
    database: Database,
    local_store: ObjectStore,
    settings: Settings,
    claimed: Callable[..., ClaimedJob],
    view: Callable[..., JobView],
) -> None:
    job, lively = claimed(), claimed()
    fall_silent(database, job)
    with database.session() as session:
        lost = jobs.recover_lost(session, settings)
    assert [entry.job_id for entry in lost] == [job.job_id]
    assert (lost[0].kind, lost[0].service) == ("segmentation", "segmentation")
    assert view(lively.job_id).state is JobState.RUNNING
    shown = view(job.job_id)
    assert (shown.state, shown.attempt) == (JobState.QUEUED, 1)
    assert "6 s" in shown.message
    with database.session() as session:
        second = jobs.claim(session, job.job_id, "worker-2")
    assert second is not None
    assert second.attempt == 2
    blobs_ = [local_store.put_bytes(data) for data in (b"of the first", b"of the second")]
    with database.session() as session:
        # the first comes back to life and thinks that it still has the job
        assert jobs.heartbeat(session, job.job_id, job.lease) is None
        assert not jobs.succeed(
            session, job.job_id, job.lease, {"by": 1}, [NewArtifact("a", blobs_[0].sha256, blobs_[0].size)]
        )
    with database.session() as session:
        assert jobs.succeed(
            session, job.job_id, second.lease, {"by": 2}, [NewArtifact("a", blobs_[1].sha256, blobs_[1].size)]
        )
    shown = view(job.job_id)
    assert shown.result == {"by": 2}
    assert [entry.sha256 for entry in shown.artifacts] == [blobs_[1].sha256]


def test_a_job_that_kills_its_workers_crashes_after_the_bounded_number(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    job: ClaimedJob | None = claimed()
    for attempt in range(1, settings.max_attempts + 1):
        assert job is not None
        assert job.attempt == attempt
        fall_silent(database, job)
        with database.session() as session:
            requeued = len(jobs.recover_lost(session, settings))
            assert requeued == (1 if attempt < settings.max_attempts else 0)
        with database.session() as session:
            job = jobs.claim(session, job.job_id, "worker")
    assert job is None
    with database.session(readonly=True) as session:
        page, _ = jobs.list_jobs(session, "ann")
    shown = view(page[0].id)
    assert shown.state is JobState.CRASHED
    assert shown.error is not None
    assert shown.error.code == "worker_lost"
    assert "3 times" in shown.error.message
    # the user may try again, with as many attempts as before
    with database.session() as session:
        jobs.retry(session, "ann", shown.id)
        again = jobs.claim(session, shown.id, "worker")
        assert again is not None
        assert again.attempt == 1


def test_a_fault_of_ours_is_tried_again_and_then_crashes(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    job = claimed()
    for attempt in range(1, settings.max_attempts + 1):
        with database.session() as session:
            state = jobs.crash_or_requeue(session, job.job_id, job.lease, "ZeroDivisionError")
            assert state is (JobState.QUEUED if attempt < settings.max_attempts else JobState.CRASHED)
            if state is JobState.QUEUED:
                following = jobs.claim(session, job.job_id, "worker")
                assert following is not None
                job = following
    shown = view(job.job_id)
    assert shown.error is not None
    assert shown.error.code == "internal_error"
    assert "ZeroDivisionError" in shown.error.message


def test_a_cancelled_job_whose_worker_is_lost_ends_as_cancelled(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    silent, broken, asked_to_go = claimed(), claimed(), claimed()
    with database.session() as session:
        for job in (silent, broken, asked_to_go):
            jobs.cancel(session, "ann", job.job_id)
    fall_silent(database, silent)
    with database.session() as session:
        assert jobs.recover_lost(session, settings) == []
        assert jobs.crash_or_requeue(session, broken.job_id, broken.lease, "oops") is JobState.CANCELLED
        assert jobs.release(session, asked_to_go.job_id, asked_to_go.lease) is JobState.CANCELLED
    for job in (silent, broken, asked_to_go):
        assert view(job.job_id).state is JobState.CANCELLED


def test_a_worker_that_is_asked_to_go_does_not_use_up_an_attempt(
    database: Database, claimed: Callable[..., ClaimedJob]
) -> None:
    job = claimed()
    for _ in range(5):
        with database.session() as session:
            assert jobs.release(session, job.job_id, job.lease) is JobState.QUEUED
            following = jobs.claim(session, job.job_id, "worker")
            assert following is not None
            assert following.attempt == 1
            job = following


def test_reapers_at_the_same_time_give_each_job_back_once(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob]
) -> None:
    lost = [claimed() for _ in range(10)]
    for job in lost:
        fall_silent(database, job)
    barrier = threading.Barrier(4)
    found: list[UUID] = []

    def reap() -> None:
        barrier.wait()
        with database.session() as session:
            found.extend(entry.job_id for entry in jobs.recover_lost(session, settings))

    threads = [threading.Thread(target=reap) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(found) == sorted(job.job_id for job in lost)


def test_a_heartbeat_keeps_the_lease(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob]
) -> None:
    beats = [
        lambda session, job: jobs.heartbeat(session, job.job_id, job.lease),
        lambda session, job: jobs.report_progress(session, job.job_id, job.lease, "evolve", 0.5),
    ]
    for beat in beats:
        job = claimed()
        fall_silent(database, job)
        with database.session() as session:
            assert beat(session, job) is JobState.RUNNING
        with database.session() as session:
            assert jobs.recover_lost(session, settings) == []


# --- artifacts


def test_artifacts_are_found_by_name(
    database: Database, local_store: ObjectStore, claimed: Callable[..., ClaimedJob]
) -> None:
    job = claimed()
    blob = local_store.put_bytes(b"labels")
    with database.session() as session:
        assert jobs.succeed(session, job.job_id, job.lease, {}, [NewArtifact("labels.nii.gz", blob.sha256, blob.size)])
    with database.session(readonly=True) as session:
        found = jobs.artifact(session, "ann", job.job_id, "labels.nii.gz")
        assert isinstance(found, JobArtifact)
        assert (found.sha256, found.size) == (blob.sha256, blob.size)
        with pytest.raises(UserError) as error:
            jobs.artifact(session, "ann", job.job_id, "other")
        assert error.value.code == "not_found"


@pytest.mark.parametrize("fraction", [float("nan"), -1.0, 2.0])
def test_fractions_stay_between_nothing_and_all(
    database: Database, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView], fraction: float
) -> None:
    job = claimed()
    with database.session() as session:
        jobs.report_progress(session, job.job_id, job.lease, "x" * 100, fraction, "y" * 10_000)
    shown = view(job.job_id)
    assert 0.0 <= shown.fraction <= 1.0
    assert len(shown.stage) == 64
    assert len(shown.message) == 4000

"""How jobs end that nobody disturbs, on both databases."""

from __future__ import annotations

import hashlib
import time

import pytest

from shapery_contracts.states import JobState
from shapery_platform.db.models import Job
from shapery_platform.storage import object_key
from shapery_worker.lifeline import alive
from tests.support import measures
from tests.support.stack import Stack, expected_end

pytestmark = pytest.mark.server

CUBE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def test_a_job_leaves_its_result_and_its_artifacts(shared_stack: Stack) -> None:
    first, second, third = (shared_stack.upload(CUBE + b"#%d\n" % i, "Shape.OBJ") for i in range(3))
    artifacts = {"report.json": 100, "surfaces/1.ply": 70_000, "empty.txt": 0}
    job_id = shared_stack.submit(
        inputs={"data": [first, second], "other": third}, artifacts=artifacts, seed=5, steps=3, step_seconds=0.3
    )
    job = shared_stack.wait(job_id)
    expected_end(job, artifacts=artifacts, seed=5, stack=shared_stack)
    assert {artifact.name: artifact.media_type for artifact in job.artifacts} == {
        "report.json": "application/json",
        "surfaces/1.ply": "application/x-ply",
        "empty.txt": "text/plain",
    }
    digests = [hashlib.sha256(CUBE + b"#%d\n" % i).hexdigest() for i in range(3)]
    assert job.result is not None
    # several files lie in a folder under the names they were uploaded with; a single one has the usual extension
    assert job.result["inputs"] == {
        "data": {"data/Shape.OBJ": digests[0], "data/00001.obj": digests[1]},
        "other": {"other.obj": digests[2]},
    }
    assert job.attempt == 1
    assert job.expires_at is not None


def test_progress_is_told_in_order_and_ends_at_one(shared_stack: Stack) -> None:
    job_id = shared_stack.submit(steps=6, step_seconds=0.3)
    assert shared_stack.wait(job_id).fraction == 1.0
    events = shared_stack.events(job_id)
    assert [event.state for event in events if event.type == "state"] == [
        JobState.QUEUED,
        JobState.RUNNING,
        JobState.SUCCEEDED,
    ]
    told = [event for event in events if event.type == "progress"]
    assert len(told) >= 2
    assert [event.fraction for event in told] == sorted(event.fraction for event in told)
    assert told[-1].stage == "step 6"
    assert told[-1].message == "step 6 of 6"


def test_what_a_handler_cannot_mend_ends_as_crashed_and_what_a_user_can_as_failed(shared_stack: Stack) -> None:
    ends = {
        "user_error": (JobState.FAILED, "no_object_found", "There are 0 objects", 1),
        "raise": (JobState.CRASHED, "internal_error", "RuntimeError: the probe was asked to raise", 3),
        "exit": (JobState.CRASHED, "internal_error", "SystemExit", 3),
        "memory_error": (JobState.CRASHED, "internal_error", "out of memory", 3),
        "wrong_result": (JobState.CRASHED, "internal_error", "ValidationError", 3),
        "link": (JobState.CRASHED, "internal_error", "'link' is not a regular file", 3),
    }
    job_ids = {action: shared_stack.submit(action=action, artifacts={"a.json": 10}) for action in ends}
    for action, (state, code, message, attempts) in ends.items():
        job = shared_stack.wait(job_ids[action])
        assert job.error is not None, job
        assert (job.state, job.error.code, job.attempt) == (state, code, attempts)
        assert message in job.error.message
        assert job.artifacts == []
    log = shared_stack.logs(10_000)
    assert 'raise RuntimeError("the probe was asked to raise")' in log  # the traceback is for the operator


def test_limits_end_a_job_and_say_so(shared_stack: Stack) -> None:
    slow = shared_stack.submit("probe-brief", action="hold_interpreter")
    hungry = shared_stack.submit("probe-lean", action="eat_memory", mebibytes=3000)
    job = shared_stack.wait(slow)
    assert job.state is JobState.FAILED
    assert job.error is not None
    assert job.error.code == "time_limit_exceeded"
    assert "1 s" in job.error.message
    job = shared_stack.wait(hungry)
    assert job.state is JobState.FAILED
    assert job.error is not None
    assert job.error.code == "memory_limit_exceeded"
    assert "400 MiB" in job.error.message


@pytest.mark.parametrize("manner", ["between steps", "in native code"])
def test_a_cancel_stops_the_work(shared_stack: Stack, manner: str) -> None:
    if manner == "between steps":
        job_id = shared_stack.submit(steps=600, step_seconds=0.1)
    else:
        job_id = shared_stack.submit(steps=1, action="hold_interpreter")
    handler = shared_stack.wait_until_running(job_id)
    began = time.monotonic()
    shared_stack.cancel(job_id)
    job = shared_stack.wait(job_id, 30)
    measures.record(f"cancel {manner}", time.monotonic() - began)
    assert job.state is JobState.CANCELLED
    shared_stack.until(lambda: handler not in shared_stack.running().values(), "the folder is removed", 10)
    assert job.artifacts == []


def test_a_handler_has_surroundings_of_its_own(shared_stack: Stack) -> None:
    job = shared_stack.wait(shared_stack.submit(action="see_context"))
    assert job.result is not None
    seen = job.result["seen"]
    # neither a connection of the worker nor its database is open in it, and it leads a session of its own
    assert (seen["sockets"], seen["database"], seen["leader"]) == ("0", "0", "True")
    assert seen["folder"] == seen["scratch"] == seen["temporary"]
    assert seen["numba"] == "workqueue"
    assert int(seen["threads"]) >= 1
    assert int(seen["nice"]) >= 5
    assert seen["handler"] == "0"  # SIG_DFL


def test_what_a_handler_prints_is_logged_under_its_job(shared_stack: Stack) -> None:
    job_id = shared_stack.submit(action="print")
    assert shared_stack.wait(job_id).state is JobState.SUCCEEDED
    lines = [line for line in shared_stack.logs(10_000).splitlines() if str(job_id) in line]
    assert any("the probe prints to standard output" in line for line in lines)
    assert any("native output without an end of line" in line for line in lines)
    assert any("\\xff not text" in line for line in lines)
    assert max(len(line) for line in lines) < 5000


def test_what_a_handler_left_running_ends_with_it(shared_stack: Stack) -> None:
    job = shared_stack.wait(shared_stack.submit(action="spawn"))
    assert job.state is JobState.SUCCEEDED
    assert job.result is not None
    child = int(job.result["seen"]["child"])
    shared_stack.until(lambda: not alive(child), "the handler's child is gone", 10)


def test_a_missing_input_fails_the_job(shared_stack: Stack) -> None:
    asset = shared_stack.upload(CUBE + b"# soon gone\n")
    job_id = shared_stack.submit(inputs={"data": asset}, enqueue=False)
    shared_stack.store.delete(object_key(hashlib.sha256(CUBE + b"# soon gone\n").hexdigest()))
    job = shared_stack.wait(job_id)  # its message is sent by the reaper
    assert job.state is JobState.FAILED
    assert job.error is not None
    assert job.error.code == "input_expired"
    assert "shape.obj" in job.error.message


def test_damaged_input_is_never_computed_with(shared_stack: Stack) -> None:
    data = CUBE + b"# soon damaged\n"
    asset = shared_stack.upload(data)
    path = shared_stack.home / "objects" / object_key(hashlib.sha256(data).hexdigest())
    job_id = shared_stack.submit(inputs={"data": asset}, enqueue=False)
    path.chmod(0o644)
    path.write_bytes(data[:-2] + b"!\n")
    job = shared_stack.wait(job_id)
    assert job.state is JobState.CRASHED
    assert job.error is not None
    assert "SHA-256" in job.error.message


def test_a_result_waits_for_a_store_that_is_away(shared_stack: Stack) -> None:
    objects = shared_stack.home / "objects"
    away = objects.rename(shared_stack.home / "away")
    try:
        job_id = shared_stack.submit(artifacts={"a.json": 100}, seed=9)
        shared_stack.until(
            lambda: "storing 'a.json' failed and is tried again" in shared_stack.logs(10_000), "it fails"
        )
        assert shared_stack.view(job_id).state is JobState.RUNNING
    finally:
        away.rename(objects)
    job = shared_stack.wait(job_id)
    expected_end(job, artifacts={"a.json": 100}, seed=9, stack=shared_stack)
    assert job.attempt == 1


def test_a_message_that_comes_twice_or_for_nothing_does_nothing(shared_stack: Stack) -> None:
    from uuid import uuid4

    from shapery_platform.queue import enqueue

    job_id = shared_stack.submit(artifacts={"a.json": 10})
    for _ in range(5):
        enqueue(shared_stack.celery, job_id, "probe")
        enqueue(shared_stack.celery, uuid4(), "probe")
    assert shared_stack.wait(job_id).state is JobState.SUCCEEDED
    probe_after = shared_stack.submit()  # the queue goes on after all of them
    assert shared_stack.wait(probe_after).state is JobState.SUCCEEDED
    job = shared_stack.view(job_id)
    assert job.attempt == 1
    states = [event.state for event in shared_stack.events(job_id) if event.type == "state"]
    assert states == [JobState.QUEUED, JobState.RUNNING, JobState.SUCCEEDED]


def test_nothing_is_left_on_the_disk_or_in_the_rows(shared_stack: Stack) -> None:
    from sqlalchemy import select

    job_ids = [shared_stack.submit(artifacts={"a.json": 100}, seed=seed) for seed in range(6)]
    for seed, job in enumerate(shared_stack.wait_all(job_ids)):
        expected_end(job, artifacts={"a.json": 100}, seed=seed, stack=shared_stack)
    shared_stack.until(lambda: not shared_stack.running(), "all folders are removed", 10)
    with shared_stack.database.session(readonly=True) as session:
        rows = session.scalars(select(Job).where(Job.state.in_([JobState.RUNNING, JobState.CANCELLING]))).all()
        assert rows == []

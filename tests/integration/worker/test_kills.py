"""What becomes of jobs whose processes are killed, one sort of kill at a time; `tests/e2e/test_chaos.py` mixes them."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import psutil
import pytest

from shapery_contracts.states import JobState
from shapery_worker.lifeline import alive
from tests.support import measures
from tests.support.stack import Stack, expected_end

pytestmark = pytest.mark.server

ARTIFACTS = {"a.json": 1000, "b.ply": 5000}


@pytest.mark.parametrize("victim", ["self", "watcher", "main"])
def test_a_job_whose_process_was_killed_is_done_by_another_once(
    robust_stack: Stack, tmp_path: Path, victim: str
) -> None:
    began = time.monotonic()
    job_id = robust_stack.submit(action="kill", victim=victim, once=str(tmp_path / "killed"), artifacts=ARTIFACTS)
    job = robust_stack.wait(job_id)
    measures.record(f"kill of {victim}: from submission to success", time.monotonic() - began)
    expected_end(job, artifacts=ARTIFACTS, seed=0, stack=robust_stack)
    assert job.attempt == 2
    states = [event.state for event in robust_stack.events(job_id) if event.type == "state"]
    assert states == [JobState.QUEUED, JobState.RUNNING, JobState.QUEUED, JobState.RUNNING, JobState.SUCCEEDED]


def test_what_a_killed_attempt_showed_goes_and_the_next_one_shows_its_own(robust_stack: Stack) -> None:
    stack = robust_stack
    job_id = stack.submit(steps=20, step_seconds=0.1, previews=True)
    stack.until(lambda: stack.preview(job_id) is not None, "something is shown")
    first = stack.preview(job_id)
    assert first is not None
    handler = stack.running()[job_id]
    assert f'"process": {handler}'.encode() in first.data
    os.kill(psutil.Process(handler).ppid(), signal.SIGKILL)
    stack.until(lambda: stack.preview(job_id, first.number) is not None, "the next attempt shows something")
    second = stack.preview(job_id, first.number)
    assert second is not None
    assert f'"process": {stack.running()[job_id]}'.encode() in second.data
    assert stack.wait(job_id).state is JobState.SUCCEEDED
    assert stack.preview(job_id) is None


def test_poisonous_jobs_end_as_crashed_and_stop_nobody_else(robust_stack: Stack) -> None:
    stack = robust_stack
    innocent = [stack.submit(artifacts=ARTIFACTS, seed=i, steps=2, step_seconds=0.3) for i in range(4)]
    poison = [stack.submit(action="kill", victim=victim) for victim in ("self", "watcher", "main")]
    innocent += [stack.submit(artifacts=ARTIFACTS, seed=i, steps=2, step_seconds=0.3) for i in range(4, 8)]
    with measures.measured("three poisonous jobs among eight others"):
        poisoned = stack.wait_all(poison)
        others = stack.wait_all(innocent)
    for job in poisoned:
        assert job.state is JobState.CRASHED
        assert job.attempt == 3
        assert job.error is not None
        assert job.error.code in ("internal_error", "worker_lost")
        assert job.artifacts == []
    for seed, job in enumerate(others):
        expected_end(job, artifacts=ARTIFACTS, seed=seed, stack=stack)
        # lost at most once beside a poisonous job, and tried alone from then on
        assert job.attempt <= 2


def test_jobs_that_kill_the_whole_worker_are_bounded_too(stack: Stack, tmp_path: Path) -> None:
    stack.start_reaper()
    # one does it once, and one whenever it runs
    once = stack.submit(action="kill", victim="group", once=str(tmp_path / "killed"), artifacts=ARTIFACTS)
    poison = stack.submit(action="kill", victim="group")
    starts = 0
    while not (stack.view(once).state.terminal and stack.view(poison).state.terminal):
        worker = stack.start_worker(wait=False)  # as a supervisor does
        starts += 1
        stack.until(
            lambda w=worker: (
                w.poll() is not None or (stack.view(once).state.terminal and stack.view(poison).state.terminal)
            ),
            "the worker is killed again or both jobs end",
        )
    assert stack.view(poison).state is JobState.CRASHED
    assert stack.view(poison).attempt == 3
    expected_end(stack.view(once), artifacts=ARTIFACTS, seed=0, stack=stack)
    assert starts <= 5


def test_what_a_handler_had_started_is_ended_when_its_watcher_was_killed(robust_stack: Stack, tmp_path: Path) -> None:
    stack = robust_stack
    job_id = stack.submit(action="spawn_and_wait", once=str(tmp_path / "once"), steps=1)
    handler = psutil.Process(stack.wait_until_running(job_id))
    stack.until(lambda: bool(handler.children()), "it has started a process", 20)
    child = handler.children()[0]
    os.kill(handler.ppid(), signal.SIGKILL)
    assert stack.wait(job_id).state is JobState.SUCCEEDED
    stack.until(lambda: not alive(child.pid), "the handler's child is gone", 10)


def test_a_worker_that_was_taken_for_lost_publishes_nothing(stack: Stack, tmp_path: Path) -> None:
    """Stop the watcher as a paused machine would, until another has done the job, and let it go on."""
    stack.start_worker(concurrency=1)
    stack.start_reaper()
    job_id = stack.submit(steps=1, step_seconds=1.0, artifacts=ARTIFACTS, started=str(tmp_path))
    watcher = psutil.Process(stack.wait_until_running(job_id)).parent()
    assert watcher is not None
    watcher.suspend()
    second = stack.start_worker(concurrency=1)
    job = stack.wait(job_id)
    expected_end(job, artifacts=ARTIFACTS, seed=0, stack=stack)
    assert job.attempt == 2
    events = stack.events(job_id)
    watcher.resume()
    # it finds its lease lost, forgets the result, and is as good as new
    stack.until(lambda: not stack.running(), "the first attempt is cleared away", 20)
    second.send_signal(signal.SIGTERM)
    second.wait(20)
    again = stack.wait(stack.submit(artifacts=ARTIFACTS, seed=1))
    expected_end(again, artifacts=ARTIFACTS, seed=1, stack=stack)
    assert stack.view(job_id) == job
    assert stack.events(job_id) == events


def test_a_cancelled_job_whose_worker_dies_ends_as_cancelled(stack: Stack) -> None:
    worker = stack.start_worker(concurrency=1)
    stack.start_reaper()
    job_id = stack.submit(steps=1, action="hold_interpreter")
    stack.wait_until_running(job_id)
    main = stack.celery_main(worker)
    assert main is not None
    below = [main, *main.children(recursive=True)]
    assert len(below) >= 3
    for process in below:
        process.suspend()  # so that nobody can stop it in order
    stack.cancel(job_id)
    assert stack.view(job_id).state is JobState.CANCELLING
    worker.kill()
    worker.wait(10)
    assert stack.wait(job_id).state is JobState.CANCELLED
    # what the host had started went with it, level by level
    stack.until(lambda: not any(alive(process.pid) for process in below), "its processes are gone", 10)


def test_shutdown_finishes_short_jobs_and_gives_long_ones_back(stack: Stack, tmp_path: Path) -> None:
    worker = stack.start_worker(concurrency=2, SHAPERY_WORKER_SHUTDOWN_GRACE="2")
    short = stack.submit(steps=3, step_seconds=0.3, artifacts=ARTIFACTS)
    long = stack.submit(steps=600, step_seconds=0.1, once=str(tmp_path / "once"), artifacts=ARTIFACTS)
    stack.wait_until_running(short)
    stack.wait_until_running(long)
    with measures.measured("shutdown with a long job, grace 2 s"):
        worker.send_signal(signal.SIGTERM)
        assert worker.wait(30) == 0
    assert stack.view(short).state is JobState.SUCCEEDED
    assert stack.view(long).state is JobState.QUEUED
    assert stack.view(long).attempt == 0  # it is nobody's fault
    assert not stack.is_listed(worker)
    stack.start_worker()
    job = stack.wait(long)  # without a reaper: the worker that gave it back sent its message
    expected_end(job, artifacts=ARTIFACTS, seed=0, stack=stack)
    assert job.attempt == 1

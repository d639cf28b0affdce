"""Redis comes and goes; jobs neither get lost nor wait for the broker's own timeouts."""

from __future__ import annotations

import time

import pytest

from shapery_contracts.states import JobState
from tests.support import measures
from tests.support.redis import RedisServer
from tests.support.stack import Stack, expected_end

pytestmark = pytest.mark.server

ARTIFACTS = {"a.json": 1000}


def test_jobs_run_on_while_redis_is_away_and_the_worker_comes_back(stack: Stack, redis: RedisServer) -> None:
    stack.start_worker(concurrency=1)
    stack.start_reaper()
    # At the very end of a job its message is acknowledged: killed in that moment, Redis used to leave a deaf worker.
    for _ in range(3):
        assert stack.wait(stack.submit()).state is JobState.SUCCEEDED
        redis.kill()
        redis.start()
        began = time.monotonic()
        assert stack.wait(stack.submit()).state is JobState.SUCCEEDED
        measures.record("kill of Redis under an idle worker: until a job is done", time.monotonic() - began)
    for round_ in range(2):
        running = stack.submit(steps=8, step_seconds=0.25, artifacts=ARTIFACTS, seed=round_)
        stack.wait_until_running(running)
        redis.kill()
        waiting = stack.submit(artifacts=ARTIFACTS, seed=round_)  # its message cannot be sent
        assert stack.view(waiting).state is JobState.QUEUED
        time.sleep(1.0)
        redis.start()
        began = time.monotonic()
        job = stack.wait(waiting)
        measures.record("restart of Redis: until the next job is done", time.monotonic() - began)
        expected_end(job, artifacts=ARTIFACTS, seed=round_, stack=stack)
        first = stack.wait(running)
        expected_end(first, artifacts=ARTIFACTS, seed=round_, stack=stack)
        assert first.attempt == job.attempt == 1


def test_messages_that_redis_lost_are_sent_again(stack: Stack, redis: RedisServer) -> None:
    stack.start_worker(concurrency=1)
    stack.start_reaper()
    running = stack.submit(steps=4, step_seconds=0.5)
    stack.wait_until_running(running)
    jobs = [stack.submit(artifacts=ARTIFACTS, seed=seed) for seed in range(5)]
    redis.clear()  # everything, under the connections of all
    began = time.monotonic()
    assert stack.wait(running).state is JobState.SUCCEEDED
    for seed, job in enumerate(stack.wait_all(jobs)):
        expected_end(job, artifacts=ARTIFACTS, seed=seed, stack=stack)
    measures.record("all messages lost: until all jobs are done", time.monotonic() - began)


def test_jobs_without_a_message_are_found_and_several_reapers_get_along(stack: Stack) -> None:
    jobs = [stack.submit(artifacts=ARTIFACTS, seed=seed, enqueue=False) for seed in range(12)]
    stack.start_worker()
    for _ in range(2):
        stack.start_reaper()
    for seed, job in enumerate(stack.wait_all(jobs)):
        expected_end(job, artifacts=ARTIFACTS, seed=seed, stack=stack)
        assert job.attempt == 1

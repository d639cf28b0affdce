"""``shapery-worker up``: everything starts, is kept running, and goes together."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from shapery_contracts.states import JobState
from shapery_worker.supervisor.lock import read_record
from tests.support import measures
from tests.support.platform import platform
from tests.support.stack import expected_end, processes_of

pytestmark = pytest.mark.server

ARTIFACTS = {"a.json": 1000}


def test_once_tries_everything_and_exits(tmp_path: Path) -> None:
    with platform(tmp_path) as tried:
        assert tried.start("--once", "--service", "probe").wait(120) == 0
        assert "Shapery was ready at http://127.0.0.1:" in (tmp_path / "up.log").read_text()


def test_a_platform_is_kept_running_and_stops_within_seconds(tmp_path: Path) -> None:
    with platform(tmp_path, lease_seconds=3.0, heartbeat_interval=0.5) as running:
        stack = running.stack
        began = time.monotonic()
        running.start()
        record = running.wait_until_ready()
        measures.record("start of everything", time.monotonic() - began)
        assert set(record.processes) >= {
            "redis", "gateway", "reaper", "worker-segmentation", "worker-retrieval", "worker-motion", "worker-probe",
        }  # fmt: skip
        assert stack.wait(stack.submit(artifacts=ARTIFACTS)).state is JobState.SUCCEEDED

        # a second one on the same home is refused, and says by whom
        second = subprocess.run(
            [sys.executable, "-m", "shapery_worker", "up", "--home", tmp_path, "--port", "0"],
            env={**os.environ, **stack.environment},
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert second.returncode == 1
        assert f"process {running.pid}" in second.stderr
        assert record.address in second.stderr

        # what dies is started again, with another process, and the platform works on
        for name in ("redis", "worker-probe", "gateway", "reaper"):
            os.kill(record.processes[name].pid, signal.SIGKILL)
        stack.until(
            lambda: (
                (now := read_record(tmp_path)) is not None
                and all(
                    now.processes.get(name, record.processes[name]).pid != record.processes[name].pid
                    for name in ("redis", "worker-probe", "gateway", "reaper")
                )
            ),
            "everything was started again",
        )
        job = stack.wait(stack.submit(artifacts=ARTIFACTS, seed=1))
        expected_end(job, artifacts=ARTIFACTS, seed=1, stack=stack)

        # a stop gives the running job back; all that was queued goes on after the next start
        long = stack.submit(steps=600, step_seconds=0.1, once=str(tmp_path / "once"), artifacts=ARTIFACTS)
        queued = [stack.submit(artifacts=ARTIFACTS, seed=seed) for seed in range(2, 6)]
        stack.wait_until_running(long)
        began = time.monotonic()
        running.stop()
        measures.record("stop of everything with a running job", time.monotonic() - began)
        assert stack.view(long).state is JobState.QUEUED
        assert processes_of(tmp_path) == []
        running.start("--service", "probe")
        for seed, job_id in enumerate([long, *queued]):
            job = stack.wait(job_id)
            expected_end(job, artifacts=ARTIFACTS, seed=seed and seed + 1, stack=stack)
            assert job.attempt == 1


def test_nothing_survives_a_killed_supervisor_and_the_next_one_continues(tmp_path: Path) -> None:
    with platform(tmp_path, lease_seconds=3.0, heartbeat_interval=0.5) as running:
        stack = running.stack
        running.start("--service", "probe")
        record = running.wait_until_ready()
        # The first is long enough to be seen running.
        steps = (12, *[2] * 5)
        jobs = [stack.submit(artifacts=ARTIFACTS, seed=seed, steps=steps[seed], step_seconds=0.3) for seed in range(6)]
        stack.wait_until_running(jobs[0])
        os.kill(running.pid, signal.SIGKILL)
        began = time.monotonic()
        assert running.process is not None
        running.process.wait(10)
        stack.until(lambda: not processes_of(tmp_path), "all of its processes are gone", 10)
        measures.record("kill of the supervisor: until all of its processes are gone", time.monotonic() - began)
        assert all(mark.find() is None for mark in record.processes.values())
        running.start("--service", "probe")
        for seed, job in enumerate(stack.wait_all(jobs)):
            expected_end(job, artifacts=ARTIFACTS, seed=seed, stack=stack)
            assert job.attempt <= 2
        measures.record("kill of the supervisor: until all jobs are done", time.monotonic() - began)


def test_a_taken_port_is_refused_in_a_sentence(tmp_path: Path) -> None:
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        done = subprocess.run(
            [sys.executable, "-m", "shapery_worker", "up", "--home", tmp_path, "--port", str(port)],
            env={**os.environ, "SHAPERY_PLUGINS": ""},
            capture_output=True,
            text=True,
            timeout=60,
        )
    assert done.returncode == 1
    assert f"Port {port}" in done.stderr
    assert "Traceback" not in done.stderr

"""Everything is killed, again and again in the middle of jobs, and yet each job is done once.

The schedule is seeded. Kills hit the handler's process, the Celery child that watches it, Celery's main process, the
worker's whole group, Redis, the gateway, the reaper and the supervisor, while jobs are submitted over HTTP.
"""

from __future__ import annotations

import contextlib
import os
import random
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import Any
from uuid import UUID

import httpx
import psutil
import pytest

from shapery_contracts.api import JobView
from shapery_contracts.states import JobState
from shapery_platform import retention
from shapery_platform.db import utc_now
from shapery_platform.storage import object_key
from shapery_worker.supervisor.lock import read_record
from tests.support import measures, probe
from tests.support.platform import Platform, platform
from tests.support.postgres import postgres_server
from tests.support.stack import expected_end, processes_of

pytestmark = [pytest.mark.server, pytest.mark.slow]

LEAST_JOBS, MOST_JOBS = 30, 150
KILLS = ("handler", "child", "main", "group", "redis", "gateway", "reaper", "handler", "child", "group", "supervisor")


class Victims:
    """The processes of a running platform, found anew before each kill."""

    def __init__(self, running: Platform, rng: random.Random) -> None:
        self._running = running
        self._rng = rng
        self.done: Counter[str] = Counter()

    def kill(self, victim: str) -> None:
        """Kill one process of a sort in the middle of a job; what was killed before may have to come back first."""
        before = sum(self.done.values())
        deadline = time.monotonic() + 40
        while sum(self.done.values()) == before and time.monotonic() < deadline:
            if self._running.stack.running():
                self._try(victim)
            time.sleep(0.02)

    def _try(self, victim: str) -> None:
        if victim == "supervisor":
            self._kill_supervisor()
        elif victim in ("redis", "gateway", "reaper"):
            self._send(victim, self._supervised(victim), os.kill)
        elif victim == "group":
            self._send(victim, self._supervised("worker-probe"), os.killpg)
        else:
            self._send(victim, self._of_worker(victim), os.kill)

    def _supervised(self, name: str) -> int | None:
        record = read_record(self._running.home)
        process = record.processes[name].find() if record and name in record.processes else None
        return process.pid if process else None

    def _of_worker(self, victim: str) -> int | None:
        handlers = sorted(self._running.stack.running().values())
        if not handlers:
            return None
        chain = {"handler": 0, "child": 1, "main": 2}
        try:
            process: psutil.Process | None = psutil.Process(self._rng.choice(handlers))
            for _ in range(chain[victim]):
                process = process.parent() if process else None
        except psutil.Error:
            return None
        return process.pid if process and process.pid > 1 else None

    def _send(self, victim: str, pid: int | None, send: Callable[[int, int], None]) -> None:
        if pid is not None:
            with contextlib.suppress(ProcessLookupError):
                send(pid, signal.SIGKILL)
                self.done[victim] += 1

    def _kill_supervisor(self) -> None:
        process = self._running.process
        assert process is not None
        process.kill()
        process.wait()
        self._running.start("--service", "probe")
        self.done["supervisor"] += 1


class Submitter(threading.Thread):
    """Submits jobs over HTTP until told to stop, and again under the same key when the gateway did not answer."""

    def __init__(self, home: Path, rng: random.Random) -> None:
        super().__init__(daemon=True)
        self._home = home
        self._rng = rng
        self._enough = threading.Event()
        self.accepted: dict[UUID, dict[str, Any]] = {}
        """The parameters of the jobs by their ids."""
        self.failures: list[str] = []
        self.repeated = 0

    def finish(self) -> None:
        """Stop once a least number of jobs was accepted."""
        self._enough.set()
        self.join(120)

    def run(self) -> None:
        """Submit."""
        for number in range(MOST_JOBS):
            if number >= LEAST_JOBS and self._enough.is_set():
                return
            params = self._params()
            deadline = time.monotonic() + 90
            while (job_id := self._submit(number, params)) is None:
                self.repeated += 1
                if self.failures or time.monotonic() > deadline:
                    self.failures.append(f"job {number} was not accepted")
                    return
                time.sleep(0.2)
            if job_id in self.accepted:
                self.failures.append(f"job {number} is another one's")
            self.accepted[job_id] = params
            time.sleep(0.2)

    def _params(self) -> dict[str, Any]:
        """Return the parameters of a job that takes about a second; some leave the same bytes as others."""
        rng = self._rng
        return {
            "steps": rng.randint(1, 5),
            "step_seconds": 0.25,
            "seed": rng.randrange(12),
            "artifacts": {f"part {i}.json": rng.choice([0, 10, 5_000, 200_000]) for i in range(rng.randint(1, 3))},
        }

    def _submit(self, number: int, params: dict[str, Any]) -> UUID | None:
        record = read_record(self._home)
        if record is None:
            return None
        try:
            answer = httpx.post(
                f"{record.address}/v1/jobs",
                json={"kind": "probe", "inputs": {}, "params": params},
                headers={"Idempotency-Key": f"chaos-{number}"},
                timeout=10,
            )
        except httpx.TransportError:
            return None
        if answer.status_code >= 500:
            return None
        if answer.status_code not in (200, 202):
            self.failures.append(answer.text)
            return None
        return UUID(answer.json()["id"])


@pytest.mark.timeout(280)
@pytest.mark.parametrize(("sort", "seed"), [("sqlite", 1), ("postgresql", 2)])
def test_every_job_is_done_once_whatever_is_killed(tmp_path: Path, sort: str, seed: int) -> None:
    rng = random.Random(seed)
    with contextlib.ExitStack() as stack:
        url = stack.enter_context(postgres_server()).create_database() if sort == "postgresql" else None
        running = stack.enter_context(
            platform(
                tmp_path,
                url,
                lease_seconds=3.0,
                heartbeat_interval=0.5,
                # enough for whoever is hit often: here only the kills are to blame
                max_attempts=40,
                rate_limit_per_minute=0,
            )
        )
        running.stack.environment["SHAPERY_WORKER_CONCURRENCY"] = "3"
        running.start("--service", "probe")
        running.wait_until_ready()
        submitter = Submitter(tmp_path, random.Random(seed))
        victims = Victims(running, rng)
        began = time.monotonic()
        submitter.start()
        schedule = list(KILLS)
        rng.shuffle(schedule)
        for victim in schedule:
            time.sleep(rng.uniform(0.2, 1.0))
            victims.kill(victim)
        last_kill = time.monotonic()
        submitter.finish()
        assert submitter.failures == []
        ended = running.stack.wait_all(submitter.accepted, 120)
        measures.record(
            f"chaos on {sort}",
            time.monotonic() - began,
            after_the_last_kill=round(time.monotonic() - last_kill, 1),
            kills=dict(victims.done),
            requests_repeated=submitter.repeated,
            jobs=len(ended),
            attempts=dict(Counter(job.attempt for job in ended)),
        )
        assert victims.done == Counter(KILLS)
        check_ends(running, ended, submitter.accepted)
        check_over_http(running, ended)
        running.stop()
        assert processes_of(tmp_path) == []
        check_blobs(running, ended)


def check_ends(running: Platform, ended: list[JobView], accepted: dict[UUID, dict[str, Any]]) -> None:
    """Each job succeeded, once, with the artifacts it was asked for."""
    assert len(ended) == len(accepted) >= LEAST_JOBS
    for job in ended:
        params = accepted[job.id]
        expected_end(job, artifacts=params["artifacts"], seed=params["seed"], stack=running.stack)
        states = [event.state for event in running.stack.events(job.id) if event.type == "state"]
        assert states.count(JobState.SUCCEEDED) == 1
        assert states[-1] is JobState.SUCCEEDED
        assert states.count(JobState.RUNNING) == states.count(JobState.QUEUED)


def check_over_http(running: Platform, ended: list[JobView]) -> None:
    """The gateway that has survived tells the same, and hands out the bytes."""
    record = read_record(running.home)
    assert record is not None
    with httpx.Client(base_url=record.address, timeout=20) as client:
        job = next(job for job in ended if job.artifacts)
        assert JobView.model_validate(client.get(f"/v1/jobs/{job.id}").raise_for_status().json()) == job
        artifact = job.artifacts[0]
        data = client.get(artifact.url, follow_redirects=True).raise_for_status().content
        assert data == probe.artifact_bytes(job.params["seed"], artifact.name, artifact.size)


def check_blobs(running: Platform, ended: list[JobView]) -> None:
    """Once all pins have passed, the store holds what jobs refer to, every byte of it, and nothing else."""
    stack = running.stack
    for _ in range(2):
        retention.run_once(stack.database, stack.store, stack.settings, now=utc_now() + timedelta(hours=3))
    kept = {entry.key for entry in stack.store.list("objects")}
    assert kept == {object_key(artifact.sha256) for job in ended for artifact in job.artifacts}
    for job in ended:
        assert stack.artifacts(job) == {
            a.name: probe.artifact_bytes(job.params["seed"], a.name, a.size) for a in job.artifacts
        }

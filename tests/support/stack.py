"""Workers, reaper, queue and database as real processes, for tests that ask what becomes of jobs.

::

    with running_stack(folder, database_url, redis) as stack:
        stack.start_worker(concurrency=2)
        stack.start_reaper()
        job = stack.submit(artifacts={"a.json": 10})
        stack.wait(job).state
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from uuid import UUID

import psutil
import redis

from shapery_contracts.api import JobCreate, JobEvent, JobView
from shapery_contracts.formats import AssetKind, FileFormat
from shapery_contracts.states import JobState
from shapery_platform import assets, dispatch, jobs
from shapery_platform.db import Database
from shapery_platform.queue import connect, make_celery, queue_lengths
from shapery_platform.settings import Settings, load_settings
from shapery_platform.storage import object_key
from shapery_platform.storage.opening import open_store
from shapery_worker.scratch import Ownership
from shapery_worker.settings import scratch_root
from tests.conftest import ROOT
from tests.support import probe, processes
from tests.support.redis import RedisServer

OWNER = "local"
MESH = FileFormat(kind=AssetKind.MESH, format="obj", media_type="model/obj", extension=".obj")


class Stack:
    """One database, queue and store, the workers and reapers started on them, and a client to them."""

    def __init__(
        self,
        home: Path,
        database_url: str,
        redis_url: str,
        *,
        plugins: Sequence[str] = (probe.MODULE,),
        **settings: Any,
    ) -> None:
        self.home = home
        self.settings: Settings = load_settings(
            home=home,
            database_url=database_url,
            redis_url=redis_url,
            plugins=list(plugins),
            min_free_bytes=0,
            **settings,
        )
        self.environment = {
            "PYTHONPATH": str(ROOT),
            "SHAPERY_HOME": str(home),
            "SHAPERY_DATABASE_URL": database_url,
            "SHAPERY_REDIS_URL": redis_url,
            "SHAPERY_PLUGINS": ",".join(plugins),
            "SHAPERY_MIN_FREE_BYTES": "0",
            **{f"SHAPERY_{name.upper()}": _text(value) for name, value in settings.items()},
        }
        self.database = Database(self.settings.database_url)
        self.celery = make_celery(self.settings)
        self.store = open_store(self.settings, self.database)
        self.processes: list[subprocess.Popen[bytes]] = []

    # processes

    def start(self, *arguments: str, **environment: str) -> subprocess.Popen[bytes]:
        """Start ``shapery-worker`` with `arguments` in a session of its own."""
        process = processes.spawn(
            [sys.executable, "-m", "shapery_worker", *arguments],
            self.home / f"{arguments[0]}-{len(self.processes)}.log",
            environment={**self.environment, **environment},
        )
        self.processes.append(process)
        return process

    def start_worker(
        self, *, service: str = probe.SERVICE, concurrency: int = 2, wait: bool = True, **environment: str
    ) -> subprocess.Popen[bytes]:
        """Start a worker of a service, and wait until it listens."""
        worker = self.start("run", "--service", service, "--concurrency", str(concurrency), **environment)
        if wait:
            self.until(lambda: self.celery_main(worker) is not None and self.is_listed(worker), "the worker listens")
        return worker

    def start_reaper(self, **environment: str) -> subprocess.Popen[bytes]:
        """Start a reaper."""
        return self.start("reaper", **environment)

    def is_listed(self, worker: subprocess.Popen[bytes]) -> bool:
        """Tell whether a worker is in the list of live ones."""
        from shapery_platform import workers

        with self.database.session(readonly=True) as session:
            return any(row.pid == worker.pid for row in workers.live(session, self.settings))

    def celery_main(self, worker: subprocess.Popen[bytes]) -> psutil.Process | None:
        """Return the main process of Celery below a worker's host."""
        try:
            found = [c for c in psutil.Process(worker.pid).children() if "celery_main" in " ".join(c.cmdline())]
        except psutil.Error:
            return None
        return found[0] if found else None

    def running(self) -> dict[UUID, int]:
        """Return the processes of the handlers that run now, by job."""
        found: dict[UUID, int] = {}
        for path in scratch_root(self.settings, probe.SERVICE).glob("[!.]*/owner.json"):
            try:
                owner = Ownership.model_validate_json(path.read_bytes())
            except (FileNotFoundError, ValueError):
                continue
            if owner.handler_pid:
                found[owner.job_id] = owner.handler_pid
        return found

    def end(self) -> None:
        """End everything."""
        for process in self.processes:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        for process in self.processes:
            processes.end(process)
        self.database.dispose()

    # jobs

    def upload(self, data: bytes, name: str = "shape.obj") -> UUID:
        """Store bytes as an asset that probes take."""
        blob = self.store.put_bytes(data)
        with self.database.session() as session:
            return assets.create_from_upload(
                session, self.store, self.settings, OWNER, blob.sha256, blob.size, name, MESH
            ).id

    def submit(
        self,
        kind: str = "probe",
        *,
        inputs: Mapping[str, UUID | list[UUID]] | None = None,
        enqueue: bool = True,
        **params: Any,
    ) -> UUID:
        """Create a job and send its message."""
        with self.database.session() as session:
            request = JobCreate(kind=kind, inputs=dict(inputs or {}), params=params)
            job_id = jobs.create(session, self.settings, OWNER, request)[0].id
        if enqueue:
            dispatch.submit(self.database, self.celery, job_id, kind)
        return job_id

    def view(self, job_id: UUID) -> JobView:
        """Return a job as it is now."""
        with self.database.session(readonly=True) as session:
            return jobs.view(jobs.get(session, OWNER, job_id))

    def events(self, job_id: UUID) -> list[JobEvent]:
        """Return the events of a job."""
        with self.database.session(readonly=True) as session:
            return jobs.events_after(session, OWNER, job_id)

    def preview(self, job_id: UUID, after: int = 0) -> jobs.Preview | None:
        """Return what a running job shows, if it is newer than `after`."""
        with self.database.session(readonly=True) as session:
            return jobs.preview(session, OWNER, job_id, after)

    def cancel(self, job_id: UUID) -> None:
        """Cancel a job."""
        with self.database.session() as session:
            jobs.cancel(session, OWNER, job_id)

    def wait(self, job_id: UUID, seconds: float = 60.0) -> JobView:
        """Wait for the end of a job."""
        self.until(lambda: self.view(job_id).state.terminal, f"job {job_id} ends", seconds)
        return self.view(job_id)

    def wait_all(self, job_ids: Iterable[UUID], seconds: float = 90.0) -> list[JobView]:
        """Wait for the end of several jobs."""
        deadline = time.monotonic() + seconds
        return [self.wait(job_id, max(1.0, deadline - time.monotonic())) for job_id in job_ids]

    def wait_until_running(self, job_id: UUID, seconds: float = 60.0) -> int:
        """Wait until a job's handler runs, and return its process."""
        self.until(lambda: self.view(job_id).stage != "", f"job {job_id} runs", seconds)
        return self.running()[job_id]

    def until(self, condition: Callable[[], bool], what: str, seconds: float = 60.0) -> None:
        """Wait for a condition; the error tells what queue and logs say."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f"after {seconds:.0f} s not yet: {what}\n{self.queue_state()}\n{self.logs()}")
            time.sleep(0.02)

    def queue_state(self) -> str:
        """Return what the queue holds, and what workers hold of it."""
        try:
            with connect(self.settings) as client:
                held = client.hkeys("unacked")
            return f"queues: {queue_lengths(self.settings)}, unacknowledged: {held}"
        except redis.RedisError as error:
            return f"Redis does not answer: {error}"

    def logs(self, lines: int = 40) -> str:
        """Return the ends of all logs."""
        texts = []
        for path in sorted(self.home.glob("*.log")) + sorted(self.home.glob("logs/*.log")):
            tail = path.read_text(errors="replace").splitlines()[-lines:]
            texts.append(f"== {path.name}\n" + "\n".join(tail))
        return "\n".join(texts)

    def artifacts(self, job: JobView) -> dict[str, bytes]:
        """Return the bytes of a job's artifacts by name."""
        return {
            artifact.name: b"".join(self.store.iter_range(object_key(artifact.sha256))) for artifact in job.artifacts
        }


def _text(value: Any) -> str:
    return json.dumps(value) if isinstance(value, dict | list) else str(value)


@contextmanager
def running_stack(home: Path, database_url: str, redis: RedisServer, **settings: Any) -> Iterator[Stack]:
    """Make a stack on servers that run, and end its processes afterwards; nothing of them may be left."""
    stack = Stack(home, database_url, redis.url, **settings)
    try:
        yield stack
    finally:
        hosts = {process.pid for process in stack.processes}
        stack.end()
        left = [process for process in processes_of(home) if process.pid not in hosts]
        for process in left:
            process.kill()
        assert not left, f"processes outlived their worker: {left}"


def processes_of(home: Path) -> list[psutil.Process]:
    """Return the living processes whose environment names this home, other than this one."""
    found = []
    for process in psutil.process_iter():
        try:
            if process.pid != os.getpid() and process.environ().get("SHAPERY_HOME") == str(home):
                found.append(process)
        except psutil.Error:
            continue
    return [process for process in found if process.is_running() and process.status() != psutil.STATUS_ZOMBIE]


def expected_end(job: JobView, *, artifacts: Mapping[str, int], seed: int, stack: Stack) -> None:
    """Assert that a job succeeded with exactly the artifacts that its parameters ask for."""
    assert job.state is JobState.SUCCEEDED, job
    assert stack.artifacts(job) == {name: probe.artifact_bytes(seed, name, size) for name, size in artifacts.items()}

"""One worker: ``shapery-worker run --service …``.

The host is the process that a container or the supervisor starts. It runs no jobs. It starts the Celery worker in a
process of its own and starts it again when it dies, says in the database that the worker lives, takes over the jobs of
processes that were killed, offers metrics, and reaps orphans where it is the first process of a container. Where no
handler of the service is installed it starts nothing and sleeps.
"""

from __future__ import annotations

import logging
import os
import secrets
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable

from sqlalchemy.exc import SQLAlchemyError

from shapery_contracts.errors import ShaperyError
from shapery_platform import workers
from shapery_platform.db import Database
from shapery_platform.queue import make_celery
from shapery_platform.settings import Settings
from shapery_worker import leash
from shapery_worker.handlers import installed_kinds
from shapery_worker.lifeline import kill_tree
from shapery_worker.metrics import MetricsServer
from shapery_worker.ready import read_ready
from shapery_worker.recovery import recover_abandoned
from shapery_worker.settings import WorkerSettings, scratch_root
from shapery_worker.stop_signal import StopSignal

_TICK = 0.25
_FIRST_DELAY = 0.1
_LONGEST_DELAY = 10.0
_HEALTHY_AFTER = 30.0
_KILL_AFTER = 10.0
"""Seconds beyond the grace after which a worker that does not stop is killed."""

logger = logging.getLogger(__name__)


def new_worker_id(service: str) -> str:
    """Return a name for a worker that no other had or will have."""
    return f"{service}@{socket.gethostname()[:100]}:{os.getpid()}:{secrets.token_hex(4)}"


class WorkerHost:
    """The parent of one Celery worker.

    Parameters
    ----------
    settings, worker_settings
        What is set; plugins have been loaded.
    service
        Whose jobs are run.
    """

    def __init__(self, settings: Settings, worker_settings: WorkerSettings, service: str) -> None:
        self._settings = settings
        self._worker_settings = worker_settings
        self._service = service
        self._worker_id = new_worker_id(service)
        self._root = scratch_root(settings, service)
        self._database = Database(settings.database_url, pool_size=1)
        self._celery = make_celery(settings)
        self._main: subprocess.Popen[bytes] | None = None
        self._ready_fd = -1
        self._kinds: list[str] | None = None
        self._registered = False
        self._started_at = 0.0
        self._start_again_at = 0.0
        self._delay = _FIRST_DELAY
        self._database_down = False
        self._stop_signal = StopSignal()

    def run(self) -> int:
        """Work until a signal says to stop; returns the exit code."""
        idle = not installed_kinds(self._service)
        if idle:
            logger.info("no handler of %s is installed here: this worker serves nothing", self._service)
            self._kinds = []
        with self._stop_signal, MetricsServer(self._worker_settings, self._root):
            if not idle:
                self._start_main()
            sweep_due = beat_due = 0.0
            while not self._stop_signal.asked:
                now = time.monotonic()
                if not idle:
                    self._look_after_main(now)
                if now >= sweep_due and not idle:
                    self._in_database(self._recover)
                    sweep_due = now + 1.0
                if now >= beat_due:
                    self._in_database(self._tell_alive)
                    beat_due = now + (self._settings.lease_seconds / 3 if self._kinds is not None else _TICK)
                if os.getpid() == 1:
                    self._reap_orphans()
                # An idle worker has nothing to look after but its own sign of life.
                self._stop_signal.wait(beat_due - now if idle else _TICK)
            code = self._stop_main()
            self._in_database(self._tell_gone)
        self._database.engine.dispose()
        return code

    def _start_main(self) -> None:
        self._root.mkdir(parents=True, exist_ok=True)
        self._ready_fd, ready_write = os.pipe()
        os.set_blocking(self._ready_fd, False)
        arguments = {
            "--service": self._service,
            "--worker-id": self._worker_id,
            "--concurrency": str(self._worker_settings.concurrency),
            "--ready-fd": str(ready_write),
        }
        program = [sys.executable, "-m", "shapery_worker.celery_main", *(p for pair in arguments.items() for p in pair)]
        self._main = subprocess.Popen(
            leash.command(program),
            env={**os.environ, **self._worker_settings.thread_environment()},
            stdin=subprocess.DEVNULL,
            pass_fds=(ready_write,),
        )
        os.close(ready_write)
        self._started_at = time.monotonic()

    def _look_after_main(self, now: float) -> None:
        if self._main is None:
            if now >= self._start_again_at:
                self._start_main()
            return
        code = self._main.poll()
        if code is not None:
            self._main_ended(code, now)
        elif self._kinds is None:
            self._kinds = read_ready(self._ready_fd)
            if self._kinds is not None:
                logger.info("worker %s serves %s", self._worker_id, ", ".join(self._kinds) or "nothing")
                os.close(self._ready_fd)
                self._ready_fd = -1

    def _main_ended(self, code: int, now: float) -> None:
        if now - self._started_at > _HEALTHY_AFTER:
            self._delay = _FIRST_DELAY
        ended = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        logger.error("the worker's main process ended (%s) and is started again in %.1f s", ended, self._delay)
        self._main = None
        self._kinds = None
        if self._ready_fd >= 0:
            os.close(self._ready_fd)
            self._ready_fd = -1
        self._start_again_at = now + self._delay
        self._delay = min(self._delay * 2, _LONGEST_DELAY)

    def _stop_main(self) -> int:
        """Stop taking jobs; running ones finish within the grace or are given back."""
        if self._main is None:
            return 0
        self._main.send_signal(signal.SIGTERM)
        try:
            code = self._main.wait(self._worker_settings.shutdown_grace + _KILL_AFTER)
        except subprocess.TimeoutExpired:
            logger.error("the worker's main process did not stop and is killed")
            kill_tree(self._main.pid)
            code = self._main.wait()
            self._in_database(self._recover)
        return 0 if code == 0 else 1

    def _in_database(self, action: Callable[[], None]) -> None:
        """Do something with the database or the queue; when one is away, later is early enough."""
        try:
            action()
        except (SQLAlchemyError, ShaperyError, OSError) as error:
            if not self._database_down:
                logger.warning("database, queue or folder cannot be used: %s", error)
            self._database_down = True
        else:
            if self._database_down:
                logger.info("database, queue and folder can be used again")
            self._database_down = False

    def _recover(self) -> None:
        recover_abandoned(self._root, self._database, self._celery)

    def _tell_alive(self) -> None:
        if self._kinds is None:  # a worker that cannot run jobs at the moment is not shown as one that can
            if self._registered:
                self._tell_gone()
            return
        with self._database.session() as session:
            if not (self._registered and workers.seen(session, self._worker_id)):
                workers.register(
                    session, self._worker_id, self._service, self._kinds, socket.gethostname(), os.getpid()
                )
        self._registered = True

    def _tell_gone(self) -> None:
        if self._registered:
            with self._database.session() as session:
                workers.forget(session, self._worker_id)
            self._registered = False

    def _reap_orphans(self) -> None:
        """As the first process of a container, end the zombies of handlers whose watcher was killed."""
        known = {self._main.pid} if self._main is not None else set()
        while True:
            # Look first, without reaping: the main process's exit code belongs to `_look_after_main`.
            status = os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
            if status is None or status.si_pid in known:
                return
            os.waitpid(status.si_pid, 0)

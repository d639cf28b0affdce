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
from functools import cached_property
from typing import TYPE_CHECKING

from shapery_contracts.kinds import get_kind
from shapery_platform.settings import Settings
from shapery_worker import leash
from shapery_worker.handlers import installed_kinds
from shapery_worker.lifeline import kill_tree
from shapery_worker.metrics import MetricsServer
from shapery_worker.ready import read_ready
from shapery_worker.scratch import has_folders
from shapery_worker.settings import WorkerSettings, scratch_root
from shapery_worker.stop_signal import StopSignal

if TYPE_CHECKING:
    from shapery_worker.presence import Presence

_TICK = 0.25
_SWEEP_EVERY = 1.0
_IDLE_FIRST = 5.0
"""Seconds before a host without handlers says that it is there."""
_FIRST_DELAY = 0.1
_LONGEST_DELAY = 10.0
_HEALTHY_AFTER = 30.0
_RESIDENT_PAUSE = 5.0
"""Seconds between two starts of the resident process, and until it is killed when it does not stop."""
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
        self._main: subprocess.Popen[bytes] | None = None
        self._ready_fd = -1
        self._kinds: list[str] | None = None
        self._started_at = 0.0
        self._start_again_at = 0.0
        self._delay = _FIRST_DELAY
        self._stop_signal = StopSignal()

        self._resident: subprocess.Popen[bytes] | None = None
        self._resident_due = 0.0

    @cached_property
    def _presence(self) -> Presence:
        from shapery_worker.presence import Presence

        return Presence(self._settings, self._worker_id, self._service, self._root)

    def run(self) -> int:
        """Work until a signal says to stop; returns the exit code."""
        with self._stop_signal, MetricsServer(self._worker_settings, self._root):
            try:
                if installed_kinds(self._service):
                    return self._run_jobs()
                logger.info("no handler of %s is installed here: this worker serves nothing", self._service)
                return self._idle()
            finally:
                if "_presence" in self.__dict__:
                    self._presence.tell_gone()
                    self._presence.close()

    def _run_jobs(self) -> int:
        self._start_main()
        told = sweep_due = beat_due = 0.0
        while not self._stop_signal.asked:
            now = time.monotonic()
            self._look_after_main(now)
            if self._kinds is not None and any(get_kind(kind).searches for kind in self._kinds):
                self._look_after_resident(now)
            if now >= sweep_due:
                if has_folders(self._root):
                    self._presence.recover()
                sweep_due = now + _SWEEP_EVERY
            if self._kinds is not None and now >= beat_due:
                self._presence.tell_alive(self._kinds)
                told, beat_due = now, now + self._beat_every
            elif self._kinds is None and told:
                # A worker that cannot run jobs at the moment is not shown as one that can.
                self._presence.tell_gone()
                told = beat_due = 0.0
            if os.getpid() == 1:
                self._reap_orphans()
            self._stop_signal.wait(_TICK)
        self._stop_resident()
        return self._stop_main()

    def _idle(self) -> int:
        # Everything else that starts now has more to do.
        wait = _IDLE_FIRST
        while not self._stop_signal.wait(wait):
            self._presence.tell_alive(())
            wait = self._beat_every
        return 0

    @property
    def _beat_every(self) -> float:
        return self._settings.lease_seconds / 3

    def _look_after_resident(self, now: float) -> None:
        """Keep the process that answers searches at once; it starts after the one that runs the jobs."""
        if self._resident is not None and self._resident.poll() is not None:
            logger.warning("the resident process ended (%d) and is started again", self._resident.returncode)
            self._resident = None
        if self._resident is None and now >= self._resident_due:
            self._resident_due = now + _RESIDENT_PAUSE
            self._resident = subprocess.Popen(
                leash.command([sys.executable, "-m", "shapery_worker.resident", "--service", self._service]),
                env={**os.environ, **self._worker_settings.thread_environment()},
                stdin=subprocess.DEVNULL,
            )

    def _stop_resident(self) -> None:
        if self._resident is None:
            return
        self._resident.send_signal(signal.SIGTERM)
        try:
            self._resident.wait(_RESIDENT_PAUSE)
        except subprocess.TimeoutExpired:
            kill_tree(self._resident.pid)
            self._resident.wait()

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
            self._presence.recover()
        return 0 if code == 0 else 1

    def _reap_orphans(self) -> None:
        """As the first process of a container, end the zombies of handlers whose watcher was killed."""
        known = {process.pid for process in (self._main, self._resident) if process is not None}
        while True:
            # Look first, without reaping: the main process's exit code belongs to `_look_after_main`.
            status = os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
            if status is None or status.si_pid in known:
                return
            os.waitpid(status.si_pid, 0)

"""The supervisor: starts Redis, gateway, workers and reaper, keeps them running, and stops them together.

It has one thread and one loop, and holds no connection to anything: whatever one of its processes suffers, it goes on.
Every process is on a leash (`shapery_worker.leash`), so that nothing outlives the supervisor, even when it is killed.
"""

from __future__ import annotations

import contextlib
import http.client
import logging
import os
import selectors
import signal
import socket
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from urllib.parse import urlsplit

from shapery_contracts.errors import UserError
from shapery_contracts.kinds import JOB_KINDS, SERVICES
from shapery_platform.settings import Settings
from shapery_worker.handlers import installed_kinds
from shapery_worker.stop_signal import StopSignal
from shapery_worker.supervisor.lock import HomeLock, ProcessMark
from shapery_worker.supervisor.process import SupervisedProcess
from shapery_worker.supervisor.redis_server import find_redis, redis_command

_READY_WITHIN = 60.0
_TICK = 0.2
_REDIS_WITHIN = 10.0
_SHUTDOWN_GRACE = 2.0
"""Seconds that running jobs have to finish when everything stops: whoever presses Ctrl-C wants it to end. They are
given back to the queue and continue at the next start."""
_STOP_WITHIN = 10.0

logger = logging.getLogger(__name__)


class Supervisor:
    """All processes of one home.

    Parameters
    ----------
    settings
        Where the platform keeps its things and which address it serves; port 0 takes a free one. Plugins have been
        loaded.
    services
        Which services get a worker; none: all.
    announce
        Called with each line that the user shall see.
    """

    def __init__(
        self,
        settings: Settings,
        *,
        services: Sequence[str] | None = None,
        announce: Callable[[str], None] = print,
    ) -> None:
        self._settings = settings
        self._services = all_services() if services is None else services
        self._announce = announce
        self._port = settings.port
        self._processes: list[SupervisedProcess] = []
        self._redis: SupervisedProcess | None = None
        self._stop_signal = StopSignal()

    @property
    def address(self) -> str:
        """Where the gateway is reached from this machine."""
        host = self._settings.host
        if host in ("0.0.0.0", "::", ""):  # noqa: S104 (compared with, not bound to)
            host = "127.0.0.1"
        return f"http://{f'[{host}]' if ':' in host else host}:{self._port}"

    def run(self, *, once: bool = False) -> int:
        """Start everything and keep it running until a signal comes; returns the exit code.

        Parameters
        ----------
        once
            Stop as soon as everything is ready: a trial of the installation.

        Raises
        ------
        UserError
            The home is in use, the port is taken, or Redis is missing.
        """
        with HomeLock(self._settings.home) as lock, self._stop_signal:
            self._port = choose_port(self._settings.host, self._settings.port)
            try:
                ready = self._start(lock)
                if ready and not once:
                    self._announce(f"Shapery is ready at {self.address}   (Ctrl-C stops it)")
                    self._watch(lock, lambda: False)
                elif ready:
                    self._announce(f"Shapery was ready at {self.address}.")
                return 0 if ready or self._stop_signal.asked else 1
            finally:
                self._stop()

    def _start(self, lock: HomeLock) -> bool:
        settings = self._settings
        began = time.monotonic()
        logs = settings.home / "logs"
        if settings.redis_socket is not None and self._owns_redis():
            folder = settings.home / "redis"
            folder.mkdir(parents=True, exist_ok=True)
            self._redis = self._add("redis", redis_command(find_redis(), folder, settings.redis_socket), logs)
            self._redis.start()
        # Meanwhile: Redis reads its file, and the tables are brought to the newest version before anybody asks.
        migrate(settings)
        if self._redis is not None:
            self._wait_for_redis(settings.redis_socket)
        python = [sys.executable, "-m"]
        self._add("gateway", [*python, "shapery_gateway"], logs).start()
        late = []
        for service in self._services:
            worker = self._add(f"worker-{service}", [*python, "shapery_worker", "run", "--service", service], logs)
            if installed_kinds(service):
                worker.start()
            else:
                late.append(worker)
        late.append(self._add("reaper", [*python, "shapery_worker", "reaper"], logs))
        lock.record.address = self.address
        self._record(lock)
        self._watch(lock, lambda: self._ready() or time.monotonic() - began > _READY_WITHIN)
        if self._stop_signal.asked:
            return False
        if not self._ready():
            self._announce(f"Shapery was not ready after {_READY_WITHIN:.0f} s; its logs are in {logs}.")
            return False
        logger.info("ready after %.1f s", time.monotonic() - began)
        # Those that have no work yet come last: starting takes the processors that the others need to get ready.
        for process in late:
            process.start()
        self._record(lock)
        return True

    def _owns_redis(self) -> bool:
        """Whether the address of Redis is the one that the home itself gives: any other server is somebody else's."""
        own = Settings(profile="embedded", home=self._settings.home, redis_url="")
        return own.redis_socket == self._settings.redis_socket

    def _add(self, name: str, arguments: list[str], logs: Path) -> SupervisedProcess:
        process = SupervisedProcess(name, arguments, self._environment(), logs / f"{name}.log")
        self._processes.append(process)
        return process

    def _environment(self) -> dict[str, str]:
        settings = self._settings
        environment = {
            **os.environ,
            "PYTHONUNBUFFERED": "1",
            "SHAPERY_PROFILE": settings.profile,
            "SHAPERY_HOME": str(settings.home),
            "SHAPERY_HOST": settings.host,
            "SHAPERY_PORT": str(self._port),
            "SHAPERY_DATABASE_URL": settings.database_url,
            "SHAPERY_REDIS_URL": settings.redis_url,
            "SHAPERY_STORAGE_URL": settings.storage_url,
        }
        environment.setdefault("SHAPERY_WORKER_SHUTDOWN_GRACE", str(_SHUTDOWN_GRACE))
        return environment

    def _wait_for_redis(self, path: Path | None) -> None:
        deadline = time.monotonic() + _REDIS_WITHIN
        while time.monotonic() < deadline:
            assert self._redis is not None
            self._redis.read()
            self._redis.look(time.monotonic())
            with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX) as client:
                client.settimeout(1.0)
                client.connect(str(path))
                client.sendall(b"PING\r\n")
                if client.recv(64).startswith(b"+PONG"):
                    return
            time.sleep(0.01)
        raise UserError(
            "service_unavailable",
            f"Redis did not answer within {_REDIS_WITHIN:.0f} s.",
            f"Its log is {self._settings.home / 'logs' / 'redis.log'}.",
        )

    def _watch(self, lock: HomeLock, until: Callable[[], bool]) -> None:
        """Keep all processes running until a stop is asked for, or `until` says so."""
        while not self._stop_signal.asked and not until():
            self._pause(_TICK)
            now = time.monotonic()
            changed = False
            for process in self._processes:
                changed |= process.look(now)
            if changed:
                self._record(lock)

    def _pause(self, seconds: float) -> None:
        """Wait for output or a signal, and move what has come into the logs."""
        with selectors.DefaultSelector() as selector:
            selector.register(self._stop_signal, selectors.EVENT_READ)
            for process in self._processes:
                if process.output is not None:
                    selector.register(process.output, selectors.EVENT_READ, process)
            for key, _ in selector.select(seconds):
                if isinstance(key.data, SupervisedProcess):
                    key.data.read()
                else:
                    self._stop_signal.clear()

    def _record(self, lock: HomeLock) -> None:
        marks = {}
        for process in self._processes:
            if process.pid is not None:
                # It may have died this very moment; the next look finds that out.
                with contextlib.suppress(Exception):
                    marks[process.name] = ProcessMark.of(process.pid)
        lock.record.processes = marks
        lock.save()

    def _ready(self) -> bool:
        target = urlsplit(self.address)
        connection = http.client.HTTPConnection(target.hostname or "127.0.0.1", self._port, timeout=2)
        try:
            connection.request("GET", "/readyz")
            return connection.getresponse().status == 200
        except OSError:
            return False
        except http.client.HTTPException:
            return False
        finally:
            connection.close()

    def _stop(self) -> None:
        """Stop the gateway and the workers, then Redis, all within seconds."""
        began = time.monotonic()
        asked = self._stop_signal.asked
        others = [process for process in self._processes if process is not self._redis]
        for process in others:
            process.send(signal.SIGTERM)
        deadline = began + _STOP_WITHIN
        while any(not process.wait(0.0) for process in others):
            if time.monotonic() > deadline or self._stop_signal.asked > asked:  # a second Ctrl-C: at once
                break
            self._pause(0.05)
        for process in others:
            if process.pid is not None and not process.wait(0.0):
                logger.warning("%s did not stop in time and is killed", process.name)
            process.kill()
        if self._redis is not None:
            self._redis.send(signal.SIGTERM)
            self._redis.wait(time.monotonic() + 2.0)
            self._redis.kill()
        for process in self._processes:
            process.close()
        logger.info("stopped within %.1f s", time.monotonic() - began)


def all_services() -> list[str]:
    """Return our services and those of plugins: whoever registers a kind with its own service gets a worker for it."""
    return list(dict.fromkeys([*SERVICES, *(kind.service for kind in JOB_KINDS.values())]))


def choose_port(host: str, port: int) -> int:
    """Return `port` if it is free on `host`, or a free one for 0.

    Raises
    ------
    UserError
        ``conflict``: something else listens there.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host.strip("[]"), port))
        except OSError as error:
            raise UserError(
                "conflict",
                f"Port {port} on {host} cannot be used: {error.strerror or error}.",
                "Choose another with --port; --port 0 takes any that is free.",
            ) from error
        return int(probe.getsockname()[1])


def migrate(settings: Settings) -> None:
    """Bring the tables to the newest version."""
    from shapery_platform.db import Database

    settings.home.mkdir(parents=True, exist_ok=True)
    database = Database(settings.database_url)
    try:
        database.migrate()
    finally:
        database.engine.dispose()

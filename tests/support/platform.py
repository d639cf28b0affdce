"""``shapery-worker up`` as a real process tree, with the probes of `tests.support.probe`."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from shapery_worker.supervisor.lock import RunRecord, read_record
from tests.support import processes
from tests.support.stack import Stack, processes_of


class Platform:
    """A supervisor over a home, and a client to its database."""

    def __init__(self, home: Path, database_url: str | None = None, **settings: object) -> None:
        self.home = home
        database_url = database_url or f"sqlite:///{home / 'shapery.db'}"
        self.stack = Stack(home, database_url, f"unix://{home / 'redis.sock'}", **settings)
        self.process: subprocess.Popen[bytes] | None = None

    def start(self, *arguments: str, **environment: str) -> subprocess.Popen[bytes]:
        """Start the supervisor."""
        self.process = processes.spawn(
            [sys.executable, "-m", "shapery_worker", "up", "--home", self.home, "--port", "0", *arguments],
            self.home / "up.log",
            environment={**self.stack.environment, **environment},
        )
        return self.process

    def wait_until_ready(self) -> RunRecord:
        """Wait until it says so, and return what it tells about itself."""
        self.stack.until(lambda: f"({self.pid})" in self._ready_marks(), "the platform is ready", 90)
        record = read_record(self.home)
        assert record is not None
        return record

    @property
    def pid(self) -> int:
        """The supervisor's process."""
        assert self.process is not None
        return self.process.pid

    def _ready_marks(self) -> str:
        record = read_record(self.home)
        if record is None or "reaper" not in record.processes:  # which is started last
            return ""
        return f"({record.supervisor.pid})"

    def stop(self) -> None:
        """Stop everything in order."""
        if self.process is not None:
            processes.end(self.process, signal.SIGINT, 30)


@contextmanager
def platform(home: Path, database_url: str | None = None, **settings: object) -> Iterator[Platform]:
    """Make a platform; whatever a test does, nothing of it is left."""
    made = Platform(home, database_url, **settings)
    try:
        yield made
    finally:
        made.stop()
        made.stack.database.dispose()
        left = processes_of(home)
        for process in left:
            process.kill()
        assert not left, f"processes outlived their supervisor: {left}"

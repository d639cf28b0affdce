"""One process under the supervisor: started, watched, started again, stopped, its output kept."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import subprocess
import time
from collections import deque
from collections.abc import Mapping
from logging.handlers import RotatingFileHandler
from pathlib import Path

from shapery_worker.leash import command
from shapery_worker.lifeline import kill_tree

LOG_BYTES = 5_000_000
LOG_FILES = 3
_FIRST_DELAY = 0.1
_LONGEST_DELAY = 10.0
_HEALTHY_AFTER = 30.0
"""Seconds of life after which an earlier death is forgotten."""
_LOOP_AFTER = 4
"""Deaths in a row that are called a crash loop."""

logger = logging.getLogger(__name__)


class SupervisedProcess:
    """A program that shall run as long as the supervisor does.

    Parameters
    ----------
    name
        What it is called in messages; also the name of its log.
    arguments
        Its command line.
    environment
        Its whole environment.
    log
        The file that its standard output and error go to, rotated by size.
    """

    def __init__(self, name: str, arguments: list[str], environment: Mapping[str, str], log: Path) -> None:
        self.name = name
        self.arguments = arguments
        self.environment = dict(environment)
        self.log = log
        self.deaths = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._running = False
        self._started_at = 0.0
        self._start_again_at = 0.0
        self._delay = _FIRST_DELAY
        self._rest = b""
        self.tail: deque[str] = deque(maxlen=12)
        """The last lines of its log."""
        log.parent.mkdir(parents=True, exist_ok=True)
        self._writer = RotatingFileHandler(log, maxBytes=LOG_BYTES, backupCount=LOG_FILES, encoding="utf-8")

    @property
    def pid(self) -> int | None:
        """Its id while it runs."""
        return self._process.pid if self._process is not None and self._process.returncode is None else None

    @property
    def output(self) -> int | None:
        """The descriptor to read its output from, while there may be any."""
        stdout = self._process.stdout if self._process is not None else None
        return stdout.fileno() if stdout is not None and not stdout.closed else None

    def start(self, now: float | None = None) -> None:
        """Start it, on the supervisor's leash and as the leader of a group of its own."""
        self._process = subprocess.Popen(
            command(self.arguments),
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            # An interrupt typed at the terminal reaches the supervisor only, which stops all in the right order.
            process_group=0,
            close_fds=True,
        )
        assert self._process.stdout is not None
        os.set_blocking(self._process.stdout.fileno(), False)
        self._running = True
        self._started_at = time.monotonic() if now is None else now

    def look(self, now: float) -> bool:
        """See whether it still runs, and start it again when its time has come; tells whether it was started."""
        if self._process is None:
            return False
        if self._running:
            code = self._process.poll()
            if code is None:
                return False
            self._running = False
            self._died(code, now)
        if now < self._start_again_at:
            return False
        self.start(now)
        logger.info("%s was started again (process %s)", self.name, self.pid)
        return True

    def read(self) -> None:
        """Move what it has printed into its log."""
        descriptor = self.output
        if descriptor is None:
            return
        for _ in range(16):
            try:
                chunk = os.read(descriptor, 65536)
            except BlockingIOError:
                return
            if not chunk:
                self._close_output()
                return
            self._rest += chunk
            *lines, self._rest = self._rest.split(b"\n")
            if len(self._rest) > 65536:
                lines.append(self._rest)
                self._rest = b""
            for line in lines:
                self._write(line)

    def send(self, number: int) -> None:
        """Send it a signal, if it runs."""
        if self.pid is not None and self._process is not None:
            self._process.send_signal(number)

    def wait(self, deadline: float) -> bool:
        """Tell whether it has ended by `deadline` (of the monotonic clock), reading its output meanwhile."""
        while self._process is not None and self._process.poll() is None:
            self.read()
            if time.monotonic() >= deadline:
                return False
            time.sleep(0.02)
        self.read()
        return True

    def kill(self) -> None:
        """End it with all that it started."""
        if self._process is None:
            return
        if self._process.poll() is None:
            kill_tree(self._process.pid)
            self._process.wait()
        self.read()
        self._close_output()

    def close(self) -> None:
        """Close its log."""
        self._writer.close()

    def _died(self, code: int, now: float) -> None:
        assert self._process is not None
        # What it started may have outlived it where the system does not see to that.
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self.read()
        self._close_output()
        self.deaths += 1
        if now - self._started_at > _HEALTHY_AFTER:
            self._delay = _FIRST_DELAY
            self.deaths = 1
        self._start_again_at = now + self._delay
        ended = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        if self.deaths >= _LOOP_AFTER:
            logger.error(
                "%s keeps ending (%s, %d times in a row); next try in %.1f s. The end of %s:\n%s",
                self.name, ended, self.deaths, self._delay, self.log, "\n".join(f"    {line}" for line in self.tail),
            )  # fmt: skip
        else:
            logger.warning("%s ended (%s) and will be started again", self.name, ended)
        self._delay = min(self._delay * 2, _LONGEST_DELAY)

    def _close_output(self) -> None:
        if self._process is not None and self._process.stdout is not None:
            if self._rest:
                self._write(self._rest)
                self._rest = b""
            self._process.stdout.close()

    def _write(self, line: bytes) -> None:
        text = line.decode(errors="backslashreplace").rstrip("\r")
        self.tail.append(text)
        self._writer.emit(logging.LogRecord(self.name, logging.INFO, "", 0, text, None, None))

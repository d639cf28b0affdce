"""One supervisor per home, and no process left of one that was killed."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import time
from pathlib import Path
from types import TracebackType
from typing import Self

import psutil
from pydantic import BaseModel, ValidationError

from shapery_contracts.errors import UserError

_GONE_WITHIN = 5.0


class ProcessMark(BaseModel):
    """A process, told from a later one with the same id by the time it was started."""

    pid: int
    created: float

    @classmethod
    def of(cls, pid: int) -> ProcessMark:
        """Return the mark of a living process."""
        return cls(pid=pid, created=psutil.Process(pid).create_time())

    def find(self) -> psutil.Process | None:
        """Return the process if it is still there."""
        with contextlib.suppress(psutil.Error):
            process = psutil.Process(self.pid)
            if abs(process.create_time() - self.created) < 0.02 and process.status() != psutil.STATUS_ZOMBIE:
                return process
        return None


class RunRecord(BaseModel):
    """What a running supervisor tells about itself in its lock file."""

    supervisor: ProcessMark
    address: str = ""
    processes: dict[str, ProcessMark] = {}


class HomeLock:
    """The lock on a home, held as long as the supervisor lives: the kernel drops it with the process.

    So a lock file that a killed supervisor left behind stops nobody; only what it says is read, to end processes that
    might have outlived it.
    """

    def __init__(self, home: Path) -> None:
        self.path = home / "supervisor.lock"
        self._descriptor = -1
        self.record = RunRecord(supervisor=ProcessMark.of(os.getpid()))

    def __enter__(self) -> Self:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            record = self._read()
            os.close(self._descriptor)
            where = f" at {record.address}" if record and record.address else ""
            who = f"process {record.supervisor.pid}" if record else "another process"
            raise UserError(
                "conflict",
                f"Shapery is already running in {self.path.parent}{where} ({who}).",
                "Stop it first, or choose another folder with --home.",
            ) from None
        previous = self._read()
        if previous is not None:
            end_survivors(previous)
        self.save()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        # Emptied and not removed: between a removal and the end of this process another could lock a new file.
        os.ftruncate(self._descriptor, 0)
        os.close(self._descriptor)

    def save(self) -> None:
        """Write down the processes that there are now."""
        data = self.record.model_dump_json().encode()
        os.pwrite(self._descriptor, data, 0)
        os.ftruncate(self._descriptor, len(data))

    def _read(self) -> RunRecord | None:
        data = os.pread(self._descriptor, 1 << 16, 0)
        if not data:
            return None
        try:
            return RunRecord.model_validate_json(data)
        except ValidationError:
            return None  # read while it was being written, or cut off by a full disk


def read_record(home: Path) -> RunRecord | None:
    """Return what the supervisor of `home` says of itself; None when none is running or it says nothing yet."""
    try:
        record = RunRecord.model_validate_json((home / "supervisor.lock").read_bytes())
    except (FileNotFoundError, ValidationError, json.JSONDecodeError):
        return None
    return record if record.supervisor.find() else None


def end_survivors(record: RunRecord) -> None:
    """Kill what a killed supervisor has left running, and wait until it is gone.

    On Linux its processes die with it, which may take a moment; elsewhere this is what ends them.
    """
    survivors = [process for mark in record.processes.values() if (process := mark.find())]
    deadline = time.monotonic() + 0.5
    while survivors and time.monotonic() < deadline:
        time.sleep(0.02)
        survivors = [process for process in survivors if process.is_running() and process.status() != "zombie"]
    for process in survivors:
        with contextlib.suppress(psutil.Error):
            for descendant in process.children(recursive=True):
                descendant.kill()
            process.kill()
    psutil.wait_procs(survivors, timeout=_GONE_WITHIN)

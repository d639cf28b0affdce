"""The folders in which jobs keep their files while they run, and what is left of them when a worker was killed.

Each folder is locked by the watcher that owns it. The kernel lets go of the lock when that process ends, however it
ends, so an unlocked folder proves on the spot what a silent heartbeat only suggests after seconds: the watcher is
dead. The folder tells which job it had and under which lease, so the job can be taken over at once.
"""

from __future__ import annotations

import fcntl
import logging
import os
import shutil
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self
from uuid import UUID

from pydantic import BaseModel

from shapery_worker.handler_process import Folders

_OWNER = "owner.json"
_ABANDONED_AFTER = 3600.0
"""Seconds after which a folder that was never finished being made is litter."""

logger = logging.getLogger(__name__)


class Ownership(BaseModel):
    """Which attempt at which job a folder belongs to."""

    job_id: UUID
    kind: str
    lease: UUID
    handler_pid: int = 0


@dataclass(frozen=True, slots=True)
class Abandoned:
    """A folder whose watcher is dead; it stays locked by the finder until it is removed."""

    path: Path
    ownership: Ownership | None
    """None when the watcher died before it had written it."""


class ScratchFolder:
    """The locked folder of one attempt at a job; a context manager that removes it.

    The lock is a POSIX record lock because children do not inherit it: a handler that survived its watcher must not
    keep the folder locked. Such a lock goes with *any* descriptor of the file, so the file is opened here only.
    """

    def __init__(self, root: Path, ownership: Ownership) -> None:
        self._root = root
        self._ownership = ownership
        self.path = root / f"{ownership.job_id}.{ownership.lease.hex[-8:]}"
        self._lock = -1

    @property
    def folders(self) -> Folders:
        """The places inside."""
        return Folders(
            inputs=self.path / "inputs",
            output=self.path / "output",
            work=self.path / "work",
            outcome=self.path / "outcome.json",
            preview=self.path / "preview",
        )

    @property
    def descriptor(self) -> int:
        """The descriptor that holds the lock; a process that is forked meanwhile has no use for it."""
        return self._lock

    def __enter__(self) -> Self:
        # Under a hidden name until it is locked: a sweep that came in between would take it for abandoned.
        hidden = self._root / f".{self.path.name}"
        hidden.mkdir(parents=True, mode=0o700)
        for name in ("inputs", "output", "work"):
            (hidden / name).mkdir()
        (hidden / _OWNER).write_text(self._ownership.model_dump_json())
        self._lock = os.open(hidden / _OWNER, os.O_RDWR | os.O_CLOEXEC)
        fcntl.lockf(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        hidden.rename(self.path)
        return self

    def tell_handler(self, pid: int) -> None:
        """Write down which process runs the handler, so that what it starts can be found."""
        told = self._ownership.model_copy(update={"handler_pid": pid})
        # In place, through the descriptor that holds the lock: closing any other one would drop it.
        os.pwrite(self._lock, told.model_dump_json().encode(), 0)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        remove_tree(self.path)
        os.close(self._lock)


def has_folders(root: Path) -> bool:
    """Tell whether there is anything below `root` that might be abandoned."""
    try:
        with os.scandir(root) as entries:
            return any(True for _ in entries)
    except FileNotFoundError:
        return False


def find_abandoned(root: Path) -> Iterator[Abandoned]:
    """Yield the folders below `root` whose watchers are dead; each is removed when the caller asks for the next one.

    Several finders may run at once: whoever gets the lock has the folder to itself.
    """
    try:
        paths = sorted(root.iterdir())
    except FileNotFoundError:
        return
    for path in paths:
        if path.name.startswith("."):
            _remove_litter(path)
            continue
        try:
            lock = os.open(path / _OWNER, os.O_RDWR | os.O_CLOEXEC)
        except FileNotFoundError:
            _remove_litter(path)
            continue
        try:
            fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(lock)
            continue
        try:
            try:
                ownership = Ownership.model_validate_json(os.pread(lock, 65536, 0))
            except ValueError:
                ownership = None
            yield Abandoned(path, ownership)
            remove_tree(path)
        finally:
            os.close(lock)


def _remove_litter(path: Path) -> None:
    try:
        age = time.time() - path.stat().st_mtime
    except FileNotFoundError:
        return
    if age > _ABANDONED_AFTER:
        logger.info("removing %s, left %d s ago", path, age)
        remove_tree(path)


def remove_tree(path: Path) -> None:
    """Remove a folder with all that is in it, whatever permissions a handler has set there."""
    if not path.exists():
        return
    # The mark of ownership goes last: a folder half removed is still found by the next sweep.
    for entry in path.iterdir():
        if entry.name != _OWNER:
            _remove(entry)
    _remove(path)


def _remove(path: Path) -> None:
    if path.is_symlink() or not path.is_dir():
        path.unlink(missing_ok=True)
        return
    shutil.rmtree(path, ignore_errors=True)
    if path.exists():
        for folder, _, _ in os.walk(path):
            Path(folder).chmod(0o700)
        shutil.rmtree(path, ignore_errors=True)
    if path.exists():
        logger.warning("cannot remove %s", path)

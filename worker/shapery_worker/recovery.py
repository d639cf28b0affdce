"""Taking over what a killed process of this machine had, at once and without waiting for its lease to run out."""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Callable
from pathlib import Path
from uuid import UUID

import psutil

from shapery_contracts.states import JobState
from shapery_platform import jobs
from shapery_platform.db import Database
from shapery_worker.scratch import Abandoned, Ownership, find_abandoned

logger = logging.getLogger(__name__)


def recover_abandoned(root: Path, database: Database, submit: Callable[[UUID, str], object]) -> int:
    """Give back the jobs whose folders below `root` are abandoned, and remove the folders; return how many.

    The change is made under the dead worker's own lease, so it does nothing where the reaper was faster. `submit` is
    called with id and kind of each job that waits again.
    """
    recovered = 0
    for abandoned in find_abandoned(root):
        if abandoned.ownership is None:
            continue
        _end_orphans(abandoned)
        ownership = abandoned.ownership
        with database.session() as session:
            state = jobs.crash_or_requeue(
                session, ownership.job_id, ownership.lease, "its worker was killed.", "worker_lost"
            )
        if state is None:
            continue
        recovered += 1
        logger.warning("job %s: its worker was killed; it is %s now", ownership.job_id, state.value)
        if state is JobState.QUEUED:
            submit(ownership.job_id, ownership.kind)
    return recovered


def _end_orphans(abandoned: Abandoned) -> None:
    """Kill what the handler had started: it dies with its watcher itself, but its children are not told.

    They are known by the folder in which they were started, so that a process that has only got the same id is safe.
    """
    ownership: Ownership | None = abandoned.ownership
    if ownership is None or ownership.handler_pid <= 1:
        return
    for process in psutil.process_iter():
        try:
            if os.getsid(process.pid) != ownership.handler_pid:
                continue
            if not Path(process.cwd()).is_relative_to(abandoned.path.resolve()):
                continue
            process.send_signal(signal.SIGKILL)
            logger.warning("killed process %d, left over from job %s", process.pid, ownership.job_id)
        except (psutil.Error, OSError):
            continue

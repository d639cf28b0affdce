"""The thread that keeps a claimed job alive in the database while its worker is busy with it."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from pathlib import Path
from uuid import UUID

from sqlalchemy.exc import SQLAlchemyError

from shapery_contracts.states import JobState
from shapery_platform import jobs
from shapery_platform.db import Database
from shapery_platform.settings import Settings
from shapery_worker.board import Board, Progress
from shapery_worker.preview import PreviewFile

logger = logging.getLogger(__name__)


class LeaseKeeper:
    """Renews a lease, passes on progress, and learns of a cancel; a context manager.

    The handler runs in another process, so nothing that it does, not even native code that never lets go of the
    interpreter, can hold this thread up; and what the watcher itself does meanwhile (storing, staging, hashing) lets
    go of it.

    Parameters
    ----------
    database, settings
        Where the row is, and the pulse.
    job_id, lease
        What is held.
    board
        Where the handler writes its progress.
    preview
        The file in which it shows how its result looks so far.
    """

    def __init__(
        self, database: Database, settings: Settings, job_id: UUID, lease: UUID, board: Board, preview: Path
    ) -> None:
        self._database = database
        self._settings = settings
        self._job_id = job_id
        self._lease = lease
        self._board = board
        self._shown = Progress()
        self._preview = PreviewFile(preview)
        self._cancelled = threading.Event()
        self._lost = threading.Event()
        self._stop = threading.Event()
        self._failing_since: float | None = None
        self._thread = threading.Thread(target=self._run, name=f"lease-{job_id}", daemon=True)

    @property
    def cancelled(self) -> bool:
        """Whether the user no longer wants the job."""
        return self._cancelled.is_set()

    @property
    def lost(self) -> bool:
        """Whether the job belongs to another worker now, or has ended: whatever is done for it is in vain."""
        return self._lost.is_set()

    def __enter__(self) -> LeaseKeeper:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        beat_every = min(self._settings.heartbeat_interval, self._settings.cancel_poll)
        show_every = max(self._settings.progress_interval, 0.05)
        beat_due = show_due = time.monotonic()
        while not self._lost.is_set():
            now = time.monotonic()
            if now >= show_due:
                if self._attempt(self._show):
                    beat_due = now + beat_every  # progress is a sign of life too
                show_due = time.monotonic() + show_every
            if now >= beat_due:
                self._attempt(self._beat)
                beat_due = time.monotonic() + beat_every
            if self._stop.wait(max(0.0, min(beat_due, show_due) - time.monotonic())):
                return

    def _attempt(self, action: Callable[[], bool]) -> bool:
        """Do something with the database; an outage is waited for, since it may pass before the lease does."""
        try:
            done = action()
        except SQLAlchemyError as error:
            if self._failing_since is None:
                self._failing_since = time.monotonic()
                logger.warning("job %s: the database does not answer: %s", self._job_id, error)
            return False
        if done and self._failing_since is not None:
            seconds = time.monotonic() - self._failing_since
            logger.info("job %s: the database answers again after %.1f s", self._job_id, seconds)
            self._failing_since = None
        return done

    def _beat(self) -> bool:
        with self._database.session() as session:
            state = jobs.heartbeat(session, self._job_id, self._lease)
        self._learn(state)
        return True

    def _show(self) -> bool:
        progress = self._board.read()
        if progress is None:
            return False
        preview = self._preview.read()
        if preview is None and progress == self._shown:
            return False
        with self._database.session() as session:
            state = jobs.report_progress(
                session, self._job_id, self._lease, progress.stage, progress.fraction, progress.message, preview
            )
        self._shown = progress
        self._preview.taken()
        self._learn(state)
        return True

    def _learn(self, state: JobState | None) -> None:
        if state is None:
            self._lost.set()  # also after this worker itself has ended the job, so it is nothing to log
        elif state is JobState.CANCELLING and not self._cancelled.is_set():
            logger.info("job %s: cancelled by its owner", self._job_id)
            self._cancelled.set()

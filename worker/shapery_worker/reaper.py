"""The reaper: finds what was lost and what has expired. ``shapery-worker reaper``.

Every second it takes running jobs from workers that fell silent, and sends the messages of queued jobs that have none.
Once a minute it removes what has expired, in a thread, so that a large sweep delays no recovery. Several reapers may
run at once: every change is conditional, and a message sent twice finds its job taken.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from pathlib import Path

from redis import RedisError
from sqlalchemy.exc import SQLAlchemyError

from shapery_contracts.errors import ShaperyError
from shapery_platform import dispatch, jobs, queue, retention
from shapery_platform.db import Database
from shapery_platform.queue import make_celery
from shapery_platform.settings import Settings
from shapery_platform.storage.opening import open_store
from shapery_worker.settings import scratch_root
from shapery_worker.stop_signal import StopSignal

ALIVE_WITHIN = 30.0
"""Seconds after which a reaper that has completed no turn is not healthy."""

RESEND_AFTER = 300.0
"""Seconds after which the message of a job that still waits is sent once more, however long the queue is."""
RESEND_EVERY = 60.0

logger = logging.getLogger(__name__)


def alive_file(settings: Settings) -> Path:
    """Return the file that a reaper on this machine touches after every turn."""
    return scratch_root(settings, "reaper") / "alive"


class Reaper:
    """Recovery and retention over one database, queue and store."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._database = Database(settings.database_url, pool_size=2)
        self._celery = make_celery(settings)
        self._retention: threading.Thread | None = None
        self._troubles: set[str] = set()
        self._resend_due = time.monotonic() + RESEND_EVERY

    def run(self, stop: StopSignal) -> None:
        """Take turns until asked to stop."""
        alive = alive_file(self._settings)
        alive.parent.mkdir(parents=True, exist_ok=True)
        retention_due = time.monotonic() + min(self._settings.retention_interval, 5.0)
        logger.info("the reaper looks every %g s", self._settings.reaper_interval)
        while not stop.wait(self._settings.reaper_interval):
            if self.turn():
                alive.touch()
            if time.monotonic() >= retention_due and (self._retention is None or not self._retention.is_alive()):
                self._retention = threading.Thread(target=self.expire, name="retention", daemon=True)
                self._retention.start()
                retention_due = time.monotonic() + self._settings.retention_interval
        if self._retention is not None:
            self._retention.join(5.0)
        alive.unlink(missing_ok=True)
        self._database.engine.dispose()

    def turn(self) -> bool:
        """Recover and dispatch once; tells whether everything answered."""
        # The one does not need the other: jobs of dead workers end as they should while the queue is away.
        recovered = self._attempt("recovery", self._recover)
        sent = self._attempt("dispatch", self._dispatch)
        if time.monotonic() >= self._resend_due:
            self._attempt("sending again", self.resend)
            self._resend_due = time.monotonic() + RESEND_EVERY
        return recovered and sent

    def resend(self) -> None:
        """Send old messages once more, as far as the queues are not twice as long as they should be.

        The dispatcher takes a message for lost when its queue is empty. A queue that never drains would hide the loss
        of one message for ever; a message too many is dropped by the claim.
        """
        for service, length in queue.queue_lengths(self._settings).items():
            room = 2 * self._settings.dispatch_window - length
            if room <= 0:
                continue
            with self._database.session(readonly=True) as session:
                waiting = jobs.queued_without_message(session, service, room, RESEND_AFTER)
            sent = dispatch.send(self._database, self._celery, waiting)
            if sent:
                logger.info("sent %d messages of %s once more", sent, service)

    def expire(self) -> bool:
        """Remove what has expired, once; tells whether everything answered."""
        return self._attempt("retention", self._expire)

    def _recover(self) -> None:
        with self._database.session() as session:
            lost = jobs.recover_lost(session, self._settings)
        if lost:
            logger.warning("took %d jobs from workers that fell silent", len(lost))
            dispatch.send(self._database, self._celery, lost)

    def _dispatch(self) -> None:
        sent = dispatch.dispatch_pending(self._database, self._celery, self._settings)
        if sent:
            logger.info("sent the messages of %d queued jobs", sent)

    def _expire(self) -> None:
        store = open_store(self._settings, self._database)
        retention.run_once(self._database, store, self._settings)

    def _attempt(self, name: str, action: Callable[[], None]) -> bool:
        """Do one part of a turn; what is away now is asked again in the next, and said once."""
        try:
            action()
        except (SQLAlchemyError, RedisError, ShaperyError, OSError) as error:
            if name not in self._troubles:
                logger.warning("%s has to wait: %s", name, error)
            self._troubles.add(name)
            return False
        except Exception:
            # A defect in one part must not end the others, on which the recovery of every job depends.
            logger.exception("%s failed", name)
            return False
        if name in self._troubles:
            logger.info("%s works again", name)
            self._troubles.discard(name)
        return True

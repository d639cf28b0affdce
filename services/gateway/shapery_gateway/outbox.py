"""Messages to the queue, sent after the commit of the rows they speak of.

A request answers as soon as its rows are committed. The message only makes a job start sooner: while the broker is
away, jobs stay queued in the database, and the reaper sends what no message was sent for. So a message that cannot be
sent is counted, said once in the log, and dropped.
"""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable, Sequence
from typing import Literal

from sqlalchemy.orm import Session

from shapery_platform.db.models import Job
from shapery_platform.jobs.recovery import QueuedJob

logger = logging.getLogger(__name__)

_KEY = "shapery_gateway.outbox"
MANY = 64
"""From so many messages on, the dispatcher sends them, which fills the queues up to their window only."""
MAX_WAITING = 10_000
"""Messages that wait at the most; beyond, the reaper sends them."""

Dispatch = Literal["dispatch"]
Entry = QueuedJob | Dispatch


def defer(session: Session, job: Job) -> None:
    """Remember to send the message of `job` once `session` has committed."""
    session.info.setdefault(_KEY, []).append(QueuedJob(job.id, job.kind, job.service))


def defer_dispatch(session: Session) -> None:
    """Remember to let the dispatcher look for queued jobs once `session` has committed."""
    session.info.setdefault(_KEY, []).append("dispatch")


def deferred(session: Session) -> list[Entry]:
    """Take what was remembered."""
    entries: list[Entry] = session.info.pop(_KEY, [])
    return entries


class Outbox:
    """A thread that sends messages, so that no request waits for the broker.

    Parameters
    ----------
    send
        Sends the messages of jobs.
    dispatch
        Sends the messages of whatever waits in the database.
    on_failure
        Called with the number of messages that were dropped.
    """

    def __init__(
        self,
        send: Callable[[Sequence[QueuedJob]], object],
        dispatch: Callable[[], object],
        on_failure: Callable[[int], None],
    ) -> None:
        self._send = send
        self._dispatch = dispatch
        self._on_failure = on_failure
        self._queue: queue.Queue[Entry | None] = queue.Queue(MAX_WAITING)
        self._down = False
        self._pending = 0
        self._idle = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="outbox", daemon=True)
        self._thread.start()

    def put(self, entries: Sequence[Entry]) -> None:
        """Send `entries` soon."""
        for entry in entries:
            with self._idle:
                self._pending += 1
            try:
                self._queue.put_nowait(entry)
            except queue.Full:
                self._done(1, dropped=1)

    def flush(self, timeout: float = 5.0) -> bool:
        """Wait until everything was sent or dropped; tell whether that came to pass in time."""
        with self._idle:
            return self._idle.wait_for(lambda: self._pending == 0, timeout)

    def close(self, timeout: float = 5.0) -> None:
        """Send what waits, then stop."""
        self.flush(timeout)
        try:
            self._queue.put_nowait(None)
        except queue.Full:
            return  # the thread is a daemon and ends with the process
        self._thread.join(timeout)

    def _run(self) -> None:
        while (first := self._queue.get()) is not None:
            entries = [first]
            while len(entries) < MAX_WAITING:
                try:
                    entry = self._queue.get_nowait()
                except queue.Empty:
                    break
                if entry is None:
                    self._deliver(entries)
                    return
                entries.append(entry)
            self._deliver(entries)

    def _deliver(self, entries: Sequence[Entry]) -> None:
        queued = [entry for entry in entries if isinstance(entry, QueuedJob)]
        dropped = 0
        try:
            if len(queued) != len(entries) or len(queued) >= MANY:
                self._dispatch()
            else:
                self._send(queued)
            if self._down:
                logger.info("the job queue answers again")
            self._down = False
        except Exception as error:
            if not self._down:
                logger.warning("jobs stay queued until the reaper sends them: %s", error)
            self._down = True
            dropped = len(entries)
        self._done(len(entries), dropped)

    def _done(self, count: int, dropped: int) -> None:
        if dropped:
            self._on_failure(dropped)
        with self._idle:
            self._pending -= count
            self._idle.notify_all()

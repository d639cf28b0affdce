"""From queued rows to messages: bounded, so that a large batch neither floods Redis nor makes others wait behind it.

A queue holds at most `Settings.dispatch_window` messages of the dispatcher; the rest follow as it drains. Whether a
message was lost (a crash between commit and send, or Redis without its last second) is seen when a queue is empty
while rows still wait.
"""

from __future__ import annotations

import logging
from collections.abc import Collection
from uuid import UUID

from shapery_contracts.errors import Unavailable
from shapery_platform import queue
from shapery_platform.db import Database
from shapery_platform.jobs.recovery import QueuedJob, mark_enqueued, queued_without_message
from shapery_platform.queue import Celery
from shapery_platform.settings import Settings

_log = logging.getLogger(__name__)

_LOST_AFTER = 5.0
"""Seconds after which a message that is in no queue counts as lost; a worker needs less to claim what it received."""


def submit(database: Database, celery: Celery, job_id: UUID, kind: str) -> bool:
    """Send the message of a job just committed. False where the queue does not answer: the reaper sends it later."""
    try:
        queue.enqueue(celery, job_id, kind)
    except Unavailable as error:
        _log.warning("job %s is queued, its message is sent later: %s", job_id, error)
        return False
    with database.session() as session:
        mark_enqueued(session, [job_id])
    return True


def send(database: Database, celery: Celery, jobs: Collection[QueuedJob]) -> int:
    """Send the messages of queued jobs and record it; raises ``service_unavailable``."""
    if not jobs:
        return 0
    sent = queue.send(celery, [(job.job_id, job.service) for job in jobs])
    with database.session() as session:
        mark_enqueued(session, [job.job_id for job in jobs])
    return sent


def dispatch_pending(database: Database, celery: Celery, settings: Settings) -> int:
    """Fill the queues up to the window; return how many messages were sent.

    Called by the reaper at its interval, and once after a batch was created.

    Raises
    ------
    Unavailable
        ``service_unavailable`` where Redis does not answer.
    """
    sent = 0
    for service, length in queue.queue_lengths(settings).items():
        room = settings.dispatch_window - length
        if room <= 0:
            continue
        with database.session(readonly=True) as session:
            jobs = queued_without_message(session, service, room, _LOST_AFTER if length == 0 else None)
        sent += send(database, celery, jobs)
    return sent

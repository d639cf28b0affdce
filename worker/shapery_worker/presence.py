"""What a worker's host says and does in the database: that the worker lives, and what became of killed processes.

Imported late, and itself importing late: the host first starts the process that runs the jobs, a host without handlers
has no hurry at all, and most need neither the queue nor the rows of jobs.
"""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import UUID

from sqlalchemy.exc import SQLAlchemyError

from shapery_contracts.errors import ShaperyError
from shapery_platform import workers
from shapery_platform.db import Database
from shapery_platform.settings import Settings

if TYPE_CHECKING:
    from celery import Celery

logger = logging.getLogger(__name__)


class Presence:
    """A worker's row in the list of workers, and the recovery of jobs on its machine.

    An outage of database, queue or folder is said once and waited for: later is early enough for everything here.
    """

    def __init__(self, settings: Settings, worker_id: str, service: str, root: Path) -> None:
        self._settings = settings
        self._worker_id = worker_id
        self._service = service
        self._root = root
        self._database = Database(settings.database_url, pool_size=1)
        self._registered = False
        self._troubled = False

    @cached_property
    def _celery(self) -> Celery:
        from shapery_platform.queue import make_celery

        return make_celery(self._settings)

    def tell_alive(self, kinds: Sequence[str]) -> None:
        """Say that the worker lives and which kinds it serves."""
        self._attempt(lambda: self._register(kinds))

    def tell_gone(self) -> None:
        """Take the worker off the list: it stops, or it cannot run jobs at the moment."""
        self._attempt(self._forget)

    def recover(self) -> None:
        """Give back the jobs whose watchers were killed on this machine."""
        from shapery_worker.recovery import recover_abandoned

        self._attempt(lambda: recover_abandoned(self._root, self._database, self._submit))

    def close(self) -> None:
        """Close the connections."""
        self._database.engine.dispose()

    def _register(self, kinds: Sequence[str]) -> None:
        with self._database.session() as session:
            if not (self._registered and workers.seen(session, self._worker_id)):
                workers.register(session, self._worker_id, self._service, kinds, socket.gethostname(), os.getpid())
        self._registered = True

    def _forget(self) -> None:
        if self._registered:
            with self._database.session() as session:
                workers.forget(session, self._worker_id)
            self._registered = False

    def _submit(self, job_id: UUID, kind: str) -> None:
        from shapery_platform import dispatch

        dispatch.submit(self._database, self._celery, job_id, kind)

    def _attempt(self, action: Callable[[], object]) -> None:
        try:
            action()
        except (SQLAlchemyError, ShaperyError, OSError) as error:
            if not self._troubled:
                logger.warning("database, queue or folder cannot be used: %s", error)
            self._troubled = True
        else:
            if self._troubled:
                logger.info("database, queue and folder can be used again")
            self._troubled = False

"""What goes by itself after its time: results, unfinished uploads, bytes that nothing refers to."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy.orm import Session

from shapery_platform import blobs, uploads, workers
from shapery_platform.db import Database, utc_now
from shapery_platform.db.repositories import blobs as blob_repository
from shapery_platform.db.repositories import jobs as job_repository
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore
from shapery_platform.storage.staging import UploadStaging

_log = logging.getLogger(__name__)

_AT_ONCE = 200
_STALE_TEMPORARY = 86_400.0
"""Seconds after which a temporary object has no living writer."""


@dataclass(frozen=True, slots=True)
class Swept:
    """What one run removed."""

    results: int
    uploads: int
    staged: int
    blobs: int
    temporary: int
    workers: int


def expire_results(session: Session, now: datetime, limit: int = _AT_ONCE) -> int:
    """Remove results and artifacts whose time is over; return of how many jobs. The jobs stay, and say so."""
    ids = job_repository.due_to_expire(session, now, limit)
    if ids:
        blob_repository.mark(session, job_repository.drop_results(session, ids), now)
    return len(ids)


def run_once(
    database: Database,
    store: ObjectStore,
    settings: Settings,
    *,
    staging: UploadStaging | None = None,
    now: datetime | None = None,
) -> Swept:
    """Remove everything whose time is over. Several processes may run this at the same time."""
    moment = now or utc_now()
    staging = staging or UploadStaging.over(store)
    expired = 0
    while True:
        with database.session() as session:
            some = expire_results(session, moment)
        expired += some
        if some < _AT_ONCE:
            break
    swept = Swept(
        results=expired,
        uploads=uploads.expire(database, staging, now=moment),
        staged=uploads.sweep_staging(database, staging),
        blobs=blobs.sweep(database, store, now=moment),
        temporary=store.sweep_temporary(_STALE_TEMPORARY),
        workers=_sweep_workers(database, settings),
    )
    if any((swept.results, swept.uploads, swept.staged, swept.blobs, swept.temporary)):
        _log.info("retention removed %s", swept)
    return swept


def _sweep_workers(database: Database, settings: Settings) -> int:
    with database.session() as session:
        return workers.sweep(session, settings)

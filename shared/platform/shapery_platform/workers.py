"""Worker processes that announced themselves, so that it can be said how many live ones serve a kind."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from datetime import timedelta

from sqlalchemy.orm import Session

from shapery_platform.db import database_now
from shapery_platform.db.models import Worker
from shapery_platform.db.repositories import workers as repository
from shapery_platform.settings import Settings


def register(session: Session, worker_id: str, service: str, kinds: Collection[str], host: str, pid: int) -> None:
    """Announce a worker; one that comes back under its id replaces itself."""
    repository.upsert(
        session,
        {
            "id": worker_id,
            "service": service,
            "kinds": sorted(kinds),
            "host": host,
            "pid": pid,
            "started_at": database_now(session),
            "seen_at": database_now(session),
        },
    )


def seen(session: Session, worker_id: str) -> bool:
    """Say that a worker lives; False where it was forgotten meanwhile and has to register again."""
    return repository.touch(session, worker_id, database_now(session))


def forget(session: Session, worker_id: str) -> None:
    """Take a worker off the list: it is going to stop."""
    repository.remove(session, worker_id)


def live(session: Session, settings: Settings) -> Sequence[Worker]:
    """Return the workers that were seen within the lease."""
    return repository.seen_since(session, database_now(session) - timedelta(seconds=settings.lease_seconds))


def live_by_kind(session: Session, settings: Settings) -> dict[str, int]:
    """Return how many live workers serve each kind; kinds that none serves are missing."""
    return dict(Counter(kind for worker in live(session, settings) for kind in worker.kinds))


def sweep(session: Session, settings: Settings) -> int:
    """Forget workers that were not seen for long; return how many."""
    return repository.remove_unseen(
        session, database_now(session) - timedelta(seconds=max(60.0, 10 * settings.lease_seconds))
    )

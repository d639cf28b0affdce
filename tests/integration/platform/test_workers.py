"""Workers that announce themselves, on both databases."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

from sqlalchemy import update

from shapery_platform import workers
from shapery_platform.db import Database
from shapery_platform.db.models import Worker
from shapery_platform.settings import Settings


def register(database: Database, worker_id: str, kinds: list[str]) -> None:
    with database.session() as session:
        workers.register(session, worker_id, "segmentation", kinds, "host", 42)


def fall_silent(database: Database, worker_id: str, seconds: float) -> None:
    with database.session() as session:
        past = datetime.now(UTC) - timedelta(seconds=seconds)
        session.execute(update(Worker).where(Worker.id == worker_id).values(seen_at=past))


def live(database: Database, settings: Settings) -> dict[str, int]:
    with database.session(readonly=True) as session:
        return workers.live_by_kind(session, settings)


def test_live_workers_are_counted_by_kind(database: Database, settings: Settings) -> None:
    register(database, "one", ["segmentation"])
    register(database, "two", ["segmentation", "phantom"])
    assert live(database, settings) == {"segmentation": 2, "phantom": 1}
    fall_silent(database, "two", settings.lease_seconds + 1)
    assert live(database, settings) == {"segmentation": 1}
    with database.session() as session:
        assert workers.seen(session, "two")
    assert live(database, settings) == {"segmentation": 2, "phantom": 1}
    with database.session() as session:
        workers.forget(session, "one")
        assert not workers.seen(session, "one"), "it has to register again"
    register(database, "one", ["phantom"])
    register(database, "one", ["segmentation"])
    assert live(database, settings) == {"segmentation": 2, "phantom": 1}


def test_workers_not_seen_for_long_are_forgotten(database: Database, settings: Settings) -> None:
    register(database, "lively", ["segmentation"])
    register(database, "silent", ["segmentation"])
    fall_silent(database, "silent", 3600)
    with database.session() as session:
        assert workers.sweep(session, settings) == 1
    with database.session() as session:
        assert workers.seen(session, "lively")
        assert not workers.seen(session, "silent")

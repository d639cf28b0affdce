"""Queries about workers."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any

from sqlalchemy import delete, select, update
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from shapery_platform.db.models import Worker


def upsert(session: Session, values: dict[str, Any]) -> None:
    """Insert a worker or replace the row it left."""
    insert: Any = postgresql.insert if session.get_bind().dialect.name == "postgresql" else sqlite.insert
    statement = insert(Worker).values(**values)
    session.execute(
        statement.on_conflict_do_update(
            index_elements=[Worker.id], set_={key: value for key, value in values.items() if key != "id"}
        )
    )


def touch(session: Session, worker_id: str, at: datetime) -> bool:
    """Record that a worker was seen; tell whether there is a row."""
    return (
        session.execute(update(Worker).where(Worker.id == worker_id).values(seen_at=at).returning(Worker.id)).first()
        is not None
    )


def remove(session: Session, worker_id: str) -> None:
    """Delete a worker's row."""
    session.execute(delete(Worker).where(Worker.id == worker_id))


def seen_since(session: Session, since: datetime) -> Sequence[Worker]:
    """Return the workers seen after `since`."""
    return session.scalars(select(Worker).where(Worker.seen_at >= since).order_by(Worker.id)).all()


def remove_unseen(session: Session, since: datetime) -> int:
    """Delete the rows of workers not seen after `since`; return how many."""
    return len(session.execute(delete(Worker).where(Worker.seen_at < since).returning(Worker.id)).all())

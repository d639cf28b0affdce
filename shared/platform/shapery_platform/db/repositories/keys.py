"""Queries about API keys."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import select, update
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from shapery_platform.db.models import ApiKey


def find_by_hash(session: Session, digest: str) -> ApiKey | None:
    """Return the key whose secret has this hash."""
    return session.scalars(select(ApiKey).where(ApiKey.secret_hash == digest)).one_or_none()


def note_use(session: Session, key_id: UUID, at: datetime) -> None:
    """Record the time of the last use."""
    session.execute(
        update(ApiKey).where(ApiKey.id == key_id).values(last_used_at=at).execution_options(synchronize_session=False)
    )


def of_owner(session: Session, owner: str) -> Sequence[ApiKey]:
    """Return the keys of an owner that are not revoked."""
    return session.scalars(
        select(ApiKey).where(ApiKey.owner == owner, ApiKey.revoked_at.is_(None)).order_by(ApiKey.id.desc())
    ).all()


def revoke(session: Session, owner: str, key_id: UUID, at: datetime) -> bool:
    """Mark a key as revoked; tell whether there was one to revoke."""
    return (
        session.execute(
            update(ApiKey)
            .where(ApiKey.id == key_id, ApiKey.owner == owner, ApiKey.revoked_at.is_(None))
            .values(revoked_at=at)
            .returning(ApiKey.id)
        ).first()
        is not None
    )


def insert_if_new(session: Session, values: dict[str, Any]) -> bool:
    """Insert a key unless one with this hash exists; tell whether it was inserted."""
    insert: Any = postgresql.insert if session.get_bind().dialect.name == "postgresql" else sqlite.insert
    statement = insert(ApiKey).values(**values).on_conflict_do_nothing(index_elements=[ApiKey.secret_hash])
    return session.execute(statement.returning(ApiKey.id)).first() is not None

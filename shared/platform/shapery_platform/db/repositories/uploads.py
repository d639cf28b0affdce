"""Queries about resumable uploads."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import delete, insert, or_, select, update
from sqlalchemy.orm import Session

from shapery_platform.db.models import Upload, UploadPart
from shapery_platform.storage.staging import StagedPart


def find(session: Session, owner: str, upload_id: UUID, *, lock: bool = False) -> Upload | None:
    """Return an upload as it is now, and with `lock` keep it so until the transaction ends."""
    query = select(Upload).where(Upload.id == upload_id, Upload.owner == owner)
    if lock:
        query = query.with_for_update()
    return session.scalars(query.execution_options(populate_existing=True)).one_or_none()


def parts(session: Session, upload_id: UUID) -> list[StagedPart]:
    """Return the staged parts in their order."""
    rows = session.scalars(
        select(UploadPart).where(UploadPart.upload_id == upload_id).order_by(UploadPart.offset)
    ).all()
    return [StagedPart(row.offset, row.size, row.key) for row in rows]


def take_lease(session: Session, upload_id: UUID, token: UUID, now: datetime, until: datetime) -> bool:
    """Give a request the right to write, unless another has it; tell whether it was given."""
    return (
        session.execute(
            update(Upload)
            .where(Upload.id == upload_id, or_(Upload.lease.is_(None), Upload.lease_until < now))
            .values(lease=token, lease_until=until)
            .returning(Upload.id)
            .execution_options(synchronize_session=False)
        ).first()
        is not None
    )


def advance(
    session: Session, upload_id: UUID, token: UUID, offset: int, staged: Iterable[StagedPart], **values: Any
) -> bool:
    """Record a new offset and its parts under the lease; tell whether the lease still held."""
    row = session.execute(
        update(Upload)
        .where(Upload.id == upload_id, Upload.lease == token)
        .values(offset=offset, **values)
        .returning(Upload.id)
        .execution_options(synchronize_session=False)
    ).first()
    if row is None:
        return False
    rows = [{"upload_id": upload_id, "offset": part.offset, "size": part.size, "key": part.key} for part in staged]
    if rows:
        session.execute(insert(UploadPart), rows)
    return True


def write(session: Session, upload_id: UUID, token: UUID, **values: Any) -> bool:
    """Write columns of an upload under the lease; tell whether the lease still held."""
    return (
        session.execute(
            update(Upload)
            .where(Upload.id == upload_id, Upload.lease == token)
            .values(**values)
            .returning(Upload.id)
            .execution_options(synchronize_session=False)
        ).first()
        is not None
    )


def remove(session: Session, upload_id: UUID, token: UUID | None = None) -> bool:
    """Delete an upload's row and parts, where a token is given only under it; tell whether there was one."""
    query = delete(Upload).where(Upload.id == upload_id)
    if token is not None:
        query = query.where(Upload.lease == token)
    return session.execute(query.returning(Upload.id)).first() is not None


def expired(session: Session, now: datetime, limit: int) -> Sequence[UUID]:
    """Return uploads whose time is over and that nobody is writing to."""
    return session.scalars(
        select(Upload.id)
        .where(Upload.expires_at <= now, or_(Upload.lease.is_(None), Upload.lease_until < now))
        .order_by(Upload.expires_at)
        .limit(limit)
    ).all()


def existing(session: Session, ids: Collection[UUID]) -> set[UUID]:
    """Return those of the ids that have a row."""
    return set(session.scalars(select(Upload.id).where(Upload.id.in_(ids))))

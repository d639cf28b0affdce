"""Queries about assets. Each names the owner: a row of somebody else does not exist."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from uuid import UUID

from sqlalchemy import Row, select
from sqlalchemy.orm import Session

from shapery_platform.db.models import Asset
from shapery_platform.paging import Columns, Sort, arranged

ORDERS: Columns = {"name": Asset.filename}

_AT_ONCE = 500
"""Ids in one condition; SQLite takes 32,766 variables, and a plan for more is slow anyway."""


def find(session: Session, owner: str, asset_id: UUID, *, lock: bool = False) -> Asset | None:
    """Return an asset that is not deleted."""
    query = select(Asset).where(Asset.id == asset_id, Asset.owner == owner, Asset.deleted_at.is_(None))
    if lock:
        query = query.with_for_update()
    return session.scalars(query).one_or_none()


def page(session: Session, owner: str, sort: Sort, limit: int, kind: str | None) -> Sequence[Asset]:
    """Return assets in an order."""
    query = select(Asset).where(Asset.owner == owner, Asset.deleted_at.is_(None))
    if kind is not None:
        query = query.where(Asset.kind == kind)
    return session.scalars(arranged(query, sort, Asset.id, ORDERS).limit(limit)).all()


def for_use(session: Session, owner: str, ids: Collection[UUID]) -> dict[UUID, Row[tuple[UUID, str, str]]]:
    """Return id, kind and file name of assets that exist, and keep these until the transaction ends."""
    wanted = sorted(set(ids))
    found: dict[UUID, Row[tuple[UUID, str, str]]] = {}
    for begin in range(0, len(wanted), _AT_ONCE):
        rows = session.execute(
            select(Asset.id, Asset.kind, Asset.filename)
            .where(Asset.id.in_(wanted[begin : begin + _AT_ONCE]), Asset.owner == owner, Asset.deleted_at.is_(None))
            .order_by(Asset.id)
            .with_for_update(read=True)
        )
        found.update({row.id: row for row in rows})
    return found


def hashes(session: Session, ids: Collection[UUID]) -> set[str]:
    """Return the hashes of assets, also of deleted ones."""
    return set(session.scalars(select(Asset.sha256).where(Asset.id.in_(ids))))

"""Queries about collections. Each names the owner: a row of somebody else does not exist."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import Row, case, func, select
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from shapery_platform.db.models import Collection, Shape
from shapery_platform.db.types import new_id, utc_now
from shapery_platform.paging import Sort, arranged


def find(session: Session, owner: str, collection_id: UUID, *, lock: bool = False) -> Collection | None:
    """Return a collection."""
    query = select(Collection).where(Collection.id == collection_id, Collection.owner == owner)
    if lock:
        query = query.with_for_update()
    return session.scalars(query).one_or_none()


def id_of(session: Session, owner: str, name: str, *, keep: bool = False) -> UUID | None:
    """Return the id of the collection called `name`, with `keep` held until the transaction ends."""
    query = select(Collection.id).where(Collection.owner == owner, Collection.name == name)
    if keep:
        query = query.with_for_update(read=True)
    return session.scalars(query).one_or_none()


def ensure(session: Session, owner: str, name: str) -> UUID:
    """Return the id of the collection called `name`, which is made where there is none, and keep it."""
    insert: Any = postgresql.insert if session.get_bind().dialect.name == "postgresql" else sqlite.insert
    session.execute(
        insert(Collection)
        .values(id=new_id(), owner=owner, name=name, description="", details={}, created_at=utc_now())
        .on_conflict_do_nothing(index_elements=[Collection.owner, Collection.name])
    )
    found = id_of(session, owner, name, keep=True)
    assert found is not None
    return found


def page(session: Session, owner: str, sort: Sort, limit: int) -> Sequence[Collection]:
    """Return collections in an order."""
    query = select(Collection).where(Collection.owner == owner)
    return session.scalars(arranged(query, sort, Collection.id).limit(limit)).all()


def counts(session: Session, ids: Sequence[UUID], version: int) -> Sequence[Row[Any]]:
    """Return for each collection that has any its number of shapes, and of those of other index versions."""
    return session.execute(
        select(
            Shape.collection_id,
            func.count().label("shapes"),
            func.sum(case((Shape.index_version == version, 0), else_=1)).label("outdated"),
        )
        .where(Shape.collection_id.in_(ids))
        .group_by(Shape.collection_id)
    ).all()

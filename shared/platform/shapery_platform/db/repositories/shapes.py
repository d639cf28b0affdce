"""Queries about shapes. Each names the owner: a row of somebody else does not exist."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import Row, Select, delete, exists, func, insert, select, update
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from shapery_platform.db.models import Asset, Bank, Shape, ShapeFile, ShapeGraph, ShapeLabel
from shapery_platform.paging import Columns, Sort, arranged

ORDERS: Columns = {"name": Shape.name}


def change_bank(session: Session, owner: str, *, removal: bool = False) -> int:
    """Count a change of an owner's shapes and return its number; others who change them wait for this transaction."""
    insert_: Any = postgresql.insert if session.get_bind().dialect.name == "postgresql" else sqlite.insert
    statement = insert_(Bank).values(owner=owner, revision=1, removals=int(removal))
    revision: int = session.execute(
        statement.on_conflict_do_update(
            index_elements=[Bank.owner],
            set_={"revision": Bank.revision + 1, "removals": Bank.removals + int(removal)},
        ).returning(Bank.revision)
    ).scalar_one()
    return revision


def find(session: Session, owner: str, shape_id: UUID) -> Shape | None:
    """Return a shape, as it is now."""
    return session.scalars(
        select(Shape).where(Shape.id == shape_id, Shape.owner == owner).execution_options(populate_existing=True)
    ).one_or_none()


def find_all(session: Session, owner: str, ids: Collection[UUID]) -> Sequence[Shape]:
    """Return those of some shapes that exist."""
    return session.scalars(select(Shape).where(Shape.id.in_(ids), Shape.owner == owner)).all()


def page(
    session: Session,
    owner: str,
    sort: Sort,
    limit: int,
    *,
    collection_id: UUID | None,
    labels: Mapping[str, str],
    name: str | None,
    outdated_at: int | None,
    job_id: UUID | None = None,
) -> Sequence[Shape]:
    """Return shapes in an order."""
    # As in `jobs.page`: a collection's shapes are few among all those of its owner.
    owned = (Shape.owner if collection_id is None else Shape.owner.concat("")) == owner
    query = select(Shape).where(owned, *narrowed(collection_id, labels))
    if name is not None:
        query = query.where(Shape.name.icontains(name, autoescape=True))
    if outdated_at is not None:
        query = query.where(Shape.index_version != outdated_at)
    if job_id is not None:
        query = query.where(Shape.job_id == job_id)
    return session.scalars(arranged(query, sort, Shape.id, ORDERS).limit(limit)).all()


def label_counts(
    session: Session, owner: str, limit: int, *, collection_id: UUID | None
) -> Sequence[Row[tuple[str, str, int]]]:
    """Return labels as name, value and number of shapes, the most frequent first."""
    number = func.count().label("shapes")
    return session.execute(
        select(ShapeLabel.name, ShapeLabel.value, number)
        .join(Shape, Shape.id == ShapeLabel.shape_id)
        .where(Shape.owner == owner, *narrowed(collection_id, {}))
        .group_by(ShapeLabel.name, ShapeLabel.value)
        .order_by(number.desc(), ShapeLabel.name, ShapeLabel.value)
        .limit(limit)
    ).all()


def narrowed(collection_id: UUID | None, labels: Mapping[str, str]) -> list[Any]:
    """Return the conditions that a shape belongs to a collection and carries labels."""
    conditions: list[Any] = [] if collection_id is None else [Shape.collection_id == collection_id]
    conditions += [
        exists().where(ShapeLabel.shape_id == Shape.id, ShapeLabel.name == name, ShapeLabel.value == value)
        for name, value in sorted(labels.items())
    ]
    return conditions


def outdated(
    session: Session, owner: str, collection_id: UUID, version: int, limit: int
) -> Sequence[Row[tuple[UUID, UUID]]]:
    """Return shapes of other index versions with their assets, as far as those are not deleted."""
    return session.execute(
        select(Shape.id, Shape.asset_id)
        .join(Asset, Asset.id == Shape.asset_id)
        .where(
            Shape.collection_id == collection_id,
            Shape.owner == owner,
            Shape.index_version != version,
            Asset.deleted_at.is_(None),
        )
        .order_by(Shape.id)
        .limit(limit)
    ).all()


def add(session: Session, values: Mapping[str, Any], graph: bytes) -> None:
    """Insert a shape and its graph."""
    session.execute(insert(Shape), [dict(values)])
    session.execute(insert(ShapeGraph), [{"shape_id": values["id"], "data": graph}])


def replace(session: Session, shape_id: UUID, values: Mapping[str, Any], graph: bytes) -> None:
    """Overwrite what indexing tells of a shape."""
    change(session, shape_id, values)
    session.execute(
        update(ShapeGraph)
        .where(ShapeGraph.shape_id == shape_id)
        .values(data=graph)
        .execution_options(synchronize_session=False)
    )


def change(session: Session, shape_id: UUID, values: Mapping[str, Any]) -> None:
    """Overwrite columns of a shape."""
    session.execute(
        update(Shape).where(Shape.id == shape_id).values(**values).execution_options(synchronize_session=False)
    )


def put_files(session: Session, shape_id: UUID, files: Sequence[Mapping[str, Any]]) -> list[str]:
    """Give a shape these files and no others; return the hashes of those it had."""
    before = session.scalars(delete(ShapeFile).where(ShapeFile.shape_id == shape_id).returning(ShapeFile.sha256)).all()
    if files:
        session.execute(insert(ShapeFile), [{"shape_id": shape_id, **file} for file in files])
    return sorted(set(before))


def put_labels(session: Session, shape_id: UUID, labels: Mapping[str, str]) -> None:
    """Give a shape these labels and no others."""
    session.execute(delete(ShapeLabel).where(ShapeLabel.shape_id == shape_id))
    if labels:
        session.execute(
            insert(ShapeLabel),
            [{"shape_id": shape_id, "name": name, "value": value} for name, value in labels.items()],
        )


def find_file(session: Session, owner: str, shape_id: UUID, name: str) -> ShapeFile | None:
    """Return a file of a shape."""
    return session.scalars(
        select(ShapeFile)
        .join(Shape, Shape.id == ShapeFile.shape_id)
        .where(Shape.id == shape_id, Shape.owner == owner, ShapeFile.name == name)
    ).one_or_none()


def graph(session: Session, owner: str, shape_id: UUID) -> bytes | None:
    """Return the graph of a shape."""
    return session.scalars(
        select(ShapeGraph.data)
        .join(Shape, Shape.id == ShapeGraph.shape_id)
        .where(Shape.id == shape_id, Shape.owner == owner)
    ).one_or_none()


def of_collection(collection_id: UUID) -> Select[tuple[UUID]]:
    """Select the shapes of a collection."""
    return select(Shape.id).where(Shape.collection_id == collection_id)


def remove(session: Session, chosen: Any) -> list[str]:
    """Delete the shapes whose ids `chosen` selects or lists, and return the hashes that they referred to."""
    hashes = session.scalars(delete(ShapeFile).where(ShapeFile.shape_id.in_(chosen)).returning(ShapeFile.sha256)).all()
    for table in (ShapeGraph, ShapeLabel):
        session.execute(delete(table).where(table.shape_id.in_(chosen)).execution_options(synchronize_session=False))
    session.execute(delete(Shape).where(Shape.id.in_(chosen)).execution_options(synchronize_session=False))
    return sorted(set(hashes))

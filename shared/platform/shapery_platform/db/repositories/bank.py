"""What a search reads: vectors and graphs of an owner's shapes of one index version."""

from __future__ import annotations

from collections.abc import Collection as Ids
from collections.abc import Iterator, Mapping, Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import Float, Row, bindparam, func, select, text
from sqlalchemy.orm import Session

from shapery_contracts.retrieval import VECTOR_DIMENSION, By, Nearest
from shapery_platform.db.models import Bank, Collection, Shape, ShapeGraph
from shapery_platform.db.repositories.shapes import narrowed
from shapery_platform.db.types import SentHalfVector, Vector, pack_vector

_AT_ONCE = 500
_COLUMNS: dict[By, Any] = {"whole": Shape.vector, "parts": Shape.part_vector}


def state(session: Session, owner: str) -> tuple[int, int]:
    """Return the number of the last change, and how often shapes were taken away."""
    row = session.execute(select(Bank.revision, Bank.removals).where(Bank.owner == owner)).one_or_none()
    return (0, 0) if row is None else (row.revision, row.removals)


def vectors_after(session: Session, owner: str, revision: int, by: By) -> Iterator[Row[tuple[UUID, int, bytes | None]]]:
    """Iterate over id, index version and ``vector`` of shapes that changed after a revision."""
    column: Any = _COLUMNS[by]
    return iter(
        session.execute(
            select(Shape.id, Shape.index_version, column.label("vector"))
            .where(Shape.owner == owner, Shape.revision > revision)
            .order_by(Shape.revision)
            .execution_options(yield_per=5000)
        )
    )


def ids(
    session: Session, owner: str, version: int, collection: str | None, labels: Mapping[str, str]
) -> Sequence[UUID]:
    """Return the shapes of an index version in the collection of this name and with these labels."""
    query = select(Shape.id).where(
        Shape.owner == owner, Shape.index_version == version, *_conditions(collection, labels)
    )
    return session.scalars(query).all()


def nearest(session: Session, owner: str, asked: Nearest) -> Sequence[Row[tuple[UUID, float, bytes]]]:
    """Return ids, distances and vectors of the shapes nearest to a vector; PostgreSQL alone can tell.

    For wholes an index of neighbours is walked until enough of them meet the conditions (pgvector 0.8). For parts all
    are measured: what a part asks for lies far from every whole, and such an index loses its way there.
    """
    session.execute(text("SET LOCAL hnsw.iterative_scan = strict_order"))
    session.execute(text(f"SET LOCAL hnsw.ef_search = {min(1000, max(100, 2 * asked.limit)):d}"))
    query = bindparam("vector", pack_vector(asked.vector), type_=Vector(VECTOR_DIMENSION))
    column: Any = _COLUMNS[asked.by]
    sent = func.halfvec_send(column, type_=SentHalfVector())
    distance: Any = column.op("<->", return_type=Float())(query)
    return session.execute(
        select(Shape.id, distance.label("distance"), sent.label("vector"))
        .where(
            Shape.owner == owner,
            Shape.index_version == asked.version,
            column.is_not(None),
            *_conditions(asked.only.collection, asked.only.labels),
        )
        .order_by(distance)
        .limit(asked.limit)
    ).all()


def graphs(session: Session, owner: str, version: int, wanted: Ids[UUID]) -> Iterator[tuple[UUID, bytes]]:
    """Iterate over those of some shapes that exist in an index version, with their graphs."""
    listed = sorted(wanted)
    for begin in range(0, len(listed), _AT_ONCE):
        rows = session.execute(
            select(ShapeGraph.shape_id, ShapeGraph.data)
            .join(Shape, Shape.id == ShapeGraph.shape_id)
            .where(
                ShapeGraph.shape_id.in_(listed[begin : begin + _AT_ONCE]),
                Shape.owner == owner,
                Shape.index_version == version,
            )
        )
        for row in rows:
            yield row.shape_id, row.data


def _conditions(collection: str | None, labels: Mapping[str, str]) -> list[Any]:
    conditions = narrowed(None, labels)
    if collection is not None:
        named = select(Collection.id).where(Collection.owner == Shape.owner, Collection.name == collection)
        conditions.append(Shape.collection_id.in_(named))
    return conditions

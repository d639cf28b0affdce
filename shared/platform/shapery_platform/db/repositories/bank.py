"""What a search reads: vectors and graphs of an owner's shapes of one index version."""

from __future__ import annotations

from collections.abc import Collection as Ids
from collections.abc import Iterator, Mapping, Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import Float, Row, bindparam, false, func, select
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
    query = select(Shape.id).where(Shape.index_version == version, *_conditions(session, owner, collection, labels))
    return session.scalars(query).all()


def nearest(session: Session, owner: str, asked: Nearest) -> Sequence[Row[tuple[UUID, float, bytes]]]:
    """Return ids, distances and vectors of the shapes nearest to a vector; PostgreSQL alone can tell.

    For wholes it walks an index of neighbours (pgvector 0.8), or measures all shapes that meet the conditions where
    they are few by its statistics. A walk gives up after a while, far from shapes that meet the conditions: then they
    are measured after all. For parts there is no such index: what a part asks for lies far from every whole, and it
    would lose its way there.
    """
    query = bindparam("vector", pack_vector(asked.vector), type_=Vector(VECTOR_DIMENSION))
    column: Any = _COLUMNS[asked.by]
    sent = func.halfvec_send(column, type_=SentHalfVector())
    distance: Any = column.op("<->", return_type=Float())(query)
    found = (
        select(Shape.id, distance.label("distance"), sent.label("vector"))
        .where(
            Shape.index_version == asked.version,
            column.is_not(None),
            *_conditions(session, owner, asked.only.collection, asked.only.labels),
        )
        .limit(asked.limit)
    )
    if asked.by == "whole":
        session.execute(
            select(
                # whoever asks puts them in order: what comes late is not to be left out
                func.set_config("hnsw.iterative_scan", "relaxed_order", True),
                func.set_config("hnsw.ef_search", str(min(1000, max(100, asked.limit + asked.limit // 4))), True),
                # how many shapes meet the conditions depends on the very collection and labels
                func.set_config("plan_cache_mode", "force_custom_plan", True),
            )
        )
        rows = session.execute(found.order_by(distance)).all()
        if len(rows) == asked.limit:
            return rows
    return session.execute(found.order_by(distance + 0.0)).all()  # no index is of this sum


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


def _conditions(session: Session, owner: str, collection: str | None, labels: Mapping[str, str]) -> list[Any]:
    conditions = [Shape.owner == owner, *narrowed(None, labels)]
    if collection is not None:
        named = select(Collection.id).where(Collection.owner == owner, Collection.name == collection)
        # asked for by itself: PostgreSQL knows how many shapes are in a collection, if it knows which one
        found = session.scalar(named)
        conditions.append(false() if found is None else Shape.collection_id == found)
    return conditions

"""Lists, page by page: by a column and then by id, so that every place in the order is one row's.

Ids are UUIDv7, so that they alone are the order of creation. A cursor says where the last item shown stood, not how
many came before: it stays right while rows come and go, and wherever that item has moved since.
"""

from __future__ import annotations

import json
from base64 import urlsafe_b64decode, urlsafe_b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar
from uuid import UUID

from sqlalchemy import Float, Select, tuple_
from sqlalchemy.orm import InstrumentedAttribute

from shapery_contracts.errors import InvalidInput

T = TypeVar("T")
S = TypeVar("S", bound=Select[Any])

LARGEST_PAGE = 500
NEWEST_FIRST: Final = "-created"

Columns = Mapping[str, InstrumentedAttribute[Any]]
"""What else than the time of creation a list may be ordered by."""
NO_COLUMNS: Columns = {}


@dataclass(frozen=True, slots=True)
class Sort:
    """By what a list is ordered, and after which place it is read."""

    by: str = "created"
    descending: bool = True
    after: UUID | tuple[str | float, UUID] | None = None
    """The last item shown: its id, or its value and its id."""


def parse_sort(cursor: str | None, order: str = NEWEST_FIRST, columns: Columns = NO_COLUMNS) -> Sort:
    """Return the order that is named, ``name`` or ``-name`` (downwards), after the place behind a cursor.

    Raises
    ------
    InvalidInput
        ``validation_failed`` where the cursor is none of ours, or of another order.
    """
    by, descending = order.removeprefix("-"), order.startswith("-")
    if cursor is None:
        return Sort(by, descending)
    try:
        if by == "created":
            return Sort(by, descending, UUID(cursor))
        of, value, at = json.loads(urlsafe_b64decode(cursor.encode("ascii")))
        number = isinstance(columns[by].type, Float)
        if of != order or not isinstance(value, float if number else str) or "\0" in str(value).encode().decode():
            raise ValueError
        return Sort(by, descending, (value, UUID(at)))
    except (ValueError, TypeError, AttributeError, RecursionError):
        raise InvalidInput(
            "validation_failed",
            "The cursor is not one that a list in this order gave out.",
            "Use `next_cursor` of the page before, or leave it out for the first page.",
        ) from None


def arranged(query: S, sort: Sort, identity: InstrumentedAttribute[UUID], columns: Columns = NO_COLUMNS) -> S:
    """Put a query into an order, and begin it after the place where the page before ended."""
    place: Any
    if sort.by == "created":
        keys, place = [identity], identity
    else:
        keys = [columns[sort.by], identity]
        place = tuple_(*keys)
    if sort.after is not None:
        query = query.where(place < sort.after if sort.descending else place > sort.after)
    return query.order_by(*(key.desc() if sort.descending else key for key in keys))


def cut_page(rows: Sequence[T], limit: int, sort: Sort, columns: Columns = NO_COLUMNS) -> tuple[list[T], str | None]:
    """Cut `limit` rows off a query for one more, and return them with the cursor of the next page."""
    if len(rows) <= limit:
        return list(rows), None
    last: Any = rows[limit - 1]
    if sort.by == "created":
        return list(rows[:limit]), str(last.id)
    order = f"-{sort.by}" if sort.descending else sort.by
    place = json.dumps([order, getattr(last, columns[sort.by].key), str(last.id)])
    return list(rows[:limit]), urlsafe_b64encode(place.encode()).decode()


def checked_limit(limit: int) -> int:
    """Bring a page size into 1 … `LARGEST_PAGE`."""
    return max(1, min(limit, LARGEST_PAGE))

"""Cursors of lists. Ids are UUIDv7, so the id of the last item shown is a cursor that stays right while rows come."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar
from uuid import UUID

from shapery_contracts.errors import InvalidInput

T = TypeVar("T")

LARGEST_PAGE = 500


def parse_cursor(cursor: str | None) -> UUID | None:
    """Return the id behind a cursor.

    Raises
    ------
    InvalidInput
        ``validation_failed`` where it is none of ours.
    """
    if cursor is None:
        return None
    try:
        return UUID(cursor)
    except ValueError:
        raise InvalidInput(
            "validation_failed",
            "The cursor is not one that a list gave out.",
            "Use `next_cursor` of the page before, or leave it out for the first page.",
        ) from None


def cut_page(rows: Sequence[T], limit: int, key: Callable[[T], UUID]) -> tuple[list[T], str | None]:
    """Cut `limit` rows off a query for one more, and return them with the cursor of the next page."""
    if len(rows) <= limit:
        return list(rows), None
    return list(rows[:limit]), str(key(rows[limit - 1]))


def checked_limit(limit: int) -> int:
    """Bring a page size into 1 … `LARGEST_PAGE`."""
    return max(1, min(limit, LARGEST_PAGE))

"""Headers and query parameters that more than one resource takes."""

from __future__ import annotations

from collections import Counter
from typing import Annotated, get_origin

from fastapi import Depends, Header, Query, Request

from shapery_contracts.errors import InvalidInput

MAX_SEQ = 2**31 - 1

IdempotencyKey = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=255,
        description="Any text of your choice. A second request with the same key and the same body returns the first "
        "one's result; with another body it is refused.",
    ),
]


async def last_event(
    after: Annotated[
        int | None, Query(ge=0, le=MAX_SEQ, description="Number of the last event received; all later ones follow.")
    ] = None,
    last_event_id: Annotated[
        str | None,
        Header(
            alias="Last-Event-ID",
            pattern=r"^[0-9]{0,9}$",
            description="The same as `after`, as browsers send it when they reconnect; it comes first.",
        ),
    ] = None,
) -> int:
    """Return the number of the event after which a stream continues; 0: from the beginning."""
    return int(last_event_id) if last_event_id else after or 0


LastEvent = Annotated[int, Depends(last_event)]


async def refuse_repeated(request: Request) -> None:
    """Refuse a query parameter that is given twice and takes one value: nobody knows which is meant.

    Raises
    ------
    InvalidInput
        ``validation_failed``.
    """
    given = Counter(name for name, _ in request.query_params.multi_items())
    if given.total() == len(given):
        return
    for parameter in request.scope["route"].dependant.query_params:
        if given[parameter.alias] > 1 and get_origin(parameter.field_info.annotation) is not list:
            raise InvalidInput("validation_failed", f"The parameter {parameter.alias!r} is given more than once.")

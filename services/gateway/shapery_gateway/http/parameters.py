"""Headers and query parameters that more than one resource takes."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Header, Query

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

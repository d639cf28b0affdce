"""Batches that come as NDJSON: a header, then one item per line."""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from shapery_contracts.api import BatchHeader, BatchItem
from shapery_contracts.errors import InvalidInput, LimitExceeded
from shapery_gateway.http.storable import refuse_unstorable
from shapery_gateway.problems import ProblemError

M = TypeVar("M", bound=BaseModel)

MEDIA_TYPE = "application/x-ndjson"
MAX_LINE = 1 << 20


async def lines(stream: AsyncIterator[bytes]) -> AsyncGenerator[tuple[int, bytes], None]:
    """Yield the lines of `stream` that are not empty, with their numbers from 1.

    Raises
    ------
    ProblemError
        ``request_too_large`` for a line of more than `MAX_LINE` bytes.
    """
    rest = b""
    number = 0
    async for data in stream:
        *complete, rest = (rest + data).split(b"\n")
        for line in complete:
            number += 1
            if line.strip():
                yield number, line
        if len(rest) > MAX_LINE:
            raise ProblemError("request_too_large", f"Line {number + 1} has more than {MAX_LINE} bytes.")
    if rest.strip():
        yield number + 1, rest


async def read_batch(stream: AsyncIterator[bytes], max_items: int) -> tuple[BatchHeader, list[BatchItem]]:
    """Read a whole batch, line by line: the first mistake ends it, however much would follow.

    Raises
    ------
    UserError, ProblemError
        With the number of the line that is wrong.
    """
    header: BatchHeader | None = None
    items: list[BatchItem] = []
    async for number, line in lines(stream):
        if header is None:
            header = _parse(BatchHeader, number, line)
        elif len(items) == max_items:
            raise LimitExceeded("too_large", f"The batch has more than {max_items} items.", "Send several batches.")
        else:
            items.append(_parse(BatchItem, number, line))
    if header is None:
        raise InvalidInput(
            "validation_failed", "The body is empty; its first line must be the batch's kind and params."
        )
    return header, items


def _parse(model: type[M], number: int, line: bytes) -> M:
    try:
        parsed = model.model_validate_json(line)
    except ValidationError as error:
        fault = error.errors(include_url=False, include_input=False, include_context=False)[0]
        place = ".".join(str(part) for part in fault["loc"])
        raise InvalidInput(
            "validation_failed",
            f"Line {number} is not valid: {f'{place}: ' if place else ''}{fault['msg']}.",
            "The first line is {kind, params}, every further line {inputs, params}.",
        ) from None
    refuse_unstorable(parsed.model_dump(), f"Line {number}")
    return parsed

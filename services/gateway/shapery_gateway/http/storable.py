"""Refuses text and numbers that JSON can carry and a database cannot keep."""

from __future__ import annotations

import math
from typing import Any

from shapery_contracts.errors import InvalidInput

MAX_DEPTH = 32


def refuse_unstorable(value: Any, where: str) -> None:
    """Look through a JSON value for what cannot be stored.

    Raises
    ------
    InvalidInput
        ``validation_failed`` for a NUL character, a lone surrogate, a number that is not finite, or nesting deeper
        than `MAX_DEPTH`.
    """
    waiting: list[tuple[Any, int]] = [(value, 0)]
    while waiting:
        item, depth = waiting.pop()
        if depth > MAX_DEPTH:
            raise InvalidInput("validation_failed", f"{where} is nested deeper than {MAX_DEPTH} levels.")
        if isinstance(item, dict):
            waiting.extend((part, depth + 1) for pair in item.items() for part in pair)
        elif isinstance(item, list | tuple):
            waiting.extend((part, depth + 1) for part in item)
        elif isinstance(item, str):
            if "\0" in item or any("\ud800" <= char <= "\udfff" for char in item):
                raise InvalidInput("validation_failed", f"{where} holds a NUL character or half a surrogate pair.")
        elif isinstance(item, float) and not math.isfinite(item):
            raise InvalidInput("validation_failed", f"{where} holds a number that is not finite.")

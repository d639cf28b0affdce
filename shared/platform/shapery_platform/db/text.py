"""Text that both databases can hold."""

from __future__ import annotations

import json
from typing import Any


def storable(text: str, limit: int | None = None) -> str:
    """Return `text` without what PostgreSQL cannot store (NUL, lone surrogates), cut to `limit` characters."""
    text = text.replace("\0", "").encode("utf-8", "replace").decode()
    return text if limit is None or len(text) <= limit else f"{text[: limit - 1]}…"


def canonical_json(value: Any) -> str:
    """Return JSON that is equal for equal values; raises ValueError for NaN and infinity, which JSON has not."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)

"""How a worker's main process tells the process that started it that it listens, and for which kinds."""

from __future__ import annotations

import json
import os


def tell_ready(descriptor: int, kinds: list[str]) -> None:
    """Write the kinds that are served to `descriptor` and close it."""
    os.write(descriptor, json.dumps(kinds).encode())
    os.close(descriptor)


def read_ready(descriptor: int) -> list[str] | None:
    """Return the kinds, or None as long as nothing was told. `descriptor` does not block."""
    try:
        data = os.read(descriptor, 65536)
    except BlockingIOError:
        return None
    if not data:
        return None
    return [str(kind) for kind in json.loads(data)]

"""Figures that tests measure and do not judge: kept as lines of JSON for whoever reports them."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.conftest import ROOT


def record(name: str, seconds: float, **details: object) -> None:
    """Append one figure to ``build/measures/recovery.jsonl`` (``SHAPERY_MEASURES`` names another file) and print it."""
    path = Path(os.environ.get("SHAPERY_MEASURES", ROOT / "build" / "measures" / "recovery.jsonl"))
    path.parent.mkdir(parents=True, exist_ok=True)
    line = json.dumps({"name": name, "seconds": round(seconds, 3), **details})
    with path.open("a") as file:
        file.write(line + "\n")
    print(line)


@contextmanager
def measured(name: str, **details: object) -> Iterator[None]:
    """Record how long the block takes."""
    began = time.monotonic()
    yield
    record(name, time.monotonic() - began, **details)

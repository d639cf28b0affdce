"""Measurements kept as JSON under a digest of what they depend on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Cache:
    """A folder with one file per measurement."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder

    def get(self, name: str, key: str, measure: Callable[[], Any]) -> Any:
        """Return the measurement `name` made under `key`, or make it."""
        path = self.folder / f"{''.join(c if c.isalnum() else '_' for c in name)}-{key}.json"
        if path.exists():
            return json.loads(path.read_text())
        value = measure()
        path.write_text(json.dumps(value))
        return value


def digest(*parts: object) -> str:
    """Return a short digest of values that print alike when they are alike."""
    return hashlib.sha256("\n".join(map(repr, parts)).encode()).hexdigest()[:12]


def digest_arrays(*arrays: NDArray[Any]) -> str:
    """Return a short digest of arrays."""
    h = hashlib.sha256()
    for array in arrays:
        h.update(f"{array.dtype}{array.shape}".encode())
        h.update(np.ascontiguousarray(array).view(np.uint8))
    return h.hexdigest()[:12]


def digest_sources(*folders: Path) -> str:
    """Return a short digest of all Python sources below `folders`."""
    h = hashlib.sha256()
    for path in sorted(_sources(folders)):
        h.update(path.name.encode())
        h.update(path.read_bytes())
    return h.hexdigest()[:12]


def _sources(folders: Iterable[Path]) -> Iterable[Path]:
    for folder in folders:
        yield from folder.rglob("*.py")

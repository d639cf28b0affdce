"""Content addressing: what a stored blob is called, and the errors of storage."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from shapery_contracts.errors import LimitExceeded, ShaperyError

CHUNK = 1 << 20
"""Bytes read or written at a time; memory stays a small multiple of it."""

Pin = Callable[[str, int], None]
"""Called with hash and size before bytes are published, so that no sweep removes them before a row refers to them."""


class StoredObjectMissing(ShaperyError):
    """A row refers to an object that the store does not have."""


class StagingLost(ShaperyError):
    """The staged bytes of an upload are fewer than its row says."""


@dataclass(frozen=True, slots=True)
class StoredBlob:
    """Bytes in the object store: their SHA-256 in hexadecimal digits and their number."""

    sha256: str
    size: int

    @property
    def key(self) -> str:
        """Where they are."""
        return object_key(self.sha256)


def object_key(sha256: str) -> str:
    """Return the key of the blob with this hash: ``objects/ab/cdef…``."""
    if len(sha256) != 64 or not set(sha256) <= set("0123456789abcdef"):
        raise ValueError(f"not a SHA-256 in lower-case hexadecimal digits: {sha256!r}")
    return f"objects/{sha256[:2]}/{sha256[2:]}"


def storage_full(needed: int, free: int, reserve: int) -> LimitExceeded:
    """Return the error for `needed` bytes where `free` are left and `reserve` must stay."""
    room = max(0, free - reserve)
    return LimitExceeded(
        "storage_full",
        f"The storage has room for {room:,} more bytes, and {needed:,} are needed.",
        "Delete what is no longer used, or ask the operator for more space.",
    )


@contextmanager
def disk_errors() -> Iterator[None]:
    """Turn a full disk into the error that says so."""
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise LimitExceeded(
                "storage_full",
                "The storage ran full while bytes were written.",
                "Delete what is no longer used, or ask the operator for more space.",
            ) from error
        raise

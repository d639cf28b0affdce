"""The object store: what the platform asks of a local folder and of S3 alike."""

from __future__ import annotations

import errno
import io
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Self

from shapery_platform.storage.content import CHUNK, Pin, StoredBlob

TEMPORARY = "tmp/"
"""Prefix of what is being written and has no name yet."""
STAGING = "staging/"
"""Prefix of uploads that are not finished."""


@dataclass(frozen=True, slots=True)
class ObjectEntry:
    """One object of a listing."""

    key: str
    size: int
    modified: datetime


class BlobWriter(ABC):
    """Bytes on their way into the store whose hash is not known yet.

    Nothing is visible under a content address before `finish`; leaving the ``with`` block without it discards them.
    """

    @property
    @abstractmethod
    def size(self) -> int:
        """Bytes written so far."""

    @abstractmethod
    def write(self, data: bytes | memoryview) -> None:
        """Append `data`; raises ``storage_full`` when the disk is nearly full."""

    @abstractmethod
    def finish(self) -> StoredBlob:
        """Publish the bytes under their hash, atomically, unless they are there already."""

    @abstractmethod
    def discard(self) -> None:
        """Forget the bytes. Harmless after `finish`."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.discard()


class ObjectStore(ABC):
    """Objects by key. Blobs live under the key that their hash gives (`object_key`)."""

    pin: Pin | None = None
    """Called before a blob is published; `open_store` sets it."""

    @abstractmethod
    def writer(self, expected: int | None = None) -> BlobWriter:
        """Begin a blob; `expected` bytes, where known, must have room."""

    def put_bytes(self, data: bytes) -> StoredBlob:
        """Store a small blob."""
        with self.writer(len(data)) as writer:
            writer.write(data)
            return writer.finish()

    def put_blob(self, chunks: Iterable[bytes], expected: int | None = None) -> StoredBlob:
        """Store a blob that comes in chunks."""
        with self.writer(expected) as writer:
            for chunk in chunks:
                writer.write(chunk)
            return writer.finish()

    @abstractmethod
    def put_file(self, path: Path, *, move: bool = False) -> StoredBlob:
        """Store the file at `path` as a blob; with `move` the file may be taken instead of copied."""

    @abstractmethod
    def put_stream(self, key: str, chunks: Iterable[bytes]) -> int:
        """Store `chunks` under `key`, replacing what is there, and return their number of bytes."""

    @abstractmethod
    def create(self, key: str, data: bytes) -> bool:
        """Store `data` under `key` if nothing is there; tell whether it was stored."""

    @abstractmethod
    def size(self, key: str) -> int | None:
        """Return the number of bytes under `key`, or None where nothing is."""

    def exists(self, key: str) -> bool:
        """Tell whether something is stored under `key`."""
        return self.size(key) is not None

    @abstractmethod
    def open_read(self, key: str) -> BinaryIO:
        """Open an object for seeking and reading, with a bounded buffer.

        Raises
        ------
        StoredObjectMissing
            Where nothing is stored under `key`.
        """

    @abstractmethod
    def iter_range(self, key: str, start: int = 0, stop: int | None = None) -> Iterator[bytes]:
        """Yield the bytes from `start` up to `stop` in chunks; a missing object raises at once."""

    @abstractmethod
    def download(self, key: str, path: Path) -> int:
        """Write an object to the file `path`, which appears complete or not at all; return its size."""

    @abstractmethod
    def delete(self, key: str) -> None:
        """Remove an object; one that is not there is no error."""

    @abstractmethod
    def list(self, prefix: str = "") -> Iterator[ObjectEntry]:
        """Yield the objects whose key begins with the folder `prefix`."""

    @abstractmethod
    def free_bytes(self) -> int | None:
        """Return the space left, or None where it is not limited by a disk of ours."""

    @abstractmethod
    def ensure_room(self, needed: int) -> None:
        """Raise ``storage_full`` unless `needed` more bytes leave the reserve free."""

    @abstractmethod
    def ping(self) -> None:
        """Ask the store a question; raises if it does not answer."""

    @abstractmethod
    def sweep_temporary(self, older_than: float) -> int:
        """Remove what writers left behind that died more than `older_than` seconds ago; return how many."""

    def pin_blob(self, blob: StoredBlob) -> None:
        """Keep a blob that is about to be published from the sweep."""
        if self.pin is not None:
            self.pin(blob.sha256, blob.size)


def file_chunks(stream: BinaryIO, size: int = CHUNK) -> Iterator[bytes]:
    """Yield a file in chunks."""
    while chunk := stream.read(size):
        yield chunk


class RangeReader(io.RawIOBase):
    """A seekable file over something that reads ranges.

    Reads ahead: little where reading jumps about, as it does in headers, and more and more while it goes on in order.

    Parameters
    ----------
    read_range
        Returns the bytes from a first up to a second position.
    size
        Number of bytes of the whole.
    most
        Bytes read at a time at the most, which is also what is kept in memory.
    """

    def __init__(self, read_range: Callable[[int, int], bytes], size: int, most: int) -> None:
        self._read_range = read_range
        self._size = size
        self._position = 0
        self._most = most
        self._ahead = least = 1 << 16
        self._least = least
        self._window = b""
        self._begin = 0

    def readable(self) -> bool:
        """Yes."""
        return True

    def seekable(self) -> bool:
        """Yes."""
        return True

    def tell(self) -> int:
        """Return the position."""
        return self._position

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Move; before the beginning is an error, beyond the end is not."""
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._position, os.SEEK_END: self._size}[whence]
        if base + offset < 0:
            raise OSError(errno.EINVAL, "a position before the beginning")
        self._position = base + offset
        return self._position

    def readinto(self, buffer: Any) -> int:
        """Read up to the length of `buffer`."""
        wanted = min(len(buffer), max(0, self._size - self._position))
        if wanted == 0:
            return 0
        end = self._begin + len(self._window)
        if not self._begin <= self._position < end:
            goes_on = bool(self._window) and self._position == end
            self._ahead = min(2 * self._ahead, self._most) if goes_on else self._least
            stop = min(self._position + max(wanted, self._ahead), self._position + self._most, self._size)
            self._window = b""  # freed before the next one comes
            self._window = self._read_range(self._position, stop)
            self._begin = self._position
        start = self._position - self._begin
        piece = memoryview(self._window)[start : start + wanted]
        buffer[: len(piece)] = piece
        self._position += len(piece)
        return len(piece)

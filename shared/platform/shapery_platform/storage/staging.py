"""Staging of resumable uploads: bytes that arrived and are not an object yet.

The offset in the upload's row is the truth. What staging holds beyond it (a crash between the write and the update of
the row) is cut off or overwritten by the next request; what it lacks is an error.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import threading
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from io import FileIO
from pathlib import Path
from typing import Any
from uuid import UUID

from typing_extensions import override

from shapery_platform.db.types import new_id
from shapery_platform.storage.content import CHUNK, StagingLost, StoredBlob, StoredObjectMissing, disk_errors
from shapery_platform.storage.local import LocalStore, write_all
from shapery_platform.storage.s3 import S3Store
from shapery_platform.storage.store import STAGING, ObjectStore, file_chunks

_REMEMBERED = 1024
"""Uploads whose hash so far is kept in memory; of the others the bytes are read back at the end."""
_S3_PART = 8 << 20
"""Bytes of an upload that are kept in memory before they become a part in S3."""
_ROOM_EVERY = 64 << 20


@dataclass(frozen=True, slots=True)
class StagedPart:
    """A piece of an upload that is an object of its own."""

    offset: int
    size: int
    key: str


class Patch(ABC):
    """The bytes of one request on their way into staging."""

    @abstractmethod
    def write(self, data: bytes | memoryview) -> None:
        """Append `data`."""

    @abstractmethod
    def settle(self) -> tuple[int, list[StagedPart]]:
        """Make what was written durable; return the offset reached and the parts since the last call."""

    @abstractmethod
    def close(self) -> None:
        """Release what the patch holds; bytes after the last `settle` are lost."""

    @abstractmethod
    def rollback(self, offset: int) -> None:
        """Forget everything from `offset` on, the offset at which the patch began."""


class UploadStaging(ABC):
    """Staged uploads by the id of their row."""

    def __init__(self) -> None:
        self._hashes: OrderedDict[UUID, tuple[int, Any]] = OrderedDict()
        self._hashes_lock = threading.Lock()

    @classmethod
    def over(cls, store: ObjectStore) -> UploadStaging:
        """Return the staging that belongs to a store."""
        if isinstance(store, LocalStore):
            return LocalStaging(store)
        assert isinstance(store, S3Store)
        return S3Staging(store)

    @abstractmethod
    def begin(self, upload_id: UUID, length: int | None) -> None:
        """Make room for an upload; raises ``storage_full``."""

    @abstractmethod
    def open_patch(self, upload_id: UUID, offset: int) -> Patch:
        """Begin to write at `offset`.

        The caller holds the upload's lease.

        Raises
        ------
        StagingLost
            Where fewer than `offset` bytes are staged.
        """

    @abstractmethod
    def read(self, upload_id: UUID, size: int, parts: Sequence[StagedPart]) -> Iterator[bytes]:
        """Yield the first `size` staged bytes."""

    @abstractmethod
    def publish(self, upload_id: UUID, size: int, parts: Sequence[StagedPart]) -> StoredBlob:
        """Make a blob of the complete upload. What is staged stays until `remove`, so this may be repeated."""

    @abstractmethod
    def remove(self, upload_id: UUID) -> None:
        """Remove what is staged for an upload; harmless where nothing is."""

    @abstractmethod
    def staged(self) -> Iterator[UUID]:
        """Yield the ids of uploads of which something is staged."""

    def append(self, upload_id: UUID, offset: int, chunks: Iterable[bytes]) -> tuple[int, list[StagedPart]]:
        """Write `chunks` at `offset` and return the new offset."""
        patch = self.open_patch(upload_id, offset)
        try:
            for chunk in chunks:
                patch.write(chunk)
            return patch.settle()
        finally:
            patch.close()

    def hash_at(self, upload_id: UUID, offset: int) -> Any | None:
        """Return a copy of the running SHA-256 of the first `offset` bytes if this process has it."""
        with self._hashes_lock:
            known = self._hashes.get(upload_id)
            if known is not None and known[0] == offset:
                self._hashes.move_to_end(upload_id)
                return known[1].copy()
        return hashlib.sha256() if offset == 0 else None

    def remember_hash(self, upload_id: UUID, offset: int, running: Any) -> None:
        """Keep the running SHA-256 of the first `offset` bytes."""
        with self._hashes_lock:
            self._hashes[upload_id] = (offset, running.copy())
            self._hashes.move_to_end(upload_id)
            while len(self._hashes) > _REMEMBERED:
                self._hashes.popitem(last=False)

    def forget_hash(self, upload_id: UUID) -> None:
        """Drop the running hash of an upload that is over."""
        with self._hashes_lock:
            self._hashes.pop(upload_id, None)

    def digest(self, upload_id: UUID, size: int, parts: Sequence[StagedPart]) -> str:
        """Return the SHA-256 of the first `size` staged bytes, reading them back where this process has it not."""
        running = self.hash_at(upload_id, size)
        if running is None:
            running = hashlib.sha256()
            for chunk in self.read(upload_id, size, parts):
                running.update(chunk)
            self.remember_hash(upload_id, size, running)
        return str(running.hexdigest())


class LocalStaging(UploadStaging):
    """One growing file per upload, which becomes the object by a further name."""

    def __init__(self, store: LocalStore) -> None:
        super().__init__()
        self._store = store
        self._folder = store.root / STAGING
        self._folder.mkdir(parents=True, exist_ok=True)

    @override
    def begin(self, upload_id: UUID, length: int | None) -> None:
        self._store.ensure_room(length or 0)

    @override
    def open_patch(self, upload_id: UUID, offset: int) -> Patch:
        return _LocalPatch(self._store, self._folder / str(upload_id), offset)

    @override
    def read(self, upload_id: UUID, size: int, parts: Sequence[StagedPart]) -> Iterator[bytes]:
        left = size
        if left == 0:
            return
        with contextlib.suppress(FileNotFoundError), (self._folder / str(upload_id)).open("rb") as file:
            for chunk in file_chunks(file):
                yield chunk[:left]
                left -= len(chunk)
                if left <= 0:
                    return
        raise StagingLost(f"{left:,} of the {size:,} bytes of upload {upload_id} are not staged")

    @override
    def publish(self, upload_id: UUID, size: int, parts: Sequence[StagedPart]) -> StoredBlob:
        path = self._folder / str(upload_id)
        digest = self.digest(upload_id, size, parts)
        patch = _LocalPatch(self._store, path, size)
        try:
            patch.settle()
            return self._store.publish(path, digest, size, keep=True)
        finally:
            patch.close()

    @override
    def remove(self, upload_id: UUID) -> None:
        self.forget_hash(upload_id)
        (self._folder / str(upload_id)).unlink(missing_ok=True)

    @override
    def staged(self) -> Iterator[UUID]:
        for path in self._folder.iterdir():
            yield UUID(path.name)


class _LocalPatch(Patch):
    def __init__(self, store: LocalStore, path: Path, offset: int) -> None:
        self._store = store
        self._file = self._open(path, offset)
        try:
            size = self._file.seek(0, os.SEEK_END)
            if size < offset:
                raise StagingLost(f"{size:,} bytes are staged where the upload's row says {offset:,}")
            if size > offset:
                self._file.truncate(offset)
            self._file.seek(offset)
        except BaseException:
            self._file.close()
            raise
        self._offset = offset
        self._next_check = offset + _ROOM_EVERY

    def _open(self, path: Path, offset: int) -> FileIO:
        """Open and lock the file.

        Who comes here holds the upload's lease. So another one that has the file locked is a request whose lease ran
        out while it hung, and which may still write when it wakes up: it keeps the file it has, and the bytes that
        count, which nobody writes to any more, are copied to a new one.
        """
        while True:
            file = FileIO(os.open(path, os.O_RDWR | os.O_CREAT, 0o600), "r+")
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                file.close()
                return self._take_over(path, offset)
            except BaseException:
                file.close()
                raise
            with contextlib.suppress(FileNotFoundError):
                if path.stat().st_ino == os.fstat(file.fileno()).st_ino:
                    return file
            file.close()

    def _take_over(self, path: Path, offset: int) -> FileIO:
        temporary = self._store.temporary()
        file = FileIO(temporary, "x+")
        try:
            fcntl.flock(file, fcntl.LOCK_EX)
            left = offset
            with disk_errors(), path.open("rb") as source:
                while left and (chunk := source.read(min(CHUNK, left))):
                    write_all(file, chunk)
                    left -= len(chunk)
                os.fsync(file.fileno())
            temporary.replace(path)
        except BaseException:
            file.close()
            temporary.unlink(missing_ok=True)
            raise
        return file

    @override
    def write(self, data: bytes | memoryview) -> None:
        if self._offset + len(data) >= self._next_check:
            self._store.ensure_room(len(data))
            self._next_check = self._offset + len(data) + _ROOM_EVERY
        with disk_errors():
            write_all(self._file, data)
        self._offset += len(data)

    @override
    def settle(self) -> tuple[int, list[StagedPart]]:
        with disk_errors():
            os.fsync(self._file.fileno())
        return self._offset, []

    @override
    def close(self) -> None:
        self._file.close()

    @override
    def rollback(self, offset: int) -> None:
        self._file.truncate(offset)
        self._file.seek(offset)
        self._offset = offset


class S3Staging(UploadStaging):
    """Parts as objects of their own, put together when the upload is complete."""

    def __init__(self, store: S3Store) -> None:
        super().__init__()
        self._store = store

    @override
    def begin(self, upload_id: UUID, length: int | None) -> None:
        return

    @override
    def open_patch(self, upload_id: UUID, offset: int) -> Patch:
        return _S3Patch(self._store, f"{STAGING}{upload_id}/", offset)

    @override
    def read(self, upload_id: UUID, size: int, parts: Sequence[StagedPart]) -> Iterator[bytes]:
        offset = 0
        for part in parts:
            if part.offset != offset:
                break
            try:
                yield from self._store.iter_range(part.key, 0, part.size)
            except StoredObjectMissing:
                break
            offset += part.size
        if offset != size:
            raise StagingLost(f"{offset:,} bytes of upload {upload_id} are staged where its row says {size:,}")

    @override
    def publish(self, upload_id: UUID, size: int, parts: Sequence[StagedPart]) -> StoredBlob:
        blob = StoredBlob(self.digest(upload_id, size, parts), size)
        self._store.pin_blob(blob)
        if self._store.size(blob.key) == size:
            return blob
        if len(parts) == 1 and parts[0].size == size:
            self._store.copy(parts[0].key, blob.key, size)
        else:
            self._store.put_content(blob.key, self.read(upload_id, size, parts), size)
        return blob

    @override
    def remove(self, upload_id: UUID) -> None:
        self.forget_hash(upload_id)
        for entry in list(self._store.list(f"{STAGING}{upload_id}/")):
            self._store.delete(entry.key)

    @override
    def staged(self) -> Iterator[UUID]:
        seen: set[str] = set()
        for entry in self._store.list(STAGING):
            name = entry.key.removeprefix(STAGING).split("/")[0]
            if name not in seen:
                seen.add(name)
                yield UUID(name)


class _S3Patch(Patch):
    def __init__(self, store: S3Store, prefix: str, offset: int) -> None:
        self._store = store
        self._prefix = prefix
        self._offset = offset
        self._buffer = bytearray()
        self._parts: list[StagedPart] = []

    @override
    def write(self, data: bytes | memoryview) -> None:
        self._buffer += data
        if len(self._buffer) >= _S3_PART:
            self._flush()

    def _flush(self) -> None:
        if not self._buffer:
            return
        # the name is new each time: a request that was given up and still writes touches nothing of its successor
        key = f"{self._prefix}{self._offset:020d}-{new_id()}"
        self._store.put_object(key, self._buffer)
        self._parts.append(StagedPart(self._offset, len(self._buffer), key))
        self._offset += len(self._buffer)
        self._buffer = bytearray()

    @override
    def settle(self) -> tuple[int, list[StagedPart]]:
        self._flush()
        parts, self._parts = self._parts, []
        return self._offset, parts

    @override
    def close(self) -> None:
        self._buffer.clear()

    @override
    def rollback(self, offset: int) -> None:
        self._buffer.clear()
        for part in self._parts:
            self._store.delete(part.key)
        self._parts.clear()
        self._offset = offset

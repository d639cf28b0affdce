"""Objects in a local folder.

Reading and listing go through obstore; what must be atomic and durable (publishing a blob) is written here, because it
needs the file system's own means: a link that fails where the name exists, and fsync before it.
"""

from __future__ import annotations

import hashlib
import io
import os
import shutil
import time
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath
from typing import BinaryIO, cast

import obstore
from obstore.store import LocalStore as ObstoreLocal
from typing_extensions import override

from shapery_platform.db.types import new_id
from shapery_platform.storage.content import (
    CHUNK,
    StoredBlob,
    StoredObjectMissing,
    disk_errors,
    storage_full,
)
from shapery_platform.storage.store import TEMPORARY, BlobWriter, ObjectEntry, ObjectStore, file_chunks

_ROOM_EVERY = 64 << 20
"""Bytes after which a writer of unknown length asks again how much room is left."""


class LocalStore(ObjectStore):
    """A folder as an object store."""

    def __init__(self, root: Path, *, min_free_bytes: int = 0) -> None:
        self.root = root.absolute()
        self.min_free_bytes = min_free_bytes
        (self.root / TEMPORARY).mkdir(parents=True, exist_ok=True)
        self._store = ObstoreLocal(self.root)

    def path(self, key: str) -> Path:
        """Return the file of `key`; keys that lead out of the folder are refused."""
        parts = PurePosixPath(key).parts
        if not parts or key.startswith("/") or any(part in ("..", ".") for part in parts) or "\0" in key:
            raise ValueError(f"not a key: {key!r}")
        return self.root.joinpath(*parts)

    @override
    def writer(self, expected: int | None = None) -> BlobWriter:
        self.ensure_room(expected or 0)
        return _LocalBlobWriter(self)

    @override
    def put_file(self, path: Path, *, move: bool = False) -> StoredBlob:
        with path.open("rb") as source:
            if move and path.stat().st_dev == self.root.stat().st_dev and not path.is_symlink():
                digest = hashlib.file_digest(source, "sha256").hexdigest()
                size = source.tell()
                os.fsync(source.fileno())
                temporary = self.temporary()
                path.rename(temporary)
                return self.publish(temporary, digest, size)
            return self.put_blob(file_chunks(source), expected=path.stat().st_size)

    @override
    def put_stream(self, key: str, chunks: Iterable[bytes]) -> int:
        self.ensure_room(0)
        target = self.path(key)
        temporary = self.temporary()
        written = 0
        try:
            with disk_errors(), temporary.open("xb") as file:
                for chunk in chunks:
                    written += file.write(chunk)
                file.flush()
                os.fsync(file.fileno())
            target.parent.mkdir(parents=True, exist_ok=True)
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)
        sync_folder(target.parent)
        return written

    @override
    def create(self, key: str, data: bytes) -> bool:
        self.ensure_room(len(data))
        target = self.path(key)
        temporary = self.temporary()
        try:
            with disk_errors(), temporary.open("xb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            return self._link(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)

    @override
    def size(self, key: str) -> int | None:
        try:
            return self.path(key).stat().st_size
        except FileNotFoundError:
            return None

    @override
    def open_read(self, key: str) -> BinaryIO:
        try:
            return self.path(key).open("rb")
        except FileNotFoundError:
            raise StoredObjectMissing(f"There is no object {key!r}.") from None

    @override
    def iter_range(self, key: str, start: int = 0, stop: int | None = None) -> Iterator[bytes]:
        # opened here and not in the generator, so that a missing object is known before a response begins
        return _file_range(self.open_read(key), start, stop)

    @override
    def download(self, key: str, path: Path) -> int:
        source = self.path(key)
        partial = path.with_name(f".{path.name}.{new_id()}.partial")
        try:
            with disk_errors():
                # a copy and not a link: what reads it may also write to it
                shutil.copyfile(source, partial)
            size = partial.stat().st_size
            partial.replace(path)
        except FileNotFoundError as error:
            if not source.exists():
                raise StoredObjectMissing(f"There is no object {key!r}.") from None
            raise error from None
        finally:
            partial.unlink(missing_ok=True)
        return size

    @override
    def delete(self, key: str) -> None:
        self.path(key).unlink(missing_ok=True)

    @override
    def list(self, prefix: str = "") -> Iterator[ObjectEntry]:
        for page in obstore.list(self._store, prefix.rstrip("/") or None):
            for entry in page:
                yield ObjectEntry(entry["path"], entry["size"], entry["last_modified"])

    @override
    def free_bytes(self) -> int:
        return shutil.disk_usage(self.root).free

    @override
    def ensure_room(self, needed: int) -> None:
        free = self.free_bytes()
        if free - needed < self.min_free_bytes:
            raise storage_full(needed, free, self.min_free_bytes)

    @override
    def ping(self) -> None:
        (self.root / TEMPORARY).stat()

    @override
    def sweep_temporary(self, older_than: float) -> int:
        limit = time.time() - older_than
        removed = 0
        for path in (self.root / TEMPORARY).iterdir():
            try:
                if path.stat().st_mtime < limit:
                    path.unlink()
                    removed += 1
            except FileNotFoundError:
                continue  # its writer has just finished
        return removed

    def temporary(self) -> Path:
        """Return the path of a new temporary file in the same file system as the objects."""
        return self.root / TEMPORARY / str(new_id())

    def publish(self, file: Path, sha256: str, size: int, *, keep: bool = False) -> StoredBlob:
        """Give the complete and synced `file` its content address; the name `file` goes unless `keep`."""
        blob = StoredBlob(sha256, size)
        self.pin_blob(blob)
        target = self.path(blob.key)
        file.chmod(0o444)
        there = size
        while not self._link(file, target):
            try:
                there = target.stat().st_size
            except FileNotFoundError:
                continue  # it was removed between the two calls
            break
        if there != size:
            # what is there is not what its name says: a disk was full or damaged; the sound bytes take its place
            replacement = self.temporary()
            os.link(file, replacement)
            replacement.replace(target)
            sync_folder(target.parent)
        if not keep:
            file.unlink(missing_ok=True)
        return blob

    def _link(self, file: Path, target: Path) -> bool:
        """Give `file` the further name `target` unless it is taken; tell whether it was free."""
        for _ in range(3):
            target.parent.mkdir(parents=True, exist_ok=True)
            try:
                os.link(file, target)
            except FileExistsError:
                return False
            except FileNotFoundError:
                if not file.exists():
                    raise
                continue  # the folder was removed between the two calls
            sync_folder(target.parent)
            return True
        raise FileNotFoundError(target)


class _LocalBlobWriter(BlobWriter):
    def __init__(self, store: LocalStore) -> None:
        self._store = store
        self._path = store.temporary()
        self._file = self._path.open("xb", buffering=0)
        self._hash = hashlib.sha256()
        self._size = 0
        self._next_check = _ROOM_EVERY

    @property
    @override
    def size(self) -> int:
        return self._size

    @override
    def write(self, data: bytes | memoryview) -> None:
        if self._size + len(data) >= self._next_check:
            self._store.ensure_room(len(data))
            self._next_check = self._size + len(data) + _ROOM_EVERY
        with disk_errors():
            write_all(self._file, data)
        self._hash.update(data)
        self._size += len(data)

    @override
    def finish(self) -> StoredBlob:
        with disk_errors():
            os.fsync(self._file.fileno())
        self._file.close()
        return self._store.publish(self._path, self._hash.hexdigest(), self._size)

    @override
    def discard(self) -> None:
        self._file.close()
        self._path.unlink(missing_ok=True)


def write_all(file: io.RawIOBase | io.FileIO, data: bytes | memoryview) -> None:
    """Write all of `data` to an unbuffered file, which may take less than it is given."""
    view = memoryview(data)
    while view:
        view = view[cast("int", file.write(view)) :]


def sync_folder(folder: Path) -> None:
    """Make the names in `folder` durable."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _file_range(file: BinaryIO, start: int, stop: int | None) -> Iterator[bytes]:
    with file:
        file.seek(start)
        left = None if stop is None else stop - start
        while left is None or left > 0:
            chunk = file.read(CHUNK if left is None else min(CHUNK, left))
            if not chunk:
                return
            yield chunk
            if left is not None:
                left -= len(chunk)

"""Objects in S3 or a compatible store, through obstore."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, BinaryIO, cast

import obstore
from obstore.exceptions import AlreadyExistsError, BaseError
from obstore.store import S3Store as ObstoreS3
from typing_extensions import override

from shapery_contracts.errors import Unavailable
from shapery_platform.db.types import new_id
from shapery_platform.storage.content import StoredBlob, StoredObjectMissing, disk_errors, object_key
from shapery_platform.storage.store import TEMPORARY, BlobWriter, ObjectEntry, ObjectStore, RangeReader, file_chunks

PART = 8 << 20
"""Bytes of one part of a multipart upload, and of one ranged read. S3 takes 10,000 parts, which makes 80 GiB."""
_CONCURRENCY = 3
"""Parts on their way at a time: memory stays below (1 + `_CONCURRENCY`) parts per writer."""
_LARGEST_COPY = 5 << 30
"""S3 copies objects up to this size by itself."""


@contextmanager
def _s3_errors() -> Iterator[None]:
    """Tell an S3 that does not answer, or not as it should, from a defect of ours."""
    try:
        yield
    except BaseError as error:
        if isinstance(error, AlreadyExistsError):
            raise
        raise Unavailable("service_unavailable", "The object storage does not answer.", "Try again later.") from error


class S3Store(ObjectStore):
    """A prefix of a bucket as an object store."""

    def __init__(
        self,
        bucket: str,
        prefix: str = "",
        *,
        endpoint: str | None = None,
        region: str = "us-east-1",
        access_key: str | None = None,
        secret_key: str | None = None,
    ) -> None:
        options: dict[str, Any] = {"region": region}
        if endpoint is not None:
            options["endpoint"] = endpoint
        if access_key is not None:
            options["access_key_id"] = access_key
        if secret_key is not None:
            options["secret_access_key"] = secret_key
        plain = endpoint is not None and endpoint.startswith("http://")

        def connect(timeout: int, retries: int) -> ObstoreS3:
            return ObstoreS3(
                bucket,
                prefix=prefix or None,
                client_options={"timeout": f"{timeout}s", "connect_timeout": "5s", "allow_http": plain},
                retry_config={"max_retries": retries, "retry_timeout": timedelta(seconds=timeout)},
                **options,
            )

        self._store = connect(60, 4)
        # whether it answers is asked often and by those who will not wait
        self._probe = connect(5, 0)

    @override
    def writer(self, expected: int | None = None) -> BlobWriter:
        return _S3BlobWriter(self)

    @override
    def put_file(self, path: Path, *, move: bool = False) -> StoredBlob:
        with path.open("rb") as source:
            digest = hashlib.file_digest(source, "sha256").hexdigest()
            size = source.tell()
            source.seek(0)
            self.pin_blob(StoredBlob(digest, size))
            self.put_content(object_key(digest), file_chunks(source), size)
        if move:
            path.unlink()
        return StoredBlob(digest, size)

    def put_content(self, key: str, chunks: Iterable[bytes], size: int) -> None:
        """Store `size` bytes under their content address unless they are there already."""
        if self.size(key) == size:
            return
        if size <= PART:
            self.create(key, b"".join(chunks))
        else:
            # a multipart upload knows no condition, but whoever overwrites here writes the same bytes
            self._put_multipart(key, chunks)

    def _put_multipart(self, key: str, chunks: Iterable[bytes]) -> None:
        # pushed and not pulled: obstore would ask for the chunks from within its own event loop, where nothing that
        # reads from the store again may run
        with _s3_errors():
            writer = self.open_writer(key)
            for chunk in chunks:
                writer.write(chunk)
            writer.close()

    @override
    def put_stream(self, key: str, chunks: Iterable[bytes]) -> int:
        written = 0

        def counted() -> Iterator[bytes]:
            nonlocal written
            for chunk in chunks:
                written += len(chunk)
                yield chunk

        first = bytearray()
        pieces = counted()
        for piece in pieces:
            first += piece
            if len(first) > PART:
                break
        else:
            self.put_object(key, first)
            return written
        self._put_multipart(key, _chain(bytes(first), pieces))
        return written

    def put_object(self, key: str, data: bytes | bytearray) -> None:
        """Store `data` in one request, replacing what is there."""
        with _s3_errors():
            obstore.put(self._store, key, data, use_multipart=False)

    @override
    def create(self, key: str, data: bytes) -> bool:
        try:
            with _s3_errors():
                obstore.put(self._store, key, data, mode="create", use_multipart=False)
        except AlreadyExistsError:
            return False
        return True

    def open_writer(self, key: str) -> Any:
        """Return obstore's writer: the object appears when it is closed, and not at all where it is dropped."""
        return obstore.open_writer(self._store, key, buffer_size=PART, max_concurrency=_CONCURRENCY)

    def copy(self, source: str, key: str, size: int) -> None:
        """Copy an object of `size` bytes within the bucket, by S3 itself where it does that."""
        if size <= _LARGEST_COPY:
            with _s3_errors():
                obstore.copy(self._store, source, key)
        else:
            self._put_multipart(key, self.iter_range(source, 0, size))

    @override
    def size(self, key: str) -> int | None:
        try:
            with _s3_errors():
                return obstore.head(self._store, key)["size"]
        except FileNotFoundError:
            return None

    @override
    def open_read(self, key: str) -> BinaryIO:
        size = self.size(key)
        if size is None:
            raise StoredObjectMissing(f"There is no object {key!r}.")
        reader = RangeReader(lambda start, stop: self._range(key, start, stop), size, PART)
        return cast("BinaryIO", io.BufferedReader(reader))

    @override
    def iter_range(self, key: str, start: int = 0, stop: int | None = None) -> Iterator[bytes]:
        size = self.size(key)
        if size is None:
            raise StoredObjectMissing(f"There is no object {key!r}.")
        return self._ranges(key, start, size if stop is None else min(stop, size))

    def _ranges(self, key: str, start: int, stop: int) -> Iterator[bytes]:
        # range by range and not one long response: each is retried alone, and no limit of time falls on the whole
        for begin in range(start, stop, PART):
            yield self._range(key, begin, min(begin + PART, stop))

    def _range(self, key: str, start: int, stop: int) -> bytes:
        try:
            with _s3_errors():
                return bytes(obstore.get_range(self._store, key, start=start, end=stop))
        except FileNotFoundError:
            raise StoredObjectMissing(f"There is no object {key!r}.") from None

    @override
    def download(self, key: str, path: Path) -> int:
        chunks = self.iter_range(key)
        partial = path.with_name(f".{path.name}.{new_id()}.partial")
        size = 0
        try:
            with disk_errors(), partial.open("xb") as file:
                for chunk in chunks:
                    size += file.write(chunk)
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
        return size

    @override
    def delete(self, key: str) -> None:
        try:
            with _s3_errors():
                obstore.delete(self._store, key)
        except FileNotFoundError:
            return

    @override
    def list(self, prefix: str = "") -> Iterator[ObjectEntry]:
        with _s3_errors():
            for page in obstore.list(self._store, prefix.rstrip("/") or None):
                for entry in page:
                    yield ObjectEntry(entry["path"], entry["size"], entry["last_modified"])

    @override
    def free_bytes(self) -> None:
        return None

    @override
    def ensure_room(self, needed: int) -> None:
        return

    @override
    def ping(self) -> None:
        try:
            with _s3_errors():
                obstore.head(self._probe, f"{TEMPORARY}ping")
        except FileNotFoundError:
            return

    @override
    def sweep_temporary(self, older_than: float) -> int:
        limit = datetime.now(UTC) - timedelta(seconds=older_than)
        stale = [entry.key for entry in self.list(TEMPORARY) if entry.modified < limit]
        for key in stale:
            self.delete(key)
        return len(stale)


class _S3BlobWriter(BlobWriter):
    """Keeps a small blob in memory; a larger one goes to a temporary object and is copied within the bucket."""

    def __init__(self, store: S3Store) -> None:
        self._store = store
        self._hash = hashlib.sha256()
        self._size = 0
        self._buffer: bytearray | None = bytearray()
        self._temporary = f"{TEMPORARY}{new_id()}"
        self._stream: Any = None

    @property
    @override
    def size(self) -> int:
        return self._size

    @override
    def write(self, data: bytes | memoryview) -> None:
        self._hash.update(data)
        self._size += len(data)
        if self._buffer is not None:
            self._buffer += data
            if len(self._buffer) <= PART:
                return
            self._stream = self._store.open_writer(self._temporary)
            data, self._buffer = bytes(self._buffer), None
        with _s3_errors():
            self._stream.write(bytes(data))

    @override
    def finish(self) -> StoredBlob:
        blob = StoredBlob(self._hash.hexdigest(), self._size)
        self._store.pin_blob(blob)
        if self._buffer is not None:
            self._store.put_content(blob.key, [bytes(self._buffer)], blob.size)
            return blob
        with _s3_errors():
            self._stream.close()
        self._stream = None
        if self._store.size(blob.key) != blob.size:
            self._store.copy(self._temporary, blob.key, blob.size)
        self._store.delete(self._temporary)
        return blob

    @override
    def discard(self) -> None:
        self._buffer = None
        # a writer that is dropped before it is closed leaves no object; the bucket's rule removes its parts
        self._stream = None


def _chain(first: bytes, rest: Iterator[bytes]) -> Iterator[bytes]:
    yield first
    yield from rest

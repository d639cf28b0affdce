"""Resumable uploads: tus 1.0 with a checksum on every piece, resumed across dropped connections and processes."""

from __future__ import annotations

import base64
import hashlib
import json
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO
from uuid import UUID

import httpx

from shapery_client._errors import ApiError, ConnectionFailed, TransferError
from shapery_client._transport import Transport

TUS = {"Tus-Resumable": "1.0.0"}
CHUNK = 8 << 20
"""Bytes per request: a dropped connection costs at most this much."""

MENDABLE = frozenset({409, 423, 429, 460, 502, 503, 504})
"""Refusals after which the same upload may go on: ask where it stands and continue from there."""

Progress = Callable[[int, int], None]
"""Called with the bytes sent and the bytes in all."""


class UploadJournal:
    """Remembers unfinished uploads, so that another process can resume them.

    One small JSON file per user; an entry is keyed by server, path, size and modification time, so a file that was
    changed starts anew.
    """

    def __init__(self, path: Path | None = None) -> None:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        self.path = path or cache / "shapery" / "uploads.json"

    @staticmethod
    def key(server: str, path: Path) -> str:
        """Return the key of `path` as it is now."""
        stat = path.stat()
        return f"{server} {path.resolve()} {stat.st_size} {stat.st_mtime_ns}"

    def get(self, key: str) -> str | None:
        """Return the upload's address, if one was begun."""
        return self._read().get(key)

    def put(self, key: str, location: str) -> None:
        """Remember an upload."""
        self._write({**self._read(), key: location})

    def forget(self, key: str) -> None:
        """Forget a finished or vanished upload."""
        entries = self._read()
        if entries.pop(key, None) is not None:
            self._write(entries)

    def _read(self) -> dict[str, str]:
        try:
            entries = json.loads(self.path.read_text("utf-8"))
        except (OSError, ValueError):
            return {}  # no journal, or one that was cut off: uploads then start anew, nothing else depends on it
        return {str(k): str(v) for k, v in entries.items()} if isinstance(entries, dict) else {}

    def _write(self, entries: dict[str, str]) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        temporary = self.path.with_suffix(f".{os.getpid()}")
        temporary.write_text(json.dumps(entries, indent=1), "utf-8")
        temporary.replace(self.path)


def upload_file(
    transport: Transport,
    path: Path,
    *,
    filename: str | None = None,
    chunk_size: int = CHUNK,
    progress: Progress | None = None,
    journal: UploadJournal | None = None,
) -> UUID:
    """Send a file and return the id of its asset.

    Raises
    ------
    TransferError
        The file became shorter while it was sent.
    ApiError, ConnectionFailed
        The server refused, or was away for longer than the retries last.
    """
    size = path.stat().st_size
    journal = journal or UploadJournal()
    key = journal.key(transport.server, path)
    location = journal.get(key)
    offset = 0
    if location is not None:
        try:
            offset, asset = _offset(transport, location)
        except ApiError as error:
            if error.status not in {403, 404, 410}:
                raise
            journal.forget(key)
            location = None
        else:
            if asset is not None:
                journal.forget(key)
                return asset
    if location is None:
        location = _create(transport, size, filename or path.name)
        journal.put(key, location)
        offset = 0
    try:
        with path.open("rb") as stream:
            asset = _send(transport, stream, location, offset, size, chunk_size, progress, path)
    except ApiError as error:
        if 400 <= error.status < 500 and error.status not in MENDABLE:
            journal.forget(key)  # refused for good: the next try begins anew
        raise
    journal.forget(key)
    return asset


def _create(transport: Transport, size: int, filename: str) -> str:
    encoded = base64.b64encode(filename.encode()).decode()
    # May be repeated: a lost answer leaves an empty upload behind, which expires by itself.
    response = transport.request(
        "POST",
        "/v1/uploads",
        repeatable=True,
        headers={**TUS, "Upload-Length": str(size), "Upload-Metadata": f"filename {encoded}"},
    )
    return str(httpx.URL(response.headers["Location"]).raw_path.decode())


def _offset(transport: Transport, location: str) -> tuple[int, UUID | None]:
    response = transport.request("HEAD", location, headers=TUS)
    asset = response.headers.get("Upload-Asset-Id")
    return int(response.headers["Upload-Offset"]), UUID(asset) if asset else None


def _send(
    transport: Transport,
    stream: BinaryIO,
    location: str,
    offset: int,
    size: int,
    chunk_size: int,
    progress: Progress | None,
    path: Path,
) -> UUID:
    failures = 0
    asset: UUID | None = None
    while asset is None:
        if progress:
            progress(offset, size)
        stream.seek(offset)
        chunk = stream.read(min(chunk_size, size - offset))
        if len(chunk) < min(chunk_size, size - offset):
            raise TransferError(f"{path.name} became shorter while it was sent: it changed on disk. Send it again.")
        digest = base64.b64encode(hashlib.sha256(chunk).digest()).decode()
        try:
            response = transport.request(
                "PATCH",
                location,
                content=chunk,
                headers={
                    **TUS,
                    "Upload-Offset": str(offset),
                    "Upload-Checksum": f"sha256 {digest}",
                    "Content-Type": "application/offset+octet-stream",
                },
            )
        except (ConnectionFailed, ApiError) as error:
            mendable = isinstance(error, ConnectionFailed) or error.status in MENDABLE
            failures += 1
            if not mendable or failures > transport.attempts:
                raise
            transport.pause(failures)
            with suppress(ConnectionFailed):  # still away: the next round's PATCH counts as the next failure
                offset, asset = _offset(transport, location)
            continue
        failures = 0
        offset = int(response.headers["Upload-Offset"])
        told = response.headers.get("Upload-Asset-Id")
        if told:
            asset = UUID(told)
        elif offset >= size:
            raise TransferError(f"The server has all of {path.name} but names no asset for it.")
    if progress:
        progress(size, size)
    return asset

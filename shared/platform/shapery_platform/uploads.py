"""Resumable uploads: what tus asks for, over our own storage.

A request that writes holds a lease on the row. Bytes go to staging without any transaction being open; the row's
offset is advanced after they are durable, and only under the lease.
"""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime, timedelta
from types import TracebackType
from typing import Any, Self
from uuid import UUID, uuid4

from sqlalchemy.orm import Session

from shapery_contracts.errors import InvalidInput, LimitExceeded, UserError
from shapery_platform import assets
from shapery_platform.db import Database, new_id, utc_now
from shapery_platform.db.models import Asset, Upload
from shapery_platform.db.repositories import uploads as repository
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore
from shapery_platform.storage.staging import UploadStaging

CHECKSUM_ALGORITHMS = ("sha1", "sha256", "md5")
"""As tus names them in ``Tus-Checksum-Algorithm``."""

_LEASE = timedelta(seconds=10)
"""So long an upload stays locked after the process that was writing died; who writes on renews it."""
_RENEW_EVERY = timedelta(seconds=3)
_SETTLE_EVERY = 64 << 20
"""Bytes after which the row is advanced within a long request, so that little is sent again after a crash."""


@dataclass(frozen=True, slots=True)
class UploadState:
    """An upload as it is now."""

    id: UUID
    owner: str
    offset: int
    length: int | None
    metadata: Mapping[str, str]
    expires_at: datetime
    asset_id: UUID | None

    @property
    def complete(self) -> bool:
        """Whether all bytes have arrived."""
        return self.length is not None and self.offset == self.length

    @property
    def filename(self) -> str:
        """The client's name for the file, as it was given."""
        return self.metadata.get("filename") or self.metadata.get("name") or ""


def create(
    session: Session,
    staging: UploadStaging,
    settings: Settings,
    owner: str,
    length: int | None,
    metadata: Mapping[str, str],
) -> UploadState:
    """Begin an upload of `length` bytes, or of a length told later.

    Raises
    ------
    LimitExceeded
        ``too_large`` beyond `Settings.max_upload_bytes`; ``storage_full``.
    """
    _check_length(settings, length)
    upload = Upload(
        id=new_id(),
        owner=owner,
        length=length,
        offset=0,
        details=dict(metadata),
        expires_at=utc_now() + timedelta(seconds=settings.upload_ttl),
    )
    staging.begin(upload.id, length)
    session.add(upload)
    session.flush()
    return _state(upload)


def get(
    session: Session, owner: str, upload_id: UUID, *, now: datetime | None = None, lock: bool = False
) -> UploadState:
    """Return an upload; raises ``not_found`` or ``upload_expired``."""
    upload = repository.find(session, owner, upload_id, lock=lock)
    if upload is None:
        raise InvalidInput("not_found", f"There is no upload {upload_id}.")
    if upload.expires_at <= (now or utc_now()) and upload.asset_id is None:
        raise InvalidInput(
            "upload_expired",
            f"The upload was not finished before {upload.expires_at:%Y-%m-%d %H:%M} UTC.",
            "Begin a new upload.",
        )
    return _state(upload)


def open_patch(
    database: Database,
    staging: UploadStaging,
    settings: Settings,
    owner: str,
    upload_id: UUID,
    offset: int,
    *,
    length: int | None = None,
    checksum: tuple[str, bytes] | None = None,
) -> UploadWriter:
    """Begin to append at `offset`.

    Parameters
    ----------
    length
        The total length, where it was deferred and is told now.
    checksum
        Algorithm (of `CHECKSUM_ALGORITHMS`) and digest of the bytes of this request.

    Raises
    ------
    UserError
        ``not_found``, ``upload_expired``, ``upload_offset_mismatch``, ``upload_locked``, ``bad_request`` (another
        length, an unknown algorithm).
    """
    if checksum is not None and checksum[0] not in CHECKSUM_ALGORITHMS:
        known = ", ".join(CHECKSUM_ALGORITHMS)
        raise InvalidInput("bad_request", f"The checksum algorithm {checksum[0]!r} is unknown.", f"Known: {known}.")
    _check_length(settings, length)
    token = uuid4()
    now = utc_now()
    with database.session() as session:
        state = get(session, owner, upload_id, lock=True)
        if state.asset_id is not None or offset != state.offset:
            raise InvalidInput(
                "upload_offset_mismatch", f"The upload continues at byte {state.offset:,}, not at {offset:,}."
            )
        if length is not None and state.length not in (None, length):
            raise InvalidInput("bad_request", f"The upload's length is {state.length:,}, not {length:,}.")
        if length is not None and length < offset:
            raise InvalidInput("bad_request", f"The length {length:,} is less than the {offset:,} bytes that arrived.")
        if not repository.take_lease(session, upload_id, token, now, now + _LEASE):
            raise _locked()
        if length is not None:
            repository.write(session, upload_id, token, length=length)
    limit = length if length is not None else state.length
    try:
        return UploadWriter(database, staging, settings, upload_id, token, offset, limit, checksum)
    except BaseException:
        _drop_lease(database, upload_id, token)
        raise


class UploadWriter:
    """One request's bytes; made by `open_patch`.

    Call `write` for each chunk, then `finish`; or `interrupt` when the client went away, which keeps what arrived.
    Leaving the ``with`` block without either interrupts.
    """

    def __init__(
        self,
        database: Database,
        staging: UploadStaging,
        settings: Settings,
        upload_id: UUID,
        token: UUID,
        offset: int,
        limit: int | None,
        checksum: tuple[str, bytes] | None,
    ) -> None:
        self._database = database
        self._staging = staging
        self._settings = settings
        self._id = upload_id
        self._token = token
        self._start = self._settled = self._offset = offset
        self._limit = settings.max_upload_bytes if limit is None else limit
        self._expected = checksum
        self._check = None if checksum is None else hashlib.new(checksum[0], usedforsecurity=False)
        self._hash = staging.hash_at(upload_id, offset)
        self._renewed = utc_now()
        self._open = True
        self._patch = staging.open_patch(upload_id, offset)

    @property
    def offset(self) -> int:
        """The offset reached, durable or not."""
        return self._offset

    def write(self, data: bytes | memoryview) -> None:
        """Append a chunk.

        Raises
        ------
        UserError
            ``request_too_large`` beyond the upload's length; ``storage_full``; ``upload_locked`` where the lease was
            lost because nothing came for long.
        """
        if self._offset + len(data) > self._limit:
            raise LimitExceeded(
                "request_too_large", f"More bytes came than the {self._limit:,} that the upload may have."
            )
        if utc_now() - self._renewed > _RENEW_EVERY:
            self._renew()
        self._patch.write(data)
        self._offset += len(data)
        if self._hash is not None:
            self._hash.update(data)
        if self._check is not None:
            self._check.update(data)
        elif self._offset - self._settled >= _SETTLE_EVERY:
            self._settle()

    def finish(self) -> UploadState:
        """Verify the checksum, advance the row and release it.

        Raises
        ------
        UserError
            ``checksum_mismatch``: the offset stays where it was; ``upload_locked``.
        """
        try:
            if self._check is not None and self._expected is not None and self._check.digest() != self._expected[1]:
                self._patch.rollback(self._start)
                self._hash = None
                raise InvalidInput(
                    "checksum_mismatch",
                    f"The {self._offset - self._start:,} bytes that arrived have the {self._expected[0]} "
                    f"{self._check.hexdigest()}, not {self._expected[1].hex()}.",
                    "Send them again.",
                )
            self._settle()
        finally:
            self._release()
        with self._database.session(readonly=True) as session:
            return _state(session.get_one(Upload, self._id))

    def interrupt(self) -> None:
        """Keep what arrived and release the upload. With a checksum nothing is kept: it could not be verified."""
        if not self._open:
            return
        try:
            if self._check is None:
                self._settle()
            else:
                self._patch.rollback(self._start)
        finally:
            self._release()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.interrupt()

    def _settle(self) -> None:
        offset, parts = self._patch.settle()
        now = utc_now()
        with self._database.session() as session:
            held = repository.advance(
                session,
                self._id,
                self._token,
                offset,
                parts,
                lease_until=now + _LEASE,
                expires_at=now + timedelta(seconds=self._settings.upload_ttl),
            )
        if not held:
            raise _locked()
        self._renewed = now
        self._settled = offset
        if self._hash is not None:
            self._staging.remember_hash(self._id, offset, self._hash)

    def _renew(self) -> None:
        now = utc_now()
        with self._database.session() as session:
            if not repository.write(session, self._id, self._token, lease_until=now + _LEASE):
                raise _locked()
        self._renewed = now

    def _release(self) -> None:
        if self._open:
            self._open = False
            self._patch.close()
            _drop_lease(self._database, self._id, self._token)


def append(
    database: Database,
    staging: UploadStaging,
    settings: Settings,
    owner: str,
    upload_id: UUID,
    offset: int,
    chunks: Iterable[bytes],
    *,
    length: int | None = None,
    checksum: tuple[str, bytes] | None = None,
) -> UploadState:
    """Append all of `chunks`; what arrived before an error of theirs is kept (see `UploadWriter`)."""
    with open_patch(database, staging, settings, owner, upload_id, offset, length=length, checksum=checksum) as writer:
        for chunk in chunks:
            writer.write(chunk)
        return writer.finish()


def finish(
    database: Database, staging: UploadStaging, store: ObjectStore, settings: Settings, owner: str, upload_id: UUID
) -> Asset:
    """Make an asset of a complete upload; one that was finished before gives the same asset.

    Raises
    ------
    UserError
        ``conflict`` while bytes are missing; ``upload_locked``; and where the content is of no known kind what
        `shapery_contracts.formats.sniff` raises, after which the upload is gone.
    """
    token = uuid4()
    now = utc_now()
    with database.session() as session:
        state = get(session, owner, upload_id, lock=True)
        if state.asset_id is not None:
            return assets.get(session, owner, state.asset_id)
        if not state.complete:
            raise InvalidInput("conflict", f"The upload has {state.offset:,} of {state.length or '?'} bytes.")
        if not repository.take_lease(session, upload_id, token, now, now + _LEASE):
            raise _locked()
        parts = repository.parts(session, upload_id)
    try:
        with _kept_lease(database, upload_id, token):
            blob = staging.publish(upload_id, state.offset, parts)
            found = assets.inspect(store, blob.sha256, blob.size)
        with database.session() as session:
            asset = assets.create_from_upload(
                session, store, settings, owner, blob.sha256, blob.size, state.filename, found
            )
            if not repository.write(session, upload_id, token, asset_id=asset.id, lease=None, lease_until=None):
                raise _locked()
    except UserError as error:
        if error.code in ("upload_locked", "storage_full"):
            _drop_lease(database, upload_id, token)
            raise
        with database.session() as session:
            removed = repository.remove(session, upload_id, token)
        if removed:
            staging.remove(upload_id)
        raise
    except BaseException:
        _drop_lease(database, upload_id, token)
        raise
    staging.remove(upload_id)
    return asset


def terminate(database: Database, staging: UploadStaging, owner: str, upload_id: UUID) -> None:
    """Remove an upload and what was staged of it; an asset made of it stays.

    Raises
    ------
    UserError
        ``not_found`` or ``upload_locked``.
    """
    token = uuid4()
    now = utc_now()
    with database.session() as session:
        if repository.find(session, owner, upload_id, lock=True) is None:
            raise InvalidInput("not_found", f"There is no upload {upload_id}.")
        if not repository.take_lease(session, upload_id, token, now, now + _LEASE):
            raise _locked()
        repository.remove(session, upload_id, token)
    staging.remove(upload_id)


def expire(database: Database, staging: UploadStaging, *, now: datetime | None = None, limit: int = 500) -> int:
    """Remove uploads whose time is over; return how many."""
    moment = now or utc_now()
    with database.session(readonly=True) as session:
        candidates = repository.expired(session, moment, limit)
    removed = 0
    for upload_id in candidates:
        token = uuid4()
        with database.session() as session:
            gone = repository.take_lease(session, upload_id, token, moment, moment + _LEASE) and repository.remove(
                session, upload_id, token
            )
        if gone:
            staging.remove(upload_id)
            removed += 1
    return removed


def sweep_staging(database: Database, staging: UploadStaging) -> int:
    """Remove what is staged for uploads that have no row: a process died between the two; return how many."""
    # listed before the rows are asked: an upload that begins in between is not in the list
    staged = list(staging.staged())
    removed = 0
    for begin in range(0, len(staged), 500):
        some = staged[begin : begin + 500]
        with database.session(readonly=True) as session:
            known = repository.existing(session, some)
        for upload_id in set(some) - known:
            staging.remove(upload_id)
            removed += 1
    return removed


@contextmanager
def _kept_lease(database: Database, upload_id: UUID, token: UUID) -> Iterator[None]:
    """Renew the lease from a thread of its own while something takes long."""
    done = threading.Event()

    def renew() -> None:
        while not done.wait(_RENEW_EVERY.total_seconds()):
            with database.session() as session:
                if not repository.write(session, upload_id, token, lease_until=utc_now() + _LEASE):
                    return

    thread = threading.Thread(target=renew, name="upload-lease", daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _check_length(settings: Settings, length: int | None) -> None:
    if length is not None and length > settings.max_upload_bytes:
        raise LimitExceeded(
            "too_large", f"The upload has {length:,} bytes, and {settings.max_upload_bytes:,} are allowed."
        )


def _drop_lease(database: Database, upload_id: UUID, token: UUID) -> None:
    with database.session() as session:
        repository.write(session, upload_id, token, lease=None, lease_until=None)


def _state(upload: Upload) -> UploadState:
    return UploadState(
        id=upload.id,
        owner=upload.owner,
        offset=upload.offset,
        length=upload.length,
        metadata=_metadata(upload.details),
        expires_at=upload.expires_at,
        asset_id=upload.asset_id,
    )


def _metadata(details: Mapping[str, Any]) -> dict[str, str]:
    return {key: str(value) for key, value in details.items()}


def _locked() -> UserError:
    return UserError("upload_locked", "Another request is writing to this upload.", "Try again in a moment.")

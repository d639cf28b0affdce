"""The life of stored bytes: pinned before they are published, swept when nothing refers to them.

The order of events is what keeps a blob from being lost when the same bytes are uploaded while the last asset that had
them is deleted:

1. An upload **pins**: it commits a row that says "do not look at this blob before …", and only then asks the store
   whether the bytes are there, and publishes them if not.
2. The **sweep** locks the row, sees that the pin has passed and that nothing refers to the blob, deletes the object
   *while it holds the lock*, then the row.

So a pin either comes before the lock, and the sweep leaves the blob alone; or it waits until object and row are gone,
and the upload finds the object missing and publishes it.
"""

from __future__ import annotations

import logging
from datetime import datetime, timedelta

from sqlalchemy.orm import Session

from shapery_contracts.errors import InvalidInput
from shapery_platform.db import Database, utc_now
from shapery_platform.db.repositories import blobs as repository
from shapery_platform.storage import ObjectStore, object_key
from shapery_platform.storage.content import Pin

_log = logging.getLogger(__name__)

PIN_SECONDS = 3600.0
"""How long a blob is kept for the row that shall refer to it."""
_SLOWEST = 4 << 20
"""Bytes per second at which a large blob is published at the least; its pin lasts for so much longer."""
_LOOK_AGAIN = timedelta(seconds=60)
"""A blob that only a live job reads is looked at again after this time."""


def pin(session: Session, sha256: str, size: int, seconds: float = PIN_SECONDS) -> None:
    """Keep the blob from the sweep for some time."""
    repository.upsert(session, sha256, size, utc_now() + timedelta(seconds=seconds))


def pinner(database: Database) -> Pin:
    """Return the function that a store calls before it publishes: it pins in a transaction of its own."""

    def pin_now(sha256: str, size: int) -> None:
        with database.session() as session:
            pin(session, sha256, size, PIN_SECONDS + size / _SLOWEST)

    return pin_now


def require(session: Session, store: ObjectStore, sha256: str, size: int) -> None:
    """Lock the blob's row and make sure that its bytes are in the store.

    Raises
    ------
    InvalidInput
        ``gone`` where they are not: they were stored too long ago without anything referring to them.
    """
    pin(session, sha256, size)
    if store.size(object_key(sha256)) != size:
        raise InvalidInput("gone", "The uploaded bytes are no longer stored.", "Upload the file again.")


def sweep(database: Database, store: ObjectStore, *, now: datetime | None = None, limit: int = 1000) -> int:
    """Remove blobs that nothing refers to, one transaction each, and return how many."""
    moment = now or utc_now()
    with database.session(readonly=True) as session:
        candidates = repository.due(session, moment, limit)
    removed = 0
    for sha256 in candidates:
        with database.session() as session:
            blob = repository.lock_due(session, sha256, moment)
            if blob is None:
                continue
            # questions after the lock: each sees what was committed before it was taken
            if repository.is_kept(session, sha256):
                blob.check_after = None
            elif repository.is_read(session, sha256):
                blob.check_after = moment + _LOOK_AGAIN
            else:
                store.delete(object_key(sha256))
                session.delete(blob)
                removed += 1
    if removed:
        _log.info("removed %d blobs that nothing refers to", removed)
    return removed

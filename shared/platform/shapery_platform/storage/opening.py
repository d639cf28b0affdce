"""Which object store the settings name."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote, urlsplit

from shapery_platform.blobs import pinner
from shapery_platform.db import Database
from shapery_platform.settings import Settings
from shapery_platform.storage.local import LocalStore
from shapery_platform.storage.s3 import S3Store
from shapery_platform.storage.store import ObjectStore


def open_store(settings: Settings, database: Database | None = None) -> ObjectStore:
    """Open the store that `settings.storage_url` names.

    Parameters
    ----------
    settings
        Address, credentials and the space to be left free.
    database
        Where blobs are pinned before they are published. A process that publishes blobs must give it.
    """
    parts = urlsplit(settings.storage_url)
    store: ObjectStore
    if parts.scheme == "file":
        store = LocalStore(Path(unquote(parts.path)), min_free_bytes=settings.min_free_bytes)
    else:
        store = S3Store(
            parts.netloc,
            parts.path.strip("/"),
            endpoint=settings.s3_endpoint,
            region=settings.s3_region,
            access_key=settings.s3_access_key,
            secret_key=settings.s3_secret_key.get_secret_value() if settings.s3_secret_key else None,
        )
    if database is not None:
        store.pin = pinner(database)
    return store

"""Object storage over a local folder or S3, and the staging of uploads."""

from shapery_platform.storage.content import (
    StagingLost,
    StoredBlob,
    StoredObjectMissing,
    object_key,
)
from shapery_platform.storage.staging import StagedPart, UploadStaging
from shapery_platform.storage.store import BlobWriter, ObjectEntry, ObjectStore

__all__ = [
    "BlobWriter",
    "ObjectEntry",
    "ObjectStore",
    "StagedPart",
    "StagingLost",
    "StoredBlob",
    "StoredObjectMissing",
    "UploadStaging",
    "object_key",
]

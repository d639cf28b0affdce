"""Assets: uploaded files of an owner, addressed by their content."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection
from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.api import AssetOrder, AssetView
from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats import AssetKind, FileFormat, sniff
from shapery_platform import blobs
from shapery_platform.db import utc_now
from shapery_platform.db.models import Asset
from shapery_platform.db.repositories import assets as repository
from shapery_platform.db.repositories import blobs as blob_repository
from shapery_platform.paging import NEWEST_FIRST, checked_limit, cut_page, parse_sort
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore, object_key

_LONGEST_NAME = 255


def inspect(store: ObjectStore, sha256: str, size: int) -> FileFormat:
    """Tell from its content what a stored blob is; call it before the session opens, because it reads the store.

    Raises
    ------
    InvalidInput
        As `shapery_contracts.formats.sniff`.
    """
    with store.open_read(object_key(sha256)) as stream:
        return sniff(stream, size)


def create_from_upload(
    session: Session,
    store: ObjectStore,
    settings: Settings,  # noqa: ARG001 - limits on assets will be read here
    owner: str,
    sha256: str,
    size: int,
    filename: str,
    found: FileFormat | None = None,
) -> Asset:
    """Make an asset of bytes that the store has under their hash.

    Parameters
    ----------
    found
        What `inspect` said; without it the content is read here, while the session is open.

    Raises
    ------
    InvalidInput
        Where the content is of no known format, or ``gone`` where the bytes are not stored any more.
    """
    if found is None:
        found = inspect(store, sha256, size)
    blobs.require(session, store, sha256, size)
    asset = Asset(
        owner=owner,
        sha256=sha256,
        size=size,
        kind=found.kind.value,
        format=found.format,
        media_type=found.media_type,
        extension=found.extension,
        filename=clean_filename(filename) or f"{found.kind}{found.extension}",
        details=found.details,
    )
    session.add(asset)
    session.flush()
    return asset


def get(session: Session, owner: str, asset_id: UUID) -> Asset:
    """Return an asset of this owner; raises ``not_found``."""
    asset = repository.find(session, owner, asset_id)
    if asset is None:
        raise _not_found(asset_id)
    return asset


def list_assets(
    session: Session,
    owner: str,
    cursor: str | None = None,
    limit: int = 50,
    kind: AssetKind | None = None,
    order: AssetOrder = NEWEST_FIRST,
) -> tuple[list[Asset], str | None]:
    """Return a page of assets in an order, and the cursor of the next one."""
    limit = checked_limit(limit)
    sort = parse_sort(cursor, order, repository.ORDERS)
    return cut_page(repository.page(session, owner, sort, limit + 1, kind), limit, sort, repository.ORDERS)


def delete(session: Session, owner: str, asset_id: UUID) -> None:
    """Delete an asset; its bytes go when no other asset, artifact or job that has not ended needs them."""
    asset = repository.find(session, owner, asset_id, lock=True)
    if asset is None:
        raise _not_found(asset_id)
    asset.deleted_at = utc_now()
    session.flush()
    blob_repository.mark(session, [asset.sha256], asset.deleted_at)


def have_same_content(session: Session, ids: Collection[UUID]) -> bool:
    """Tell whether assets, also deleted ones, are of the same bytes."""
    return len(repository.hashes(session, ids)) == 1


def view(asset: Asset) -> AssetView:
    """Return the representation that the API shows."""
    return AssetView(
        id=asset.id,
        sha256=asset.sha256,
        size=asset.size,
        kind=AssetKind(asset.kind),
        format=asset.format,
        media_type=asset.media_type,
        filename=asset.filename,
        details=asset.details,
        created_at=asset.created_at,
        content_url=f"/v1/assets/{asset.id}/content",
    )


def clean_filename(name: str) -> str:
    """Return the last component of a client's file name without characters that files or headers cannot hold."""
    name = re.split(r"[/\\]", name)[-1]
    name = "".join(char for char in name if unicodedata.category(char)[0] != "C").strip()
    if name in (".", ".."):
        return ""
    if len(name) > _LONGEST_NAME:
        # the end tells more than the middle: it has the extension
        name = f"{name[: _LONGEST_NAME - 41]}…{name[-40:]}"
    return name


def _not_found(asset_id: UUID) -> InvalidInput:
    return InvalidInput("not_found", f"There is no asset {asset_id}.")

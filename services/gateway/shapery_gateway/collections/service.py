"""Makes, shows, changes and deletes collections."""

from __future__ import annotations

from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.api import BatchHeader, BatchItem, BatchView, Page
from shapery_contracts.errors import InvalidInput
from shapery_contracts.shapes import CollectionCreate, CollectionUpdate, CollectionView
from shapery_gateway import outbox
from shapery_gateway.backend import Backend
from shapery_gateway.http.storable import refuse_unstorable
from shapery_platform import batches, collections, shapes
from shapery_platform.keys import Principal


def list_collections(session: Session, caller: Principal, cursor: str | None, limit: int) -> Page[CollectionView]:
    """Return a page of the caller's collections, newest first."""
    found, following = collections.list_collections(session, caller.owner, cursor, limit)
    return Page(items=collections.views(session, found), next_cursor=following)


def create(session: Session, caller: Principal, request: CollectionCreate) -> CollectionView:
    """Make a collection of the caller."""
    refuse_unstorable(request.model_dump(), "The collection")
    return collections.views(session, [collections.create(session, caller.owner, request)])[0]


def get(session: Session, caller: Principal, collection_id: UUID) -> CollectionView:
    """Return a collection of the caller."""
    return collections.views(session, [collections.get(session, caller.owner, collection_id)])[0]


def update(session: Session, caller: Principal, collection_id: UUID, request: CollectionUpdate) -> CollectionView:
    """Change a collection of the caller."""
    refuse_unstorable(request.model_dump(), "The collection")
    return collections.views(session, [collections.update(session, caller.owner, collection_id, request)])[0]


def delete(session: Session, caller: Principal, collection_id: UUID, *, with_shapes: bool) -> None:
    """Delete a collection of the caller."""
    collections.delete(session, caller.owner, collection_id, with_shapes=with_shapes)


def reindex(session: Session, backend: Backend, caller: Principal, collection_id: UUID) -> BatchView:
    """Make a batch that indexes a collection's outdated shapes again.

    Raises
    ------
    InvalidInput
        ``conflict`` where there is nothing to do.
    """
    collection = collections.get(session, caller.owner, collection_id)
    outdated = shapes.outdated(session, caller.owner, collection_id, backend.settings.max_batch_items)
    if not outdated:
        raise InvalidInput("conflict", f"The collection {collection.name!r} has no outdated shape with a mesh.")
    items = (BatchItem(inputs={"mesh": asset_id}, params={"replaces": shape_id}) for shape_id, asset_id in outdated)
    batch, _ = batches.create(session, backend.settings, caller.owner, BatchHeader(kind="shape-index"), items)
    outbox.defer_dispatch(session)
    return batches.view(session, batch)

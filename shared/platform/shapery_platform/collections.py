"""Collections: shapes of an owner that belong together."""

from __future__ import annotations

from collections.abc import Sequence
from uuid import UUID

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from shapery_contracts.errors import InvalidInput
from shapery_contracts.retrieval import INDEX_VERSION
from shapery_contracts.shapes import CollectionCreate, CollectionUpdate, CollectionView
from shapery_platform.db import utc_now
from shapery_platform.db.models import Collection
from shapery_platform.db.repositories import blobs as blob_repository
from shapery_platform.db.repositories import collections as repository
from shapery_platform.db.repositories import shapes as shape_repository
from shapery_platform.paging import checked_limit, cut_page, parse_sort


def create(session: Session, owner: str, request: CollectionCreate) -> Collection:
    """Create a collection.

    Raises
    ------
    InvalidInput
        ``conflict`` where the owner has one of this name.
    """
    collection = Collection(owner=owner, name=request.name, description=request.description, details=request.metadata)
    _write(session, collection)
    return collection


def get(session: Session, owner: str, collection_id: UUID) -> Collection:
    """Return a collection of this owner; raises ``not_found``."""
    return _found(repository.find(session, owner, collection_id), collection_id)


def named(session: Session, owner: str, name: str, *, keep: bool = False) -> UUID:
    """Return the id of the collection called `name`, with `keep` held until the commit; raises ``not_found``."""
    found = repository.id_of(session, owner, name, keep=keep)
    if found is None:
        raise InvalidInput("not_found", f"There is no collection called {name!r}.")
    return found


def list_collections(
    session: Session, owner: str, cursor: str | None = None, limit: int = 50
) -> tuple[list[Collection], str | None]:
    """Return a page of collections, the newest first, and the cursor of the next one."""
    limit = checked_limit(limit)
    sort = parse_sort(cursor)
    return cut_page(repository.page(session, owner, sort, limit + 1), limit, sort)


def update(session: Session, owner: str, collection_id: UUID, request: CollectionUpdate) -> Collection:
    """Change what the request names.

    Raises
    ------
    InvalidInput
        ``not_found``, or ``conflict`` where another collection has the name.
    """
    collection = _found(repository.find(session, owner, collection_id, lock=True), collection_id)
    if request.name is not None:
        collection.name = request.name
    if request.description is not None:
        collection.description = request.description
    if request.metadata is not None:
        collection.details = request.metadata
    _write(session, collection)
    return collection


def delete(session: Session, owner: str, collection_id: UUID, *, with_shapes: bool) -> None:
    """Delete a collection, with its shapes where that is wanted.

    Raises
    ------
    InvalidInput
        ``not_found``, or ``conflict`` where it has shapes and they shall stay.
    """
    # The bank's row first, as all do who change shapes; then no shape joins the collection any more.
    shape_repository.change_bank(session, owner, removal=True)
    collection = _found(repository.find(session, owner, collection_id, lock=True), collection_id)
    counted = repository.counts(session, [collection_id], INDEX_VERSION)
    if counted and not with_shapes:
        raise InvalidInput(
            "conflict",
            f"The collection {collection.name!r} has {counted[0].shapes:,} shapes.",
            "Delete or move them first, or ask to delete them with it (`shapes=true`).",
        )
    hashes = shape_repository.remove(session, shape_repository.of_collection(collection_id))
    blob_repository.mark(session, hashes, utc_now())
    session.delete(collection)
    session.flush()


def views(session: Session, collections: Sequence[Collection]) -> list[CollectionView]:
    """Return the representations that the API shows."""
    counted = {
        row.collection_id: row
        for row in repository.counts(session, [collection.id for collection in collections], INDEX_VERSION)
    }
    return [
        CollectionView(
            id=collection.id,
            name=collection.name,
            description=collection.description,
            metadata=collection.details,
            shapes=counted[collection.id].shapes if collection.id in counted else 0,
            outdated=counted[collection.id].outdated if collection.id in counted else 0,
            created_at=collection.created_at,
        )
        for collection in collections
    ]


def _write(session: Session, collection: Collection) -> None:
    name = collection.name
    try:
        with session.begin_nested():
            session.add(collection)
            session.flush()
    except IntegrityError:
        raise InvalidInput("conflict", f"There is a collection called {name!r} already.") from None


def _found(collection: Collection | None, collection_id: UUID) -> Collection:
    if collection is None:
        raise InvalidInput("not_found", f"There is no collection {collection_id}.")
    return collection

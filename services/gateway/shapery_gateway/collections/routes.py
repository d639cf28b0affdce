"""``/v1/collections``."""

from __future__ import annotations

from typing import Annotated, Any
from uuid import UUID

from fastapi import APIRouter, Body, Query, Response

from shapery_contracts.api import BatchView, Page
from shapery_contracts.shapes import CollectionCreate, CollectionUpdate, CollectionView
from shapery_gateway.collections import service
from shapery_gateway.dependencies import BackendDep, Cursor, Limit, Reader, ReadSession, Writer, WriteSession
from shapery_gateway.openapi import COMMON_PROBLEMS, problems

router = APIRouter(prefix="/v1/collections", tags=["shapes"])

_EXAMPLES: Any = {
    "bones": {"summary": "A collection", "value": {"name": "bones", "description": "Long bones, scanned in 2024."}}
}
_BATCH: dict[str, Any] = {"Location": {"description": "The batch's address.", "schema": {"type": "string"}}}


@router.get("", operation_id="listCollections", summary="List your collections", responses=problems(*COMMON_PROBLEMS))
def list_collections(
    session: ReadSession, caller: Reader, cursor: Cursor = None, limit: Limit = 50
) -> Page[CollectionView]:
    """Newest first, each with the number of its shapes."""
    return service.list_collections(session, caller, cursor, limit)


@router.post(
    "",
    operation_id="createCollection",
    summary="Make a collection",
    status_code=201,
    responses={
        201: {"headers": {"Location": {"description": "The collection's address.", "schema": {"type": "string"}}}},
        **problems(*COMMON_PROBLEMS, "bad_request", "conflict"),
    },
)
def create_collection(
    session: WriteSession,
    caller: Writer,
    request: Annotated[CollectionCreate, Body(openapi_examples=_EXAMPLES)],
    response: Response,
) -> CollectionView:
    """Its name is not used yet. One is also made by the first shape that names a collection which does not exist."""
    collection = service.create(session, caller, request)
    response.headers["Location"] = f"/v1/collections/{collection.id}"
    return collection


@router.get(
    "/{collection_id}",
    operation_id="getCollection",
    summary="What a collection is",
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def get_collection(session: ReadSession, caller: Reader, collection_id: UUID) -> CollectionView:
    """Name, description and number of shapes of a collection."""
    return service.get(session, caller, collection_id)


@router.patch(
    "/{collection_id}",
    operation_id="updateCollection",
    summary="Change a collection",
    responses=problems(*COMMON_PROBLEMS, "bad_request", "not_found", "conflict"),
)
def update_collection(
    session: WriteSession, caller: Writer, collection_id: UUID, request: CollectionUpdate
) -> CollectionView:
    """Change its name, description or metadata; what the request leaves out stays."""
    return service.update(session, caller, collection_id, request)


@router.delete(
    "/{collection_id}",
    operation_id="deleteCollection",
    summary="Delete a collection",
    status_code=204,
    responses=problems(*COMMON_PROBLEMS, "not_found", "conflict"),
)
def delete_collection(
    session: WriteSession,
    caller: Writer,
    collection_id: UUID,
    shapes: Annotated[bool, Query(description="Whether its shapes are deleted with it; without, it must be empty.")] = (
        False
    ),
) -> Response:
    """Delete it for good. The meshes that its shapes were made of stay."""
    service.delete(session, caller, collection_id, with_shapes=shapes)
    return Response(status_code=204)


@router.post(
    "/{collection_id}/reindex",
    operation_id="reindexCollection",
    summary="Index a collection's outdated shapes again",
    status_code=202,
    responses={202: {"headers": _BATCH}, **problems(*COMMON_PROBLEMS, "not_found", "conflict", "input_expired")},
)
def reindex_collection(
    backend: BackendDep, session: WriteSession, caller: Writer, collection_id: UUID, response: Response
) -> BatchView:
    """Make a batch of the shapes that an older version has indexed, at most as many as a batch may have.

    Each is replaced as a whole at the end of its job; until then the old one is shown. Shapes whose mesh was deleted
    are left out.
    """
    batch = service.reindex(session, backend, caller, collection_id)
    response.headers["Location"] = f"/v1/batches/{batch.id}"
    return batch

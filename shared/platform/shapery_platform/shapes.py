"""Shapes: indexed meshes of an owner, which searches find. How one comes to be is told in `publication`."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.errors import InvalidInput
from shapery_contracts.retrieval import INDEX_VERSION
from shapery_contracts.shapes import LabelCount, ShapeDetail, ShapeOrder, ShapeUpdate, ShapeView
from shapery_platform import collections
from shapery_platform.db import utc_now
from shapery_platform.db.models import Shape, ShapeFile
from shapery_platform.db.repositories import blobs as blob_repository
from shapery_platform.db.repositories import shapes as repository
from shapery_platform.paging import NEWEST_FIRST, checked_limit, cut_page, parse_sort

MESH, PREVIEW, COMPONENTS = "mesh.glb", "preview.png", "components.json"
FILES = (MESH, PREVIEW, COMPONENTS)
"""What a shape has for viewers."""


def get(session: Session, owner: str, shape_id: UUID) -> Shape:
    """Return a shape of this owner, as it is now; raises ``not_found``."""
    shape = repository.find(session, owner, shape_id)
    if shape is None:
        raise _not_found(shape_id)
    return shape


def some(session: Session, owner: str, ids: Collection[UUID]) -> dict[UUID, Shape]:
    """Return those of some shapes that exist and belong to the owner."""
    return {shape.id: shape for shape in repository.find_all(session, owner, ids)}


def list_shapes(
    session: Session,
    owner: str,
    cursor: str | None = None,
    limit: int = 50,
    *,
    collection: str | None = None,
    labels: Mapping[str, str] | None = None,
    name: str | None = None,
    outdated: bool = False,
    job_id: UUID | None = None,
    order: ShapeOrder = NEWEST_FIRST,
) -> tuple[list[Shape], str | None]:
    """Return a page of shapes in an order, and the cursor of the next one.

    Parameters
    ----------
    collection, labels, name
        Only shapes of the collection of this name, with all of these labels, with this text in their name.
    outdated
        Only shapes of other index versions than the one that searches read.
    job_id
        Only the shape that this job has indexed last.

    Raises
    ------
    InvalidInput
        ``not_found`` where there is no such collection.
    """
    limit = checked_limit(limit)
    sort = parse_sort(cursor, order, repository.ORDERS)
    rows = repository.page(
        session,
        owner,
        sort,
        limit + 1,
        collection_id=None if collection is None else collections.named(session, owner, collection),
        labels=labels or {},
        name=name,
        outdated_at=INDEX_VERSION if outdated else None,
        job_id=job_id,
    )
    return cut_page(rows, limit, sort, repository.ORDERS)


def labels(session: Session, owner: str, limit: int, *, collection: str | None = None) -> list[LabelCount]:
    """Return the labels of an owner's shapes, or of those of a collection, the most frequent first, ties by name.

    Raises
    ------
    InvalidInput
        ``not_found`` where there is no such collection.
    """
    collection_id = None if collection is None else collections.named(session, owner, collection)
    rows = repository.label_counts(session, owner, checked_limit(limit), collection_id=collection_id)
    return [LabelCount(name=row.name, value=row.value, shapes=row.shapes) for row in rows]


def outdated(session: Session, owner: str, collection_id: UUID, limit: int) -> list[tuple[UUID, UUID]]:
    """Return shapes of a collection that an older version has indexed, with their assets where they still exist."""
    return [(row.id, row.asset_id) for row in repository.outdated(session, owner, collection_id, INDEX_VERSION, limit)]


def update(session: Session, owner: str, shape_id: UUID, request: ShapeUpdate) -> Shape:
    """Change what the request names.

    Raises
    ------
    InvalidInput
        ``not_found``: the shape, or the collection that it shall belong to.
    """
    revision = repository.change_bank(session, owner)
    get(session, owner, shape_id)
    values: dict[str, object] = {"revision": revision}
    if request.name is not None:
        values["name"] = request.name
    if request.collection is not None:
        values["collection_id"] = collections.named(session, owner, request.collection, keep=True)
    if request.metadata is not None:
        values["details"] = request.metadata
    repository.change(session, shape_id, values)
    if request.labels is not None:
        repository.put_labels(session, shape_id, request.labels)
    return get(session, owner, shape_id)


def delete(session: Session, owner: str, shape_id: UUID) -> None:
    """Delete a shape; its files go when nothing else refers to them. Its asset stays.

    Raises
    ------
    InvalidInput
        ``not_found``.
    """
    repository.change_bank(session, owner, removal=True)
    get(session, owner, shape_id)
    blob_repository.mark(session, repository.remove(session, [shape_id]), utc_now())


def file(session: Session, owner: str, shape_id: UUID, name: str) -> ShapeFile:
    """Return a file of a shape; raises ``not_found``."""
    found = repository.find_file(session, owner, shape_id, name)
    if found is None:
        get(session, owner, shape_id)
        raise InvalidInput("not_found", f"The shape {shape_id} has no {name!r}.")
    return found


def graph(session: Session, owner: str, shape_id: UUID) -> bytes:
    """Return the attributed relational graph of a shape; raises ``not_found``."""
    found = repository.graph(session, owner, shape_id)
    if found is None:
        raise _not_found(shape_id)
    return found


def is_outdated(shape: Shape) -> bool:
    """Tell whether an older version has indexed a shape, so that it is compared with none."""
    return shape.index_version != INDEX_VERSION


def view(shape: Shape) -> ShapeView:
    """Return the representation that the API shows in lists."""
    return ShapeView.model_validate(_representation(shape))


def detail(shape: Shape) -> ShapeDetail:
    """Return the representation that the API shows of one shape."""
    return ShapeDetail.model_validate(_representation(shape))


def _representation(shape: Shape) -> dict[str, object]:
    url = f"/v1/shapes/{shape.id}"
    return {
        **shape.report,
        "id": shape.id,
        "collection": shape.collection.name,
        "collection_id": shape.collection_id,
        "name": shape.name,
        "labels": {label.name: label.value for label in shape.labels},
        "metadata": shape.details,
        "asset_id": shape.asset_id,
        "job_id": shape.job_id,
        "index_version": shape.index_version,
        "outdated": is_outdated(shape),
        "created_at": shape.created_at,
        "indexed_at": shape.indexed_at,
        "arg_url": f"{url}/arg",
        "mesh_url": f"{url}/{MESH}",
        "preview_url": f"{url}/{PREVIEW}",
        "components_url": f"{url}/components",
    }


def _not_found(shape_id: UUID) -> InvalidInput:
    return InvalidInput("not_found", f"There is no shape {shape_id}.")

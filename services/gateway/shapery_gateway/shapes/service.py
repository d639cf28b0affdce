"""Shows, changes and deletes shapes, and gives out their files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal
from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.api import JobCreate, JobView, Page
from shapery_contracts.errors import InvalidInput
from shapery_contracts.shapes import LabelCount, ShapeDetail, ShapeOrder, ShapeUpdate, ShapeView
from shapery_gateway import outbox
from shapery_gateway.assets.service import stored_content
from shapery_gateway.backend import Backend
from shapery_gateway.http.content import Content
from shapery_gateway.http.storable import refuse_unstorable
from shapery_platform import assets, jobs, shapes
from shapery_platform.keys import Principal

ShapeFileName = Literal["arg", "mesh.glb", "preview.png", "components"]
_STORED = {"mesh.glb": shapes.MESH, "preview.png": shapes.PREVIEW, "components": shapes.COMPONENTS}


def list_shapes(
    session: Session,
    caller: Principal,
    cursor: str | None,
    limit: int,
    collection: str | None,
    label: Sequence[str],
    name: str | None,
    *,
    outdated: bool,
    job_id: UUID | None,
    order: ShapeOrder,
) -> Page[ShapeView]:
    """Return a page of the caller's shapes."""
    refuse_unstorable([collection, name, list(label)], "The filter")
    found, following = shapes.list_shapes(
        session,
        caller.owner,
        cursor,
        limit,
        collection=collection,
        labels=parse_labels(label),
        name=name,
        outdated=outdated,
        job_id=job_id,
        order=order,
    )
    return Page(items=[shapes.view(shape) for shape in found], next_cursor=following)


def list_labels(session: Session, caller: Principal, collection: str | None, limit: int) -> list[LabelCount]:
    """Return the labels of the caller's shapes, the most frequent first."""
    refuse_unstorable([collection], "The filter")
    return shapes.labels(session, caller.owner, limit, collection=collection)


def parse_labels(texts: Sequence[str]) -> dict[str, str]:
    """Return labels given as ``name:value``.

    Raises
    ------
    InvalidInput
        ``validation_failed`` for a text without a colon, or two values for one name.
    """
    labels: dict[str, str] = {}
    for text in texts:
        name, colon, value = text.partition(":")
        if not name or not colon or labels.setdefault(name, value) != value:
            raise InvalidInput(
                "validation_failed", f"The label {text!r} is not of the form name:value, each name once."
            )
    return labels


def get(session: Session, caller: Principal, shape_id: UUID) -> ShapeDetail:
    """Return a shape of the caller."""
    return shapes.detail(shapes.get(session, caller.owner, shape_id))


def update(session: Session, caller: Principal, shape_id: UUID, request: ShapeUpdate) -> ShapeDetail:
    """Change a shape of the caller."""
    refuse_unstorable(request.model_dump(), "The shape")
    return shapes.detail(shapes.update(session, caller.owner, shape_id, request))


def delete(session: Session, caller: Principal, shape_id: UUID) -> None:
    """Delete a shape of the caller."""
    shapes.delete(session, caller.owner, shape_id)


def reindex(session: Session, backend: Backend, caller: Principal, shape_id: UUID) -> JobView:
    """Queue a job that indexes a shape of the caller again.

    Raises
    ------
    InvalidInput
        ``not_found``, or ``input_expired`` where its mesh was deleted.
    """
    asset_id = mesh_of(session, caller, shape_id)
    request = JobCreate(kind="shape-index", inputs={"mesh": asset_id}, params={"replaces": str(shape_id)})
    job, _ = jobs.create(session, backend.settings, caller.owner, request)
    outbox.defer(session, job)
    return jobs.view(job)


def mesh_of(session: Session, caller: Principal, shape_id: UUID) -> UUID:
    """Return the asset that a shape of the caller was made of.

    Raises
    ------
    InvalidInput
        ``not_found``, or ``input_expired`` where it was deleted.
    """
    shape = shapes.get(session, caller.owner, shape_id)
    try:
        return assets.get(session, caller.owner, shape.asset_id).id
    except InvalidInput:
        raise InvalidInput(
            "input_expired",
            f"The mesh of the shape {shape_id} has been deleted.",
            "Upload it again and index it as a new shape.",
        ) from None


def file(backend: Backend, caller: Principal, shape_id: UUID, name: ShapeFileName) -> Content:
    """Return a file of a shape, to be read after the session is closed; its graph is held by its row."""
    with backend.database.session(readonly=True) as session:
        if name != "arg":
            found = shapes.file(session, caller.owner, shape_id, _STORED[name])
            return stored_content(backend.store, found.sha256, found.size, found.media_type, found.name)
        shape = shapes.get(session, caller.owner, shape_id)
        data = shapes.graph(session, caller.owner, shape_id)

    def read(start: int, stop: int) -> Iterator[bytes]:
        yield data[start:stop]

    return Content(shape.arg_sha256, len(data), "application/x-shapery-arg", "shape.arg", read)

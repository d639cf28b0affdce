"""``/v1/shapes``."""

from __future__ import annotations

import re
from typing import Annotated, Any, get_args
from uuid import UUID

from fastapi import APIRouter, Query, Request, Response
from starlette.convertors import StringConvertor, register_url_convertor

from shapery_contracts.api import JobView, Page
from shapery_contracts.shapes import LabelCount, ShapeDetail, ShapeOrder, ShapeUpdate, ShapeView
from shapery_gateway.dependencies import BackendDep, Cursor, Limit, Reader, ReadSession, Writer, WriteSession
from shapery_gateway.http.content import content_response
from shapery_gateway.http.documentation import CONTENT_PARAMETERS, CONTENT_PROBLEMS, CONTENT_RESPONSES
from shapery_gateway.openapi import COMMON_PROBLEMS, problems
from shapery_gateway.shapes import service


class _FileConvertor(StringConvertor):
    """Only the names that a shape's files have, so that its other resources answer for themselves."""

    regex = "|".join(re.escape(name) for name in get_args(service.ShapeFileName))


register_url_convertor("shape_file", _FileConvertor())

router = APIRouter(prefix="/v1/shapes", tags=["shapes"])
labels_router = APIRouter(prefix="/v1/labels", tags=["shapes"])

_JOB: dict[str, Any] = {"Location": {"description": "The job's address.", "schema": {"type": "string"}}}
_CONTENT = {**CONTENT_RESPONSES, **problems(*COMMON_PROBLEMS, *CONTENT_PROBLEMS)}
_PARAMETERS = {"parameters": CONTENT_PARAMETERS}


@router.get(
    "", operation_id="listShapes", summary="List your shapes", responses=problems(*COMMON_PROBLEMS, "not_found")
)
def list_shapes(
    session: ReadSession,
    caller: Reader,
    cursor: Cursor = None,
    limit: Limit = 50,
    collection: Annotated[
        str | None, Query(min_length=1, max_length=200, description="Only shapes of the collection of this name.")
    ] = None,
    label: Annotated[
        list[str], Query(max_length=16, description="Only shapes with this label, as `name:value`; all, where several.")
    ] = [],  # noqa: B006 (FastAPI copies it)
    name: Annotated[
        str | None, Query(min_length=1, max_length=255, description="Only shapes with this text in their name.")
    ] = None,
    outdated: Annotated[
        bool, Query(description="Only shapes that an older version has indexed, which searches do not see.")
    ] = False,
    job_id: Annotated[UUID | None, Query(description="Only the shape that this job has indexed last.")] = None,
    order: Annotated[ShapeOrder, Query(description="By what, upwards; downwards with a minus.")] = "-created",
) -> Page[ShapeView]:
    """Newest first, if no other order is asked for."""
    return service.list_shapes(
        session, caller, cursor, limit, collection, label, name, outdated=outdated, job_id=job_id, order=order
    )


@labels_router.get(
    "",
    operation_id="listShapeLabels",
    summary="Which labels your shapes carry",
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def list_shape_labels(
    session: ReadSession,
    caller: Reader,
    collection: Annotated[
        str | None, Query(min_length=1, max_length=200, description="Only of the collection of this name.")
    ] = None,
    limit: Limit = 200,
) -> list[LabelCount]:
    """Names and values with the number of shapes that carry them, the most frequent first."""
    return service.list_labels(session, caller, collection, limit)


@router.get(
    "/{shape_id}",
    operation_id="getShape",
    summary="What a shape is",
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def get_shape(session: ReadSession, caller: Reader, shape_id: UUID) -> ShapeDetail:
    """Where it belongs, what its mesh is like, what was done to it before it was analysed, and its levels of parts."""
    return service.get(session, caller, shape_id)


@router.patch(
    "/{shape_id}",
    operation_id="updateShape",
    summary="Change a shape",
    responses=problems(*COMMON_PROBLEMS, "bad_request", "not_found"),
)
def update_shape(session: WriteSession, caller: Writer, shape_id: UUID, request: ShapeUpdate) -> ShapeDetail:
    """Its name, collection, labels or metadata; what the request leaves out stays as it is."""
    return service.update(session, caller, shape_id, request)


@router.delete(
    "/{shape_id}",
    operation_id="deleteShape",
    summary="Delete a shape",
    status_code=204,
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def delete_shape(session: WriteSession, caller: Writer, shape_id: UUID) -> Response:
    """No search finds it any more. The mesh that it was made of stays."""
    service.delete(session, caller, shape_id)
    return Response(status_code=204)


@router.post(
    "/{shape_id}/reindex",
    operation_id="reindexShape",
    summary="Index a shape again",
    status_code=202,
    responses={202: {"headers": _JOB}, **problems(*COMMON_PROBLEMS, "not_found", "input_expired")},
)
def reindex_shape(
    backend: BackendDep, session: WriteSession, caller: Writer, shape_id: UUID, response: Response
) -> JobView:
    """Queue a job that replaces it as a whole; until its end the old one is shown."""
    job = service.reindex(session, backend, caller, shape_id)
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    return job


@router.get(
    "/{shape_id}/{file:shape_file}",
    operation_id="getShapeFile",
    summary="A shape's graph, or what viewers show of it",
    response_class=Response,
    openapi_extra=_PARAMETERS,
    responses=_CONTENT,
)
@router.head("/{shape_id}/{file:shape_file}", response_class=Response, include_in_schema=False)
def get_shape_file(
    backend: BackendDep, caller: Reader, request: Request, shape_id: UUID, file: service.ShapeFileName
) -> Response:
    """One of its files.

    - `arg`: the attributed relational graph, in the binary form that is described beside this interface's schema.
    - `mesh.glb`: binary glTF, small enough to be shown; the mesh as it was uploaded is the asset's content.
    - `preview.png`: a picture for lists and results.
    - `components`: JSON, for each level the part of every vertex of `mesh.glb`, so that matched parts can be colored
      alike.
    """
    return content_response(request, service.file(backend, caller, shape_id, file))

"""``/v1/assets``."""

from __future__ import annotations

from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query, Request, Response

from shapery_contracts.api import AssetOrder, AssetView, Page
from shapery_contracts.formats import AssetKind
from shapery_gateway.assets import service
from shapery_gateway.dependencies import BackendDep, Cursor, Limit, Reader, ReadSession, Writer, WriteSession
from shapery_gateway.http.content import content_response
from shapery_gateway.http.documentation import BINARY, CONTENT_PARAMETERS, CONTENT_PROBLEMS, CONTENT_RESPONSES
from shapery_gateway.openapi import COMMON_PROBLEMS, problems

router = APIRouter(prefix="/v1/assets", tags=["assets"])

_FORM = {
    "requestBody": {
        "required": True,
        "content": {
            "multipart/form-data": {
                "schema": {"type": "object", "required": ["file"], "properties": {"file": BINARY["schema"]}}
            }
        },
    }
}
_FILE_PROBLEMS = (
    "unknown_format",
    "corrupt_file",
    "unsupported_format",
    "unsafe_archive",
    "empty_content",
    "missing_input",
)


@router.post(
    "",
    operation_id="createAsset",
    summary="Upload a file at once",
    status_code=201,
    openapi_extra=_FORM,
    responses=problems(
        *COMMON_PROBLEMS,
        *_FILE_PROBLEMS,
        "bad_request",
        "request_timeout",
        "request_too_large",
        "unsupported_media_type",
        "storage_full",
    ),
)
async def create_asset(backend: BackendDep, caller: Writer, request: Request, response: Response) -> AssetView:
    """Send one file as the form field `file`. Large files are better sent resumably, through `/v1/uploads`.

    The file's kind is told from its content. The same bytes are stored once, however often they are sent.
    """
    asset = await service.receive(backend, caller, request)
    response.headers["Location"] = f"/v1/assets/{asset.id}"
    return asset


@router.get("", operation_id="listAssets", summary="List your assets", responses=problems(*COMMON_PROBLEMS))
def list_assets(
    session: ReadSession,
    caller: Reader,
    cursor: Cursor = None,
    limit: Limit = 50,
    kind: Annotated[AssetKind | None, Query(description="Only assets of this kind.")] = None,
    order: Annotated[AssetOrder, Query(description="By what, upwards; downwards with a minus.")] = "-created",
) -> Page[AssetView]:
    """Newest first, if no other order is asked for."""
    return service.list_assets(session, caller, cursor, limit, kind, order)


@router.get(
    "/{asset_id}",
    operation_id="getAsset",
    summary="What an asset is",
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def get_asset(session: ReadSession, caller: Reader, asset_id: UUID) -> AssetView:
    """Kind, format, size and hash of an asset, and what its header tells."""
    return service.get(session, caller, asset_id)


@router.delete(
    "/{asset_id}",
    operation_id="deleteAsset",
    summary="Delete an asset",
    status_code=204,
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def delete_asset(session: WriteSession, caller: Writer, asset_id: UUID) -> Response:
    """Jobs that are under way keep what they read; the bytes go when nothing refers to them any more."""
    service.delete(session, caller, asset_id)
    return Response(status_code=204)


@router.get(
    "/{asset_id}/content",
    operation_id="getAssetContent",
    summary="An asset's bytes",
    response_class=Response,
    openapi_extra={"parameters": CONTENT_PARAMETERS},
    responses={**CONTENT_RESPONSES, **problems(*COMMON_PROBLEMS, *CONTENT_PROBLEMS)},
)
@router.head(
    "/{asset_id}/content",
    operation_id="headAssetContent",
    summary="Size and entity tag of an asset's bytes",
    response_class=Response,
    include_in_schema=False,
)
def get_asset_content(backend: BackendDep, caller: Reader, request: Request, asset_id: UUID) -> Response:
    """In whole or in part (`Range`). Sent so that no browser runs it."""
    return content_response(request, service.content(backend, caller, asset_id))

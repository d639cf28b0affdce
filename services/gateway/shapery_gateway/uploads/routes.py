"""``/v1/uploads``: tus 1.0."""

from __future__ import annotations

from typing import Any
from uuid import UUID

from fastapi import APIRouter, Request, Response

from shapery_gateway.dependencies import BackendDep, ReadSession, Writer
from shapery_gateway.http.documentation import header
from shapery_gateway.middleware.tus import VERSION
from shapery_gateway.openapi import COMMON_PROBLEMS, problems
from shapery_gateway.uploads import service
from shapery_gateway.uploads.headers import CONTENT_TYPE, EXTENSIONS
from shapery_platform.uploads import CHECKSUM_ALGORITHMS

PREFIX = "/v1/uploads"
router = APIRouter(prefix=PREFIX, tags=["uploads"])

_RESUMABLE = header(
    "Tus-Resumable", "The version of the protocol.", {"type": "string", "enum": [VERSION]}, required=True
)
_BYTES: dict[str, Any] = {"schema": {"type": "integer", "minimum": 0}}
_TEXT: dict[str, Any] = {"schema": {"type": "string"}}
_BODY = {
    "requestBody": {"content": {CONTENT_TYPE: {"schema": {"type": "string", "format": "binary"}}}},
}
_COUNT = {"type": "string", "pattern": "^[0-9]{1,18}$"}
_WRITING = (
    "bad_request",
    "request_timeout",
    "gone",
    "upload_offset_mismatch",
    "upload_locked",
    "precondition_failed",
    "request_too_large",
    "too_large",
    "checksum_mismatch",
    "unsupported_media_type",
    "unknown_format",
    "corrupt_file",
    "unsupported_format",
    "unsafe_archive",
    "empty_content",
    "storage_full",
)
_STANDING = {
    "Upload-Offset": {"description": "Bytes the server has.", **_BYTES},
    "Upload-Expires": {"description": "When an unfinished upload is removed.", **_TEXT},
    "Upload-Asset-Id": {"description": "The asset that a finished upload became.", **_TEXT},
}


@router.options(
    "",
    operation_id="getUploadCapabilities",
    summary="What of tus is spoken here",
    status_code=204,
    responses={204: {"description": "Told in headers.", "headers": {"Tus-Version": _TEXT, "Tus-Extension": _TEXT}}},
)
@router.options("/{upload_id}", include_in_schema=False, status_code=204)
async def get_capabilities(backend: BackendDep) -> Response:
    """Version, extensions, largest size and checksum algorithms."""
    return Response(
        status_code=204,
        headers={
            "Tus-Version": VERSION,
            "Tus-Extension": ",".join(EXTENSIONS),
            "Tus-Max-Size": str(backend.settings.max_upload_bytes),
            "Tus-Checksum-Algorithm": ",".join(CHECKSUM_ALGORITHMS),
        },
    )


@router.post(
    "",
    operation_id="createUpload",
    summary="Begin an upload",
    status_code=201,
    response_class=Response,
    openapi_extra={
        "parameters": [
            _RESUMABLE,
            header("Upload-Length", "Bytes of the whole file.", _COUNT),
            header("Upload-Defer-Length", "`1`: the length is told later.", {"type": "string", "enum": ["1"]}),
            header("Upload-Metadata", "`filename` and its name in base64.", {"type": "string"}),
            header("Upload-Checksum", "`sha256` and the body's digest in base64.", {"type": "string"}),
        ],
        **_BODY,
    },
    responses={
        201: {"description": "The upload's address.", "headers": {"Location": _TEXT, **_STANDING}},
        **problems(*COMMON_PROBLEMS, *_WRITING),
    },
)
async def create_upload(backend: BackendDep, caller: Writer, request: Request) -> Response:
    """Tell the length (or defer it) and get an address for the bytes; the first of them may come along as the body."""
    return Response(status_code=201, headers=await service.create(backend, caller, request, PREFIX))


@router.head(
    "/{upload_id}",
    operation_id="getUpload",
    summary="Where an upload stands",
    status_code=200,
    response_class=Response,
    openapi_extra={"parameters": [_RESUMABLE]},
    responses={
        200: {"description": "Told in headers.", "headers": {"Upload-Length": _BYTES, **_STANDING}},
        **problems(*COMMON_PROBLEMS, "not_found", "upload_expired", "precondition_failed"),
    },
)
def get_upload(session: ReadSession, caller: Writer, upload_id: UUID) -> Response:
    """From this offset the upload continues; a finished one names its asset."""
    return Response(headers=service.standing(session, caller, upload_id))


@router.patch(
    "/{upload_id}",
    operation_id="appendToUpload",
    summary="Send bytes of an upload",
    status_code=204,
    openapi_extra={
        "parameters": [
            _RESUMABLE,
            header("Upload-Offset", "Where the bytes begin.", _COUNT, required=True),
            header("Upload-Length", "Bytes of the whole file, if they were not told before.", _COUNT),
            header("Upload-Checksum", "`sha256` and the body's digest in base64.", {"type": "string"}),
        ],
        **_BODY,
    },
    responses={
        204: {"description": "Taken in.", "headers": _STANDING},
        **problems(*COMMON_PROBLEMS, "not_found", *_WRITING),
    },
)
async def append_to_upload(backend: BackendDep, caller: Writer, request: Request, upload_id: UUID) -> Response:
    """Send bytes. What arrives is kept, also when the connection breaks, unless a checksum came that cannot be checked.

    The answer to the last bytes names the asset in `Upload-Asset-Id`.
    """
    return Response(status_code=204, headers=await service.append(backend, caller, request, upload_id))


@router.delete(
    "/{upload_id}",
    operation_id="deleteUpload",
    summary="Give up an upload",
    status_code=204,
    openapi_extra={"parameters": [_RESUMABLE]},
    responses=problems(*COMMON_PROBLEMS, "not_found", "upload_locked", "precondition_failed"),
)
def delete_upload(backend: BackendDep, caller: Writer, upload_id: UUID) -> Response:
    """Remove what was sent. The asset of a finished upload stays."""
    service.terminate(backend, caller, upload_id)
    return Response(status_code=204)

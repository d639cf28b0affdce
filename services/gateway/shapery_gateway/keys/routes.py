"""``/v1/keys``."""

from __future__ import annotations

from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Body, Response

from shapery_contracts.api import KeyCreate, KeyCreated, KeyView, Page
from shapery_gateway.dependencies import Admin, ReadSession, WriteSession
from shapery_gateway.keys import service
from shapery_gateway.openapi import COMMON_PROBLEMS, problems

router = APIRouter(prefix="/v1/keys", tags=["keys"])

_EXAMPLE = {
    "reading": {
        "summary": "A key that can only look",
        "value": {"name": "viewer", "scopes": ["read"], "expires_at": "2030-01-01T00:00:00Z"},
    }
}


@router.get("", operation_id="listKeys", summary="List your keys", responses=problems(*COMMON_PROBLEMS))
def list_keys(session: ReadSession, caller: Admin) -> Page[KeyView]:
    """List the keys of your owner that are not revoked, newest first, without their secrets."""
    return service.list_keys(session, caller)


@router.post(
    "",
    operation_id="createKey",
    summary="Make a key",
    status_code=201,
    responses=problems(*COMMON_PROBLEMS, "bad_request"),
)
def create_key(
    session: WriteSession, caller: Admin, request: Annotated[KeyCreate, Body(openapi_examples=_EXAMPLE)]
) -> KeyCreated:
    """Make a key to the same things as yours, within its scopes. Its secret is shown in this answer and never again."""
    return service.create(session, caller, request)


@router.delete(
    "/{key_id}",
    operation_id="deleteKey",
    summary="Revoke a key",
    status_code=204,
    responses=problems(*COMMON_PROBLEMS, "not_found"),
)
def delete_key(session: WriteSession, caller: Admin, key_id: UUID) -> Response:
    """From now on the key is refused. It cannot be taken back."""
    service.revoke(session, caller, key_id)
    return Response(status_code=204)

"""Makes, lists and revokes API keys."""

from __future__ import annotations

from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.api import KeyCreate, KeyCreated, KeyView, Page
from shapery_gateway.http.storable import refuse_unstorable
from shapery_platform import keys
from shapery_platform.keys import Principal


def list_keys(session: Session, caller: Principal) -> Page[KeyView]:
    """Return all keys of the caller's owner; there are never so many that they need pages."""
    return Page(items=[keys.view(key) for key in keys.list_keys(session, caller.owner)])


def create(session: Session, caller: Principal, request: KeyCreate) -> KeyCreated:
    """Make a key of the caller's owner and return it with its secret."""
    refuse_unstorable(request.name, "The name")
    key, secret = keys.create(session, request.name, request.scopes, request.expires_at, owner=caller.owner)
    return KeyCreated(**keys.view(key).model_dump(), secret=secret)


def revoke(session: Session, caller: Principal, key_id: UUID) -> None:
    """Revoke a key of the caller's owner."""
    keys.revoke(session, caller.owner, key_id)

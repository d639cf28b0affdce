"""API keys: made once, shown once, kept as a hash."""

from __future__ import annotations

import hashlib
import hmac
import secrets
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Self
from uuid import UUID

from sqlalchemy.orm import Session

from shapery_contracts.api import KeyView, Scope
from shapery_contracts.errors import InvalidInput
from shapery_platform.db import new_id, utc_now
from shapery_platform.db.models import ApiKey
from shapery_platform.db.repositories import keys as repository
from shapery_platform.settings import Settings

LOCAL_OWNER = "local"
"""Who owns everything in the local-only mode."""
ADMIN_OWNER = "admin"
"""Who owns what is made with the bootstrap key."""
_PREFIX = "shp_"
_SHOWN = len(_PREFIX) + 8
_USE_NOTED_EVERY = timedelta(seconds=60)


@dataclass(frozen=True, slots=True)
class Principal:
    """Who is asking, and what they may do."""

    owner: str
    scopes: frozenset[Scope]
    key_id: UUID | None = None
    use_is_due: bool = False
    """Whether `note_use` should be called: the last use on record is older than a minute."""

    @classmethod
    def local(cls) -> Self:
        """Return the owner of this machine, in the local-only mode."""
        return cls(LOCAL_OWNER, frozenset(Scope))

    def may(self, scope: Scope) -> bool:
        """Tell whether the scopes allow `scope`: an administrator may everything, a writer may read."""
        if Scope.ADMIN in self.scopes:
            return True
        if scope is Scope.READ:
            return bool(self.scopes & {Scope.READ, Scope.WRITE})
        return scope in self.scopes


def create(
    session: Session,
    name: str,
    scopes: Iterable[Scope],
    expires_at: datetime | None = None,
    owner: str | None = None,
) -> tuple[ApiKey, str]:
    """Make a key and return it with its secret, which nobody can show again.

    Parameters
    ----------
    owner
        Whose things the key opens; None makes a new owner.
    """
    if expires_at is not None:
        if expires_at.tzinfo is None:
            raise InvalidInput("validation_failed", "The expiry has no time zone.", "End it with Z for UTC.")
        if expires_at <= utc_now():
            raise InvalidInput("validation_failed", f"The expiry {expires_at.isoformat()} lies in the past.")
    secret = f"{_PREFIX}{secrets.token_hex(4)}{secrets.token_urlsafe(32)}"
    key = ApiKey(
        owner=owner or str(new_id()),
        name=_clean_name(name),
        prefix=secret[:_SHOWN],
        secret_hash=_hash(secret),
        scopes=sorted({Scope(scope).value for scope in scopes}),
        expires_at=expires_at,
    )
    session.add(key)
    session.flush()
    return key, secret


def authenticate(session: Session, secret: str, now: datetime | None = None) -> Principal | None:
    """Return whose key this is, or None where it is unknown, expired or revoked. It only reads."""
    digest = _hash(secret)
    key = repository.find_by_hash(session, digest)
    if key is None or not hmac.compare_digest(key.secret_hash, digest):
        return None
    moment = now or utc_now()
    if key.revoked_at is not None or (key.expires_at is not None and key.expires_at <= moment):
        return None
    due = key.last_used_at is None or moment - key.last_used_at > _USE_NOTED_EVERY
    return Principal(key.owner, frozenset(Scope(scope) for scope in key.scopes), key.id, due)


def note_use(session: Session, key_id: UUID) -> None:
    """Record that a key was used; call it where `Principal.use_is_due` says so."""
    repository.note_use(session, key_id, utc_now())


def list_keys(session: Session, owner: str) -> list[ApiKey]:
    """Return the owner's keys that are not revoked, the newest first."""
    return list(repository.of_owner(session, owner))


def revoke(session: Session, owner: str, key_id: UUID) -> None:
    """Take a key out of use at once; raises ``not_found``."""
    if not repository.revoke(session, owner, key_id, utc_now()):
        raise InvalidInput("not_found", f"There is no API key {key_id}.")


def view(key: ApiKey) -> KeyView:
    """Return the representation that the API shows."""
    return KeyView(
        id=key.id,
        name=key.name,
        prefix=key.prefix,
        scopes=[Scope(scope) for scope in key.scopes],
        created_at=key.created_at,
        expires_at=key.expires_at,
        last_used_at=key.last_used_at,
    )


def ensure_bootstrap(session: Session, settings: Settings) -> bool:
    """Admit the administrator's key of the settings, once; tell whether it was new.

    A key that was revoked later stays revoked.
    """
    if settings.bootstrap_admin_key is None:
        return False
    secret = settings.bootstrap_admin_key.get_secret_value()
    return repository.insert_if_new(
        session,
        {
            "id": new_id(),
            "owner": ADMIN_OWNER,
            "name": "bootstrap",
            "prefix": "bootstrap",
            "secret_hash": _hash(secret),
            "scopes": sorted(scope.value for scope in Scope),
            "created_at": utc_now(),
        },
    )


def _hash(secret: str) -> str:
    # 256 random bits need no slow hash: there is nothing to guess
    return hashlib.sha256(secret.encode("utf-8", "surrogatepass")).hexdigest()


def _clean_name(name: str) -> str:
    cleaned = " ".join("".join(char if char.isprintable() else " " for char in name).split())
    if not cleaned:
        raise InvalidInput("validation_failed", "The key needs a name.")
    return cleaned[:200]

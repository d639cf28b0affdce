"""What routes ask for in their signatures: the backend, a session, and who is calling."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from typing import Annotated

from anyio.to_thread import run_sync
from fastapi import Depends, Query, Request
from fastapi.security import APIKeyHeader, HTTPAuthorizationCredentials, HTTPBearer
from sqlalchemy.orm import Session

from shapery_contracts.api import Scope
from shapery_gateway import outbox
from shapery_gateway.backend import Backend
from shapery_gateway.middleware.context import client_address
from shapery_gateway.problems import ProblemError
from shapery_gateway.rates import retry_after
from shapery_platform import keys
from shapery_platform.keys import Principal

MAX_SECRET = 256
"""Characters of a key that are looked at; ours are shorter."""


# What asks nothing of the database is a coroutine: FastAPI would run a plain function in a thread.


async def get_backend(request: Request) -> Backend:
    """Return the app's backend."""
    backend: Backend = request.app.state.backend
    return backend


BackendDep = Annotated[Backend, Depends(get_backend)]


def get_session(backend: BackendDep) -> Iterator[Session]:
    """Open a session that commits before the response is sent, and send the messages of its rows after that."""
    with backend.database.session() as session:
        yield session
        messages = outbox.deferred(session)
    backend.outbox.put(messages)


def get_read_session(backend: BackendDep) -> Iterator[Session]:
    """Open a session that cannot write, and so never waits for one that does."""
    with backend.database.session(readonly=True) as session:
        yield session


# scope="function": closed after the route and before the response. Otherwise a client could be told of a job that
# is not committed yet, and ask for it in vain.
WriteSession = Annotated[Session, Depends(get_session, scope="function")]
ReadSession = Annotated[Session, Depends(get_read_session, scope="function")]

_bearer = HTTPBearer(auto_error=False, scheme_name="bearer", description="An API key: `Authorization: Bearer shp_…`.")
_header = APIKeyHeader(
    name="X-API-Key", auto_error=False, scheme_name="apiKey", description="The same key in a header of its own."
)


def charge(backend: Backend, caller: str) -> None:
    """Count a request of `caller`, or refuse it.

    Raises
    ------
    ProblemError
        ``rate_limited``, with ``Retry-After``.
    """
    refuse_after(backend.limiter.take(caller), backend.limiter.per_minute)


def refuse_after(wait: float, per_minute: int) -> None:
    """Refuse a caller who has to wait."""
    if wait > 0:
        raise ProblemError(
            "rate_limited",
            f"More than {per_minute} requests a minute came from this caller.",
            f"Wait {wait:.1f} seconds.",
            headers=retry_after(wait),
        )


async def get_principal(
    request: Request,
    backend: BackendDep,
    bearer: Annotated[HTTPAuthorizationCredentials | None, Depends(_bearer)],
    header: Annotated[str | None, Depends(_header)],
) -> Principal:
    """Return who is calling.

    Raises
    ------
    ProblemError
        ``unauthenticated`` or ``rate_limited``.
    """
    address = f"address {client_address(request.scope)}"
    if backend.settings.auth == "local":
        charge(backend, address)
        return Principal.local()
    # Before the key is looked up: who guesses keys pays with the allowance of the address.
    refuse_after(backend.limiter.wait(address), backend.limiter.per_minute)
    secret = bearer.credentials if bearer is not None else header
    principal = None
    if secret and len(secret) <= MAX_SECRET and secret.isascii():
        principal = await run_sync(_look_up, backend, secret)
    if principal is None:
        charge(backend, address)
        detail = "The API key is not known, has expired, or was revoked." if secret else "No API key was sent."
        raise ProblemError(
            "unauthenticated",
            detail,
            "Send a key as `Authorization: Bearer …` or `X-API-Key: …`.",
            headers={"WWW-Authenticate": 'Bearer realm="shapery"'},
        )
    charge(backend, f"key {principal.key_id}")
    request.scope["state"]["key_id"] = str(principal.key_id)
    return principal


def _look_up(backend: Backend, secret: str) -> Principal | None:
    with backend.database.session(readonly=True) as session:
        principal = keys.authenticate(session, secret)
    if principal is not None and principal.use_is_due and principal.key_id is not None:
        with backend.database.session() as session:
            keys.note_use(session, principal.key_id)
    return principal


async def get_public_caller(request: Request, backend: BackendDep) -> None:
    """Count a request that needs no key."""
    charge(backend, f"address {client_address(request.scope)}")


def require(scope: Scope) -> Callable[[Principal], Awaitable[Principal]]:
    """Return the dependency that asks for a key with `scope`."""

    async def check(principal: Annotated[Principal, Depends(get_principal)]) -> Principal:
        if not principal.may(scope):
            raise ProblemError(
                "forbidden",
                f"This needs the scope {scope.value!r}; the key has {', '.join(sorted(principal.scopes)) or 'none'}.",
            )
        return principal

    return check


Reader = Annotated[Principal, Depends(require(Scope.READ))]
Writer = Annotated[Principal, Depends(require(Scope.WRITE))]
Admin = Annotated[Principal, Depends(require(Scope.ADMIN))]
PublicCaller = Depends(get_public_caller)

Cursor = Annotated[
    str | None,
    Query(max_length=2000, description="`next_cursor` of the page before; leave it out for the first page."),
]
Limit = Annotated[int, Query(ge=1, le=200, description="Items a page may have.")]

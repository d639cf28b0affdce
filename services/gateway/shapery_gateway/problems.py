"""Errors as ``application/problem+json`` (RFC 9457), made in this one place for everything that can go wrong.

Every error that leaves the gateway carries a code of `shapery_contracts.errors.ERROR_CODES` and the id of its request.
What is not a `UserError` is ours: it is logged with its traceback and told as ``internal_error``, without its text.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError, ResponseValidationError
from obstore.exceptions import BaseError as StoreError
from sqlalchemy.exc import InterfaceError, OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.responses import Response
from starlette.routing import BaseRoute, Match
from starlette.types import Scope

from shapery_contracts.errors import ERROR_CODES, UserError

logger = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
TYPE_PREFIX = "urn:shapery:problem:"
MAX_FIELD_PROBLEMS = 50
"""A list of items may hold thousands of like mistakes; the first ones tell enough."""

_CODE_OF_STATUS = {
    400: "bad_request",
    401: "unauthenticated",
    403: "forbidden",
    404: "not_found",
    405: "method_not_allowed",
    406: "not_acceptable",
    408: "request_timeout",
    409: "conflict",
    410: "gone",
    411: "length_required",
    412: "precondition_failed",
    413: "request_too_large",
    415: "unsupported_media_type",
    416: "range_not_satisfiable",
    422: "validation_failed",
    429: "rate_limited",
    503: "service_unavailable",
    507: "storage_full",
}


class ProblemError(Exception):
    """A problem of the HTTP layer itself, with headers that its answer must carry."""

    def __init__(
        self, code: str, detail: str, hint: str = "", *, headers: Mapping[str, str] | None = None, **extra: Any
    ) -> None:
        super().__init__(detail)
        self.code = code
        self.detail = detail
        self.hint = hint
        self.headers = dict(headers or {})
        self.extra = extra


def request_id_of(scope: Scope) -> str:
    """Return the id that the outermost middleware gave to the request."""
    return str(scope.get("state", {}).get("request_id", ""))


def problem_response(
    scope: Scope,
    code: str,
    detail: str,
    hint: str = "",
    *,
    headers: Mapping[str, str] | None = None,
    **extra: Any,
) -> Response:
    """Make the answer for the error `code`; `extra` members are added to the problem."""
    entry = ERROR_CODES[code]
    problem = {
        "type": TYPE_PREFIX + code,
        "title": entry.title,
        "status": entry.status,
        "detail": detail or entry.title,
        "code": code,
        "hint": hint,
        "instance": scope.get("path", ""),
        "request_id": request_id_of(scope),
        **extra,
    }
    scope.setdefault("state", {})["problem_code"] = code
    # Escaped to ASCII: a lone surrogate that a request carried must not break the very answer that refuses it.
    content = json.dumps(problem, ensure_ascii=True, allow_nan=False).encode("ascii")
    return Response(content, entry.status, headers=headers, media_type=MEDIA_TYPE)


def _field_problems(errors: Sequence[Any]) -> list[dict[str, str]]:
    problems = []
    for error in errors[:MAX_FIELD_PROBLEMS]:
        location = ".".join(str(part) for part in error.get("loc", ()))
        problems.append({"location": location, "message": str(error.get("msg", ""))})
    return problems


def allowed_methods(routes: Iterable[BaseRoute], scope: Scope) -> list[str]:
    """Return every method that some route knows for the path of `scope`."""
    methods: set[str] = set()
    for route in routes:
        match, _ = route.matches(scope)
        if match is not Match.NONE:
            methods.update(getattr(route, "methods", None) or ())
    return sorted(methods)


async def _handle_user_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, UserError)
    return problem_response(request.scope, error.code, error.message, error.hint)


async def _handle_problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, ProblemError)
    return problem_response(request.scope, error.code, error.detail, error.hint, headers=error.headers, **error.extra)


async def _handle_validation(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    errors = error.errors()
    problems = _field_problems(errors)
    first = f" The first: {problems[0]['location']}: {problems[0]['message']}." if problems else ""
    places = "1 place is" if len(errors) == 1 else f"{len(errors)} places are"
    return problem_response(
        request.scope, "validation_failed", f"{places} not valid.{first}", errors=problems, error_count=len(errors)
    )


async def _handle_http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    headers = dict(error.headers or {})
    code = _CODE_OF_STATUS.get(error.status_code)
    if code is None:
        logger.error("unexpected HTTP status %d", error.status_code)
        code = "internal_error" if error.status_code >= 500 else "bad_request"
    detail, hint = str(error.detail), ""
    if error.status_code == 405:
        methods = allowed_methods(request.app.state.api_routes, request.scope)
        headers["Allow"] = ", ".join(methods)
        detail, hint = f"{request.method} is not possible here.", f"Possible: {', '.join(methods)}."
    elif error.status_code == 404:
        detail = "There is nothing at this address."
    return problem_response(request.scope, code, detail, hint, headers=headers)


async def _handle_unavailable(request: Request, error: Exception) -> Response:
    # The database or the object store went away in the middle of a request, which was rolled back.
    logger.error(
        "%s %s failed for want of a part of the platform",
        request.method,
        request.url.path,
        exc_info=error,
        extra={"request_id": request_id_of(request.scope)},
    )
    return problem_response(
        request.scope,
        "service_unavailable",
        "The database or the object store does not answer.",
        "Try again in a moment.",
        headers={"Retry-After": "2"},
    )


async def _handle_disconnect(request: Request, _: Exception) -> Response:
    # Nobody reads this answer; it only keeps the log from calling a client that left a defect of ours.
    return problem_response(request.scope, "bad_request", "The client left before its request was complete.")


def internal_error_response(scope: Scope, error: BaseException) -> Response:
    """Log `error` with its traceback, and answer without a word of it."""
    logger.error(
        "unhandled error in %s %s",
        scope.get("method"),
        scope.get("path"),
        exc_info=error,
        extra={"request_id": request_id_of(scope)},
    )
    return problem_response(
        scope,
        "internal_error",
        "The request could not be answered because of a fault of the server.",
        "Try again; if it stays, report the request id.",
    )


async def _handle_response_validation(request: Request, error: Exception) -> Response:
    return internal_error_response(request.scope, error)


def install(app: FastAPI) -> None:
    """Let `app` tell all its errors as problems."""
    app.add_exception_handler(UserError, _handle_user_error)
    app.add_exception_handler(ProblemError, _handle_problem)
    app.add_exception_handler(RequestValidationError, _handle_validation)
    app.add_exception_handler(ResponseValidationError, _handle_response_validation)
    app.add_exception_handler(HTTPException, _handle_http)
    app.add_exception_handler(ClientDisconnect, _handle_disconnect)
    for unavailable in (OperationalError, InterfaceError, PoolTimeout, StoreError):
        app.add_exception_handler(unavailable, _handle_unavailable)

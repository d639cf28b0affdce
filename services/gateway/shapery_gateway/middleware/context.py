"""The outermost layer: request id, safe headers, access log, metrics, and the answer to what nobody caught."""

from __future__ import annotations

import logging
import re
import time
import uuid
from collections.abc import Mapping

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from shapery_gateway.metrics import RequestMetrics
from shapery_gateway.problems import internal_error_response

access_logger = logging.getLogger("shapery_gateway.access")

_PROBES = frozenset({"/healthz", "/readyz", "/metrics"})
"""Asked every few seconds, and of interest to nobody as long as they answer."""
_REQUEST_ID = re.compile(r"^[A-Za-z0-9._-]{1,64}$")

API_CONTENT_SECURITY_POLICY = "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'; sandbox"
"""For everything that is not a page of our own: were a browser to take it for one, nothing in it would run."""

SECURITY_HEADERS: Mapping[str, str] = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Content-Security-Policy": API_CONTENT_SECURITY_POLICY,
    "Cache-Control": "no-store",
}
"""Set where the route did not choose a value of its own."""


def route_template(scope: Scope) -> str:
    """Return the path of the route with its placeholders, which bounds the number of metrics series."""
    template = scope.get("state", {}).get("route_template")
    if template:
        return str(template)
    path = getattr(scope.get("route"), "path", None)
    return str(path) if path else "unmatched"


class RequestContextMiddleware:
    """Give each request an id and an end that is logged, counted and safe.

    Parameters
    ----------
    app
        The layers below.
    secure_transport
        Whether clients reach this server by HTTPS, so that browsers may be told to insist on it.
    """

    def __init__(self, app: ASGIApp, *, secure_transport: bool) -> None:
        self.app = app
        self.headers = dict(SECURITY_HEADERS)
        if secure_transport:
            self.headers["Strict-Transport-Security"] = "max-age=31536000"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        state = scope.setdefault("state", {})
        request_id = _given_request_id(scope) or uuid.uuid4().hex
        state["request_id"] = request_id
        began = time.perf_counter()
        answered = began
        status = 0
        sent = 0

        async def send_with_headers(message: Message) -> None:
            nonlocal status, sent, answered
            if message["type"] == "http.response.start":
                status = message["status"]
                answered = time.perf_counter()
                headers = MutableHeaders(scope=message)
                headers["X-Request-Id"] = request_id
                for name, value in self.headers.items():
                    headers.setdefault(name, value)
            elif message["type"] == "http.response.body":
                sent += len(message.get("body", b""))
            await send(message)

        metrics: RequestMetrics = scope["app"].state.backend.metrics
        metrics.in_progress.inc()
        try:
            await self.app(scope, receive, send_with_headers)
        except Exception as error:
            response = internal_error_response(scope, error)
            if status:
                raise  # too late for an answer: the server closes the connection, so that the client sees a cut
            await response(scope, receive, send_with_headers)
        finally:
            metrics.in_progress.dec()
            template = route_template(scope)
            # Until the answer began: an event stream that lives for an hour is not a slow request.
            metrics.observe(scope["method"], template, status, answered - began)
            access_logger.log(
                logging.DEBUG if template in _PROBES else logging.INFO,
                "%s %s %d",
                scope["method"],
                _printable(scope["path"]),
                status,
                extra={
                    "request_id": request_id,
                    "method": scope["method"],
                    "path": _printable(scope["path"]),
                    "route": template,
                    "status": status,
                    "code": state.get("problem_code", ""),
                    "seconds": round(time.perf_counter() - began, 6),
                    "bytes_sent": sent,
                    "client": client_address(scope),
                    "key_id": state.get("key_id", ""),
                },
            )


def client_address(scope: Scope) -> str:
    """Return the address a request came from; ``local`` for a socket of this machine's file system."""
    client = scope.get("client")
    return str(client[0]) if client else "local"


def _given_request_id(scope: Scope) -> str | None:
    for name, value in scope["headers"]:
        if name == b"x-request-id":
            text = value.decode("latin-1")
            return text if _REQUEST_ID.match(text) else None
    return None


def _printable(path: str) -> str:
    # A line break in a path must not be able to forge a line of the log.
    return path.encode("unicode_escape").decode("ascii")[:500]

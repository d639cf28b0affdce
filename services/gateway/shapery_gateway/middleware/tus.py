"""What tus 1.0 asks of every request and answer below ``/v1/uploads``."""

from __future__ import annotations

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from shapery_gateway.problems import problem_response

VERSION = "1.0.0"
_OVERRIDABLE = frozenset({"PATCH", "DELETE", "HEAD"})


class TusMiddleware:
    """Check and answer ``Tus-Resumable``, and heed ``X-HTTP-Method-Override``.

    The header belongs on refusals as well, which no route makes; hence this layer.
    """

    def __init__(self, app: ASGIApp, *, prefix: str) -> None:
        self.app = app
        self.prefix = prefix

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one request."""
        path = scope.get("path", "")
        if scope["type"] != "http" or not (path == self.prefix or path.startswith(self.prefix + "/")):
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        if scope["method"] == "POST":
            wanted = headers.get("x-http-method-override", "").upper()
            if wanted in _OVERRIDABLE:
                scope["method"] = wanted

        async def send_with_version(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message)["Tus-Resumable"] = VERSION
            await send(message)

        given = headers.get("tus-resumable")
        versioned = {"POST"} if path == self.prefix else _OVERRIDABLE
        if scope["method"] in versioned and given != VERSION:
            said = "no Tus-Resumable header" if given is None else f"Tus-Resumable {given!r}"
            response = problem_response(
                scope,
                "precondition_failed",
                f"Uploads speak tus {VERSION}; the request has {said}.",
                f"Send the header Tus-Resumable: {VERSION}, or the whole file at once to POST /v1/assets.",
                headers={"Tus-Version": VERSION},
            )
            await response(scope, receive, send_with_version)
            return
        await self.app(scope, receive, send_with_version)

"""How large a body may be, and how long a client may stay silent while it sends one."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from shapery_gateway.problems import problem_response

_CLOSE = {"Connection": "close"}
"""What remains of a refused body is not worth reading; without this the server would drain all of it."""


class BodyLimitMiddleware:
    """Refuse bodies that are declared or turn out too large, and give up on clients that stall.

    Parameters
    ----------
    app
        The layers below.
    limit_for
        Bytes that a body may have, given method and path.
    idle_timeout
        Seconds that a client may stay silent within its body.
    """

    def __init__(self, app: ASGIApp, *, limit_for: Callable[[str, str], int], idle_timeout: float) -> None:
        self.app = app
        self.limit_for = limit_for
        self.idle_timeout = idle_timeout

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        limit = self.limit_for(scope["method"], scope["path"])
        declared = Headers(scope=scope).get("content-length", "")
        if declared and not (declared.isascii() and declared.isdigit()):
            response = problem_response(scope, "bad_request", "Content-Length is not a number.", headers=_CLOSE)
            await response(scope, receive, send)
            return
        if declared and (len(declared) > 18 or int(declared) > limit):
            response = problem_response(scope, "request_too_large", too_large(declared, limit), headers=_CLOSE)
            await response(scope, receive, send)
            return

        received = 0
        complete = False

        async def limited_receive() -> Message:
            nonlocal received, complete
            if complete:
                # The body is over: what is awaited now is the client's leaving, which may take as long as it likes.
                return await receive()
            try:
                async with asyncio.timeout(self.idle_timeout):
                    message = await receive()
            except TimeoutError:
                raise HTTPException(
                    408, f"Nothing arrived for {self.idle_timeout:g} seconds within the body.", headers=_CLOSE
                ) from None
            if message["type"] == "http.request":
                received += len(message.get("body", b""))
                complete = not message.get("more_body", False)
                if received > limit:
                    raise HTTPException(413, too_large(f"more than {limit}", limit), headers=_CLOSE)
            return message

        await self.app(scope, limited_receive, send)


def too_large(size: str, limit: int) -> str:
    """Return the sentence that says by how much a body is too large."""
    return f"The body has {size} bytes; at most {limit} are accepted here."

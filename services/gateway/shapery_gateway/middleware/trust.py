"""Who may call a server that asks for no key: this machine's own programs and pages, not a web site's.

A server on loopback without keys is reachable by every page that the user's browser opens. Two things keep such pages
out: the ``Host`` must be one of ours, which stops DNS rebinding (a foreign name that resolves to 127.0.0.1), and a
request that changes something must not come from a foreign ``Origin``, which stops cross-site request forgery. With
keys the second is no danger, since a key travels in a header that no page can make a browser add; the check stays on
for both, as it costs nothing.
"""

from __future__ import annotations

from collections.abc import Collection
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from shapery_gateway.problems import problem_response

LOOPBACK_HOSTS = frozenset({"localhost", "127.0.0.1", "::1"})
_SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


class TrustMiddleware:
    """Refuse foreign hosts (where no key is asked for) and foreign origins.

    Parameters
    ----------
    app
        The layers below.
    allowed_hosts
        Host names without port that requests may be addressed to; None: any.
    allowed_origins
        Origins besides the server's own from which a page may change something.
    """

    def __init__(
        self, app: ASGIApp, *, allowed_hosts: Collection[str] | None, allowed_origins: Collection[str]
    ) -> None:
        self.app = app
        self.allowed_hosts = None if allowed_hosts is None else frozenset(host.lower() for host in allowed_hosts)
        self.allowed_origins = frozenset(allowed_origins)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if self.allowed_hosts is not None and host_name(host) not in self.allowed_hosts:
            response = problem_response(
                scope,
                "untrusted_host",
                "This server asks for no key and answers only to its own names on this machine.",
                f"Use one of: {', '.join(sorted(self.allowed_hosts))}; or set SHAPERY_AUTH=keys.",
            )
            await response(scope, receive, send)
            return
        if scope["method"] not in _SAFE_METHODS and not self._origin_is_ours(headers, host):
            response = problem_response(
                scope,
                "untrusted_origin",
                "A page of another origin may not change anything here.",
                "Add the origin to SHAPERY_CORS_ORIGINS if it is yours.",
            )
            await response(scope, receive, send)
            return
        await self.app(scope, receive, send)

    def _origin_is_ours(self, headers: Headers, host: str) -> bool:
        origin = headers.get("origin")
        if origin is not None:
            # The scheme may differ behind a proxy that ends TLS, so that the authority alone decides.
            return origin in self.allowed_origins or (bool(host) and urlsplit(origin).netloc.lower() == host.lower())
        # A browser that leaves out the origin still says how the page relates to us; programs say neither.
        return headers.get("sec-fetch-site", "none") in {"same-origin", "none"}


def host_name(host: str) -> str:
    """Return the name of a ``Host`` header without its port, in lower case; empty where it is malformed."""
    try:
        return (urlsplit(f"//{host}").hostname or "").rstrip(".")
    except ValueError:
        return ""

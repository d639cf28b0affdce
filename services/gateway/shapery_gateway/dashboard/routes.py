"""``/`` and everything below it that is not the interface: the dashboard."""

from __future__ import annotations

from anyio.to_thread import run_sync
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, Response
from starlette.types import Receive, Scope, Send

from shapery_gateway.dashboard.service import CONTENT_SECURITY_POLICY, NOT_BUILT, STATIC, StaticFile, find
from shapery_gateway.http.ranges import etag_matches

_API_PREFIXES = ("v1/", "docs/", "openapi.json/", "healthz/", "readyz/", "metrics/", "assets/")
"""Below these a path that does not exist is an error, and not a page of the dashboard."""

_PAGE_HEADERS = {"Content-Security-Policy": CONTENT_SECURITY_POLICY, "Cache-Control": "no-cache"}


async def serve_dashboard(scope: Scope, receive: Receive, send: Send) -> None:
    """Answer what no route of the interface does: with a file of the dashboard, its page, or 404."""
    if scope["type"] != "http":
        raise HTTPException(404)
    request = Request(scope, receive)
    scope["state"]["route_template"] = "dashboard"
    response = await run_sync(_answer, request)
    await response(scope, receive, send)


def _answer(request: Request) -> Response:
    path = str(request.scope["path"]).removeprefix("/")
    if request.method not in {"GET", "HEAD"}:
        raise HTTPException(404)
    if path:
        file = find(STATIC, path)
        if file is not None:
            return _file_response(request, file)
        # A page of the dashboard's own paths is asked for by a browser, which says so.
        if f"{path}/".startswith(_API_PREFIXES) or "text/html" not in request.headers.get("accept", ""):
            raise HTTPException(404)
    page = find(STATIC, "index.html")
    if page is None:
        return HTMLResponse(NOT_BUILT, headers=_PAGE_HEADERS)
    return _file_response(request, page)


def _file_response(request: Request, file: StaticFile) -> Response:
    headers = {**_PAGE_HEADERS, "ETag": file.etag}
    path = file.path
    if file.compressed is not None:
        headers["Vary"] = "Accept-Encoding"
        if _takes_gzip(request.headers.get("accept-encoding", "")):
            path = file.compressed
            headers |= {"Content-Encoding": "gzip", "ETag": f'{file.etag[:-1]}-gzip"'}
    if file.immutable:
        headers["Cache-Control"] = "public, max-age=31536000, immutable"
    if etag_matches(request.headers.get("if-none-match", ""), headers["ETag"], weak=True):
        headers.pop("Content-Encoding", None)
        return Response(status_code=304, headers=headers)
    return FileResponse(path, media_type=file.media_type, headers=headers)


def _takes_gzip(accepted: str) -> bool:
    """Whether a client's Accept-Encoding takes gzip (RFC 9110, 12.5.3)."""
    for part in accepted.split(","):
        coding, _, weight = part.partition(";")
        if coding.strip().lower() in {"gzip", "*"}:
            return weight.replace(" ", "") not in {"q=0", "q=0.0", "q=0.00", "q=0.000"}
    return False

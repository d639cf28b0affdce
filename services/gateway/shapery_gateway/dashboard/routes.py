"""``/`` and everything below it that is not the interface: the dashboard."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse, HTMLResponse
from starlette.exceptions import HTTPException

from shapery_gateway.dashboard.service import CONTENT_SECURITY_POLICY, NOT_BUILT, STATIC, StaticFile, find
from shapery_gateway.http.ranges import etag_matches

router = APIRouter(include_in_schema=False)

_API_PREFIXES = ("v1/", "docs/", "healthz/", "readyz/", "metrics/", "assets/")
"""Below these a path that does not exist is an error, and not a page of the dashboard."""

_PAGE_HEADERS = {"Content-Security-Policy": CONTENT_SECURITY_POLICY, "Cache-Control": "no-cache"}


@router.api_route("/{path:path}", methods=["GET", "HEAD"])
def get_dashboard(request: Request, path: str) -> Response:
    """Serve a file of the dashboard, or its page for the paths that it routes itself."""
    if path:
        file = find(STATIC, path)
        if file is not None:
            return _file_response(request, file)
        if f"{path}/".startswith(_API_PREFIXES) or "text/html" not in request.headers.get("accept", ""):
            raise HTTPException(404)
    page = find(STATIC, "index.html")
    if page is None:
        return HTMLResponse(NOT_BUILT, headers=_PAGE_HEADERS)
    return _file_response(request, page)


def _file_response(request: Request, file: StaticFile) -> Response:
    headers = {**_PAGE_HEADERS, "ETag": file.etag}
    if file.immutable:
        headers["Cache-Control"] = "public, max-age=31536000, immutable"
    if etag_matches(request.headers.get("if-none-match", ""), file.etag, weak=True):
        return Response(status_code=304, headers=headers)
    return FileResponse(file.path, media_type=file.media_type, headers=headers)

"""``/openapi.json`` and ``/docs``."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, JSONResponse

from shapery_gateway.dependencies import PublicCaller
from shapery_gateway.reference.page import CONTENT_SECURITY_POLICY, render

router = APIRouter(include_in_schema=False, dependencies=[PublicCaller])


@router.get("/openapi.json")
def get_openapi(request: Request) -> JSONResponse:
    """Give the interface in OpenAPI 3.1."""
    document: dict[str, Any] = request.app.openapi()
    return JSONResponse(document, headers={"Cache-Control": "no-cache"})


@router.get("/docs")
def get_docs(request: Request) -> HTMLResponse:
    """Give the same as a page to read."""
    app = request.app
    if not hasattr(app.state, "reference_page"):
        app.state.reference_page = render(app.openapi())
    return HTMLResponse(
        app.state.reference_page,
        headers={"Content-Security-Policy": CONTENT_SECURITY_POLICY, "Cache-Control": "no-cache"},
    )

"""The app: layers, routes and life cycle."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from anyio.to_thread import run_sync
from fastapi import Depends, FastAPI
from fastapi.routing import APIRoute
from starlette.middleware import Middleware
from starlette.middleware.cors import CORSMiddleware

from shapery_gateway import __version__, openapi, problems
from shapery_gateway.assets.routes import router as assets
from shapery_gateway.backend import Backend
from shapery_gateway.batches.routes import router as batches
from shapery_gateway.collections.routes import router as collections
from shapery_gateway.dashboard.routes import serve_dashboard
from shapery_gateway.health.routes import router as health
from shapery_gateway.http.parameters import refuse_repeated
from shapery_gateway.jobs.routes import router as jobs
from shapery_gateway.keys.routes import router as keys
from shapery_gateway.kinds.routes import router as kinds
from shapery_gateway.middleware.context import RequestContextMiddleware
from shapery_gateway.middleware.limits import BodyLimitMiddleware
from shapery_gateway.middleware.trust import LOOPBACK_HOSTS, TrustMiddleware, host_name
from shapery_gateway.middleware.tus import TusMiddleware
from shapery_gateway.reference.routes import router as reference
from shapery_gateway.search.routes import router as search
from shapery_gateway.shapes.routes import labels_router as labels
from shapery_gateway.shapes.routes import router as shapes
from shapery_gateway.uploads.routes import PREFIX as UPLOADS
from shapery_gateway.uploads.routes import router as uploads
from shapery_platform.settings import Settings, load_plugins

IDLE_SECONDS = 30.0
"""How long a client may stay silent within a body. Uploads keep what arrived, so giving up soon costs them nothing."""
MULTIPART_OVERHEAD = 1 << 20
"""Bytes that a form may have around its file."""

EXPOSED_HEADERS = (
    "Location",
    "ETag",
    "Content-Range",
    "Content-Disposition",
    "Accept-Ranges",
    "Retry-After",
    "X-Request-Id",
    "Tus-Resumable",
    "Tus-Version",
    "Tus-Extension",
    "Tus-Max-Size",
    "Tus-Checksum-Algorithm",
    "Upload-Offset",
    "Upload-Length",
    "Upload-Defer-Length",
    "Upload-Metadata",
    "Upload-Expires",
    "Upload-Asset-Id",
)
"""What a page of an allowed origin may read."""


def create_app(settings: Settings) -> FastAPI:
    """Make the app. Nothing is opened before it starts, so that its description can be had without a database."""
    load_plugins(settings)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        backend = Backend(settings)
        app.state.backend = backend
        try:
            await run_sync(backend.admit_first_key)
            yield
        finally:
            await backend.end_streams()
            backend.close()

    app = FastAPI(
        title="Shapery",
        version=__version__,
        lifespan=lifespan,
        # Swagger's and Redoc's pages load scripts from elsewhere; `reference` has one that does not.
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
        redirect_slashes=False,
        generate_unique_id_function=_operation_id,
        middleware=_layers(settings),
        dependencies=[Depends(refuse_repeated)],
    )
    app.state.settings = settings
    problems.install(app)
    routers = (health, kinds, uploads, assets, jobs, batches, collections, shapes, labels, search, keys, reference)
    for router in routers:
        app.include_router(router)
    app.state.api_routes = [route for router in routers for route in router.routes]
    # Whatever no route knows. As a route of its own it would take every path for known, and answer 405 for 404.
    app.router.default = serve_dashboard
    app.openapi = lambda: _document(app)  # type: ignore[method-assign]
    return app


def _operation_id(route: APIRoute) -> str:
    # Every route names its own; this runs only where one forgot, and the schema test says so.
    return route.name


def _document(app: FastAPI) -> dict[str, Any]:
    if app.openapi_schema is None:
        app.openapi_schema = openapi.build(app)
    return app.openapi_schema


def _layers(settings: Settings) -> list[Middleware]:
    """Return the layers around the routes, outermost first."""
    public_host = host_name((settings.public_url or "").partition("://")[2].partition("/")[0])
    allowed_hosts = None
    if settings.auth == "local":
        allowed_hosts = LOOPBACK_HOSTS | ({public_host} if public_host else set())

    def limit_for(method: str, path: str) -> int:
        if path == UPLOADS or path.startswith(f"{UPLOADS}/"):
            return settings.max_upload_bytes
        if method == "POST" and path == "/v1/assets":
            return settings.max_upload_bytes + MULTIPART_OVERHEAD
        return settings.max_request_bytes

    layers: list[Middleware] = [
        Middleware(RequestContextMiddleware, secure_transport=(settings.public_url or "").startswith("https://"))
    ]
    if settings.cors_origins:
        layers.append(
            Middleware(
                CORSMiddleware,
                allow_origins=settings.cors_origins,
                allow_methods=["GET", "HEAD", "POST", "PATCH", "DELETE"],
                allow_headers=["*"],
                expose_headers=EXPOSED_HEADERS,
                max_age=3600,
            )
        )
    layers += [
        Middleware(TrustMiddleware, allowed_hosts=allowed_hosts, allowed_origins=settings.cors_origins),
        Middleware(BodyLimitMiddleware, limit_for=limit_for, idle_timeout=IDLE_SECONDS),
        Middleware(TusMiddleware, prefix=UPLOADS),
    ]
    return layers

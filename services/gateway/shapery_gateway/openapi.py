"""The OpenAPI document: what FastAPI derives from the routes, and what it cannot know."""

from __future__ import annotations

from collections import defaultdict
from typing import Any, Literal

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from shapery_contracts.api import BatchCreate, BatchEvent, BatchHeader, BatchResult, FieldProblem, JobEvent, Problem
from shapery_contracts.errors import ERROR_CODES
from shapery_gateway import __version__
from shapery_gateway.problems import MEDIA_TYPE, TYPE_PREFIX

DESCRIPTION = """\
Shapery finds the surface hidden in a volume, the shape hidden in a bank of shapes, and the few motions hidden in a
long mesh sequence.

1. **Upload** a file: at once (`POST /v1/assets`) or resumably with tus 1.0 (`/v1/uploads`). It becomes an *asset*,
   addressed by its SHA-256; what kind of thing it is, is told from its content.
2. **Create a job** (`POST /v1/jobs`) that names a kind (`GET /v1/kinds`), assets and parameters.
3. **Follow it** (`GET /v1/jobs/{job_id}/events`, server-sent events) and fetch its result and artifacts.

Errors are `application/problem+json` (RFC 9457) with a stable `code`. Lists page by cursor. Times are UTC, ids are
UUIDv7. On a server that asks for keys, send `Authorization: Bearer …` or `X-API-Key: …`.
"""

TAGS = [
    {"name": "assets", "description": "Files addressed by their content."},
    {"name": "uploads", "description": "Resumable uploads: tus 1.0."},
    {"name": "jobs", "description": "Work on assets: its state, its progress, its results."},
    {"name": "batches", "description": "Many jobs of one kind, asked for at once."},
    {"name": "shapes", "description": "The shape database: indexed meshes, which searches find."},
    {"name": "keys", "description": "API keys."},
    {"name": "server", "description": "What this server offers, and its limits."},
    {"name": "health", "description": "For probes and for Prometheus."},
]


def problems(*codes: str) -> dict[int | str, dict[str, Any]]:
    """Return the ``responses`` of a route that may end with the error `codes`, one entry per status."""
    by_status: dict[int, list[str]] = defaultdict(list)
    for code in codes:
        by_status[ERROR_CODES[code].status].append(code)
    return {
        status: {
            "description": " ".join(f"`{code}`: {ERROR_CODES[code].title}" for code in found),
            "content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}, "example": example(found[0])}},
        }
        for status, found in sorted(by_status.items())
    }


def example(code: str) -> dict[str, Any]:
    """Return what a problem with `code` looks like."""
    entry = ERROR_CODES[code]
    return {
        "type": TYPE_PREFIX + code,
        "title": entry.title,
        "status": entry.status,
        "detail": entry.title,
        "code": code,
        "hint": "",
        "instance": "/v1/…",
        "request_id": "0c9f3c5c6f0b4b5c9e7a4d1d1f6f2f3a",
    }


COMMON_PROBLEMS = ("unauthenticated", "forbidden", "rate_limited")
"""What every route that asks for a key may answer."""

_UNNAMED: tuple[tuple[type[BaseModel], Literal["validation", "serialization"]], ...] = (
    (Problem, "serialization"),
    (FieldProblem, "serialization"),
    (JobEvent, "serialization"),
    (BatchEvent, "serialization"),
    (BatchResult, "serialization"),
    (BatchCreate, "validation"),
    (BatchHeader, "validation"),
)
"""Models that no signature names: they travel in streams and in bodies that are read piece by piece."""

_HEADERS = {
    "X-Request-Id": {
        "description": "The id under which the request is logged; the one that was sent, if it was well-formed.",
        "schema": {"type": "string"},
    }
}


def build(app: FastAPI) -> dict[str, Any]:
    """Return the OpenAPI 3.1 document of `app`."""
    document = get_openapi(
        title="Shapery",
        version=__version__,
        openapi_version="3.1.0",
        summary="Recovers shapes from volumes, shape banks and mesh sequences.",
        description=DESCRIPTION,
        routes=app.routes,
        tags=TAGS,
        license_info={"name": "Apache-2.0", "identifier": "Apache-2.0"},
    )
    schemas = document["components"]["schemas"]
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    _, definitions = models_json_schema(
        [(model, mode) for model, mode in _UNNAMED], ref_template="#/components/schemas/{model}"
    )
    for name, schema in definitions["$defs"].items():
        schemas.setdefault(name, schema)
    schemas["Problem"]["properties"]["code"]["enum"] = sorted(ERROR_CODES)
    schemas["Problem"]["properties"]["errors"] = {
        "type": "array",
        "items": {"$ref": "#/components/schemas/FieldProblem"},
        "description": "The places that are not valid (`validation_failed`).",
    }
    default = problems("internal_error")[500]
    default["description"] = "Any other error."
    for path in document["paths"].values():
        for operation in path.values():
            responses = operation["responses"]
            invalid = responses.get("422", {}).get("content", {}).get("application/json")
            if invalid is not None:
                # FastAPI's own shape of it is never sent: see `shapery_gateway.problems`.
                responses["422"] = problems("validation_failed")[422]
            responses["default"] = default
            for response in responses.values():
                response.setdefault("headers", {}).update(_HEADERS)
    document["components"]["schemas"] = dict(sorted(schemas.items()))
    return document

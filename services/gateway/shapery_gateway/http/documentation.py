"""How answers that are not JSON are described in the OpenAPI document."""

from __future__ import annotations

from typing import Any

BINARY: dict[str, Any] = {"schema": {"type": "string", "format": "binary"}}

_ETAG = {"description": "The SHA-256 of the content, quoted.", "schema": {"type": "string"}}
_CONTENT_HEADERS: dict[str, Any] = {
    "ETag": _ETAG,
    "Accept-Ranges": {"schema": {"type": "string", "enum": ["bytes"]}},
    "Content-Disposition": {"schema": {"type": "string"}},
}
_RANGE = {"Content-Range": {"description": "Which bytes these are.", "schema": {"type": "string"}}}

_ANYTHING: dict[str, Any] = {"*/*": {"schema": {"description": "Bytes of any media type."}}}

CONTENT_RESPONSES: dict[int | str, dict[str, Any]] = {
    200: {"description": "The whole content.", "content": _ANYTHING, "headers": _CONTENT_HEADERS},
    206: {
        "description": "The asked ranges: one as it is, several as `multipart/byteranges`.",
        "content": _ANYTHING,
        "headers": {**_CONTENT_HEADERS, **_RANGE},
    },
    304: {"description": "The content is still the one of `If-None-Match`.", "headers": {"ETag": _ETAG}},
}
"""Of routes that give out stored bytes."""


def header(name: str, description: str, schema: dict[str, Any], *, required: bool = False) -> dict[str, Any]:
    """Return the description of a request header."""
    return {"name": name, "in": "header", "required": required, "description": description, "schema": schema}


CONTENT_PARAMETERS = [
    header("Range", "Bytes to return: `bytes=0-1023`.", {"type": "string"}),
    header("If-Range", "Entity tag for which `Range` holds; with another the whole content comes.", {"type": "string"}),
    header("If-None-Match", "Entity tags that the client has already.", {"type": "string"}),
    header("If-Match", "Entity tags one of which the content must have.", {"type": "string"}),
]
CONTENT_PROBLEMS = ("not_found", "gone", "precondition_failed", "range_not_satisfiable")


def event_stream(description: str, model: str) -> dict[int | str, dict[str, Any]]:
    """Return the ``responses`` of a route that sends server-sent events whose data is a `model`."""
    event = {
        "type": "object",
        "description": "One event; a stream is any number of them.",
        "required": ["id", "event", "data"],
        "properties": {
            "id": {"type": "string", "pattern": "^[0-9]+$"},
            "event": {"type": "string"},
            "data": {
                "type": "string",
                "contentMediaType": "application/json",
                "contentSchema": {"$ref": f"#/components/schemas/{model}"},
            },
            "retry": {"type": "integer"},
        },
    }
    return {
        200: {"description": description, "content": {"text/event-stream": {"schema": event}}},
        204: {"description": "There is nothing more to come: the client need not ask again."},
    }

"""Stored bytes as an answer: ranges, entity tags, and headers that keep a browser from running what was uploaded."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from starlette.concurrency import iterate_in_threadpool
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

from shapery_gateway.http.disposition import content_disposition
from shapery_gateway.http.ranges import ByteRange, UnsatisfiableRange, etag_matches, parse_range
from shapery_gateway.problems import ProblemError

INLINE_TYPES = frozenset({"application/json", "image/jpeg", "image/png", "text/plain"})
"""What a browser may show by itself; everything else is offered as a download. None of them can run."""
_ACTIVE = ("html", "xml", "svg", "javascript", "ecmascript", "xsl", "shockwave", "pdf")
"""Words in a media type that a browser might run or hand to a plug-in."""

ReadRange = Callable[[int, int], Iterator[bytes]]
"""Yields the bytes from a start up to a stop."""


@dataclass(frozen=True, slots=True)
class Content:
    """Stored bytes and what is known of them."""

    sha256: str
    size: int
    media_type: str
    filename: str
    read: ReadRange

    @property
    def etag(self) -> str:
        """The strong entity tag: the same bytes have the same tag, and no others do."""
        return f'"{self.sha256}"'


def content_response(request: Request, content: Content) -> Response:
    """Answer a GET or HEAD for `content`, in whole or in part. Call it in a thread: it opens the object.

    Raises
    ------
    ProblemError
        ``precondition_failed`` (``If-Match``) or ``range_not_satisfiable``.
    """
    headers = request.headers
    media_type = safe_media_type(content.media_type)
    answer = {
        "ETag": content.etag,
        "Accept-Ranges": "bytes",
        # May be kept, by this user's browser alone, and asked for again at the price of a 304.
        "Cache-Control": "private, no-cache",
        "Content-Disposition": content_disposition(content.filename, inline=media_type in INLINE_TYPES),
    }
    if_match = headers.get("if-match")
    if if_match is not None and not etag_matches(if_match, content.etag, weak=False):
        raise ProblemError("precondition_failed", f"The content's entity tag is {content.etag}.")
    if_none_match = headers.get("if-none-match")
    if if_none_match is not None and etag_matches(if_none_match, content.etag, weak=True):
        return Response(status_code=304, headers=answer)
    ranges = _asked_ranges(request, headers, content)
    if ranges is None:
        answer["Content-Length"] = str(content.size)
        return _stream(request, 200, answer, media_type, content.read, [ByteRange(0, content.size)])
    if len(ranges) == 1:
        answer["Content-Range"] = ranges[0].content_range(content.size)
        answer["Content-Length"] = str(ranges[0].size)
        return _stream(request, 206, answer, media_type, content.read, ranges)
    return _multipart(answer, media_type, content, ranges)


def safe_media_type(media_type: str) -> str:
    """Return `media_type`, or ``application/octet-stream`` where a browser might run what is of it."""
    plain = media_type.partition(";")[0].strip().lower()
    if any(word in plain for word in _ACTIVE) or "/" not in plain or not plain.isascii() or not plain.isprintable():
        return "application/octet-stream"
    return plain


def _asked_ranges(request: Request, headers: Headers, content: Content) -> list[ByteRange] | None:
    if_range = headers.get("if-range")
    # A date never matches: what is addressed by its content has an entity tag and no date.
    if request.method != "GET" or (if_range is not None and if_range.strip() != content.etag):
        return None
    try:
        return parse_range(headers.get("range"), content.size)
    except UnsatisfiableRange:
        raise ProblemError(
            "range_not_satisfiable",
            f"The content has {content.size} bytes; the asked range lies behind its end.",
            headers={"Content-Range": f"bytes */{content.size}"},
        ) from None


def _stream(
    request: Request, status: int, headers: dict[str, str], media_type: str, read: ReadRange, ranges: list[ByteRange]
) -> Response:
    if request.method == "HEAD":
        return Response(status_code=status, headers=headers, media_type=media_type)
    part = ranges[0]
    # not even opened where there is nothing to read
    body = iterate_in_threadpool(read(part.start, part.stop) if part.size else iter(()))
    return StreamingResponse(body, status, headers, media_type)


def _multipart(headers: dict[str, str], media_type: str, content: Content, ranges: list[ByteRange]) -> Response:
    boundary = secrets.token_hex(16)
    opening = f"--{boundary}\r\nContent-Type: {media_type}\r\nContent-Range: "
    heads = [f"{opening}{part.content_range(content.size)}\r\n\r\n".encode() for part in ranges]
    tail = f"--{boundary}--\r\n".encode()
    # Each part is followed by a line break of its own, which belongs to the delimiter after it.
    length = sum(len(head) + part.size + 2 for head, part in zip(heads, ranges, strict=True)) + len(tail)

    def body() -> Iterator[bytes]:
        for head, part in zip(heads, ranges, strict=True):
            yield head
            yield from content.read(part.start, part.stop)
            yield b"\r\n"
        yield tail

    headers["Content-Length"] = str(length)
    return StreamingResponse(iterate_in_threadpool(body()), 206, headers, f"multipart/byteranges; boundary={boundary}")

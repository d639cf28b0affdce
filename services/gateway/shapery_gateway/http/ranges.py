"""Range requests (RFC 9110, section 14): which bytes were asked for."""

from __future__ import annotations

import re
from dataclasses import dataclass

MAX_RANGES = 32
"""A request for more is answered with the whole content: many tiny ranges cost the server, and nobody needs them."""

_SPEC = re.compile(r"^\s*(\d{0,19})\s*-\s*(\d{0,19})\s*$", re.ASCII)


@dataclass(frozen=True, slots=True)
class ByteRange:
    """The bytes from `start` up to and without `stop`."""

    start: int
    stop: int

    @property
    def size(self) -> int:
        """How many bytes these are."""
        return self.stop - self.start

    def content_range(self, size: int) -> str:
        """Return the value of ``Content-Range`` for content of `size` bytes."""
        return f"bytes {self.start}-{self.stop - 1}/{size}"


class UnsatisfiableRange(Exception):
    """None of the asked ranges lies inside the content."""


def parse_range(header: str | None, size: int) -> list[ByteRange] | None:
    """Tell which ranges of content of `size` bytes a ``Range`` header asks for.

    Parameters
    ----------
    header
        The header's value, or None where there is none.
    size
        Bytes of the whole content.

    Returns
    -------
    Ranges in ascending order, those that overlap or touch joined; None where the whole content is to be sent: no
    header, another unit, a header that is malformed (which RFC 9110 lets a server ignore), or too many ranges.

    Raises
    ------
    UnsatisfiableRange
        All ranges are well-formed and none lies inside.
    """
    if header is None:
        return None
    unit, separator, specs = header.partition("=")
    if not separator or unit.strip().lower() != "bytes":
        return None
    parts = [part for part in specs.split(",") if part.strip()]
    if not parts or len(parts) > MAX_RANGES:
        return None
    found: list[ByteRange] = []
    for part in parts:
        match = _SPEC.match(part)
        if match is None:
            return None
        first, last = match.groups()
        if not first and not last:
            return None
        if not first:
            suffix = min(int(last), size)
            start, stop = size - suffix, size
        else:
            start = int(first)
            if last and int(last) < start:
                return None
            stop = min(int(last) + 1, size) if last else size
        if start < stop:
            found.append(ByteRange(start, stop))
    if not found:
        raise UnsatisfiableRange
    found.sort(key=lambda item: item.start)
    joined = found[:1]
    for item in found[1:]:
        if item.start <= joined[-1].stop:
            joined[-1] = ByteRange(joined[-1].start, max(joined[-1].stop, item.stop))
        else:
            joined.append(item)
    return joined


def etag_matches(header: str, etag: str, *, weak: bool) -> bool:
    """Tell whether a list of entity tags, or ``*``, names `etag`.

    Parameters
    ----------
    header
        The value of ``If-None-Match``, ``If-Match`` or ``If-Range``.
    etag
        The strong entity tag of the content, with its quotes.
    weak
        Whether a weak tag counts as well (``If-None-Match``; RFC 9110, section 8.8.3.2).
    """
    if header.strip() == "*":
        return True
    for tag in header.split(","):
        candidate = tag.strip()
        if weak and candidate.startswith("W/"):
            candidate = candidate[2:]
        if candidate == etag:
            return True
    return False

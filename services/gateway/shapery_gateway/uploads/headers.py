"""The headers of tus 1.0, read strictly."""

from __future__ import annotations

import base64
import binascii
import hashlib
from collections.abc import Mapping
from datetime import datetime
from email.utils import format_datetime

from shapery_gateway.http.storable import refuse_unstorable
from shapery_gateway.problems import ProblemError
from shapery_platform.uploads import CHECKSUM_ALGORITHMS

EXTENSIONS = ("creation", "creation-with-upload", "creation-defer-length", "checksum", "termination", "expiration")
CONTENT_TYPE = "application/offset+octet-stream"
MAX_METADATA = 4096


def parse_count(name: str, value: str | None) -> int | None:
    """Return the number of bytes in the header `name`, None where there is none."""
    if value is None:
        return None
    if not (value.isascii() and value.isdigit()) or len(value) > 18:
        raise ProblemError("bad_request", f"{name} is {value[:40]!r}; it must be a number of bytes, 0 or more.")
    return int(value)


def parse_length(length: str | None, defer: str | None) -> int | None:
    """Return the length that a creation declares, None where it is deferred."""
    if defer is not None:
        if defer != "1" or length is not None:
            raise ProblemError(
                "bad_request", "Upload-Defer-Length must be 1, and excludes Upload-Length.", "Send one of the two."
            )
        return None
    count = parse_count("Upload-Length", length)
    if count is None:
        raise ProblemError(
            "bad_request", "Neither Upload-Length nor Upload-Defer-Length was sent.", "Send the length of the file."
        )
    return count


def parse_metadata(value: str | None) -> dict[str, str]:
    """Return the pairs of ``Upload-Metadata``; values that are not UTF-8 are refused."""
    if value is None or not value.strip():
        return {}
    if len(value) > MAX_METADATA:
        raise ProblemError(
            "bad_request", f"Upload-Metadata has {len(value)} characters; at most {MAX_METADATA} may be."
        )
    pairs: dict[str, str] = {}
    for part in value.split(","):
        key, _, encoded = part.strip().partition(" ")
        if not key or not key.isascii() or key in pairs:
            raise ProblemError("bad_request", f"Upload-Metadata has an empty, doubled or non-ASCII key {key[:40]!r}.")
        try:
            pairs[key] = base64.b64decode(encoded.strip(), validate=True).decode("utf-8")
        except (binascii.Error, ValueError):
            raise ProblemError(
                "bad_request", f"The value of {key[:40]!r} in Upload-Metadata is not base64 of UTF-8."
            ) from None
    refuse_unstorable(pairs, "Upload-Metadata")
    return pairs


def format_metadata(metadata: Mapping[str, str]) -> str:
    """Return the value of ``Upload-Metadata`` for these pairs."""
    return ",".join(f"{key} {base64.b64encode(value.encode()).decode()}" for key, value in metadata.items())


def parse_checksum(value: str | None) -> tuple[str, bytes] | None:
    """Return algorithm and digest of ``Upload-Checksum``, None where there is none."""
    if value is None:
        return None
    algorithm, _, encoded = value.strip().partition(" ")
    if algorithm not in CHECKSUM_ALGORITHMS:
        raise ProblemError(
            "bad_request",
            f"The checksum algorithm {algorithm[:20]!r} is not known here.",
            f"Known: {', '.join(CHECKSUM_ALGORITHMS)}.",
        )
    try:
        digest = base64.b64decode(encoded.strip(), validate=True)
    except (binascii.Error, ValueError):
        raise ProblemError("bad_request", "The value of Upload-Checksum is not base64.") from None
    expected = hashlib.new(algorithm, usedforsecurity=False).digest_size
    if len(digest) != expected:
        raise ProblemError("bad_request", f"The checksum has {len(digest)} bytes; {algorithm} has {expected}.")
    return algorithm, digest


def http_date(moment: datetime) -> str:
    """Return `moment`, which must be UTC, as RFC 9110 writes dates."""
    return format_datetime(moment, usegmt=True)

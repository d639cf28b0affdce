from __future__ import annotations

import base64
import hashlib
from datetime import UTC, datetime

import pytest

from shapery_contracts.errors import UserError
from shapery_gateway.problems import ProblemError
from shapery_gateway.uploads.headers import (
    MAX_METADATA,
    format_metadata,
    http_date,
    parse_checksum,
    parse_count,
    parse_length,
    parse_metadata,
)


def b64(data: bytes) -> str:
    return base64.b64encode(data).decode()


def test_lengths() -> None:
    assert parse_length("12", None) == 12
    assert parse_length("0", None) == 0
    assert parse_length(None, "1") is None
    assert parse_count("Upload-Offset", None) is None


@pytest.mark.parametrize(
    ("length", "defer"),
    [
        (None, None),
        ("1", "1"),
        (None, "0"),
        (None, "yes"),
        ("-1", None),
        ("1.5", None),
        ("", None),
        ("９", None),
        ("1" * 19, None),
    ],
)
def test_lengths_refused(length: str | None, defer: str | None) -> None:
    with pytest.raises(ProblemError) as caught:
        parse_length(length, defer)
    assert caught.value.code == "bad_request"


def test_metadata_round_trip() -> None:
    pairs = {"filename": "Größe.nii", "empty": "", "type": "a/b"}
    assert parse_metadata(format_metadata(pairs)) == pairs
    assert parse_metadata("is_confidential") == {"is_confidential": ""}
    assert parse_metadata(f"a {b64(b'1')} , b {b64(b'2')}") == {"a": "1", "b": "2"}
    assert parse_metadata(None) == {}
    assert parse_metadata("  ") == {}


@pytest.mark.parametrize(
    "value",
    [
        ",",
        "a b c",
        "a !!!",
        f"a {b64(b'x')},a {b64(b'y')}",
        f"ä {b64(b'x')}",
        "a " + b64(b"\xff\xfe"),
        "a" * (MAX_METADATA + 1),
    ],
)
def test_metadata_refused(value: str) -> None:
    with pytest.raises(ProblemError) as caught:
        parse_metadata(value)
    assert caught.value.code == "bad_request"


def test_metadata_with_nul_is_refused() -> None:
    with pytest.raises(UserError):
        parse_metadata("filename " + b64(b"a\x00b"))


def test_checksums() -> None:
    for name in ("sha1", "sha256", "md5"):
        digest = hashlib.new(name, b"x", usedforsecurity=False).digest()
        assert parse_checksum(f"{name} {b64(digest)}") == (name, digest)
    assert parse_checksum(None) is None


@pytest.mark.parametrize("value", ["", "sha256", "crc32 AAAA", "sha256 !!", f"sha256 {b64(b'short')}", "sha1"])
def test_checksums_refused(value: str) -> None:
    with pytest.raises(ProblemError):
        parse_checksum(value)


def test_dates() -> None:
    assert http_date(datetime(2030, 1, 2, 3, 4, 5, tzinfo=UTC)) == "Wed, 02 Jan 2030 03:04:05 GMT"

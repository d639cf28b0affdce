from __future__ import annotations

import re
from urllib.parse import unquote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapery_gateway.http.content import safe_media_type
from shapery_gateway.http.disposition import MAX_NAME, content_disposition, safe_filename


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("head.nii.gz", "head.nii.gz"),
        ("/etc/passwd", "passwd"),
        ("..\\..\\C:\\scans\\head.nii", "head.nii"),
        ("..", "file"),
        ("", "file"),
        ("...", "file"),
        ("a\r\nSet-Cookie: x=1.nii", "aSet-Cookie_ x=1.nii"),
        ("a\0b.obj", "ab.obj"),
        ("\u202egpj.exe", "gpj.exe"),
        ("Gehirn Ä.nii", "Gehirn Ä.nii"),
        ("a\ud800b", "ab"),
        (' "quoted" ', "_quoted_"),
        (".hidden", ".hidden"),
    ],
)
def test_safe_filename(name: str, expected: str) -> None:
    assert safe_filename(name) == expected


def test_a_long_name_keeps_its_ending() -> None:
    name = safe_filename("ä" * 400 + ".nii.gz")
    assert name.endswith(".nii.gz")
    assert len(name.encode()) <= MAX_NAME


@given(st.text(st.characters(codec=None), max_size=300), st.booleans())
def test_no_name_breaks_out_of_the_header(name: str, inline: bool) -> None:
    value = content_disposition(name, inline=inline)
    assert value.isascii()
    assert value.isprintable()
    match = re.fullmatch(r"(inline|attachment); filename=\"([^\"\\]+)\"(?:; filename\*=UTF-8''([\w.%~-]+))?", value)
    assert match is not None, value
    assert (match[1] == "inline") is inline
    if match[3] is not None:
        assert unquote(match[3], errors="strict") == safe_filename(name)


def test_umlauts_arrive() -> None:
    value = content_disposition("Größe.nii", inline=False)
    assert value == "attachment; filename=\"Groe.nii\"; filename*=UTF-8''Gr%C3%B6%C3%9Fe.nii"


@pytest.mark.parametrize(
    ("given_type", "expected"),
    [
        ("text/html", "application/octet-stream"),
        ("TEXT/HTML; charset=utf-8", "application/octet-stream"),
        ("image/svg+xml", "application/octet-stream"),
        ("application/xhtml+xml", "application/octet-stream"),
        ("text/javascript", "application/octet-stream"),
        ("application/pdf", "application/octet-stream"),
        ("nonsense", "application/octet-stream"),
        ("model/gltf-binary", "model/gltf-binary"),
        ("application/json; charset=utf-8", "application/json"),
        ("image/png", "image/png"),
    ],
)
def test_nothing_active_keeps_its_type(given_type: str, expected: str) -> None:
    assert safe_media_type(given_type) == expected

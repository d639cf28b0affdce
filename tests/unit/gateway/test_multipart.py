from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapery_gateway.assets.multipart import MAX_OTHER_FIELDS, MultipartFile, blocks
from shapery_gateway.problems import ProblemError

TYPE = "multipart/form-data; boundary=b"


def part(name: str, content: bytes, filename: str | None = None) -> bytes:
    file = "" if filename is None else f'; filename="{filename}"'
    return f'--b\r\nContent-Disposition: form-data; name="{name}"{file}\r\n\r\n'.encode() + content + b"\r\n"


END = b"--b--\r\n"


async def stream(pieces: Iterable[bytes]) -> AsyncIterator[bytes]:
    for piece in pieces:
        yield piece


def read(body: bytes, sizes: int = 1000, content_type: str = TYPE) -> tuple[str, bytes]:
    async def run() -> tuple[str, bytes]:
        form = MultipartFile(content_type)
        cut = (body[i : i + sizes] for i in range(0, len(body), sizes))
        content = b"".join([piece async for piece in form.content(stream(cut))])
        return form.filename, content

    return asyncio.run(run())


@given(st.binary(max_size=400), st.integers(1, 60))
def test_the_content_arrives_however_it_is_cut(content: bytes, sizes: int) -> None:
    # what looks like a boundary and is none must come through as well
    content = content + b"\r\n--" + content + b"\r\n--a\r\n"
    body = part("note", b"x") + part("file", content, "head.nii") + part("after", b"y") + END
    assert read(body, sizes) == ("head.nii", content)


def test_the_name_is_made_safe() -> None:
    assert read(part("file", b"x", "../../etc/passwd") + END) == ("passwd", b"x")
    assert read(part("file", b"x") + END) == ("file", b"x")


@pytest.mark.parametrize(
    ("body", "code"),
    [
        (part("other", b"x") + END, "missing_input"),
        (END, "missing_input"),
        (part("file", b"x", "a"), "bad_request"),
        (part("file", b"x", "a") + END[:-4], "bad_request"),
        (b"", "bad_request"),
        (b"hello world, this is no form", "bad_request"),
        (part("file", b"x", "a") + part("file", b"y", "b") + END, "validation_failed"),
        (part("other", b"x" * (MAX_OTHER_FIELDS + 1)) + END, "request_too_large"),
        (b"--b\r\n" + b"X-Long: " + b"x" * 100_000 + b"\r\n\r\n", "bad_request"),
    ],
)
def test_refused(body: bytes, code: str) -> None:
    with pytest.raises(ProblemError) as caught:
        read(body)
    assert caught.value.code == code


@pytest.mark.parametrize(
    ("content_type", "code"),
    [
        ("", "unsupported_media_type"),
        ("application/json", "unsupported_media_type"),
        ("multipart/mixed; boundary=b", "unsupported_media_type"),
        ("multipart/form-data", "bad_request"),
        ("multipart/form-data; boundary=" + "b" * 300, "bad_request"),
    ],
)
def test_content_types(content_type: str, code: str) -> None:
    with pytest.raises(ProblemError) as caught:
        read(END, content_type=content_type)
    assert caught.value.code == code


@given(st.lists(st.binary(max_size=30), max_size=30), st.integers(1, 50))
def test_blocks_keep_every_byte(pieces: list[bytes], size: int) -> None:
    async def run() -> list[bytes]:
        return [block async for block in blocks(stream(pieces), size)]

    found = asyncio.run(run())
    assert b"".join(found) == b"".join(pieces)
    assert all(len(block) >= size for block in found[:-1])
    assert all(found)

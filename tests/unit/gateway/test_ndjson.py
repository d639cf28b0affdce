from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from uuid import UUID, uuid4

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapery_contracts.api import BatchHeader, BatchItem
from shapery_contracts.errors import UserError
from shapery_gateway.batches import ndjson
from shapery_gateway.problems import ProblemError

ID = UUID("01890a5d-ac96-774b-bcce-b302099a8057")
HEADER = '{"kind": "segmentation"}\n'
ITEM = f'{{"inputs": {{"post": "{ID}"}}}}\n'


def read(body: str | bytes, sizes: int = 7, max_items: int = 10) -> tuple[BatchHeader, list[BatchItem]]:
    data = body.encode() if isinstance(body, str) else body

    async def stream() -> AsyncIterator[bytes]:
        for begin in range(0, len(data), sizes):
            yield data[begin : begin + sizes]

    return asyncio.run(ndjson.read_batch(stream(), max_items))


@given(st.integers(1, 200), st.integers(0, 9), st.sampled_from(["\n", "\r\n", "\n\n", " \n"]))
def test_read_however_it_is_cut(sizes: int, count: int, end: str) -> None:
    ids = [uuid4() for _ in range(count)]
    rows = ['{"kind": "k", "params": {"ä": 1}}', *(json.dumps({"inputs": {"post": str(i)}}) for i in ids)]
    header, items = read(end.join(rows), sizes)
    assert header == BatchHeader(kind="k", params={"ä": 1})
    assert [item.inputs["post"] for item in items] == ids


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("", "empty"),
        ("\n \n", "empty"),
        (ITEM, "Line 1"),
        (HEADER + "{", "Line 2"),
        (HEADER + ITEM + "\n\n" + '{"inputs": {"post": "x"}}', "Line 5"),
        (HEADER + ITEM.replace("}}", '}, "more": 1}'), "Line 2"),
        (HEADER.replace("}", ', "params": {"a": "\\u0000"}}'), "Line 1"),
        (HEADER + "[]", "Line 2"),
        (b'{"kind": "\xff"}\n', "Line 1"),
    ],
)
def test_mistakes_name_their_line(body: str | bytes, said: str) -> None:
    with pytest.raises(UserError, match=said) as caught:
        read(body)
    assert caught.value.code == "validation_failed"


def test_too_many_items_end_the_reading() -> None:
    with pytest.raises(UserError) as caught:
        read(HEADER + ITEM * 11)
    assert caught.value.code == "too_large"
    assert len(read(HEADER + ITEM * 10)[1]) == 10


def test_a_line_without_end_is_not_gathered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ndjson, "MAX_LINE", 1000)
    seen = 0

    async def endless() -> AsyncIterator[bytes]:
        nonlocal seen
        while True:
            seen += 100
            yield b"x" * 100

    with pytest.raises(ProblemError) as caught:
        asyncio.run(ndjson.read_batch(endless(), 10))
    assert caught.value.code == "request_too_large"
    assert seen < 2000

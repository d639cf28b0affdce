from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapery_gateway.http.ranges import (
    MAX_RANGES,
    ByteRange,
    UnsatisfiableRange,
    etag_matches,
    parse_range,
)


@pytest.mark.parametrize(
    ("header", "expected"),
    [
        ("bytes=0-0", [(0, 1)]),
        ("bytes=0-99", [(0, 10)]),
        ("bytes=3-", [(3, 10)]),
        ("bytes=-3", [(7, 10)]),
        ("bytes=-99", [(0, 10)]),
        ("bytes= 1-2 , 5-6", [(1, 3), (5, 7)]),
        ("BYTES=1-2", [(1, 3)]),
        ("bytes=5-6,1-2", [(1, 3), (5, 7)]),
        ("bytes=0-4,3-6", [(0, 7)]),
        ("bytes=0-4,5-6", [(0, 7)]),
        ("bytes=2-3,50-60", [(2, 4)]),
        ("bytes=1-2,,", [(1, 3)]),
    ],
)
def test_well_formed(header: str, expected: list[tuple[int, int]]) -> None:
    assert parse_range(header, 10) == [ByteRange(*pair) for pair in expected]


@pytest.mark.parametrize(
    "header",
    [
        None,
        "",
        "bytes",
        "bytes=",
        "bytes=-",
        "bytes=a-b",
        "bytes=5-3",
        "bytes=1-2;3-4",
        "bytes=+1-2",
        "bytes=١-٢",
        "bytes=0x1-2",
        "bytes=1-2,x",
        "items=0-1",
        "bytes=99999999999999999999-",
        "bytes=" + ",".join(f"{i}-{i}" for i in range(MAX_RANGES + 1)),
    ],
)
def test_ignored(header: str | None) -> None:
    assert parse_range(header, 10) is None


@pytest.mark.parametrize("header", ["bytes=10-", "bytes=10-20", "bytes=-0", "bytes=11-12,13-14"])
def test_unsatisfiable(header: str) -> None:
    with pytest.raises(UnsatisfiableRange):
        parse_range(header, 10)


def test_empty_content_satisfies_nothing() -> None:
    for header in ("bytes=0-", "bytes=-5", "bytes=0-0"):
        with pytest.raises(UnsatisfiableRange):
            parse_range(header, 0)


@given(
    st.integers(1, 60),
    st.lists(st.tuples(st.none() | st.integers(0, 70), st.none() | st.integers(0, 70)), min_size=1, max_size=6),
)
def test_is_the_union_of_what_was_asked_for(size: int, asked: list[tuple[int | None, int | None]]) -> None:
    header = "bytes=" + ",".join(f"{'' if a is None else a}-{'' if b is None else b}" for a, b in asked)
    malformed = any((a is None and b is None) or (a is not None and b is not None and b < a) for a, b in asked)
    wanted: set[int] = set()
    for first, last in asked:
        if first is None and last is not None:
            wanted |= set(range(max(0, size - last), size))
        elif first is not None:
            wanted |= set(range(first, size if last is None else min(size, last + 1)))
    if malformed:
        assert parse_range(header, size) is None
    elif not wanted:
        with pytest.raises(UnsatisfiableRange):
            parse_range(header, size)
    else:
        found = parse_range(header, size)
        assert found is not None
        listed = [i for part in found for i in range(part.start, part.stop)]
        assert listed == sorted(wanted)
        assert all(a.stop < b.start for a, b in itertools.pairwise(found)), "neighbours are joined"


def test_content_range() -> None:
    assert ByteRange(3, 7).content_range(10) == "bytes 3-6/10"
    assert ByteRange(3, 7).size == 4


@pytest.mark.parametrize(
    ("header", "weak", "expected"),
    [
        ('"a"', False, True),
        ("*", False, True),
        ('"b", "a"', False, True),
        ('W/"a"', True, True),
        ('W/"a"', False, False),
        ('"b"', True, False),
        ("a", True, False),
        ("", True, False),
    ],
)
def test_entity_tags(header: str, weak: bool, expected: bool) -> None:
    assert etag_matches(header, '"a"', weak=weak) is expected

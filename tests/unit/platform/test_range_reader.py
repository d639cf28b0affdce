"""The file over ranges that reads ahead."""

from __future__ import annotations

import io
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapery_platform.storage.store import RangeReader

DATA = random.Random(1).randbytes(300_000)


class Ranges:
    """Counts what is asked for."""

    def __init__(self) -> None:
        self.asked: list[tuple[int, int]] = []

    def __call__(self, start: int, stop: int) -> bytes:
        assert 0 <= start < stop <= len(DATA)
        self.asked.append((start, stop))
        return DATA[start:stop]


Step = tuple[str, int]
STEPS = st.lists(
    st.tuples(st.just("read"), st.integers(0, 100_000)) | st.tuples(st.just("seek"), st.integers(0, 310_000)),
    max_size=20,
)


@given(steps=STEPS, most=st.sampled_from([1, 1000, 1 << 16, 1 << 20]))
def test_reads_what_a_file_would(steps: list[Step], most: int) -> None:
    if most == 1:
        steps = [(what, min(number, 50)) for what, number in steps]
    plain = io.BytesIO(DATA)
    file = io.BufferedReader(RangeReader(Ranges(), len(DATA), most))
    for what, number in steps:
        if what == "read":
            assert file.read(number) == plain.read(number)
        else:
            assert file.seek(number) == plain.seek(number)
        assert file.tell() == plain.tell()


def test_little_is_read_for_a_header_and_much_in_order() -> None:
    ranges = Ranges()
    file = io.BufferedReader(RangeReader(ranges, len(DATA), 1 << 20))
    file.read(348)
    file.seek(-22, io.SEEK_END)
    file.read()
    assert len(ranges.asked) == 2
    assert sum(stop - start for start, stop in ranges.asked) < 70_000
    ranges.asked.clear()
    file.seek(100)
    assert file.read() == DATA[100:]
    sizes = [stop - start for start, stop in ranges.asked]
    assert len(sizes) <= 3, "more and more at a time"


def test_no_more_is_kept_than_allowed() -> None:
    ranges = Ranges()
    file = RangeReader(ranges, len(DATA), 10_000)
    while file.read(7):
        pass
    assert max(stop - start for start, stop in ranges.asked) == 10_000
    assert sum(stop - start for start, stop in ranges.asked) == len(DATA)


def test_positions() -> None:
    file = RangeReader(Ranges(), len(DATA), 1000)
    assert (file.readable(), file.seekable(), file.writable()) == (True, True, False)
    assert file.seek(10) == 10
    assert file.seek(5, io.SEEK_CUR) == 15
    assert file.seek(1, io.SEEK_END) == len(DATA) + 1
    assert file.read(1) == b""
    with pytest.raises(OSError, match="before the beginning"):
        file.seek(-1)

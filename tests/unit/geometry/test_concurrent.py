"""Two parts of the work at once give what one after the other gives."""

from __future__ import annotations

import threading

import pytest

from shapery_geometry.concurrent import at_once, both, in_halves


def test_results_keep_the_order_of_the_items() -> None:
    first_may_end = threading.Event()

    def work(item: int) -> int:
        if item == 0:
            assert first_may_end.wait(10)
        else:
            first_may_end.set()
        return 10 * item

    assert at_once(work, range(5)) == [0, 10, 20, 30, 40]


def test_both_run_at_the_same_time() -> None:
    meeting = threading.Barrier(2, timeout=10)
    here = threading.get_ident()
    assert both(lambda: (meeting.wait() >= 0, threading.get_ident() == here), lambda: meeting.wait() >= 0) == (
        (True, True),
        True,
    )


def test_the_first_error_is_raised() -> None:
    def work(item: int) -> int:
        raise KeyError(item)

    with pytest.raises(KeyError, match="0"):
        at_once(work, (0, 1))
    with pytest.raises(KeyError, match="7"):
        both(lambda: 1, lambda: work(7))


def test_halves_are_worked_at_the_same_time_and_few_items_by_one() -> None:
    meeting = threading.Barrier(2, timeout=10)

    def work(first: int, end: int) -> range:
        if end - first < 9:
            meeting.wait()
        return range(first, end)

    assert in_halves(work, 9, 5) == [range(4), range(4, 9)]
    assert in_halves(work, 9, 10) == [range(9)]

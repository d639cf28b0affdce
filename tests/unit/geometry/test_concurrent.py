"""Two parts of the work at once give what one after the other gives."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from shapery_geometry.concurrent import MANY_VOXELS, at_once, both, in_halves, in_slabs, threads


@pytest.fixture
def two_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")


@pytest.mark.usefixtures("two_threads")
def test_results_keep_the_order_of_the_items() -> None:
    first_may_end = threading.Event()

    def work(item: int) -> int:
        if item == 0:
            assert first_may_end.wait(10)
        else:
            first_may_end.set()
        return 10 * item

    assert at_once(work, range(5)) == [0, 10, 20, 30, 40]


@pytest.mark.usefixtures("two_threads")
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


@pytest.mark.usefixtures("two_threads")
def test_an_error_of_the_first_waits_for_the_second() -> None:
    begun, ended = threading.Event(), threading.Event()

    def fails() -> None:
        assert begun.wait(10)
        raise KeyError(1)

    def goes_on() -> None:
        begun.set()
        ended.wait(0.05)
        ended.set()

    with pytest.raises(KeyError, match="1"):
        both(fails, goes_on)
    assert ended.is_set()


@pytest.mark.usefixtures("two_threads")
@pytest.mark.timeout(60)
def test_what_runs_beside_may_have_parts_itself() -> None:
    def depth(left: int) -> int:
        return 1 if left == 0 else sum(both(lambda: depth(left - 1), lambda: depth(left - 1)))

    # More parts wait for each other than there are threads.
    with ThreadPoolExecutor(4) as callers:
        assert list(callers.map(depth, [8] * 8)) == [256] * 8


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_has_threads_of_its_own() -> None:
    code = (
        "import os, threading\n"
        "from shapery_geometry.concurrent import both\n"
        "meeting = threading.Barrier(2, timeout=20)\n"
        "assert both(meeting.wait, meeting.wait) in ((0, 1), (1, 0))\n"
        "child = os.fork()\n"
        "if child == 0:\n"
        "    both(meeting.wait, meeting.wait)\n"
        "    os._exit(7)\n"
        "assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7\n"
    )
    ended = subprocess.run(
        [sys.executable, "-W", "ignore::DeprecationWarning", "-c", code],
        env={**os.environ, "NUMBA_NUM_THREADS": "2"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr


@pytest.mark.usefixtures("two_threads")
def test_halves_are_worked_at_the_same_time_and_few_items_by_one() -> None:
    meeting = threading.Barrier(2, timeout=10)

    def work(first: int, end: int) -> range:
        if end - first < 9:
            meeting.wait()
        return range(first, end)

    assert in_halves(work, 9, 5) == [range(4), range(4, 9)]
    assert in_halves(work, 9, 10) == [range(9)]


@pytest.mark.usefixtures("two_threads")
def test_large_arrays_are_halved_and_small_ones_are_not() -> None:
    def ends(first: int, end: int) -> tuple[int, int]:
        return first, end

    assert in_slabs(ends, (6, MANY_VOXELS // 6, 1)) == [(0, 3), (3, 6)]
    assert in_slabs(ends, (6, MANY_VOXELS // 12, 1)) == [(0, 6)]
    assert in_slabs(ends, (1, MANY_VOXELS, 2)) == [(0, 1)]
    assert in_slabs(ends, (0, 4, 0)) == [(0, 0)]


@pytest.mark.parametrize(("asked", "taken"), [("1", 1), ("2", 2), ("64", 2)])
def test_as_many_threads_as_numba_may_take(asked: str, taken: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", asked)
    assert threads() == taken


@pytest.mark.parametrize("asked", ["", "0", "many"])
@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="this system does not bind processes to processors")
def test_as_many_threads_as_processors_by_default(asked: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", asked)
    for processors in (1, 2, 7):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, count=processors: set(range(count)))
        assert threads() == min(2, processors)


def test_one_thread_does_one_thing_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    done: list[tuple[str, int]] = []

    def work(name: str) -> int:
        done.append((name, threading.get_ident()))
        return len(done)

    assert both(lambda: work("a"), lambda: work("b")) == (1, 2)
    assert at_once(work, "cd") == [3, 4]
    assert in_halves(lambda first, end: (first, end), 10, 2) == [(0, 10)]
    assert done == [(name, threading.get_ident()) for name in "abcd"]

"""Two independent parts of the work at once, on two cores, where there are two.

With ``NUMBA_NUM_THREADS=1`` everything is done one after the other, as a worker wants it that has a job for each core.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

MOST_THREADS = 2
"""More would not be busy: parts of the work that do not wait for each other are two at the most."""

MOST_HELPERS = 2
"""Threads that are kept at the most; what finds none free is done by who asked for it. More are not faster on two
cores, and each keeps memory of its own."""

MANY_VOXELS = 300_000
"""Voxels from which on a second thread saves more than it costs where each takes a few nanoseconds."""


def threads() -> int:
    """Return how many threads the work takes: as many as numba may, at most `MOST_THREADS`."""
    asked = os.environ.get("NUMBA_NUM_THREADS", "")
    if asked.isdigit() and int(asked):
        return min(MOST_THREADS, int(asked))
    here = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(MOST_THREADS, here)


def at_once(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Return the work done on each item, as if one after the other; the first error is raised.

    Compiled loops, SciPy's filters and decompression let others run, so this saves time although Python itself does
    not. The result does not depend on who is first.
    """
    count = threads()
    if count == 1:
        return [work(item) for item in items]
    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(work, items))


def in_halves(work: Callable[[int, int], Result], count: int, least: int) -> list[Result]:
    """Return the work done on the items from a first to before an end, for both halves of `count` items at once.

    Parameters
    ----------
    work
        Called with first and end. What it returns must not depend on where the halves meet.
    count
        Items.
    least
        Fewer are not worth a second thread: then there is one half, which holds all.
    """
    if count < least or threads() == 1:
        return [work(0, count)]
    middle = count // 2
    return list(both(lambda: work(0, middle), lambda: work(middle, count)))


def in_slabs(work: Callable[[int, int], Result], shape: Sequence[int]) -> list[Result]:
    """Return the work done on both halves of an array's slices along its first axis, where it has `MANY_VOXELS`."""
    per_slice = max(1, math.prod(shape[1:]))
    return in_halves(work, shape[0], max(2, MANY_VOXELS // per_slice))


def both(first: Callable[[], Item], second: Callable[[], Result]) -> tuple[Item, Result]:
    """Return the results of two functions without arguments, of which the first runs here.

    The second runs beside it if a thread is free, else afterwards; so it may itself call this function.
    """
    if threads() == 1:
        return first(), second()
    later = _helpers().submit(second)
    try:
        result = first()
    except BaseException:
        # Nothing goes on behind the back of who catches this.
        if not later.cancel():
            wait((later,))
        raise
    return result, second() if later.cancel() else later.result()


@cache
def _helpers() -> ThreadPoolExecutor:
    """Return the threads that wait for work: to start one takes longer than much of what is done at once."""
    return ThreadPoolExecutor(MOST_HELPERS, "shapery-helper")


if hasattr(os, "register_at_fork"):
    # A process that is forked has none of the threads of its parent.
    os.register_at_fork(after_in_child=_helpers.cache_clear)

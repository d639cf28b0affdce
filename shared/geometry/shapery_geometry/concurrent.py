"""Two independent parts of the work at once, on two cores."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

THREADS = 2
"""More would not be busy: parts of the work that do not wait for each other are two at the most."""

MANY_VOXELS = 300_000
"""Voxels from which on a second thread saves more than it costs where each takes a few nanoseconds."""


def at_once(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Return the work done on each item, as if one after the other; the first error is raised.

    Compiled loops, SciPy's filters and decompression let others run, so this saves time although Python itself does
    not. The result does not depend on who is first.
    """
    with ThreadPoolExecutor(THREADS) as pool:
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
    if count < least:
        return [work(0, count)]
    middle = count // 2
    return list(both(lambda: work(0, middle), lambda: work(middle, count)))


def both(first: Callable[[], Item], second: Callable[[], Result]) -> tuple[Item, Result]:
    """Return the results of two functions without arguments, of which the first runs here."""
    with ThreadPoolExecutor(1) as pool:
        later = pool.submit(second)
        return first(), later.result()

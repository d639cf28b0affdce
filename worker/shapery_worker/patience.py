"""Trying again what a part of the platform could not do at the moment."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import TypeVar

from shapery_contracts.errors import ShaperyError, Unavailable

_FIRST_DELAY = 0.1
_LONGEST_DELAY = 5.0

T = TypeVar("T")

logger = logging.getLogger(__name__)


class Interrupted(Exception):
    """The work is not carried on, and is not to be tried again."""


def patiently(action: Callable[[], T], what: str, seconds: float, go_on: Callable[[], None] = lambda: None) -> T:
    """Do something with the database or the store, and do it again while they do not answer.

    The work of an hour is not thrown away for the restart of a server, nor are all attempts at a job spent within the
    second in which the store is away.

    Parameters
    ----------
    action
        What to do; it must be harmless to do it again.
    what
        What the log calls it.
    seconds
        For how long to try.
    go_on
        Called before each further try; what it raises ends them.

    Raises
    ------
    Exception
        What `action` raised last. An error that another try would not mend is raised at once: one of ours that does
        not say ``service_unavailable``, or `Interrupted`.
    """
    deadline = time.monotonic() + seconds
    delay = _FIRST_DELAY
    while True:
        try:
            return action()
        except Interrupted:
            raise
        except ShaperyError as error:
            if not isinstance(error, Unavailable) or time.monotonic() + delay > deadline:
                raise
            logger.warning("%s failed and is tried again: %s", what, error)
        except Exception as error:
            if time.monotonic() + delay > deadline:
                raise
            logger.warning("%s failed and is tried again: %s: %s", what, type(error).__name__, error)
        time.sleep(delay)
        delay = min(delay * 2, _LONGEST_DELAY)
        go_on()

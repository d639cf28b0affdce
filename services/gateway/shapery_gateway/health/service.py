"""Asks each part of the platform whether it answers."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Mapping
from typing import Literal

import anyio
from anyio.to_thread import run_sync
from pydantic import BaseModel

logger = logging.getLogger(__name__)

CHECK_SECONDS = 3.0
_KEEP_SECONDS = 1.0


class CheckView(BaseModel):
    """What one part answered."""

    status: Literal["ok", "down"]
    seconds: float
    detail: str = ""
    """The kind of failure; its text, which may hold addresses, goes to the log."""


class ReadyView(BaseModel):
    """Whether requests can be served."""

    status: Literal["ok", "down"]
    checks: dict[str, CheckView]


class Readiness:
    """Runs the checks side by side; what they said counts for a second, so that asking often costs nothing.

    Parameters
    ----------
    checks
        Functions that raise where their part does not answer.
    timeout
        Seconds after which a part that has said nothing is down.
    """

    def __init__(self, checks: Mapping[str, Callable[[], object]], timeout: float = CHECK_SECONDS) -> None:
        self._checks = checks
        self._timeout = timeout
        # Threads of its own: a check that hangs must take no thread from the requests.
        self._limiter = anyio.CapacityLimiter(2 * len(checks))
        self._view: ReadyView | None = None
        self._at = 0.0
        self._lock = asyncio.Lock()

    async def view(self) -> ReadyView:
        """Return how each part is."""
        async with self._lock:
            if self._view is None or time.monotonic() - self._at > _KEEP_SECONDS:
                names = list(self._checks)
                results = await asyncio.gather(*(self._check(name) for name in names))
                down = any(result.status == "down" for result in results)
                self._view = ReadyView(status="down" if down else "ok", checks=dict(zip(names, results, strict=True)))
                self._at = time.monotonic()
            return self._view

    async def _check(self, name: str) -> CheckView:
        began = time.monotonic()
        detail = ""
        try:
            async with asyncio.timeout(self._timeout):
                await run_sync(self._checks[name], limiter=self._limiter, abandon_on_cancel=True)
        except TimeoutError:
            detail = f"no answer within {self._timeout:g} s"
        except Exception as error:
            detail = type(error).__name__
            logger.warning("%s does not answer: %s", name, error)
        seconds = round(time.monotonic() - began, 4)
        return CheckView(status="down" if detail else "ok", seconds=seconds, detail=detail)

"""Watching a handler's process: its end, its limits, and the wish that it stop."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from shapery_worker.board import Board
from shapery_worker.handler_process import HandlerProcess
from shapery_worker.lifeline import resident_memory, resident_memory_of_descendants

_TICK = 0.1
_DESCENDANTS_EVERY = 1.0
"""Seconds between looks at the memory of processes that the handler started: each look reads all of the system's."""

logger = logging.getLogger(__name__)

StopReason = Literal["cancelled", "lost", "shutdown"]


@dataclass(frozen=True, slots=True)
class Limits:
    """What a job may use: seconds of wall time and bytes of resident memory."""

    seconds: float
    memory: int


@dataclass(frozen=True, slots=True)
class Ended:
    """How a handler's process ended: its exit code, or the limit that it broke as code, message and hint."""

    code: int | None
    limit: tuple[str, str, str] | None = None


class ProcessWatch:
    """Watches one process until its end.

    Parameters
    ----------
    process, board
        What is watched, and where it is asked to stop.
    limits
        What it may use; the time counts from now.
    cancel_grace
        Seconds that it has to stop by itself after a cancel.
    """

    def __init__(self, process: HandlerProcess, board: Board, limits: Limits, cancel_grace: float) -> None:
        self._process = process
        self._board = board
        self._limits = limits
        self._cancel_grace = cancel_grace
        self._began = time.monotonic()
        self._descendants = 0
        self._descendants_due = 0.0
        self.peak_memory = 0
        """The most resident bytes that were seen."""

    def until_end(self, why_stop: Callable[[], StopReason | None]) -> Ended:
        """Wait for the process to end, or end it.

        Parameters
        ----------
        why_stop
            Asked ten times a second whether the work is still wanted. After a cancel the handler is asked to stop and
            killed a grace later; for any other reason it is killed at once.
        """
        kill_at: float | None = None
        while True:
            code = self._process.wait(_TICK)
            if code is not None:
                return Ended(code)
            now = time.monotonic()
            broken = self._broken_limit(now)
            if broken is not None:
                self._process.kill()
                return Ended(None, broken)
            reason = why_stop()
            if reason is None:
                continue
            if kill_at is None:
                self._board.ask_to_stop()
                kill_at = now + (self._cancel_grace if reason == "cancelled" else 0.0)
            if now >= kill_at:
                if reason == "cancelled":
                    logger.info("process %d did not stop by itself and is killed", self._process.pid)
                self._process.kill()
                return Ended(None)

    def _broken_limit(self, now: float) -> tuple[str, str, str] | None:
        seconds = now - self._began
        if seconds > self._limits.seconds:
            return (
                "time_limit_exceeded",
                f"The job ran longer than the {self._limits.seconds:g} s that a job of its kind may take.",
                "Use a smaller input or coarser parameters, or ask the operator for a higher limit.",
            )
        if now >= self._descendants_due:
            self._descendants = resident_memory_of_descendants(self._process.pid)
            self._descendants_due = now + _DESCENDANTS_EVERY
        memory = resident_memory(self._process.pid) + self._descendants
        self.peak_memory = max(self.peak_memory, memory)
        if memory > self._limits.memory:
            used, allowed = memory / 2**20, self._limits.memory / 2**20
            return (
                "memory_limit_exceeded",
                f"The job used {used:,.0f} MiB of memory; a job of its kind may use {allowed:,.0f} MiB.",
                "Use a smaller input or coarser parameters, or ask the operator for a higher limit.",
            )
        return None

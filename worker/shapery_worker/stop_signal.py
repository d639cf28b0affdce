"""The wish of whoever started a process that it stop, and a sleep that this wish ends at once."""

from __future__ import annotations

import contextlib
import os
import select
import signal
from types import FrameType, TracebackType
from typing import Any, Self

_SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


class StopSignal:
    """Counts the signals that ask this process to stop, while the ``with`` block lasts.

    A pipe and not `threading.Event`: an event's lock is not safe in a signal handler that interrupts its holder.
    """

    def __init__(self) -> None:
        self.asked = 0
        """How often it was asked."""
        self._read, self._write = os.pipe()
        os.set_blocking(self._read, False)
        os.set_blocking(self._write, False)
        self._previous: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        for number in _SIGNALS:
            self._previous[number] = signal.signal(number, self._ask)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)
        os.close(self._read)
        os.close(self._write)

    def fileno(self) -> int:
        """Return the descriptor that becomes readable when the process is asked to stop."""
        return self._read

    def clear(self) -> None:
        """Make the descriptor unreadable again; the count stays."""
        with contextlib.suppress(BlockingIOError):
            os.read(self._read, 4096)

    def wait(self, seconds: float) -> bool:
        """Sleep, unless asked to stop before or meanwhile; tells whether it was."""
        if not self.asked and seconds > 0:
            select.select([self._read], [], [], seconds)
        return self.asked > 0

    def _ask(self, _number: int, _frame: FrameType | None) -> None:
        self.asked += 1
        with contextlib.suppress(BlockingIOError):
            os.write(self._write, b"!")

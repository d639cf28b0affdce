"""The surroundings that a running handler sees, inside its own process."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from shapery_contracts.errors import JobCancelled
from shapery_contracts.handler import MAX_PREVIEW
from shapery_contracts.retrieval import ShapeBank
from shapery_worker.board import Board, Progress

PREVIEW_EVERY = 0.5
"""Seconds between two previews at the least."""


class HandlerContext:
    """`shapery_contracts.handler.JobContext` over a shared page, two folders, and a file for the preview."""

    def __init__(self, board: Board, output: Path, scratch: Path, preview: Path, bank: ShapeBank | None = None) -> None:
        self._board = board
        self._output = output
        self._scratch = scratch
        self._preview = preview
        self._preview_due = 0.0
        self._bank = bank
        self._stage = ""

    @property
    def output(self) -> Path:
        """The folder whose files become artifacts."""
        return self._output

    @property
    def scratch(self) -> Path:
        """The folder for temporary files."""
        return self._scratch

    @property
    def bank(self) -> ShapeBank | None:
        """The shape database, for handlers that search it."""
        return self._bank

    def stage(self, name: str, fraction: float, message: str = "") -> None:
        """Say which stage begins, and which fraction of the whole work is done."""
        self._stage = name
        self.progress(fraction, message)

    def progress(self, fraction: float, message: str = "") -> None:
        """Say which fraction of the whole work is done."""
        self._board.write(Progress(self._stage, float(fraction), message))

    def preview(self, make: Callable[[], bytes]) -> None:
        """Show how the result looks so far."""
        if time.monotonic() < self._preview_due:
            return
        data = make()
        if len(data) <= MAX_PREVIEW:
            part = self._preview.with_suffix(".part")
            part.write_bytes(data)
            part.replace(self._preview)
        # Counted from its end: what takes long to make is made more seldom.
        self._preview_due = time.monotonic() + PREVIEW_EVERY

    def check_cancelled(self) -> None:
        """Raise `JobCancelled` if the job was cancelled."""
        if self._board.stop_asked:
            raise JobCancelled("the job was cancelled")

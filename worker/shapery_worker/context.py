"""The surroundings that a running handler sees, inside its own process."""

from __future__ import annotations

from pathlib import Path

from shapery_contracts.errors import JobCancelled
from shapery_contracts.retrieval import ShapeBank
from shapery_worker.board import Board, Progress


class HandlerContext:
    """`shapery_contracts.handler.JobContext` over a shared page and two folders."""

    def __init__(self, board: Board, output: Path, scratch: Path, bank: ShapeBank | None = None) -> None:
        self._board = board
        self._output = output
        self._scratch = scratch
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

    def check_cancelled(self) -> None:
        """Raise `JobCancelled` if the job was cancelled."""
        if self._board.stop_asked:
            raise JobCancelled("the job was cancelled")

"""``python -m shapery_worker.resident --service …``: a process that answers searches at once, without jobs.

It has the handlers loaded and the shapes of those who search in memory, and takes questions from
`shapery_platform.asking`. It reads files of nobody and writes no row: whatever needs an upload, or longer than its
asker waits, is a job. A question that it cannot end in time it gives up when the handler looks, and else with its life:
`shapery_worker.host` starts it again.
"""

from __future__ import annotations

import argparse
import faulthandler
import logging
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import redis
from sqlalchemy.exc import SQLAlchemyError

from shapery_contracts.errors import JobCancelled
from shapery_contracts.handler import AnyHandler
from shapery_contracts.kinds import get_kind
from shapery_contracts.retrieval import ShapeBank
from shapery_platform.asking import Answer, Answerer, Question
from shapery_platform.db import Database
from shapery_platform.settings import Settings, load_plugins, load_settings
from shapery_worker.bank import Banks
from shapery_worker.handler_process import run_handler
from shapery_worker.handlers import load_handlers
from shapery_worker.lifeline import resident_memory
from shapery_worker.logs import configure_logging
from shapery_worker.outcome import Failed, Succeeded
from shapery_worker.settings import WorkerSettings
from shapery_worker.stop_signal import StopSignal

_TICK = 1.0
_GRACE = 60.0
"""Seconds beyond its deadline after which a question ends the process: what was read meanwhile serves the next one."""
_PAUSE = 1.0

logger = logging.getLogger(__name__)


class QuestionContext:
    """`shapery_contracts.handler.JobContext` of a question: nobody sees its progress, and its files are thrown away."""

    def __init__(self, folder: Path, bank: ShapeBank, deadline: float) -> None:
        self.output = folder / "output"
        self.scratch = folder / "scratch"
        self.bank = bank
        self._deadline = deadline
        self.output.mkdir()
        self.scratch.mkdir()

    def stage(self, name: str, fraction: float, message: str = "") -> None:
        """Take no notice."""

    def progress(self, fraction: float, message: str = "") -> None:
        """Take no notice."""

    def preview(self, make: Callable[[], bytes]) -> None:
        """Take no notice."""

    def check_cancelled(self) -> None:
        """Raise `JobCancelled` when nobody waits any more."""
        if time.time() > self._deadline:
            raise JobCancelled("the deadline has passed")


class Resident:
    """Answers the questions of one service, one after the other.

    Parameters
    ----------
    settings
        Where database and Redis are.
    service
        Whose questions.
    handlers
        Its handlers by kind; those that search are asked.
    """

    def __init__(self, settings: Settings, service: str, handlers: dict[str, AnyHandler]) -> None:
        self._handlers = {name: handler for name, handler in handlers.items() if get_kind(name).searches}
        self._database = Database(settings.database_url, pool_size=1)
        self._banks = Banks(self._database)
        self._answerer = Answerer(settings, service)

    def run(self, stop: StopSignal) -> int:
        """Answer until it is told to stop."""
        troubled = False
        while not stop.asked:
            try:
                question = self._answerer.next(_TICK)
                if question is not None:
                    self._answerer.answer(question, self._answer(question))
                troubled = False
            except (redis.RedisError, SQLAlchemyError, ValueError) as error:
                if not troubled:
                    logger.warning("questions cannot be answered: %s", error)
                troubled = True
                stop.wait(_PAUSE)
            if self._is_bloated():
                logger.error("the process has grown beyond what a search may use, and is started again")
                break
        self._answerer.leave()
        self._database.dispose()
        return 0

    def _answer(self, question: Question) -> Answer:
        handler = self._handlers.get(question.kind)
        if handler is None:
            return Answer()
        left = question.deadline - time.time()
        faulthandler.dump_traceback_later(max(0.0, left) + _GRACE, exit=True)
        try:
            with tempfile.TemporaryDirectory(prefix="shapery-question-") as folder:
                context = QuestionContext(Path(folder), self._banks.of(question.owner), question.deadline)
                outcome = run_handler(get_kind(question.kind), handler, question.params, {}, context)
        finally:
            faulthandler.cancel_dump_traceback_later()
        match outcome:
            case Succeeded(result=result):
                return Answer(result=result)
            case Failed(code=code, message=message, hint=hint):
                return Answer(code=code, message=message, hint=hint)
            case _:
                return Answer()

    def _is_bloated(self) -> bool:
        limit = max((get_kind(name).memory_limit for name in self._handlers), default=0)
        return 0 < limit < resident_memory(os.getpid())


def main(arguments: list[str] | None = None) -> int:
    """Run until told to stop; returns the exit code."""
    parser = argparse.ArgumentParser(prog="shapery-resident", description=__doc__)
    parser.add_argument("--service", required=True)
    options = parser.parse_args(arguments)
    configure_logging(WorkerSettings().log_level)
    settings = load_settings()
    load_plugins(settings)
    handlers = load_handlers(options.service)
    with StopSignal() as stop:
        return Resident(settings, options.service, handlers).run(stop)


if __name__ == "__main__":
    sys.exit(main())

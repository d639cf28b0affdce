"""Handlers and folders for tests of single parts of the worker."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar

import pytest
from pydantic import BaseModel

from shapery_contracts.handler import JobContext
from shapery_contracts.kinds import JobKind
from shapery_worker.board import Board
from shapery_worker.handler_process import Folders, HandlerProcess


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    # Under xdist the test process has threads, of which Python 3.12 warns at every fork. Forking is what is tested.
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.filterwarnings("ignore:.*use of fork.*:DeprecationWarning"))


class Anything(BaseModel):
    """Parameters and result of the handlers made here."""

    value: Any = None
    number: float = 0.0


Action = Callable[[Anything, Mapping[str, Path], JobContext], Any]


class Handler:
    """A handler that does what it is given."""

    kind: ClassVar[str] = "anything"

    def __init__(self, action: Action) -> None:
        self._action = action

    def run(self, params: Anything, inputs: Mapping[str, Path], context: JobContext) -> Any:
        """Do it."""
        return self._action(params, inputs, context)


KIND = JobKind(name="anything", service="anything", summary="", inputs={}, params=Anything, result=Anything)


@pytest.fixture
def folders(tmp_path: Path) -> Folders:
    made = Folders(*(tmp_path / name for name in ("inputs", "output", "work", "outcome.json", "preview")))
    for path in (made.inputs, made.output, made.work):
        path.mkdir()
    return made


@pytest.fixture
def board() -> Board:
    return Board()


@pytest.fixture
def start(folders: Folders, board: Board) -> Iterator[Callable[..., HandlerProcess]]:
    """A function that forks a process which runs an action as a handler."""
    started: list[HandlerProcess] = []

    def begin(action: Action, value: Any = None, *, go: bool = True, **inputs: Path) -> HandlerProcess:
        process = HandlerProcess(KIND, Handler(action), {"value": value}, folders, board, label="job 1")
        started.append(process)
        if go:
            process.start(inputs)
        return process

    yield begin
    for process in started:
        process.kill()

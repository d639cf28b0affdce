"""The process in which a handler runs, and the watch over it."""

from __future__ import annotations

import ctypes
import logging
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from shapery_contracts.errors import InvalidInput, JobCancelled
from shapery_worker.board import Board, Progress
from shapery_worker.handler_process import Folders, HandlerProcess
from shapery_worker.lifeline import alive
from shapery_worker.outcome import Broken, Failed, Stopped, Succeeded, read_outcome
from shapery_worker.watch import Ended, Limits, ProcessWatch, StopReason
from tests.support.processes import wait_for

Start = Callable[..., HandlerProcess]
GENEROUS = Limits(seconds=60.0, memory=8 << 30)


def finish(process: HandlerProcess) -> int:
    code = process.wait(30.0)
    assert code is not None
    return code


def test_a_handler_gets_its_inputs_and_leaves_result_and_files(
    start: Start, folders: Folders, board: Board, tmp_path: Path
) -> None:
    def action(params: Any, inputs: Any, context: Any) -> Any:
        context.stage("copy", 0.5, "copying")
        (context.output / "copy").write_bytes(inputs["data"].read_bytes())
        return {"value": [params.value, os.getpid()]}

    source = tmp_path / "source"
    source.write_bytes(b"abc")
    process = start(action, "given", data=source)
    assert finish(process) == 0
    assert read_outcome(folders.outcome) == Succeeded(result={"value": ["given", process.pid], "number": 0.0})
    assert (folders.output / "copy").read_bytes() == b"abc"
    assert board.read() == Progress("copy", 0.5, "copying")
    assert process.usage.ru_maxrss > 0


def raising(error: BaseException) -> Callable[..., Any]:
    def action(*_: Any) -> Any:
        raise error

    return action


@pytest.mark.parametrize(
    ("action", "outcome"),
    [
        (raising(InvalidInput("invalid_mesh", "It has 3 holes.", "Fill them.")),
         Failed(code="invalid_mesh", message="It has 3 holes.", hint="Fill them.")),
        (raising(JobCancelled("cancelled")), Stopped()),
        (raising(MemoryError()), Broken(reason="The handler ran out of memory.")),
        (raising(ZeroDivisionError("a\nb")), Broken(reason="The handler raised ZeroDivisionError: a")),
        (raising(SystemExit(3)), Broken(reason="The handler raised SystemExit: 3")),
        (raising(KeyboardInterrupt()), Broken(reason="The handler raised KeyboardInterrupt: ")),
        (lambda *_: "not the result's type", Broken),
        (lambda *_: {"number": float("nan")}, Broken),
        (lambda *_: {"value": object()}, Broken),
    ],
)  # fmt: skip
def test_every_end_is_put_into_words(
    start: Start, folders: Folders, caplog: pytest.LogCaptureFixture, action: Any, outcome: Any
) -> None:
    caplog.set_level(logging.INFO)
    assert finish(start(action)) == 0
    written = read_outcome(folders.outcome)
    if isinstance(outcome, type):
        assert isinstance(written, outcome)
    else:
        assert written == outcome
    # tracebacks of what is ours are logged, the user's mistakes are not
    assert ("Traceback" in caplog.text) == isinstance(written, Broken)


def test_death_without_an_outcome_is_seen_by_its_code(start: Start, folders: Folders) -> None:
    assert finish(start(lambda *_: os.kill(os.getpid(), signal.SIGSEGV))) == -signal.SIGSEGV
    assert not folders.outcome.exists()


def test_a_process_that_is_not_wanted_ends_without_running(start: Start, folders: Folders) -> None:
    process = start(lambda *_: {"value": 1}, go=False)
    assert process.wait(0.05) is None
    process.kill()
    assert not alive(process.pid)
    assert not folders.outcome.exists()
    process.kill()  # again does nothing


def test_it_has_no_connections_of_its_parent(start: Start, folders: Folders) -> None:
    left, right = socket.socketpair()
    with left, right:

        def action(*_: Any) -> Any:
            kinds = {str(Path(f"/proc/self/fd/{end.fileno()}").readlink()) for end in (left, right)}
            left.close()  # as a finalizer would; the number must not have been given to another file
            return {"value": [sorted(kinds), os.getsid(0) == os.getpid(), sys.stdin.read()]}

        assert finish(start(action)) == 0
        left.send(b"still open on this side")
        assert right.recv(100) == b"still open on this side"
    assert read_outcome(folders.outcome) == Succeeded(result={"value": [[os.devnull], True, ""], "number": 0.0})


def test_its_output_is_logged_line_by_line(start: Start, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)

    def action(*_: Any) -> Any:
        print("from Python")
        logging.getLogger("some.library").warning("from a logger")
        os.write(2, b"from native code \xff\n" + b"y" * 10_000 + b"\nno end of line")
        return {}

    assert finish(start(action)) == 0
    lines = [record.getMessage() for record in caplog.records]
    assert "job 1 | from Python" in lines
    assert "job 1 | from native code \\xff" in lines
    assert "job 1 | from a logger" in lines
    assert "job 1 | no end of line" in lines
    assert max(map(len, lines)) < 5000


def test_endless_output_neither_blocks_nor_fills_the_memory(start: Start, board: Board) -> None:
    def action(_params: Any, _inputs: Any, context: Any) -> Any:
        while True:
            os.write(1, b"z" * 65_536)
            context.check_cancelled()

    process = start(action)
    assert process.wait(0.3) is None
    board.ask_to_stop()
    assert finish(process) == 0


def test_its_temporary_files_lie_in_its_folder(start: Start, folders: Folders) -> None:
    def action(*_: Any) -> Any:
        import tempfile

        return {"value": [tempfile.mkdtemp(), str(Path.cwd())]}

    assert finish(start(action)) == 0
    outcome = read_outcome(folders.outcome)
    assert isinstance(outcome, Succeeded)
    temporary, here = outcome.result["value"]
    assert here == str(folders.work)
    assert Path(temporary).parent == folders.work


def test_what_it_started_ends_with_it(start: Start, folders: Folders) -> None:
    def action(*_: Any) -> Any:
        return {"value": subprocess.Popen([sys.executable, "-c", "import time; time.sleep(100)"]).pid}

    assert finish(start(action)) == 0
    outcome = read_outcome(folders.outcome)
    assert isinstance(outcome, Succeeded)
    wait_for(lambda: not alive(outcome.result["value"]))


def test_it_dies_with_its_watcher(tmp_path: Path, folders: Folders, board: Board, start: Start) -> None:
    told = tmp_path / "pid"

    def action(*_: Any) -> Any:
        told.with_suffix(".part").write_text(str(os.getpid()))
        told.with_suffix(".part").rename(told)
        ctypes.PyDLL(None).sleep(100)

    watcher = os.fork()
    if watcher == 0:
        start(action).wait(100)
        os._exit(0)
    wait_for(told.exists)
    handler = int(told.read_text())
    assert alive(handler)
    os.kill(watcher, signal.SIGKILL)
    os.waitpid(watcher, 0)
    wait_for(lambda: not alive(handler))


def wanted() -> StopReason | None:
    return None


def test_the_watch_returns_the_end_and_the_memory(start: Start, board: Board) -> None:
    def action(*_: Any) -> Any:
        hoard = b"x" * (64 << 20)
        time.sleep(0.5)
        return {"value": len(hoard)}

    watch = ProcessWatch(start(action), board, GENEROUS, cancel_grace=1.0)
    assert watch.until_end(wanted) == Ended(0)
    assert watch.peak_memory > 64 << 20


def test_the_watch_ends_what_takes_too_long(start: Start, board: Board) -> None:
    process = start(lambda *_: ctypes.PyDLL(None).sleep(100))
    ended = ProcessWatch(process, board, Limits(0.3, 8 << 30), cancel_grace=1.0).until_end(wanted)
    assert ended.code is None
    assert ended.limit is not None
    assert ended.limit[0] == "time_limit_exceeded"
    assert "0.3 s" in ended.limit[1]
    assert not alive(process.pid)


def test_the_watch_counts_the_memory_of_all_that_was_started(start: Start, board: Board) -> None:
    def action(*_: Any) -> Any:
        program = "import time; hoard = b'x' * (200 << 20); time.sleep(100)"
        subprocess.run([sys.executable, "-c", program], check=True)

    process = start(action)
    limit = Limits(60.0, 250 << 20)
    ended = ProcessWatch(process, board, limit, cancel_grace=1.0).until_end(wanted)
    assert ended.limit is not None
    assert ended.limit[0] == "memory_limit_exceeded"
    assert "250 MiB" in ended.limit[1]


def test_a_handler_that_listens_stops_by_itself(start: Start, board: Board, folders: Folders) -> None:
    def action(_params: Any, _inputs: Any, context: Any) -> Any:
        while True:
            context.check_cancelled()
            time.sleep(0.01)

    watch = ProcessWatch(start(action), board, GENEROUS, cancel_grace=30.0)
    assert watch.until_end(lambda: "cancelled") == Ended(0)
    assert read_outcome(folders.outcome) == Stopped()


@pytest.mark.parametrize(("reason", "grace"), [("cancelled", 0.2), ("lost", 100.0), ("shutdown", 100.0)])
def test_one_that_does_not_is_killed(start: Start, board: Board, reason: StopReason, grace: float) -> None:
    process = start(lambda *_: ctypes.PyDLL(None).sleep(100))
    assert ProcessWatch(process, board, GENEROUS, grace).until_end(lambda: reason) == Ended(None)
    assert board.stop_asked
    assert not alive(process.pid)

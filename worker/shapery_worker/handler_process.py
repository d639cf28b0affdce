"""The process in which a handler runs, seen from its watcher, and what happens inside.

It is forked from a process that has loaded the handler already and runs no other thread at that moment, so it starts
in milliseconds and shares the memory of the imports. It leads a session of its own, so that it is killed together with
whatever it starts, and it dies with its watcher. It has no database, no queue and no storage: connections of the
parent are cut off in it, the inputs lie in a folder, and its outcome is a file. A search asks its watcher for shapes.
"""

from __future__ import annotations

import contextlib
import faulthandler
import json
import logging
import os
import selectors
import signal
import stat
import sys
import tempfile
import time
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from shapery_contracts.errors import JobCancelled, UserError
from shapery_contracts.handler import AnyHandler, JobContext
from shapery_contracts.kinds import JobKind
from shapery_worker.bank_line import BankClient
from shapery_worker.board import Board
from shapery_worker.context import HandlerContext
from shapery_worker.lifeline import kill_tree, tie_to_parent
from shapery_worker.outcome import Broken, Failed, Outcome, Stopped, Succeeded, write_outcome

_LINE_LIMIT = 4096
"""Bytes of one line of a handler's output that reach the log."""
_OOM_SCORE = 500
"""When memory runs out, the kernel shall take the handler and not its watcher, which can still tell the tale."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Folders:
    """Where a job's files lie on this machine; the last two need not exist."""

    inputs: Path
    output: Path
    work: Path
    outcome: Path
    preview: Path


class HandlerProcess:
    """A forked process that waits for its inputs, runs the handler once, and ends.

    Parameters
    ----------
    kind, handler, params
        What to run.
    folders
        Where its files lie; the three folders exist.
    board
        The page through which it tells its progress and learns of a cancel.
    label
        What its lines in the log begin with.
    niceness
        How far it steps back behind other processes.
    private
        Descriptors of the parent that it must not keep open.
    bank
        Its end of the line over which it reads the shape database (`shapery_worker.bank_line`), where it may.
    """

    def __init__(
        self,
        kind: JobKind,
        handler: AnyHandler,
        params: Mapping[str, Any],
        folders: Folders,
        board: Board,
        *,
        label: str,
        niceness: int = 0,
        private: tuple[int, ...] = (),
        bank: int | None = None,
    ) -> None:
        self._label = label
        self.usage: Any = None
        """Resources that the process used (``resource.struct_rusage``), once it has been reaped."""
        go_read, self._go = os.pipe()
        self._log, log_write = os.pipe()
        parent = os.getpid()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()  # or what is buffered would be written twice
        self.pid = os.fork()
        if self.pid == 0:
            for descriptor in private:
                os.close(descriptor)
            _live(parent, go_read, log_write, (kind, handler, params, folders, board, bank), niceness)
        os.close(go_read)
        os.close(log_write)
        os.set_blocking(self._log, False)
        self._rest = b""
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._log, selectors.EVENT_READ)
        self._pidfd: int | None = None
        if hasattr(os, "pidfd_open"):
            with contextlib.suppress(OSError):
                self._pidfd = os.pidfd_open(self.pid)
                self._selector.register(self._pidfd, selectors.EVENT_READ)

    def start(self, inputs: Mapping[str, Path]) -> None:
        """Hand over the staged inputs: the handler begins."""
        message = json.dumps({name: str(path) for name, path in inputs.items()}).encode()
        go, self._go = self._go, -1
        try:
            with os.fdopen(go, "wb") as pipe:
                pipe.write(message)
        except BrokenPipeError:
            logger.warning("%s: the process was gone before it began", self._label)

    def wait(self, timeout: float) -> int | None:
        """Pass on what the handler prints until it ends or `timeout` seconds are over.

        Returns
        -------
        The exit code, negative for a signal; None while the process lives. What it left running has been killed.
        """
        deadline = time.monotonic() + timeout
        while True:
            if self._ended():
                return self._reap()
            left = deadline - time.monotonic()
            if left <= 0:
                return None
            # Without a pidfd the end of the process is seen by looking.
            self._selector.select(left if self._pidfd is not None else min(left, 0.02))
            self._pass_on()

    def kill(self) -> None:
        """Kill the process with all that it started, and reap it."""
        if self.usage is None:
            kill_tree(self.pid)
            self._reap()

    def _ended(self) -> bool:
        return os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def _reap(self) -> int:
        # First its group: after the reaping its id might belong to somebody else.
        kill_tree(self.pid)
        _, status, self.usage = os.wait4(self.pid, 0)
        self._pass_on(last=True)
        self._selector.close()
        for descriptor in (self._log, self._go, self._pidfd):
            if descriptor is not None and descriptor >= 0:
                os.close(descriptor)
        return os.waitstatus_to_exitcode(status)

    def _pass_on(self, *, last: bool = False) -> None:
        data = self._rest
        for _ in range(16):  # a handler that prints without end must not keep its watcher here
            try:
                chunk = os.read(self._log, 65536)
            except BlockingIOError:
                break
            if not chunk:
                with contextlib.suppress(KeyError):
                    self._selector.unregister(self._log)
                break
            data += chunk
        *lines, self._rest = data.split(b"\n")
        if len(self._rest) > _LINE_LIMIT or (last and self._rest):
            lines.append(self._rest)
            self._rest = b""
        for line in lines:
            logger.info("%s | %s", self._label, line[:_LINE_LIMIT].decode(errors="backslashreplace").rstrip("\r"))


def _live(parent: int, go: int, log: int, task: tuple[Any, ...], niceness: int) -> NoReturn:
    """Be the handler's process: never returns, and runs nothing that the parent left to be run at exit."""
    code = 70  # EX_SOFTWARE
    try:
        kind, handler, params, folders, board, line = task
        _detach(parent, (go, log), niceness, keep=set() if line is None else {line})
        with os.fdopen(go, "rb") as pipe:
            message = pipe.read()
        if message:
            enter_work_folder(folders.work)
            inputs = {name: Path(path) for name, path in json.loads(message).items()}
            bank = None if line is None else BankClient(line)
            context = HandlerContext(board, folders.output, folders.work, folders.preview, bank)
            write_outcome(folders.outcome, run_handler(kind, handler, params, inputs, context))
            code = 0
        else:
            code = 75  # EX_TEMPFAIL: the watcher no longer wants it
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def run_handler(
    kind: JobKind,
    handler: AnyHandler,
    params: Mapping[str, Any],
    inputs: Mapping[str, Path],
    context: JobContext,
) -> Outcome:
    """Run the handler and put into words how it ended. Tracebacks of what is ours go to standard error."""
    try:
        result = handler.run(kind.params.model_validate(params), inputs, context)
        # Another type is seen here, and so is a number that is none, which would become null on its way.
        checked = kind.result.model_validate(result).model_dump(mode="json")
        json.dumps(checked, allow_nan=False)
        return Succeeded(result=checked)
    except JobCancelled:
        return Stopped()
    except UserError as error:
        return Failed(code=error.code, message=error.message, hint=error.hint)
    except MemoryError:
        traceback.print_exc()
        return Broken(reason="The handler ran out of memory.")
    except (Exception, SystemExit, KeyboardInterrupt) as error:
        traceback.print_exc()
        first_line = str(error).partition("\n")[0]
        return Broken(reason=f"The handler raised {type(error).__name__}: {first_line}"[:500])


def _detach(parent: int, pipes: tuple[int, int], niceness: int, *, keep: set[int]) -> None:
    """Leave behind what belongs to the parent: session, signals, connections, standard streams, locks of logging."""
    go, log = pipes
    for number in set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP}:
        with contextlib.suppress(OSError, ValueError):
            signal.signal(number, signal.SIG_DFL)
    signal.set_wakeup_fd(-1)
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    os.setsid()
    tie_to_parent(parent)
    cut_connections(keep={go, log, *keep})
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    os.close(null)
    os.dup2(log, 1)
    os.dup2(log, 2)
    os.close(log)
    sys.stdin = open(0, closefd=False)  # noqa: SIM115 (it lives as long as the process)
    sys.stdout = open(1, "w", buffering=1, closefd=False, errors="backslashreplace")  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, closefd=False, errors="backslashreplace")  # noqa: SIM115
    faulthandler.enable(file=2)
    root = logging.getLogger()
    for existing in list(logging.Logger.manager.loggerDict.values()):
        if isinstance(existing, logging.Logger):
            existing.handlers.clear()
            existing.propagate = True
    root.handlers[:] = [logging.StreamHandler(sys.stderr)]
    if niceness:
        os.nice(niceness)
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(str(_OOM_SCORE))


def cut_connections(keep: set[int]) -> None:
    """Put /dev/null in the place of every inherited socket and pipe but those in `keep` and the standard streams.

    Closing them instead would free their numbers, and an object of the parent that is collected here would later
    close a file of the handler which happened to get the same number.
    """
    folder = next(folder for folder in (Path("/proc/self/fd"), Path("/dev/fd")) if folder.is_dir())
    null = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
    try:
        for descriptor in [int(entry.name) for entry in folder.iterdir()]:
            if descriptor <= 2 or descriptor == null or descriptor in keep:
                continue
            try:
                mode = os.fstat(descriptor).st_mode
            except OSError:
                continue  # the listing's own descriptor
            if stat.S_ISSOCK(mode) or stat.S_ISFIFO(mode):
                os.dup2(null, descriptor, inheritable=False)
    finally:
        os.close(null)


def enter_work_folder(folder: Path) -> None:
    """Make `folder` the place for stray and temporary files of this process."""
    os.chdir(folder)
    os.environ["TMPDIR"] = str(folder)
    tempfile.tempdir = None

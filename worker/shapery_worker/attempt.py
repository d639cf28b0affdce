"""One attempt at one job, from the claim of its row to its end: the walk that every job takes through a worker.

The order matters. The row is claimed; the handler's process is forked while nothing else runs in this one and no
connection is open; the keeper begins to renew the lease; then come staging, the run itself, publishing, and one
transaction that ends the job if the lease still holds. A worker that dies in between leaves a locked folder that
becomes unlocked, a lease that runs out, and stored files that nothing refers to: all three are found and mended.
"""

from __future__ import annotations

import logging
import signal
import socket
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar
from uuid import UUID

from celery import Celery
from sqlalchemy.orm import Session

from shapery_contracts.errors import ShaperyError, Unavailable, UserError
from shapery_contracts.handler import AnyHandler
from shapery_contracts.kinds import get_kind
from shapery_contracts.states import JobState
from shapery_platform import dispatch, jobs, publication
from shapery_platform.db import Database
from shapery_platform.jobs import ClaimedJob
from shapery_platform.settings import Settings
from shapery_platform.storage.opening import open_store
from shapery_worker.bank_line import BankServer
from shapery_worker.board import Board
from shapery_worker.handler_process import HandlerProcess
from shapery_worker.keeper import LeaseKeeper
from shapery_worker.metrics import JobMetrics
from shapery_worker.outcome import Broken, Failed, Outcome, Stopped, Succeeded, read_outcome
from shapery_worker.patience import Interrupted, patiently
from shapery_worker.publishing import store_output
from shapery_worker.scratch import Ownership, ScratchFolder
from shapery_worker.settings import WorkerSettings, scratch_root
from shapery_worker.staging import stage_inputs
from shapery_worker.turns import Turns
from shapery_worker.watch import Limits, ProcessWatch, StopReason

if TYPE_CHECKING:
    from shapery_worker.bank import Banks

T = TypeVar("T")

logger = logging.getLogger(__name__)

# It runs, has ended, or was cancelled: a message is only a hint, and may come twice or late.
_NOTHING_TO_DO = "job %s: a message came, but the job does not wait"


class NotWanted(Interrupted):
    """The attempt is not carried on: it was cancelled, its lease was lost, or the worker goes."""

    def __init__(self, why: StopReason) -> None:
        super().__init__(why)
        self.why = why


@dataclass
class Runtime:
    """What a process of a worker has to run jobs with."""

    settings: Settings
    worker_settings: WorkerSettings
    service: str
    worker_id: str
    handlers: dict[str, AnyHandler]
    celery: Celery
    shutting_down: Callable[[], bool]
    alone_after_failure: bool
    """Whether others may run in this worker at the same time, so that a job that broke off before is kept apart."""

    def open(self) -> None:
        """Open database and store, in the process that uses them."""
        self.database = Database(self.settings.database_url, pool_size=2)
        self.store = open_store(self.settings, self.database)
        self.scratch = scratch_root(self.settings, self.service)
        self.turns = Turns(self.scratch.parent / f".turns-{self.service}")
        self.metrics = JobMetrics(self.service)

    @cached_property
    def banks(self) -> Banks:
        """The shape databases of the owners that this process searched for."""
        from shapery_worker.bank import Banks  # with numerics, which not every worker needs

        return Banks(self.database)

    def close(self) -> None:
        """Close what `open` opened."""
        self.database.engine.dispose()


def run_job(runtime: Runtime, job_id: UUID) -> JobState | None:
    """Carry out a job if it waits for that; returns the state it ends in, or None where it was not ours to end.

    Where others run beside it in this worker, it first waits for its turn, and claims the job only then: were it lost
    while it waits, it would count as one more attempt that broke off.
    """
    while runtime.alone_after_failure:
        with runtime.database.session(readonly=True) as session:
            tried = jobs.waiting_attempt(session, job_id)
        if tried is None:
            logger.info(_NOTHING_TO_DO, job_id)
            return None
        with runtime.turns.take(alone=tried > 0, give_up=runtime.shutting_down) as turn:
            if turn is None:
                return None
            job = _claim(runtime, job_id)
            if job is None:
                return None
            if tried > 0 or job.attempt == 1:
                return _carry_out(runtime, job, (turn,))
            # Another worker has tried it in vain meanwhile, and now it wants another turn.
            with runtime.database.session() as session:
                jobs.release(session, job.job_id, job.lease)
    job = _claim(runtime, job_id)
    return None if job is None else _carry_out(runtime, job, ())


def _claim(runtime: Runtime, job_id: UUID) -> ClaimedJob | None:
    with runtime.database.session() as session:
        job = jobs.claim(session, job_id, runtime.worker_id)
    if job is None:
        logger.info(_NOTHING_TO_DO, job_id)
    return job


def _carry_out(runtime: Runtime, job: ClaimedJob, private: tuple[int, ...]) -> JobState | None:
    began = time.monotonic()
    label = f"job {job.job_id}"
    logger.info("%s: %s, attempt %d of %d", label, job.kind, job.attempt, job.max_attempts)
    attempt = Attempt(runtime, job, private)
    try:
        state = attempt.run()
    except ShaperyError as error:
        state = attempt.give_back(str(error))
    except Exception:
        # Not the handler's: our own staging, publishing or folder. Whatever it was, the job must not be left behind.
        logger.exception("%s: the attempt broke", label)
        state = attempt.give_back("The worker could not carry out the attempt.")
    seconds = time.monotonic() - began
    end = state.value if state is not None else "lost"
    logger.info("%s: %s after %.2f s", label, end, seconds)
    runtime.metrics.attempt_ended(job.kind, end, seconds, attempt.peak_memory)
    return state


class Attempt:
    """A claimed job in the hands of this process; `private` descriptors are not for the handler's process."""

    def __init__(self, runtime: Runtime, job: ClaimedJob, private: tuple[int, ...] = ()) -> None:
        self._private = private
        self._runtime = runtime
        self._job = job
        self._kind = get_kind(job.kind)
        self.peak_memory = 0
        settings = runtime.settings
        self._limits = Limits(
            seconds=settings.job_time_limit.get(job.kind, self._kind.time_limit),
            memory=settings.job_memory_limit.get(job.kind, self._kind.memory_limit),
        )

    def run(self) -> JobState | None:
        """Stage, run, publish, and end the job."""
        job, runtime = self._job, self._runtime
        handler = runtime.handlers.get(job.kind)
        if handler is None:
            return self.give_back(f"This worker has no handler for {job.kind!r}.")
        # No connection may be open when the handler's process is forked, or both would speak through it.
        runtime.database.engine.dispose()
        ownership = Ownership(job_id=job.job_id, kind=job.kind, lease=job.lease)
        with ExitStack() as stack:
            board = Board()
            stack.callback(board.close)
            scratch = stack.enter_context(ScratchFolder(runtime.scratch, ownership))
            ours, theirs = socket.socketpair() if self._kind.searches else (None, None)
            process = HandlerProcess(
                self._kind,
                handler,
                job.params,
                scratch.folders,
                board,
                label=f"job {job.job_id}",
                niceness=runtime.worker_settings.niceness,
                private=(*self._private, scratch.descriptor, *([ours.fileno()] if ours else [])),
                bank=theirs.fileno() if theirs else None,
            )
            stack.callback(process.kill)
            if ours and theirs:
                theirs.close()
                stack.enter_context(BankServer(ours, runtime.banks.of(job.owner)))
            scratch.tell_handler(process.pid)
            keeper = stack.enter_context(
                LeaseKeeper(runtime.database, runtime.settings, job.job_id, job.lease, board, scratch.folders.preview)
            )
            try:
                return self._carry_out(scratch, process, board, keeper)
            except NotWanted as interrupted:
                process.kill()
                if interrupted.why == "lost":
                    logger.warning("job %s: the lease was lost; what was done is forgotten", job.job_id)
                    return None
                if interrupted.why == "cancelled":
                    return self._stop()
                logger.info("job %s: given back, because the worker stops", job.job_id)
                return self._release()

    def _carry_out(
        self, scratch: ScratchFolder, process: HandlerProcess, board: Board, keeper: LeaseKeeper
    ) -> JobState | None:
        job, runtime = self._job, self._runtime
        shutdown_deadline: float | None = None

        def why_stop() -> StopReason | None:
            nonlocal shutdown_deadline
            if keeper.lost:
                return "lost"
            if keeper.cancelled:
                return "cancelled"
            if runtime.shutting_down():
                now = time.monotonic()
                if shutdown_deadline is None:
                    shutdown_deadline = now + runtime.worker_settings.shutdown_grace
                if now >= shutdown_deadline:
                    return "shutdown"
            return None

        def go_on() -> None:
            why = why_stop()
            if why is not None:
                raise NotWanted(why)

        try:
            inputs = stage_inputs(
                runtime.store, job.inputs, scratch.folders.inputs, go_on, runtime.worker_settings.patience
            )
        except Unavailable:
            raise  # the store is ours to mend
        except UserError as error:
            return self._fail(error.code, error.message, error.hint)
        process.start(inputs)
        watch = ProcessWatch(process, board, self._limits, runtime.worker_settings.cancel_grace)
        ended = watch.until_end(why_stop)
        self.peak_memory = watch.peak_memory
        if ended.limit is not None:
            return self._fail(*ended.limit)
        go_on()
        outcome = self._read_outcome(scratch.folders.outcome, ended.code)
        return self._finish(outcome, scratch.folders.output, go_on)

    def _read_outcome(self, path: Path, code: int | None) -> Outcome:
        if code != 0:
            how = "without a word" if code is None else f"with exit code {code}"
            if code is not None and code < 0:
                how = f"by signal {signal.strsignal(-code) or -code}"
                if -code == signal.SIGKILL:
                    how += " (as when the machine runs out of memory)"
            return Broken(reason=f"Its process was ended {how}.")
        try:
            return read_outcome(path)
        except (OSError, ValueError) as error:
            logger.exception("job %s: the outcome cannot be read", self._job.job_id)
            return Broken(reason=f"Its outcome cannot be read ({type(error).__name__}).")

    def _finish(self, outcome: Outcome, output: Path, go_on: Callable[[], None]) -> JobState | None:
        match outcome:
            case Succeeded(result=result):
                job = self._job
                shape = publication.read_shape(job, result, output)
                try:
                    artifacts = store_output(self._runtime.store, output, go_on, self._runtime.worker_settings.patience)
                except Unavailable:
                    raise
                except UserError as error:  # the store is full
                    return self._fail(error.code, error.message, error.hint)
                end = self._end(lambda session: publication.succeed(session, job, result, artifacts, shape))
                return end or self._stop()
            case Failed(code=code, message=message, hint=hint):
                return self._fail(code, message, hint)
            case Stopped():
                return self._stop() or self.give_back("The handler stopped though nobody had asked it to.")
            case Broken(reason=reason):
                return self.give_back(reason)

    def _fail(self, code: str, message: str, hint: str) -> JobState | None:
        job = self._job
        done = self._end(lambda session: jobs.fail(session, job.job_id, job.lease, code, message, hint))
        return JobState.FAILED if done else self._stop()

    def _stop(self) -> JobState | None:
        job = self._job
        return JobState.CANCELLED if self._end(lambda session: jobs.stop(session, job.job_id, job.lease)) else None

    def _release(self) -> JobState | None:
        job = self._job
        return self._send_again(self._end(lambda session: jobs.release(session, job.job_id, job.lease)))

    def give_back(self, reason: str) -> JobState | None:
        """Give the job back after a fault of ours; it is tried again, or has crashed."""
        job = self._job
        state = self._end(lambda session: jobs.crash_or_requeue(session, job.job_id, job.lease, reason))
        logger.error("job %s: attempt %d broke off: %s", job.job_id, job.attempt, reason)
        return self._send_again(state)

    def _send_again(self, state: JobState | None) -> JobState | None:
        if state is JobState.QUEUED:
            dispatch.submit(self._runtime.database, self._runtime.celery, self._job.job_id, self._job.kind)
        return state

    def _end(self, change: Callable[[Session], T]) -> T:
        """Make the last change. When it was made though its answer was lost, another try finds another state."""

        def write() -> T:
            with self._runtime.database.session() as session:
                return change(session)

        return patiently(write, f"writing the end of job {self._job.job_id}", self._runtime.worker_settings.patience)

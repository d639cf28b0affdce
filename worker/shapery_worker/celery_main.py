"""The Celery worker of one service: ``python -m shapery_worker.celery_main``, started by `shapery_worker.host`.

It loads the handlers, and only then forks its children, so that they share the memory of what was imported. Celery
brings messages, which are hints that a row may be waiting; everything that counts is decided by the row
(`shapery_worker.attempt`).
"""

from __future__ import annotations

import argparse
import gc
import logging
import mmap
import os
import sys
import warnings
from typing import Any
from uuid import UUID

from celery import signals
from celery.exceptions import Reject, SecurityWarning

from shapery_platform.queue import TASK_NAME, make_celery
from shapery_platform.settings import load_plugins, load_settings
from shapery_worker import broker
from shapery_worker.attempt import Runtime, run_job
from shapery_worker.handlers import load_handlers
from shapery_worker.lifeline import tie_to_parent
from shapery_worker.logs import configure_logging
from shapery_worker.ready import tell_ready
from shapery_worker.settings import WorkerSettings

logger = logging.getLogger(__name__)


class ShutdownFlag:
    """One byte that the children share with the main process: it is asked to stop."""

    def __init__(self) -> None:
        self._page = mmap.mmap(-1, 1)

    def set(self) -> None:
        """Ask all processes of this worker to stop."""
        self._page[0] = 1

    def is_set(self) -> bool:
        """Whether they were asked."""
        return self._page[0] != 0


def main(arguments: list[str] | None = None) -> int:
    """Run the worker until it is told to stop; returns its exit code."""
    parser = argparse.ArgumentParser(prog="shapery-worker-main", description=__doc__)
    parser.add_argument("--service", required=True)
    parser.add_argument("--worker-id", required=True)
    parser.add_argument("--concurrency", type=int, required=True)
    parser.add_argument("--ready-fd", type=int, required=True, help="where to say that the worker listens")
    options = parser.parse_args(arguments)

    worker_settings = WorkerSettings()
    configure_logging(worker_settings.log_level)
    settings = load_settings()
    load_plugins(settings)
    celery = make_celery(settings)
    broker.prepare(celery)
    handlers = load_handlers(options.service)
    shutdown = ShutdownFlag()
    runtime = Runtime(
        settings=settings,
        worker_settings=worker_settings,
        service=options.service,
        worker_id=options.worker_id,
        handlers=handlers,
        celery=celery,
        shutting_down=shutdown.is_set,
        alone_after_failure=options.concurrency > 1,
    )

    @celery.task(name=TASK_NAME, ignore_result=True)
    def run(job_id: str) -> None:
        state = None if shutdown.is_set() else run_job(runtime, UUID(job_id))
        if state is None and shutdown.is_set():
            raise Reject("the worker stops, and the job may still wait", requeue=True)

    main_process = os.getpid()

    def enter_child(**_: Any) -> None:
        tie_to_parent(main_process)
        runtime.open()

    def ask_children_to_stop(**_: Any) -> None:
        shutdown.set()

    def announce(**_: Any) -> None:
        if options.ready_fd >= 0:  # Celery sends its signal again after each reconnection
            tell_ready(options.ready_fd, sorted(handlers))
            options.ready_fd = -1

    def keep_logging(**_: Any) -> None:
        """Receiving this signal keeps Celery from setting up logging of its own."""

    # Celery refers to receivers weakly, and these live as long as this call.
    signals.setup_logging.connect(keep_logging)
    signals.worker_process_init.connect(enter_child)
    signals.worker_shutting_down.connect(ask_children_to_stop)
    signals.worker_ready.connect(announce)

    # It warns of running as root because of pickled messages, of which this platform accepts none.
    warnings.simplefilter("ignore", SecurityWarning)
    celery.conf.update(worker_redirect_stdouts=False, worker_proc_alive_timeout=60.0)
    gc.collect()
    gc.freeze()  # collections in the children would otherwise write to, and so copy, all that they share
    worker = celery.Worker(
        hostname=options.worker_id,
        pool="prefork",
        concurrency=options.concurrency,
        queues=[options.service],
        loglevel=worker_settings.log_level.upper(),
        without_gossip=True,
        without_mingle=True,
        without_heartbeat=True,
        optimization="fair",
        quiet=True,
    )
    worker.start()
    return int(worker.exitcode or 0)


if __name__ == "__main__":
    sys.exit(main())

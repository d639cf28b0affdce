"""The command ``shapery-worker``: ``run``, ``reaper``, ``up`` and ``health``."""

from __future__ import annotations

import argparse
import logging
import os
import sys
from collections.abc import Sequence
from logging.handlers import RotatingFileHandler
from pathlib import Path
from typing import Any

from shapery_contracts.errors import InvalidInput, ShaperyError
from shapery_platform.settings import Settings, load_plugins, load_settings
from shapery_worker.logs import FORMAT, configure_logging
from shapery_worker.settings import WorkerSettings

EXIT_ERROR = 1
EXIT_UNHEALTHY = 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry of the command; returns its exit code."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.action(options))
    except ShaperyError as error:
        print(f"shapery-worker: {error}", file=sys.stderr)  # noqa: T201 (what the user is told)
        return EXIT_ERROR
    except KeyboardInterrupt:
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="shapery-worker",
        description="Runs the jobs of the Shapery platform. Settings come from SHAPERY_* and SHAPERY_WORKER_*.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    run = commands.add_parser("run", help="run the jobs of one service")
    service = os.environ.get("SHAPERY_SERVICE") or None
    run.add_argument("--service", default=service, required=service is None, help="default: SHAPERY_SERVICE")
    run.add_argument("--concurrency", type=int, help="jobs at once (default: SHAPERY_WORKER_CONCURRENCY, or 1)")
    run.set_defaults(action=_run)

    reaper = commands.add_parser("reaper", help="recover lost jobs and remove what has expired")
    reaper.set_defaults(action=_reaper)

    up = commands.add_parser("up", help="run the whole platform on this machine")
    up.add_argument("--home", type=Path, help="folder for everything the platform keeps (default: SHAPERY_HOME)")
    up.add_argument("--host", help="address to listen on")
    up.add_argument("--port", type=int, help="port to listen on; 0 takes a free one")
    up.add_argument("--service", action="append", help="start a worker for this service only; may be given repeatedly")
    up.add_argument("--once", action="store_true", help="stop as soon as everything is ready: a trial")
    up.set_defaults(action=_up)

    health = commands.add_parser("health", help="exit with 0 if the worker on this machine does its work")
    health.add_argument("--service", default=service, help="default: SHAPERY_SERVICE; none: only database and queue")
    health.add_argument("--reaper", action="store_true", help="ask for the reaper instead of a worker")
    health.set_defaults(action=_health)
    return parser


def _load(**overrides: Any) -> Settings:
    settings = load_settings(**{name: value for name, value in overrides.items() if value is not None})
    load_plugins(settings)
    return settings


def _run(options: argparse.Namespace) -> int:
    from shapery_worker.host import WorkerHost

    worker_settings = WorkerSettings()
    configure_logging(worker_settings.log_level)
    concurrency = options.concurrency or worker_settings.concurrency
    worker_settings = worker_settings.model_copy(update={"concurrency": concurrency})
    return WorkerHost(_load(), worker_settings, options.service).run()


def _reaper(_options: argparse.Namespace) -> int:
    from shapery_worker.reaper import Reaper
    from shapery_worker.stop_signal import StopSignal

    configure_logging(WorkerSettings().log_level)
    with StopSignal() as stop:
        Reaper(_load()).run(stop)
    return 0


def _up(options: argparse.Namespace) -> int:
    from shapery_worker.supervisor.supervisor import Supervisor, all_services

    settings = _load(home=options.home, host=options.host, port=options.port)
    unknown = sorted(set(options.service or ()) - set(all_services()))
    if unknown:
        raise InvalidInput(
            "bad_request", f"There is no service {unknown[0]!r}.", f"Services: {', '.join(all_services())}."
        )
    settings.home.mkdir(parents=True, exist_ok=True)
    logs = settings.home / "logs"
    logs.mkdir(exist_ok=True)
    # Warnings are for whoever looks at the terminal, everything is kept.
    configure_logging("INFO")
    root = logging.getLogger()
    root.handlers[0].setLevel(logging.WARNING)
    file = RotatingFileHandler(logs / "supervisor.log", maxBytes=1_000_000, backupCount=2, encoding="utf-8")
    file.setFormatter(logging.Formatter(FORMAT))
    root.addHandler(file)
    return Supervisor(settings, services=options.service, announce=_announce).run(once=options.once)


def _announce(line: str) -> None:
    print(line, flush=True)  # noqa: T201 (what the user is told)


def _health(options: argparse.Namespace) -> int:
    from shapery_worker.health import check_health

    faults = check_health(_load(), None if options.reaper else options.service, reaper=options.reaper)
    for fault in faults:
        print(fault, file=sys.stderr)  # noqa: T201 (what the user is told)
    return EXIT_UNHEALTHY if faults else 0

"""What can be set for workers and for the supervisor, beside the platform's own settings (``SHAPERY_WORKER_*``)."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from shapery_platform.settings import Settings

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "ITK_GLOBAL_DEFAULT_NUMBER_OF_THREADS",
)
"""Numeric libraries read them when they are loaded, so they are set before the process that loads them starts."""


class WorkerSettings(BaseSettings):
    """How one worker runs its jobs."""

    model_config = SettingsConfigDict(env_prefix="SHAPERY_WORKER_", extra="ignore", frozen=True)

    concurrency: Annotated[int, Field(ge=1, le=256)] = 1
    """Jobs that run at once. One is the safe choice where a job may use all the memory there is: processes of one
    container share its fate when the kernel runs out of memory."""
    threads: Annotated[int, Field(ge=1)] | None = None
    """Threads that the numeric libraries may use in one job; none: the processors divided by `concurrency`."""
    niceness: Annotated[int, Field(ge=0, le=19)] = 5
    """How far a handler steps back behind heartbeats and the gateway on a busy machine."""
    cancel_grace: Annotated[float, Field(ge=0)] = 1.0
    """Seconds that a handler has to stop by itself after a cancel, before it is killed."""
    shutdown_grace: Annotated[float, Field(ge=0)] = 10.0
    """Seconds that running jobs have to finish when the worker is told to stop; then they are given back to the
    queue, which does not count as a failed attempt."""
    patience: Annotated[float, Field(ge=0)] = 60.0
    """Seconds for which a running job waits for a database or a store that does not answer, with its result kept."""
    metrics_port: Annotated[int, Field(ge=0, le=65535)] | None = None
    """Port of the Prometheus metrics; none: no metrics are collected."""
    metrics_host: str = "127.0.0.1"
    log_level: str = "INFO"

    @model_validator(mode="before")
    @classmethod
    def _ignore_empty(cls, values: Any) -> Any:
        if isinstance(values, dict):
            return {key: value for key, value in values.items() if value != ""}
        return values

    def thread_environment(self) -> dict[str, str]:
        """Return the variables that bound the threads of numeric libraries; what the operator has set stays."""
        threads = self.threads or max(1, processor_count() // self.concurrency)
        variables = dict.fromkeys(THREAD_VARIABLES, str(threads))
        # The only threading layer of numba that survives a fork whatever was loaded before it.
        variables["NUMBA_THREADING_LAYER"] = "workqueue"
        return {name: os.environ.get(name, value) for name, value in variables.items()}


def processor_count() -> int:
    """Return how many processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on this system
        return os.cpu_count() or 1


def scratch_root(settings: Settings, service: str) -> Path:
    """Return the folder below which the workers of `service` on this machine keep their jobs' files."""
    if settings.scratch is not None:
        base = settings.scratch
    elif settings.profile == "embedded":
        base = settings.home / "scratch"
    else:
        base = Path(tempfile.gettempdir()) / f"shapery-{os.getuid()}"
    return base / "jobs" / service

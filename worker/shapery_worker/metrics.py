"""What a worker counts, for Prometheus: collected only where a port is set.

Jobs end in several processes, some of which are killed; each keeps its figures in files of its own below the worker's
folder (the multi-process mode of prometheus-client), and the host adds them up when asked.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shapery_worker.lifeline import alive
from shapery_worker.settings import WorkerSettings

if TYPE_CHECKING:
    from prometheus_client import Counter, Histogram

_FOLDER_VARIABLE = "PROMETHEUS_MULTIPROC_DIR"
_SECONDS = (0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000, 3000)
_BYTES = tuple(float(1 << power) for power in range(26, 37))


class JobMetrics:
    """Counters of one worker process; does nothing where metrics are off."""

    def __init__(self, service: str) -> None:
        self._service = service
        self._ended: Counter | None = None
        self._seconds: Histogram | None = None
        self._memory: Histogram | None = None
        if _FOLDER_VARIABLE not in os.environ:
            return
        from prometheus_client import Counter, Histogram

        labels = ["service", "kind"]
        self._ended = Counter("shapery_worker_attempts", "Attempts at jobs by their end.", [*labels, "end"])
        self._seconds = Histogram(
            "shapery_worker_attempt_seconds", "Wall time of attempts, with staging and publishing.", labels,
            buckets=_SECONDS,
        )  # fmt: skip
        self._memory = Histogram(
            "shapery_worker_peak_memory_bytes", "Largest resident memory of a handler.", labels, buckets=_BYTES
        )

    def attempt_ended(self, kind: str, end: str, seconds: float, peak_memory: int) -> None:
        """Count one attempt that ended as `end`."""
        if self._ended is None or self._seconds is None or self._memory is None:
            return
        self._ended.labels(self._service, kind, end).inc()
        self._seconds.labels(self._service, kind).observe(seconds)
        if peak_memory:
            self._memory.labels(self._service, kind).observe(peak_memory)


class MetricsServer:
    """Serves the figures of all processes of a worker while the ``with`` block lasts."""

    def __init__(self, settings: WorkerSettings, root: Path) -> None:
        self._settings = settings
        self._folder = root.parent / f".metrics-{root.name}-{os.getpid()}"
        self._server: Any = None
        self._thread: Any = None

    def __enter__(self) -> MetricsServer:
        if self._settings.metrics_port is None:
            return self
        self._remove_stale()
        self._folder.mkdir(parents=True)
        os.environ[_FOLDER_VARIABLE] = str(self._folder)
        from prometheus_client import CollectorRegistry, start_http_server
        from prometheus_client.multiprocess import MultiProcessCollector

        registry = CollectorRegistry()
        MultiProcessCollector(registry)  # type: ignore[no-untyped-call]
        self._server, self._thread = start_http_server(
            self._settings.metrics_port, self._settings.metrics_host, registry
        )
        return self

    def _remove_stale(self) -> None:
        for folder in self._folder.parent.glob(f"{self._folder.name.rpartition('-')[0]}-*"):
            if not alive(int(folder.name.rpartition("-")[2])) or folder == self._folder:
                shutil.rmtree(folder, ignore_errors=True)

    @property
    def port(self) -> int | None:
        """The port that is listened on."""
        return None if self._server is None else int(self._server.server_port)

    def __exit__(self, *_: object) -> None:
        if self._server is None:
            return
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
        shutil.rmtree(self._folder, ignore_errors=True)
        del os.environ[_FOLDER_VARIABLE]

"""Everything that lives as long as the app: database, store, queue, event feeds, counters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar, TypeVarTuple

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from prometheus_client import CollectorRegistry

from shapery_gateway.batches.events import BatchEventReader
from shapery_gateway.health.service import Readiness
from shapery_gateway.http.events import EventFeed
from shapery_gateway.jobs.events import read_job_events
from shapery_gateway.metrics import PlatformCollector, RequestMetrics
from shapery_gateway.outbox import Outbox
from shapery_gateway.rates import RateLimiter
from shapery_platform import keys, watching, workers
from shapery_platform.db import Database
from shapery_platform.jobs.recovery import QueuedJob
from shapery_platform.settings import Settings
from shapery_platform.storage.opening import open_store
from shapery_platform.storage.staging import UploadStaging

if TYPE_CHECKING:
    from shapery_platform.asking import Answer, Asker
    from shapery_platform.queue import Celery


STORAGE_THREADS = 16
ASKING_THREADS = 32
"""Searches that wait for an answer at the same time."""

T = TypeVar("T")
Ts = TypeVarTuple("Ts")


class Backend:
    """Opens what the settings name, and closes it.

    Make it inside a running event loop: the feeds belong to that loop.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.database = Database(settings.database_url)
        self.store = open_store(settings, self.database)
        self.staging = UploadStaging.over(self.store)
        # Apart from the threads of the routes: uploads that wait for a slow disk must not hold up everything else.
        self._storage_threads = CapacityLimiter(STORAGE_THREADS)
        self._asking_threads = CapacityLimiter(ASKING_THREADS)
        self.metrics = RequestMetrics(CollectorRegistry())
        self.metrics.registry.register(
            PlatformCollector(
                {
                    "shapery_jobs": ("Jobs by state.", "state", self._jobs_by_state),
                    "shapery_queue_length": ("Messages that wait in a queue.", "queue", self._queue_lengths),
                    "shapery_workers": ("Live workers by the kind they serve.", "kind", self._workers),
                }
            )
        )
        # One user alone would only be slowed down by a limit nobody asked for.
        limited = settings.auth == "keys" or "rate_limit_per_minute" in settings.model_fields_set
        self.limiter = RateLimiter(settings.rate_limit_per_minute if limited else 0)
        self.outbox = Outbox(self._send, self._dispatch, self.metrics.enqueue_failures.inc)
        self.job_events = EventFeed(lambda after: read_job_events(self.database, after), interval=settings.event_poll)
        self.batch_events = EventFeed(BatchEventReader(self.database), interval=max(settings.event_poll, 0.5))
        self.metrics.streams.set_function(lambda: self.job_events.streams + self.batch_events.streams)
        self.readiness = Readiness(
            {"database": self.database.ping, "queue": self._ping_queue, "storage": self.store.ping}
        )
        self.closing = False
        self._celery: Celery | None = None

    def admit_first_key(self) -> None:
        """Make the administrator's key of the settings known, if they have one."""
        if self.settings.bootstrap_admin_key is not None:
            with self.database.session() as session:
                keys.ensure_bootstrap(session, self.settings)

    async def run_storage(self, function: Callable[[*Ts], T], *args: *Ts) -> T:
        """Run what writes to storage in one of the threads set apart for it."""
        return await run_sync(function, *args, limiter=self._storage_threads)

    async def ask(self, service: str, kind: str, owner: str, params: dict[str, Any], seconds: float) -> Answer | None:
        """Ask a resident process; see `shapery_platform.asking`."""
        return await run_sync(
            lambda: self._asker.ask(service, kind, owner, params, seconds), limiter=self._asking_threads
        )

    @cached_property
    def _asker(self) -> Asker:
        from shapery_platform.asking import Asker

        return Asker(self.settings)

    async def end_streams(self) -> None:
        """End all event streams; their clients take them up again elsewhere."""
        self.closing = True
        await self.job_events.close()
        await self.batch_events.close()

    def close(self) -> None:
        """Send what waits to be sent, and close the database."""
        self.outbox.close()
        if "_asker" in self.__dict__:
            self._asker.close()
        self.database.dispose()

    # Celery takes a good part of a second to import: not before the first job, and never in a request.

    def _send(self, jobs: Sequence[QueuedJob]) -> None:
        from shapery_platform import dispatch

        dispatch.send(self.database, self._connect_queue(), jobs)

    def _dispatch(self) -> None:
        from shapery_platform import dispatch

        dispatch.dispatch_pending(self.database, self._connect_queue(), self.settings)

    def _connect_queue(self) -> Celery:
        from shapery_platform import queue

        if self._celery is None:
            self._celery = queue.make_celery(self.settings)
        return self._celery

    def _ping_queue(self) -> None:
        from shapery_platform import queue

        queue.ping(self.settings)

    def _queue_lengths(self) -> Mapping[str, float]:
        from shapery_platform import queue

        return queue.queue_lengths(self.settings)

    def _jobs_by_state(self) -> Mapping[str, float]:
        with self.database.session(readonly=True) as session:
            return {state.value: count for state, count in watching.jobs_by_state(session).items()}

    def _workers(self) -> Mapping[str, float]:
        with self.database.session(readonly=True) as session:
            return workers.live_by_kind(session, self.settings)

"""The only door to Celery, and to the Redis behind it.

A message holds the id of a job and nothing else; the row is the truth. Delivery is at least once: a message may come
twice or late, and the claim of the row decides who works.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from uuid import UUID

import redis
from celery import Celery as Celery
from kombu import Exchange, Queue
from kombu.exceptions import OperationalError

from shapery_contracts.errors import Unavailable
from shapery_contracts.kinds import JOB_KINDS, SERVICES, get_kind
from shapery_platform.settings import Settings

_log = logging.getLogger(__name__)

TASK_NAME = "shapery.run"
_VISIBILITY_MARGIN = 600.0
_PRIORITY_SEPARATOR = "\x06\x16"
_PRIORITY_STEPS = (0, 3, 6, 9)
"""kombu keeps one list per step: the queue's name alone for 0, with separator and step for the others."""


def service_names() -> tuple[str, ...]:
    """Return the services that have a queue: ours, and those of kinds that plugins registered."""
    return tuple(dict.fromkeys([*SERVICES, *(kind.service for kind in JOB_KINDS.values())]))


def broker_url(settings: Settings) -> str:
    """Return the address in the form that kombu takes: a Unix socket is ``redis+socket://`` there."""
    if settings.redis_socket is not None:
        return f"redis+socket://{settings.redis_socket}"
    return settings.redis_url


def visibility_timeout(settings: Settings) -> int:
    """Return the seconds after which Redis delivers an unacknowledged message again.

    Longer than any job: what is delivered earlier would only be dropped by the claim. Lost workers are noticed by
    their heartbeat long before.
    """
    limits = [settings.job_time_limit.get(kind.name, kind.time_limit) for kind in JOB_KINDS.values()]
    return int(max(limits, default=3600.0) + _VISIBILITY_MARGIN)


def make_celery(settings: Settings) -> Celery:
    """Return the Celery application that gateway, reaper and workers share."""
    app = Celery("shapery", broker=broker_url(settings), set_as_current=False)
    services = service_names()
    app.conf.update(
        # JSON only: a message can never run code
        task_serializer="json",
        accept_content=["json"],
        result_serializer="json",
        # the database holds results
        result_backend=None,
        task_ignore_result=True,
        task_queues=[Queue(name, Exchange(name, type="direct"), routing_key=name) for name in services],
        task_default_queue=services[0],
        task_create_missing_queues=False,
        # a message goes when the work is done, and comes back when the process dies
        task_acks_late=True,
        task_reject_on_worker_lost=True,
        worker_prefetch_multiplier=1,
        worker_cancel_long_running_tasks_on_connection_loss=False,
        worker_hijack_root_logger=False,
        worker_enable_remote_control=False,
        worker_send_task_events=False,
        task_send_sent_event=False,
        event_queue_ttl=60,
        enable_utc=True,
        broker_connection_retry_on_startup=True,
        broker_connection_max_retries=None,
        broker_transport_options={
            "visibility_timeout": visibility_timeout(settings),
            # kombu's own sweep for lost deliveries would run every 100 s
            "unacked_restore_interval": 2,
            "unacked_restore_throttle": 1,
            "health_check_interval": 10,
            "socket_keepalive": settings.redis_socket is None,
            "socket_connect_timeout": 5,
            "socket_timeout": 30,
        },
        # sending fails within about a second: the row is queued, and the reaper sends it later
        task_publish_retry=True,
        task_publish_retry_policy={"max_retries": 2, "interval_start": 0.1, "interval_step": 0.2, "interval_max": 0.5},
    )
    return app


def enqueue(celery: Celery, job_id: UUID, kind: str) -> None:
    """Give the queue of `kind` the message that a job waits. Call it after the commit.

    Raises
    ------
    Unavailable
        ``service_unavailable`` where Redis does not answer. The job is not lost: the reaper sends its message later.
    """
    send(celery, [(job_id, get_kind(kind).service)])


def send(celery: Celery, jobs: Iterable[tuple[UUID, str]]) -> int:
    """Send the messages of jobs, each with its service, over one connection; return how many.

    Raises
    ------
    Unavailable
        ``service_unavailable``; some of the messages may have been sent.
    """
    sent = 0
    try:
        with celery.producer_pool.acquire(block=True, timeout=10) as producer:
            for job_id, service in jobs:
                celery.send_task(TASK_NAME, args=[str(job_id)], queue=service, producer=producer)
                sent += 1
    except (OperationalError, redis.RedisError, OSError) as error:
        raise _unavailable() from error
    return sent


def connect(settings: Settings) -> redis.Redis:
    """Return a client of the Redis behind the queue."""
    return redis.Redis.from_url(settings.redis_url, socket_connect_timeout=2, socket_timeout=5)


def queue_lengths(settings: Settings) -> dict[str, int]:
    """Return how many messages wait in each service's queue; those that a worker holds are not counted.

    Raises
    ------
    Unavailable
        ``service_unavailable`` where Redis does not answer.
    """
    services = service_names()
    try:
        with connect(settings) as client, client.pipeline(transaction=False) as pipe:
            for service in services:
                for step in _PRIORITY_STEPS:
                    pipe.llen(f"{service}{_PRIORITY_SEPARATOR}{step}" if step else service)
            lengths = pipe.execute()
    except redis.RedisError as error:
        raise _unavailable() from error
    steps = len(_PRIORITY_STEPS)
    return {service: sum(lengths[i * steps : (i + 1) * steps]) for i, service in enumerate(services)}


def ping(settings: Settings) -> None:
    """Ask Redis a question; raises if it does not answer."""
    with connect(settings) as client:
        client.ping()


def _unavailable() -> Unavailable:
    return Unavailable(
        "service_unavailable", "The job queue does not answer.", "What was queued is kept and starts when it does."
    )

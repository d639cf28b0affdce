"""What a worker needs of its broker beyond Celery: to be back within seconds of an outage, and never to go deaf."""

from __future__ import annotations

import logging
from typing import Any

from celery import Celery, bootsteps
from celery.worker import state
from kombu import Connection

_LOOK_EVERY = 1.0
_STUCK_AFTER = 3
"""Looks in a row that find a delivery which belongs to no task: between a task's end and its acknowledgement one is
normal."""

logger = logging.getLogger(__name__)


class PatientConnection(Connection):
    """A connection that is tried again every second or two for as long as it takes; kombu would wait up to 30 s."""

    def ensure_connection(self, *args: Any, **kwargs: Any) -> Any:
        """Connect; see `kombu.Connection.ensure_connection`."""
        return super().ensure_connection(
            *args, **{"interval_start": 0.2, "interval_step": 0.2, "interval_max": 2.0, **kwargs}
        )


class DeliveryWatch(bootsteps.StartStopStep):
    """Makes a worker connect anew when deliveries are held that nobody works on.

    When Redis dies at the moment at which a finished task is acknowledged, Celery logs "Couldn't ack" and goes on, but
    kombu keeps counting the message as delivered. It fills the worker's window of prefetched messages, so nothing more
    is asked for, no request ever fails, and the worker stays connected and deaf. A new connection begins with an empty
    window; the message comes again and finds its job done.
    """

    requires = ("celery.worker.consumer.tasks:Tasks",)

    def __init__(self, consumer: Any, **_: Any) -> None:
        self._timer: Any = None
        self._seen = 0
        super().__init__(consumer)

    def start(self, consumer: Any) -> None:
        """Begin to look, whenever a connection was made."""
        self._seen = 0
        self._timer = consumer.timer.call_repeatedly(_LOOK_EVERY, self.look, (consumer,))

    def stop(self, consumer: Any) -> None:
        """Look no more."""
        self.terminate(consumer)

    def terminate(self, parent: Any) -> None:  # noqa: ARG002 (named by Celery)
        """Look no more."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def shutdown(self, consumer: Any) -> None:
        """Look no more."""
        self.terminate(consumer)

    def look(self, consumer: Any) -> None:
        """Compare the messages held with the tasks known.

        Raises
        ------
        ConnectionError
            Messages are held without a task for some seconds. The event loop takes it for the broker's.
        """
        channel = getattr(consumer.task_consumer, "channel", None)
        if channel is None:
            return
        held = len(channel.qos._delivered) - len(channel.qos._dirty)
        if held <= len(state.reserved_requests):
            self._seen = 0
            return
        self._seen += 1
        if self._seen >= _STUCK_AFTER:
            self._seen = 0
            raise ConnectionError(f"{held} deliveries are held, and {len(state.reserved_requests)} tasks are known")


def prepare(celery: Celery) -> None:
    """Give the worker of `celery` the patient connection and the watch."""
    celery.amqp.Connection = PatientConnection
    celery.steps["consumer"].add(DeliveryWatch)

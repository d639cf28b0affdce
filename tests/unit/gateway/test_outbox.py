from __future__ import annotations

import threading
from collections.abc import Sequence
from uuid import uuid4

import pytest

from shapery_gateway import outbox
from shapery_gateway.outbox import MANY, Outbox
from shapery_platform.jobs.recovery import QueuedJob


class Broker:
    def __init__(self) -> None:
        self.sent: list[QueuedJob] = []
        self.dispatched = 0
        self.dropped = 0
        self.down = False
        self.gate = threading.Event()
        self.gate.set()

    def send(self, jobs: Sequence[QueuedJob]) -> None:
        self.gate.wait(5)
        if self.down:
            raise ConnectionError("no broker")
        self.sent.extend(jobs)

    def dispatch(self) -> None:
        self.gate.wait(5)
        if self.down:
            raise ConnectionError("no broker")
        self.dispatched += 1

    def drop(self, count: int) -> None:
        self.dropped += count


@pytest.fixture
def broker() -> Broker:
    return Broker()


def job() -> QueuedJob:
    return QueuedJob(uuid4(), "segmentation", "segmentation")


def test_messages_are_sent_in_order(broker: Broker) -> None:
    box = Outbox(broker.send, broker.dispatch, broker.drop)
    jobs = [job() for _ in range(10)]
    for entry in jobs:
        box.put([entry])
    assert box.flush()
    assert broker.sent == jobs
    box.close()


def test_many_are_left_to_the_dispatcher(broker: Broker) -> None:
    box = Outbox(broker.send, broker.dispatch, broker.drop)
    broker.gate.clear()
    box.put([job()])
    box.put([job() for _ in range(MANY + 1)])
    box.put(["dispatch"])
    broker.gate.set()
    assert box.flush()
    assert broker.dispatched >= 1
    assert len(broker.sent) <= 1 + MANY
    box.close()


def test_a_broker_that_is_down_loses_messages_and_nothing_else(
    broker: Broker, caplog: pytest.LogCaptureFixture
) -> None:
    box = Outbox(broker.send, broker.dispatch, broker.drop)
    broker.down = True
    for _ in range(3):
        box.put([job()])
        assert box.flush()
    assert broker.dropped == 3
    assert sum("stay queued" in record.message for record in caplog.records) == 1, "said once, not each time"
    broker.down = False
    box.put([job()])
    assert box.flush()
    assert len(broker.sent) == 1
    box.close()


def test_putting_never_waits_for_the_broker(broker: Broker, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outbox, "MAX_WAITING", 5)
    box = Outbox(broker.send, broker.dispatch, broker.drop)
    broker.gate.clear()
    box.put([job() for _ in range(50)])
    assert broker.dropped >= 40
    assert not box.flush(0.01)
    broker.gate.set()
    assert box.flush()
    box.close()


def test_closing_sends_what_waits(broker: Broker) -> None:
    before = set(threading.enumerate())  # gateways of other tests may be open in this process
    box = Outbox(broker.send, broker.dispatch, broker.drop)
    (thread,) = set(threading.enumerate()) - before
    box.put([job(), job()])
    box.close()
    assert len(broker.sent) == 2
    assert not thread.is_alive()

"""The feed of event streams, over a reader that is a list."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable, Mapping, Sequence
from contextlib import aclosing
from uuid import UUID, uuid4

import pytest

from shapery_gateway.http import events
from shapery_gateway.http.events import Event, EventFeed, encode_event

pytestmark = pytest.mark.timeout(20)


class Log:
    """What a database would be."""

    def __init__(self) -> None:
        self.events: dict[UUID, list[Event]] = {}
        self.reads: list[dict[UUID, int]] = []
        self.fails = 0

    def add(self, topic: UUID, seq: int, *, last: bool = False) -> None:
        self.events.setdefault(topic, []).append(Event(seq, last, encode_event(seq, "state", str(seq))))

    def read(self, after: Mapping[UUID, int]) -> Mapping[UUID, Sequence[Event]]:
        self.reads.append(dict(after))
        if self.fails:
            self.fails -= 1
            raise ConnectionError("the database restarts")
        return {t: new for t, seq in after.items() if (new := [e for e in self.events.get(t, ()) if e.seq > seq])}


def seqs(text: bytes) -> list[int]:
    return [int(line[4:]) for line in text.decode().splitlines() if line.startswith("id: ")]


async def collect(stream: AsyncGenerator[bytes, None], until: int | None = None) -> list[int]:
    found: list[int] = []
    async with aclosing(stream):
        async for data in stream:
            found += seqs(data)
            if until is not None and found and found[-1] >= until:
                break
    return found


def run(test: Callable[[EventFeed, Log], Awaitable[None]], heartbeat: float = 5.0) -> Log:
    log = Log()

    async def inner() -> None:
        feed = EventFeed(log.read, interval=0.005, heartbeat=heartbeat)
        try:
            await test(feed, log)
        finally:
            await feed.close()
        assert feed.streams == 0

    asyncio.run(inner())
    return log


def test_the_past_and_then_what_happens() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        topic = uuid4()
        log.add(topic, 1)
        task = asyncio.create_task(collect(feed.stream(topic, 0)))
        await asyncio.sleep(0.03)
        log.add(topic, 2)
        log.add(topic, 5, last=True)
        assert await task == [1, 2, 5]

    run(test)


def test_it_resumes_after_a_number() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        topic = uuid4()
        for seq in range(1, 6):
            log.add(topic, seq, last=seq == 5)
        assert await collect(feed.stream(topic, 3)) == [4, 5]

    run(test)


def test_an_end_that_was_followed_by_a_retry_is_none() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        topic = uuid4()
        log.add(topic, 1)
        log.add(topic, 2, last=True)
        log.add(topic, 3)
        task = asyncio.create_task(collect(feed.stream(topic, 0)))
        await asyncio.sleep(0.03)
        assert not task.done()
        log.add(topic, 4, last=True)
        assert await task == [1, 2, 3, 4]

    run(test)


def test_late_comers_miss_nothing_and_get_nothing_twice() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        topic = uuid4()
        tasks = []
        for seq in range(1, 40):
            log.add(topic, seq)
            tasks.append(asyncio.create_task(collect(feed.stream(topic, seq % 7))))
            await asyncio.sleep(0.002)
        log.add(topic, 40, last=True)
        for number, found in enumerate(await asyncio.gather(*tasks), start=1):
            assert found == list(range(number % 7 + 1, 41))

    run(test)


def test_many_streams_of_a_topic_cost_as_much_as_one() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        topic = uuid4()
        log.add(topic, 1)
        streams = [asyncio.create_task(collect(feed.stream(topic, 0))) for _ in range(200)]
        await asyncio.sleep(0.1)
        assert feed.streams == 200
        assert all(len(read) == 1 for read in log.reads)
        before, began = len(log.reads), asyncio.get_running_loop().time()
        await asyncio.sleep(0.1)
        rounds = (asyncio.get_running_loop().time() - began) / 0.005
        assert len(log.reads) - before <= rounds + 2, "one read per round, not one per stream"
        log.add(topic, 2, last=True)
        assert await asyncio.gather(*streams) == [[1, 2]] * 200

    run(test)


def test_topics_are_read_together() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        topics = [uuid4() for _ in range(20)]
        streams = [asyncio.create_task(collect(feed.stream(topic, 0))) for topic in topics]
        await asyncio.sleep(0.05)
        assert set(log.reads[-1]) == set(topics)
        for topic in topics:
            log.add(topic, 1, last=True)
        assert await asyncio.gather(*streams) == [[1]] * 20

    run(test)


def test_a_stream_that_falls_behind_reads_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events, "RECENT_EVENTS", 4)

    async def test(feed: EventFeed, log: Log) -> None:
        topic = uuid4()
        slow = feed.stream(topic, 0)
        log.add(topic, 1)
        await anext(slow)
        assert seqs(await anext(slow)) == [1]
        fast = asyncio.create_task(collect(feed.stream(topic, 1), until=30))
        for seq in range(2, 31):
            log.add(topic, seq, last=seq == 30)
            await asyncio.sleep(0.006)
        assert await fast == list(range(2, 31))
        assert await collect(slow) == list(range(2, 31))

    run(test)


def test_streams_outlive_a_database_that_restarts() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        topic = uuid4()
        task = asyncio.create_task(collect(feed.stream(topic, 0)))
        await asyncio.sleep(0.02)
        log.fails = 2
        log.add(topic, 1, last=True)
        assert await task == [1]
        assert log.fails == 0

    run(test)


def test_nobody_listens_and_nothing_is_read() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        topic = uuid4()
        log.add(topic, 1, last=True)
        assert await collect(feed.stream(topic, 0)) == [1]
        await asyncio.sleep(0.03)
        reads = len(log.reads)
        await asyncio.sleep(0.05)
        assert len(log.reads) == reads
        # and it begins again
        assert await collect(feed.stream(topic, 0)) == [1]

    run(test)


def test_silence_is_filled() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        stream = feed.stream(uuid4(), 0)
        assert await anext(stream) == b": open\n\n"
        assert await anext(stream) == b": alive\n\n"
        assert await anext(stream) == b": alive\n\n"
        await stream.aclose()

    run(test, heartbeat=0.02)


def test_closing_ends_the_streams() -> None:
    async def test(feed: EventFeed, log: Log) -> None:
        streams = [asyncio.create_task(collect(feed.stream(uuid4(), 0))) for _ in range(5)]
        await asyncio.sleep(0.02)
        await feed.close()
        assert await asyncio.gather(*streams) == [[]] * 5

    run(test)


def test_no_stream_lives_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events, "LONGEST_STREAM_SECONDS", 0.05)

    async def test(feed: EventFeed, log: Log) -> None:
        assert await collect(feed.stream(uuid4(), 0)) == []

    run(test, heartbeat=0.02)

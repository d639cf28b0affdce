"""Server-sent events: one reader per process that feeds any number of streams.

A stream waits on an `asyncio.Event`: it holds neither a thread nor a database connection. One task asks the database
at a bounded rate for what is new on all topics that somebody watches, each event is encoded once, and every stream of
a topic sends the same bytes. A stream that begins in the past reads the past by itself, once.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import AsyncGenerator, Callable, Mapping, Sequence
from contextlib import aclosing
from dataclasses import dataclass, field
from typing import cast
from uuid import UUID

import anyio
from anyio.to_thread import run_sync
from starlette.responses import StreamingResponse
from starlette.types import Send

from shapery_gateway.problems import ProblemError

logger = logging.getLogger(__name__)

HEARTBEAT_SECONDS = 15.0
RECENT_EVENTS = 128
"""Events that a topic keeps for streams that are slower than others; who falls further behind reads the database."""
LONGEST_STREAM_SECONDS = 3600.0
"""A stream ends after this time and its client takes it up again, so that a revoked key does not listen for ever."""
MAX_STREAMS = 5000
"""Streams that one process serves; an idle one costs some kilobytes and a file descriptor."""
_LONGEST_PAUSE = 5.0


@dataclass(frozen=True, slots=True)
class Event:
    """One event, ready to be sent."""

    seq: int
    last: bool
    """Whether nothing follows it, as far as is known now."""
    data: bytes


def encode_event(seq: int, kind: str, json: str) -> bytes:
    """Return an event in the format of ``text/event-stream``; `json` must have no line breaks."""
    return f"id: {seq}\nevent: {kind}\ndata: {json}\n\n".encode()


Read = Callable[[Mapping[UUID, int]], Mapping[UUID, Sequence[Event]]]
"""Reads, for each topic, the events after a sequence number, in one go for all."""


@dataclass(slots=True)
class _Topic:
    floor: int
    """`recent` holds everything after this number up to `cursor`."""
    cursor: int
    recent: deque[Event] = field(default_factory=deque)
    streams: int = 0
    changed: asyncio.Event = field(default_factory=asyncio.Event)

    def wake(self) -> None:
        self.changed.set()
        self.changed = asyncio.Event()

    def push(self, events: Sequence[Event]) -> None:
        new = [event for event in events if event.seq > self.cursor]
        if not new:
            return
        self.recent.extend(new)
        self.cursor = new[-1].seq
        while len(self.recent) > RECENT_EVENTS:
            self.floor = self.recent.popleft().seq
        self.wake()


class EventFeed:
    """Streams of events by topic.

    Parameters
    ----------
    read
        Reads events; called in a thread.
    interval
        Seconds between two reads while somebody listens.
    heartbeat
        Seconds of silence after which a stream sends a comment, which also finds out clients that left.
    """

    def __init__(self, read: Read, *, interval: float, heartbeat: float = HEARTBEAT_SECONDS) -> None:
        self._read = read
        self._interval = interval
        self._heartbeat = heartbeat
        self._topics: dict[UUID, _Topic] = {}
        self._poller: asyncio.Task[None] | None = None
        self._kick = asyncio.Event()
        self._limiter = anyio.CapacityLimiter(2)
        self._closing = False

    def open(self, topic_id: UUID, after: int) -> EventStreamResponse:
        """Answer with the events of a topic after number `after`.

        Raises
        ------
        ProblemError
            ``service_unavailable`` where this process has `MAX_STREAMS` open already.
        """
        if self.streams >= MAX_STREAMS:
            raise ProblemError(
                "service_unavailable",
                f"{MAX_STREAMS} event streams are open here, and no more are served.",
                "Ask again later, or ask for the state now and then.",
                headers={"Retry-After": "30"},
            )
        return EventStreamResponse(self.stream(topic_id, after))

    @property
    def streams(self) -> int:
        """How many streams are open."""
        return sum(topic.streams for topic in self._topics.values())

    async def stream(self, topic_id: UUID, after: int) -> AsyncGenerator[bytes, None]:
        """Yield what to send to one client, from the event after number `after` until the last one."""
        yield b": open\n\n"
        # In the block of the first event, since some clients take a block of its own for an event without data.
        prefix = b"retry: 2000\n"
        topic = self._topics.get(topic_id)
        if topic is None:
            topic = self._topics[topic_id] = _Topic(floor=after, cursor=after)
            self._kick.set()
        topic.streams += 1
        if self._poller is None or self._poller.done():
            self._poller = asyncio.create_task(self._poll(), name="event-feed")
        ends = asyncio.get_running_loop().time() + LONGEST_STREAM_SECONDS
        try:
            while not self._closing and asyncio.get_running_loop().time() < ends:
                changed = topic.changed
                events: Sequence[Event]
                if after < topic.floor:
                    found = await run_sync(self._read, {topic_id: after}, limiter=self._limiter)
                    events = found.get(topic_id, ())
                    after = max(after, topic.floor)
                else:
                    events = [event for event in topic.recent if event.seq > after]
                if events:
                    after = max(after, events[-1].seq)
                    yield prefix + b"".join(event.data for event in events)
                    prefix = b""
                    if events[-1].last:
                        return
                    continue
                try:
                    async with asyncio.timeout(self._heartbeat):
                        await changed.wait()
                except TimeoutError:
                    yield b": alive\n\n"
        finally:
            topic.streams -= 1
            if topic.streams == 0 and self._topics.get(topic_id) is topic:
                del self._topics[topic_id]

    async def close(self) -> None:
        """End all streams and stop reading."""
        self._closing = True
        for topic in self._topics.values():
            topic.wake()
        self._kick.set()
        if self._poller is not None:
            await self._poller

    async def _poll(self) -> None:
        pause = self._interval
        while self._topics and not self._closing:
            self._kick.clear()
            cursors = {topic_id: topic.cursor for topic_id, topic in self._topics.items()}
            try:
                found = await run_sync(self._read, cursors, limiter=self._limiter)
                pause = self._interval
            except Exception:
                # Streams stay open with their heartbeat: a database that restarts is no reason to drop them.
                pause = min(pause * 2, _LONGEST_PAUSE)
                logger.warning("reading events failed; next try in %.1f s", pause, exc_info=True)
                found = {}
            for topic_id, events in found.items():
                topic = self._topics.get(topic_id)
                # A topic that was dropped and begun anew meanwhile may stand elsewhere; `push` sorts that out, but
                # must not skip what lies between.
                if topic is not None and topic.cursor >= cursors[topic_id]:
                    topic.push(events)
            try:
                async with asyncio.timeout(pause):
                    await self._kick.wait()
            except TimeoutError:
                continue


class EventStreamResponse(StreamingResponse):
    """An answer of ``text/event-stream`` whose source is closed as soon as the client is gone."""

    media_type = "text/event-stream"

    def __init__(self, content: AsyncGenerator[bytes, None]) -> None:
        super().__init__(content, headers={"Cache-Control": "no-store, no-transform", "X-Accel-Buffering": "no"})

    async def stream_response(self, send: Send) -> None:
        """Send the events; overridden so that the generator's `finally` runs now and not at garbage collection."""
        async with aclosing(cast("AsyncGenerator[bytes, None]", self.body_iterator)):
            await super().stream_response(send)

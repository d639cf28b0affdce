"""Batch events as they are sent to streams."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from uuid import UUID

from shapery_contracts.api import BatchEvent
from shapery_contracts.states import JobState
from shapery_gateway.http.events import Event, encode_event
from shapery_platform import watching
from shapery_platform.db import Database

_MAX_REMEMBERED = 1000


class BatchEventReader:
    """Reads how batches stand, and leaves out what changes nothing that an event tells."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._last: dict[UUID, tuple[int, dict[JobState, int]]] = {}

    def __call__(self, after: Mapping[UUID, int]) -> Mapping[UUID, Sequence[Event]]:
        """Read, for each batch, its standing, if its counts changed since an event's number."""
        with self._database.session(readonly=True) as session:
            standings = watching.batch_events(session, after.keys())
        found: dict[UUID, Sequence[Event]] = {}
        for batch_id, standing in standings.items():
            if standing.seq > after[batch_id] and self._last.get(batch_id) != (after[batch_id], standing.counts):
                found[batch_id] = [_encode(standing)]
                self._remember(standing)
        return found

    def _remember(self, event: BatchEvent) -> None:
        # Progress of a job raises the number and leaves the counts: such a change need not be told again.
        self._last.pop(event.batch_id, None)
        self._last[event.batch_id] = (event.seq, event.counts)
        if len(self._last) > _MAX_REMEMBERED:
            del self._last[next(iter(self._last))]


def _encode(event: BatchEvent) -> Event:
    return Event(event.seq, event.finished, encode_event(event.seq, "counts", event.model_dump_json()))

"""Job events as they are sent to streams."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from uuid import UUID

from shapery_contracts.api import JobEvent
from shapery_gateway.http.events import Event, encode_event
from shapery_platform import watching
from shapery_platform.db import Database


def read_job_events(database: Database, after: Mapping[UUID, int]) -> Mapping[UUID, Sequence[Event]]:
    """Read, for each job, what happened after an event's number."""
    with database.session(readonly=True) as session:
        found = watching.job_events(session, after)
    return {job_id: [_encode(event) for event in events] for job_id, events in found.items()}


def _encode(event: JobEvent) -> Event:
    ends = event.type == "state" and event.state.terminal
    return Event(event.seq, ends, encode_event(event.seq, event.type, event.model_dump_json()))

"""Batches: many jobs of one kind, asked for in one request."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from datetime import datetime, timedelta
from typing import Any
from uuid import UUID

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from shapery_contracts.api import BatchEvent, BatchHeader, BatchItem, BatchOrder, BatchResult, BatchView
from shapery_contracts.errors import InvalidInput, LimitExceeded
from shapery_contracts.kinds import get_kind
from shapery_contracts.states import JobAction, JobState, target_state
from shapery_platform.db import database_now, new_id, utc_now
from shapery_platform.db.models import Batch, Job
from shapery_platform.db.repositories import batches as repository
from shapery_platform.db.repositories import jobs as job_repository
from shapery_platform.jobs.creation import (
    check_assets,
    checked_idempotency_key,
    checked_names,
    conflict,
    fingerprint,
    input_rows,
    job_name,
    job_row,
    shapes_asked_by,
    validated_params,
)
from shapery_platform.jobs.lifecycle import retried
from shapery_platform.jobs.views import view as job_view
from shapery_platform.paging import NEWEST_FIRST, checked_limit, cut_page, parse_sort
from shapery_platform.settings import Settings

_AT_ONCE = 500
_RETRIED = (JobState.FAILED, JobState.CRASHED)


def create(
    session: Session,
    settings: Settings,
    owner: str,
    header: BatchHeader,
    items: Iterable[BatchItem],
    idempotency_key: str | None = None,
) -> tuple[Batch, bool]:
    """Create a batch and its jobs, or return the one created with the same key, and tell whether it is new.

    All items are valid, or none is created. `items` is read to its end before the database is asked anything, so it
    may come slowly.

    Raises
    ------
    UserError
        As `shapery_platform.jobs.create`, with the item's index; ``validation_failed`` without items; ``too_large``
        with more than `Settings.max_batch_items`.
    """
    key = checked_idempotency_key(idempotency_key)
    kind = get_kind(header.kind)
    now = utc_now()
    rows: list[dict[str, Any]] = []
    inputs: list[dict[str, list[UUID]]] = []
    for index, item in enumerate(items):
        if index == settings.max_batch_items:
            raise LimitExceeded(
                "too_large",
                f"The batch has more than {settings.max_batch_items:,} items.",
                "Send it as several batches.",
            )
        where = f"Item {index}: "
        params = validated_params(kind, {**header.params, **item.params}, where)
        listed = checked_names(kind, item.inputs, where)
        request = {
            "kind": kind.name,
            "inputs": {name: [str(asset_id) for asset_id in ids] for name, ids in listed.items()},
            "params": params,
        }
        row = job_row(settings, owner, kind, params, fingerprint(request), now)
        row["batch_index"] = index
        rows.append(row)
        inputs.append(listed)
    if not rows:
        raise InvalidInput("validation_failed", "The batch has no items.")
    print_ = fingerprint([header.model_dump(mode="json"), [row["fingerprint"] for row in rows]])
    if key is not None and (known := _known(session, owner, key, print_)) is not None:
        return known, False
    names = check_assets(session, owner, kind, inputs)
    shapes = shapes_asked_by(session, owner, (row["params"] for row in rows))
    batch_id = new_id()
    for row, listed in zip(rows, inputs, strict=True):
        row |= {"batch_id": batch_id, "name": job_name(listed, names, row["params"], shapes)}
    batch = {
        "id": batch_id,
        "owner": owner,
        "kind": kind.name,
        "params": header.params,
        "total": len(rows),
        "idempotency_key": key,
        "fingerprint": print_,
        "created_at": now,
    }
    try:
        with session.begin_nested():
            repository.add(session, batch)
    except IntegrityError:
        if key is not None and (known := _known(session, owner, key, print_)) is not None:
            return known, False
        raise
    for begin in range(0, len(rows), _AT_ONCE):
        some = slice(begin, begin + _AT_ONCE)
        job_repository.add_all(
            session,
            rows[some],
            [
                entry
                for row, listed in zip(rows[some], inputs[some], strict=True)
                for entry in input_rows(row["id"], listed)
            ],
        )
    return get(session, owner, batch_id), True


def _known(session: Session, owner: str, key: str, print_: str) -> Batch | None:
    batch = repository.find_by_idempotency_key(session, owner, key)
    if batch is not None and batch.fingerprint != print_:
        raise conflict(key)
    return batch


def get(session: Session, owner: str, batch_id: UUID) -> Batch:
    """Return a batch of this owner; raises ``not_found``."""
    batch = repository.find(session, owner, batch_id)
    if batch is None:
        raise InvalidInput("not_found", f"There is no batch {batch_id}.")
    return batch


def list_batches(
    session: Session, owner: str, cursor: str | None = None, limit: int = 50, order: BatchOrder = NEWEST_FIRST
) -> tuple[list[BatchView], str | None]:
    """Return a page of batches in an order, and the cursor of the next one."""
    limit = checked_limit(limit)
    sort = parse_sort(cursor, order)
    rows, following = cut_page(repository.page(session, owner, sort, limit + 1), limit, sort)
    return _views(session, rows), following


def view(session: Session, batch: Batch) -> BatchView:
    """Return the representation that the API shows."""
    return _views(session, [batch])[0]


def counts(session: Session, owner: str, batch_id: UUID) -> dict[JobState, int]:
    """Return how many jobs of a batch are in each state, also in those where none is."""
    return view(session, get(session, owner, batch_id)).counts


def event(session: Session, owner: str, batch_id: UUID) -> BatchEvent:
    """Return the event that describes a batch as it is now; its ``seq`` grows with every change."""
    batch = get(session, owner, batch_id)
    rows = repository.counts(session, [batch.id])
    shown = _view(batch, rows)
    return BatchEvent(
        seq=sum(int(row.events) for row in rows), batch_id=batch.id, counts=shown.counts, finished=shown.finished
    )


def results_page(
    session: Session, owner: str, batch_id: UUID, after_index: int = -1, limit: int = 200
) -> list[BatchResult]:
    """Return results with an index above `after_index`, in order; each page may have a session of its own."""
    batch = get(session, owner, batch_id)
    return [
        BatchResult(index=job.batch_index or 0, job=job_view(job))
        for job in repository.jobs_after(session, batch.id, after_index, checked_limit(limit))
    ]


def results(session: Session, owner: str, batch_id: UUID) -> Iterator[BatchResult]:
    """Yield all results in the order of their indices, with bounded memory."""
    after = -1
    while page := results_page(session, owner, batch_id, after):
        yield from page
        after = page[-1].index


def cancel(session: Session, owner: str, batch_id: UUID) -> Batch:
    """Cancel all jobs of a batch that have not ended; one that has ended entirely stays as it is."""
    batch = get(session, owner, batch_id)
    # locked first and in one order: workers that finish meanwhile come before or after, never between
    repository.lock_jobs(session, batch.id, (JobState.QUEUED, JobState.RUNNING))
    now = database_now(session)
    for state in (JobState.QUEUED, JobState.RUNNING):
        target = target_state(state, JobAction.CANCEL)
        values: dict[str, Any] = {"state": target}
        if target.terminal:
            values |= {
                "finished_at": now,
                "expires_at": now + timedelta(seconds=repository.result_ttl(session, batch.id)),
            }
        job_repository.update_states(session, [Job.batch_id == batch.id], state, values, now)
    return batch


def retry_failed(session: Session, owner: str, batch_id: UUID) -> int:
    """Queue the failed and crashed jobs of a batch again, and return how many.

    Jobs with an input that was deleted stay as they are.
    """
    batch = get(session, owner, batch_id)
    repository.lock_jobs(session, batch.id, _RETRIED)
    repository.lock_inputs(session, batch.id, _RETRIED)
    now = database_now(session)
    queued = 0
    for state in _RETRIED:
        values = {**retried(), "state": target_state(state, JobAction.RETRY)}
        condition = [Job.batch_id == batch.id, ~repository.has_deleted_input()]
        queued += len(job_repository.update_states(session, condition, state, values, now))
    return queued


def _views(session: Session, batches: list[Batch]) -> list[BatchView]:
    by_batch: dict[UUID, list[Any]] = {batch.id: [] for batch in batches}
    if batches:
        for row in repository.counts(session, list(by_batch)):
            by_batch[row.batch_id].append(row)
    return [_view(batch, by_batch[batch.id]) for batch in batches]


def _view(batch: Batch, rows: Iterable[Any]) -> BatchView:
    numbers = dict.fromkeys(JobState, 0)
    ends: list[datetime] = []
    for row in rows:
        numbers[row.state] = row.jobs
        if row.finished_at is not None:
            ends.append(row.finished_at)
    finished = all(number == 0 for state, number in numbers.items() if not state.terminal)
    return BatchView(
        id=batch.id,
        kind=batch.kind,
        params=batch.params,
        total=batch.total,
        counts=numbers,
        finished=finished,
        created_at=batch.created_at,
        finished_at=max(ends) if finished and ends else None,
    )

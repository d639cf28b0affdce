"""Batches on both databases."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from uuid import UUID, uuid4

import pytest
from sqlalchemy import event, func, select

from shapery_contracts.api import BatchHeader, BatchItem
from shapery_contracts.errors import UserError
from shapery_contracts.states import JobState
from shapery_platform import assets, batches, jobs
from shapery_platform.db import Database
from shapery_platform.db.models import Batch, Job, JobEvent
from shapery_platform.jobs import ClaimedJob
from shapery_platform.settings import Settings

HEADER = BatchHeader(kind="segmentation", params={"max_objects": 2})


@pytest.fixture
def new_batch(database: Database, settings: Settings, new_asset: Callable[..., UUID]) -> Callable[..., UUID]:
    def make(size: int, owner: str = "ann") -> UUID:
        asset_id = new_asset(owner)
        items = (BatchItem(inputs={"post": asset_id}, params={"random_seed": i}) for i in range(size))
        with database.session() as session:
            batch, created = batches.create(session, settings, owner, HEADER, items)
            assert created
            return batch.id

    return make


def job_ids(database: Database, batch_id: UUID) -> list[UUID]:
    with database.session(readonly=True) as session:
        return [result.job.id for result in batches.results(session, "ann", batch_id)]


def claim(database: Database, job_id: UUID) -> ClaimedJob:
    with database.session() as session:
        job = jobs.claim(session, job_id, "worker")
    assert job is not None
    return job


def counts(database: Database, batch_id: UUID) -> dict[str, int]:
    with database.session(readonly=True) as session:
        found = batches.counts(session, "ann", batch_id)
    assert set(found) == set(JobState)
    return {state.value: number for state, number in found.items() if number}


def finish(database: Database, ids: list[UUID]) -> None:
    """Let the first succeed, the second fail, the third crash."""
    for job_id, how in zip(ids, ("succeed", "fail", "crash"), strict=False):
        job = claim(database, job_id)
        with database.session() as session:
            if how == "succeed":
                assert jobs.succeed(session, job_id, job.lease, {"objects": []}, [])
            elif how == "fail":
                assert jobs.fail(session, job_id, job.lease, "no_object_found", "Nothing was found.")
            else:
                for _ in range(job.max_attempts - 1):
                    assert jobs.crash_or_requeue(session, job_id, job.lease, "oops") is JobState.QUEUED
                    following = jobs.claim(session, job_id, "worker")
                    assert following is not None
                    job = following
                assert jobs.crash_or_requeue(session, job_id, job.lease, "oops") is JobState.CRASHED


def test_items_become_jobs_in_their_order(database: Database, new_batch: Callable[..., UUID]) -> None:
    batch_id = new_batch(7)
    with database.session(readonly=True) as session:
        results = list(batches.results(session, "ann", batch_id))
        view = batches.view(session, batches.get(session, "ann", batch_id))
        page, _ = jobs.list_jobs(session, "ann", batch_id=batch_id)
    assert [result.index for result in results] == list(range(7))
    assert [result.job.params["random_seed"] for result in results] == list(range(7))
    assert {result.job.params["max_objects"] for result in results} == {2}, (
        "the batch's parameters lie under the item's"
    )
    assert {result.job.batch_id for result in results} == {batch_id}
    assert (view.total, view.finished, view.finished_at) == (7, False, None)
    assert view.counts == {**dict.fromkeys(JobState, 0), JobState.QUEUED: 7}
    assert len(page) == 7


@pytest.mark.slow
def test_ten_thousand_items(
    database: Database, settings: Settings, new_asset: Callable[..., UUID], new_batch: Callable[..., UUID]
) -> None:
    number_of_items = settings.max_batch_items
    assert number_of_items == 10_000
    statements: list[str] = []
    # what makes it quick is counted, because no time can be asserted
    event.listen(database.engine, "before_cursor_execute", lambda *args: statements.append(args[2]))
    batch_id = new_batch(number_of_items)
    assert len(statements) < 200
    statements.clear()
    assert counts(database, batch_id) == {"queued": number_of_items}
    assert len([text for text in statements if text.startswith("SELECT")]) == 2
    with database.session(readonly=True) as session:
        assert [result.index for result in batches.results(session, "ann", batch_id)] == list(range(number_of_items))
    statements.clear()
    with database.session() as session:
        batches.cancel(session, "ann", batch_id)
    assert len(statements) < 50
    assert counts(database, batch_id) == {"cancelled": number_of_items}
    with database.session(readonly=True) as session:
        assert session.scalar(select(func.count()).select_from(JobEvent)) == 2 * number_of_items


def test_one_wrong_item_and_nothing_is_created(
    database: Database, settings: Settings, new_asset: Callable[..., UUID]
) -> None:
    good, unknown = new_asset(), uuid4()
    cases: list[tuple[BatchItem, str, str]] = [
        (BatchItem(inputs={"post": good}, params={"max_objects": 0}), "invalid_params", "Item 2: params.max_objects"),
        (BatchItem(inputs={}), "missing_input", "Item 2: "),
        (BatchItem(inputs={"post": unknown}), "not_found", "Item 2: "),
        (BatchItem(inputs={"post": new_asset("bob")}), "not_found", "Item 2: "),
    ]
    for item, code, text in cases:
        items = [BatchItem(inputs={"post": good}), BatchItem(inputs={"post": good}), item]
        with pytest.raises(UserError, match=text) as error, database.session() as session:
            batches.create(session, settings, "ann", HEADER, items)
        assert error.value.code == code
    with database.session(readonly=True) as session:
        assert session.scalar(select(func.count()).select_from(Job)) == 0
        assert session.scalar(select(func.count()).select_from(Batch)) == 0


def test_sizes_that_are_refused(database: Database, settings: Settings, new_asset: Callable[..., UUID]) -> None:
    small = settings.model_copy(update={"max_batch_items": 3})
    asset_id = new_asset()
    taken = 0

    def endless() -> Iterator[BatchItem]:
        nonlocal taken
        while True:
            taken += 1
            yield BatchItem(inputs={"post": asset_id})

    with database.session() as session, pytest.raises(UserError, match="more than 3 items") as error:
        batches.create(session, small, "ann", HEADER, endless())
    assert error.value.code == "too_large"
    assert taken == 4
    with database.session() as session, pytest.raises(UserError) as error:
        batches.create(session, small, "ann", HEADER, [])
    assert error.value.code == "validation_failed"


def test_items_may_come_slowly_without_holding_up_others(
    database: Database, settings: Settings, new_asset: Callable[..., UUID]
) -> None:
    asset_id = new_asset()

    def slow() -> Iterator[BatchItem]:
        for _ in range(3):
            # somebody else writes while the items are on their way: the one writer of SQLite must be free
            new_asset()
            yield BatchItem(inputs={"post": asset_id})

    with database.session() as session:
        batch, _ = batches.create(session, settings, "ann", HEADER, slow())
    assert batch.total == 3


def test_an_idempotency_key_gives_the_same_batch(
    database: Database, settings: Settings, new_asset: Callable[..., UUID]
) -> None:
    items = [BatchItem(inputs={"post": new_asset()}, params={"random_seed": i}) for i in range(3)]
    with database.session() as session:
        first, created = batches.create(session, settings, "ann", HEADER, items, "key")
        assert created
    with database.session() as session:
        again, created = batches.create(session, settings, "ann", HEADER, items, "key")
        assert (again.id, created) == (first.id, False)
    with database.session() as session, pytest.raises(UserError) as error:
        batches.create(session, settings, "ann", HEADER, items[:2], "key")
    assert error.value.code == "idempotency_conflict"
    with database.session(readonly=True) as session:
        assert session.scalar(select(func.count()).select_from(Job)) == 3


def test_counts_events_and_the_end(database: Database, new_batch: Callable[..., UUID]) -> None:
    batch_id = new_batch(3)
    numbers = []

    def look() -> bool:
        with database.session(readonly=True) as session:
            shown = batches.event(session, "ann", batch_id)
        numbers.append(shown.seq)
        return shown.finished

    assert not look()
    finish(database, job_ids(database, batch_id)[:2])
    assert not look()
    assert counts(database, batch_id) == {"queued": 1, "succeeded": 1, "failed": 1}
    finish(database, job_ids(database, batch_id)[2:])
    assert look()
    assert numbers == sorted(set(numbers)), "the number grows with every change"
    with database.session(readonly=True) as session:
        view = batches.view(session, batches.get(session, "ann", batch_id))
        last = max(
            result.job.finished_at for result in batches.results(session, "ann", batch_id) if result.job.finished_at
        )
    assert view.finished_at == last


def test_cancel_reaches_what_waits_and_what_runs_and_nothing_else(
    database: Database, new_batch: Callable[..., UUID]
) -> None:
    batch_id, other = new_batch(5), new_batch(2)
    ids = job_ids(database, batch_id)
    finish(database, ids[:2])
    running = claim(database, ids[2])
    with database.session() as session:
        batches.cancel(session, "ann", batch_id)
    assert counts(database, batch_id) == {"succeeded": 1, "failed": 1, "cancelling": 1, "cancelled": 2}
    assert counts(database, other) == {"queued": 2}
    with database.session() as session:
        assert jobs.heartbeat(session, running.job_id, running.lease) is JobState.CANCELLING
        assert jobs.stop(session, running.job_id, running.lease)
        events = jobs.events_after(session, "ann", ids[4])
    assert [entry.state.value for entry in events] == ["queued", "cancelled"]
    with database.session() as session:
        batches.cancel(session, "ann", batch_id)
    assert counts(database, batch_id) == {"succeeded": 1, "failed": 1, "cancelled": 3}


def test_failed_items_are_retried_alone(database: Database, new_batch: Callable[..., UUID]) -> None:
    batch_id = new_batch(5)
    ids = job_ids(database, batch_id)
    finish(database, ids[:3])
    with database.session() as session:
        jobs.cancel(session, "ann", ids[3])
    with database.session() as session:
        assert batches.retry_failed(session, "ann", batch_id) == 2
    assert counts(database, batch_id) == {"succeeded": 1, "queued": 3, "cancelled": 1}
    with database.session(readonly=True) as session:
        again = [result.job for result in batches.results(session, "ann", batch_id)][1:3]
    assert [(job.error, job.attempt, job.finished_at) for job in again] == [(None, 0, None)] * 2
    with database.session() as session:
        assert batches.retry_failed(session, "ann", batch_id) == 0


def test_items_whose_input_was_deleted_are_not_retried(
    database: Database, settings: Settings, new_asset: Callable[..., UUID]
) -> None:
    kept, lost = new_asset(), new_asset(data=b"lost")
    items = [BatchItem(inputs={"post": asset_id}) for asset_id in (kept, lost)]
    with database.session() as session:
        batch_id = batches.create(session, settings, "ann", HEADER, items)[0].id
    for job_id in job_ids(database, batch_id):
        job = claim(database, job_id)
        with database.session() as session:
            assert jobs.fail(session, job_id, job.lease, "no_object_found", "Nothing was found.")
    with database.session() as session:
        assets.delete(session, "ann", lost)
    with database.session() as session:
        assert batches.retry_failed(session, "ann", batch_id) == 1
    assert counts(database, batch_id) == {"queued": 1, "failed": 1}


def test_results_come_in_pages_of_their_own(database: Database, new_batch: Callable[..., UUID]) -> None:
    batch_id = new_batch(5)
    seen: list[int] = []
    while True:
        with database.session(readonly=True) as session:
            page = batches.results_page(session, "ann", batch_id, seen[-1] if seen else -1, 2)
        if not page:
            break
        seen += [result.index for result in page]
    assert seen == [0, 1, 2, 3, 4]


def test_batches_are_listed_with_their_counts(database: Database, new_batch: Callable[..., UUID]) -> None:
    made = [new_batch(size) for size in (1, 2, 3)]
    new_batch(4, "bob")
    with database.session(readonly=True) as session:
        page, cursor = batches.list_batches(session, "ann", None, 2)
        rest, end = batches.list_batches(session, "ann", cursor, 2)
    assert [view.id for view in page + rest] == made[::-1]
    assert [view.counts[JobState.QUEUED] for view in page + rest] == [3, 2, 1]
    assert end is None

"""Creating and listing jobs on both databases."""

from __future__ import annotations

import json
import threading
from base64 import urlsafe_b64encode
from collections.abc import Callable
from typing import Any
from uuid import UUID, uuid4

import pytest
from sqlalchemy import func, select, update

from shapery_contracts.api import JobCreate, JobOrder, JobView
from shapery_contracts.errors import UserError
from shapery_contracts.formats import AssetKind, FileFormat
from shapery_contracts.states import JobState
from shapery_platform import assets, jobs
from shapery_platform.db import Database, new_id, utc_now
from shapery_platform.db.models import Job
from shapery_platform.jobs import ClaimedJob
from shapery_platform.settings import Settings

MESH = FileFormat(kind=AssetKind.MESH, format="ply", media_type="model/ply", extension=".ply")


# --- creation


def test_a_job_is_created_with_its_defaults(new_job: Callable[..., UUID], view: Callable[..., JobView]) -> None:
    job = view(new_job(max_objects=3))
    assert job.state is JobState.QUEUED
    assert job.params["max_objects"] == 3
    assert job.params["topology"] == "adaptive"
    assert list(job.inputs) == ["post"]
    assert (job.attempt, job.fraction, job.error, job.result, job.artifacts) == (0, 0.0, None, None, [])
    assert job.started_at is job.finished_at is job.expires_at is None


@pytest.mark.parametrize(
    ("change", "code", "text"),
    [
        ({"kind": "levitation"}, "unknown_job_kind", "levitation"),
        ({"params": {"max_objects": 0}}, "invalid_params", "params.max_objects"),
        ({"params": {"edge_length": float("nan")}}, "invalid_params", "finite"),
        ({"params": {"colour": "red"}}, "invalid_params", "params.colour"),
        ({"params": {"topology": "\ud800"}}, "invalid_params", "params.topology"),
        ({"inputs": {}}, "missing_input", "'post'"),
        ({"inputs": {"past": "ASSET"}}, "validation_failed", "no input 'past'"),
        ({"inputs": {"post": ["ASSET", "ASSET"]}}, "validation_failed", "twice"),
        ({"inputs": {"post": "MESH"}}, "wrong_input_kind", "is a mesh, and a volume is needed"),
        ({"inputs": {"post": "OTHERS"}}, "not_found", "no asset"),
        ({"inputs": {"post": "NOTHING"}}, "not_found", "no asset"),
        ({"inputs": {"post": "DELETED"}}, "not_found", "no asset"),
    ],
)
def test_requests_that_are_refused(
    database: Database,
    settings: Settings,
    new_asset: Callable[..., UUID],
    change: dict[str, Any],
    code: str,
    text: str,
) -> None:
    ids = {
        "ASSET": new_asset(),
        "MESH": new_asset(data=b"mesh", found=MESH),
        "OTHERS": new_asset("bob"),
        "NOTHING": uuid4(),
        "DELETED": new_asset(data=b"deleted"),
    }
    with database.session() as session:
        assets.delete(session, "ann", ids["DELETED"])

    def resolve(value: str | list[str]) -> UUID | list[UUID]:
        return [ids[name] for name in value] if isinstance(value, list) else ids[value]

    request = JobCreate(
        kind=change.get("kind", "segmentation"),
        inputs={name: resolve(value) for name, value in change.get("inputs", {"post": "ASSET"}).items()},
        params=change.get("params", {}),
    )
    with database.session() as session, pytest.raises(UserError, match=text) as error:
        jobs.create(session, settings, "ann", request)
    assert error.value.code == code
    with database.session(readonly=True) as session:
        assert session.scalar(select(func.count()).select_from(Job)) == 0


def test_an_idempotency_key_gives_the_same_job(
    database: Database, settings: Settings, new_asset: Callable[..., UUID]
) -> None:
    asset_id = new_asset()
    request = JobCreate(kind="segmentation", inputs={"post": asset_id})
    other = JobCreate(kind="segmentation", inputs={"post": asset_id}, params={"max_objects": 2})
    with database.session() as session:
        first, created = jobs.create(session, settings, "ann", request, "key")
        assert created
    with database.session() as session:
        assets.delete(session, "ann", asset_id)
    with database.session() as session:
        again, created = jobs.create(session, settings, "ann", request, "key")
        assert (again.id, created) == (first.id, False), "also after its input is gone"
        with pytest.raises(UserError) as error:
            jobs.create(session, settings, "ann", other, "key")
        assert error.value.code == "idempotency_conflict"


def test_an_idempotency_key_belongs_to_its_owner(
    database: Database, settings: Settings, new_asset: Callable[..., UUID]
) -> None:
    made = []
    for owner in ("ann", "bob"):
        request = JobCreate(kind="segmentation", inputs={"post": new_asset(owner)})
        with database.session() as session:
            job, created = jobs.create(session, settings, owner, request, "key")
            made.append(job.id)
            assert created
    assert made[0] != made[1]


@pytest.mark.parametrize("key", ["", "x" * 256, "a\0b", "a\nb"])
def test_keys_that_cannot_be_stored_are_refused(
    database: Database, settings: Settings, new_asset: Callable[..., UUID], key: str
) -> None:
    request = JobCreate(kind="segmentation", inputs={"post": new_asset()})
    with database.session() as session, pytest.raises(UserError) as error:
        jobs.create(session, settings, "ann", request, key)
    assert error.value.code == "validation_failed"


def test_the_same_request_at_the_same_time_makes_one_job(
    database: Database, settings: Settings, new_asset: Callable[..., UUID]
) -> None:
    request = JobCreate(kind="segmentation", inputs={"post": new_asset()})
    barrier = threading.Barrier(6)
    outcomes: list[tuple[UUID, bool]] = []
    faults: list[BaseException] = []

    def post() -> None:
        barrier.wait()
        try:
            with database.session() as session:
                job, created = jobs.create(session, settings, "ann", request, "key")
                outcomes.append((job.id, created))
        except BaseException as error:
            faults.append(error)

    threads = [threading.Thread(target=post) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert faults == []
    assert len({job_id for job_id, _ in outcomes}) == 1
    assert sum(created for _, created in outcomes) == 1


# --- lists


def test_pages_show_each_job_once_while_others_come(database: Database, new_job: Callable[..., UUID]) -> None:
    made = [new_job() for _ in range(7)]
    new_job("bob")
    seen: list[UUID] = []
    cursor = None
    for _ in range(4):
        with database.session(readonly=True) as session:
            page, cursor = jobs.list_jobs(session, "ann", cursor, 2)
        seen += [job.id for job in page]
        new_job()
    assert cursor is None
    assert seen == made[::-1]


@pytest.mark.parametrize("by", ["created", "name", "state", "took"])
def test_every_order_shows_each_job_once(
    database: Database, settings: Settings, new_asset: Callable[..., UUID], new_job: Callable[..., UUID], by: Any
) -> None:
    """Also where many are alike, upwards and downwards, and while others come."""
    states = [JobState.SUCCEEDED, JobState.FAILED]
    made = []
    for number in range(9):
        request = JobCreate(kind="segmentation", inputs={"post": new_asset(filename=f"{'bac'[number % 3]}.nii")})
        ended = {"state": states[number % 2], "took": 0.1 * (number % 4), "finished_at": utc_now()}
        with database.session() as session:
            made.append(jobs.create(session, settings, "ann", request)[0].id)
            session.execute(update(Job).where(Job.id == made[-1]).values(**ended))
    keys: dict[str, Callable[[int], Any]] = {
        "created": lambda number: number,
        "name": lambda number: ("bac"[number % 3], number),
        "state": lambda number: (states[number % 2], number),
        "took": lambda number: (number % 4, number),
    }
    expected = [made[number] for number in sorted(range(9), key=keys[by])]
    wanted: dict[JobOrder, list[UUID]] = {by: expected, f"-{by}": expected[::-1]}
    for order, ids in wanted.items():
        seen: list[UUID] = []
        cursor = None
        while True:
            with database.session(readonly=True) as session:
                page, cursor = jobs.list_jobs(session, "ann", cursor, 2, order=order)
            seen += [job.id for job in page]
            if cursor is None:
                break
            new_job("ann")
        assert [job for job in seen if job in set(made)] == ids
        assert len(set(seen)) == len(seen)


def test_a_cursor_belongs_to_an_order(database: Database, new_job: Callable[..., UUID]) -> None:
    for _ in range(3):
        new_job()
    with database.session(readonly=True) as session:
        _, cursor = jobs.list_jobs(session, "ann", None, 2, order="name")
        assert cursor is not None
        assert len(jobs.list_jobs(session, "ann", cursor, 2, order="name")[0]) == 1
        forged = [urlsafe_b64encode(json.dumps(place).encode()).decode() for place in (
            ["took", "long", str(new_id())], ["took", 1, str(new_id())], ["name", 1.5, str(new_id())],
            ["name", "\0", str(new_id())], ["name", "\ud800", str(new_id())], ["name", "a", "b"], "name", None,
        )]  # fmt: skip
        orders: list[JobOrder] = ["-name", "took", "state", "created"]
        for order in orders:
            for wrong in (cursor, *forged):
                with pytest.raises(UserError) as error:
                    jobs.list_jobs(session, "ann", wrong, 2, order=order)
                assert error.value.code == "validation_failed"


def test_how_long_a_job_took_is_known_once_it_has_ended(
    database: Database, new_job: Callable[..., UUID], claimed: Callable[..., ClaimedJob]
) -> None:
    running = claimed()

    def took() -> float:
        with database.session(readonly=True) as session:
            return jobs.get(session, "ann", running.job_id).took

    assert took() == -1
    with database.session() as session:
        assert jobs.fail(session, running.job_id, running.lease, "no_object_found", "None.", "")
    with database.session(readonly=True) as session:
        job = jobs.get(session, "ann", running.job_id)
        assert job.finished_at is not None
        assert job.started_at is not None
        assert job.took == (job.finished_at - job.started_at).total_seconds() >= 0
    with database.session() as session:
        jobs.retry(session, "ann", running.job_id)
    assert took() == -1


def test_lists_are_filtered(
    database: Database, new_job: Callable[..., UUID], claimed: Callable[..., ClaimedJob]
) -> None:
    waiting, running = new_job(), claimed().job_id
    with database.session(readonly=True) as session:

        def ids(**filters: Any) -> list[UUID]:
            return [job.id for job in jobs.list_jobs(session, "ann", **filters)[0]]

        assert ids(state=JobState.QUEUED) == [waiting]
        assert ids(state=JobState.RUNNING) == [running]
        assert ids(kind="segmentation") == [running, waiting]
        assert ids(kind="shape-index") == []
        assert ids(name="EAD") == [running, waiting]
        assert ids(name="e%d") == []
        assert ids(batch_id=uuid4()) == []
        with pytest.raises(UserError) as error:
            ids(cursor="the one before")
        assert error.value.code == "validation_failed"

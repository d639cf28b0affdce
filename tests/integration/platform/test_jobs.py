"""The life of a job on both databases."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Any
from uuid import UUID, uuid4

import pytest
from sqlalchemy import func, select, update

from shapery_contracts.api import JobCreate, JobEvent, JobView
from shapery_contracts.errors import UserError
from shapery_contracts.formats import AssetKind, FileFormat
from shapery_contracts.states import JobState
from shapery_platform import assets, jobs
from shapery_platform.db import Database
from shapery_platform.db.models import Job, JobArtifact
from shapery_platform.jobs import ClaimedJob, NewArtifact
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore

MESH = FileFormat(kind=AssetKind.MESH, format="ply", media_type="model/ply", extension=".ply")


@pytest.fixture
def view(database: Database) -> Callable[..., JobView]:
    def read(job_id: UUID, owner: str = "ann") -> JobView:
        with database.session(readonly=True) as session:
            return jobs.view(jobs.get(session, owner, job_id))

    return read


@pytest.fixture
def events(database: Database) -> Callable[..., list[JobEvent]]:
    def read(job_id: UUID, seq: int = 0, owner: str = "ann") -> list[JobEvent]:
        with database.session(readonly=True) as session:
            return jobs.events_after(session, owner, job_id, seq)

    return read


def states(listed: list[JobEvent]) -> list[str]:
    return [event.state.value for event in listed if event.type == "state"]


def fall_silent(database: Database, job: ClaimedJob, seconds: float = 60.0) -> None:
    with database.session() as session:
        past = datetime.now(UTC) - timedelta(seconds=seconds)
        session.execute(update(Job).where(Job.id == job.job_id).values(heartbeat_at=past))


# --- creation


def test_a_job_is_created_with_its_defaults(new_job: Callable[..., UUID], view: Callable[..., JobView]) -> None:
    job = view(new_job(max_objects=3))
    assert job.state is JobState.QUEUED
    assert job.params["max_objects"] == 3
    assert job.params["topology"] == "preserve"
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
        assert ids(batch_id=uuid4()) == []
        with pytest.raises(UserError) as error:
            ids(cursor="the one before")
        assert error.value.code == "validation_failed"


# --- the work


def test_a_job_from_claim_to_result(
    database: Database,
    local_store: ObjectStore,
    settings: Settings,
    claimed: Callable[..., ClaimedJob],
    view: Callable[..., JobView],
    events: Callable[..., list[JobEvent]],
) -> None:
    job = claimed()
    assert [entry.filename for entry in job.inputs["post"]] == ["head.nii"]
    assert local_store.exists(job.inputs["post"][0].key)
    for stage, fraction, message in (("read", 0.1, ""), ("evolve", 0.4, "10,000 faces"), ("evolve", 0.7, "done\0")):
        with database.session() as session:
            state = jobs.report_progress(session, job.job_id, job.lease, stage, fraction, message)
            assert state is JobState.RUNNING
    shown = view(job.job_id)
    assert (shown.state, shown.stage, shown.fraction, shown.message) == (JobState.RUNNING, "evolve", 0.7, "done")
    blob = local_store.put_bytes(b"labels")
    with database.session() as session:
        artifacts = [NewArtifact("surfaces/1.ply", blob.sha256, blob.size, "model/ply")]
        assert jobs.succeed(session, job.job_id, job.lease, {"objects": [1]}, artifacts)
    shown = view(job.job_id)
    assert (shown.state, shown.fraction, shown.result) == (JobState.SUCCEEDED, 1.0, {"objects": [1]})
    assert [(entry.name, entry.sha256, entry.size) for entry in shown.artifacts] == [
        ("surfaces/1.ply", blob.sha256, blob.size)
    ]
    assert shown.artifacts[0].url == f"/v1/jobs/{job.job_id}/artifacts/surfaces/1.ply"
    assert shown.finished_at is not None
    assert shown.expires_at == shown.finished_at + timedelta(seconds=settings.result_ttl)
    listed = events(job.job_id)
    assert [event.seq for event in listed] == sorted({event.seq for event in listed})
    assert states(listed) == ["queued", "running", "succeeded"]
    # progress that was overtaken within its stage is not kept, the path of stages is
    assert [(event.stage, event.fraction) for event in listed if event.type == "progress"] == [
        ("read", 0.1),
        ("evolve", 0.7),
    ]
    assert events(job.job_id, listed[-2].seq) == listed[-1:]
    assert events(job.job_id, listed[-1].seq) == []


def test_one_of_many_workers_gets_a_job(database: Database, new_job: Callable[..., UUID]) -> None:
    job_id = new_job()
    barrier = threading.Barrier(8)
    got: list[ClaimedJob | None] = []

    def work(number: int) -> None:
        barrier.wait()
        with database.session() as session:
            got.append(jobs.claim(session, job_id, f"worker-{number}"))

    threads = [threading.Thread(target=work, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(got) == 8
    assert sum(job is not None for job in got) == 1


def test_nothing_is_done_without_the_lease(
    database: Database, local_store: ObjectStore, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    job = claimed()
    blob = local_store.put_bytes(b"wrong")
    before = view(job.job_id)
    with database.session() as session:
        wrong = uuid4()
        assert jobs.heartbeat(session, job.job_id, wrong) is None
        assert jobs.report_progress(session, job.job_id, wrong, "evolve", 0.5) is None
        assert not jobs.succeed(session, job.job_id, wrong, {}, [NewArtifact("a", blob.sha256, blob.size)])
        assert not jobs.fail(session, job.job_id, wrong, "internal_error", "")
        assert not jobs.stop(session, job.job_id, wrong)
        assert jobs.crash_or_requeue(session, job.job_id, wrong, "") is None
        assert jobs.release(session, job.job_id, wrong) is None
    assert view(job.job_id) == before


def test_a_failure_tells_its_reason_and_can_be_retried(
    database: Database, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    job = claimed()
    with database.session() as session:
        assert jobs.fail(session, job.job_id, job.lease, "no_object_found", "Nothing found\0.", "Give a seed.")
    shown = view(job.job_id)
    assert shown.state is JobState.FAILED
    assert shown.error is not None
    assert (shown.error.code, shown.error.message, shown.error.hint) == (
        "no_object_found",
        "Nothing found.",
        "Give a seed.",
    )
    assert shown.expires_at is not None
    with database.session() as session:
        jobs.retry(session, "ann", job.job_id)
    shown = view(job.job_id)
    assert (shown.state, shown.error, shown.attempt) == (JobState.QUEUED, None, 0)
    assert shown.started_at is shown.finished_at is shown.expires_at is None
    with database.session() as session:
        again = jobs.claim(session, job.job_id, "worker-2")
        assert again is not None
        assert again.lease != job.lease
        assert jobs.heartbeat(session, job.job_id, job.lease) is None


@pytest.mark.parametrize("result", [{"x": float("inf")}, {"x": {1, 2}}])
def test_a_result_that_is_not_json_is_a_defect_and_changes_nothing(
    database: Database, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView], result: dict[str, Any]
) -> None:
    job = claimed()
    with pytest.raises((ValueError, TypeError)), database.session() as session:
        jobs.succeed(session, job.job_id, job.lease, result, [])
    assert view(job.job_id).state is JobState.RUNNING


@pytest.mark.parametrize("names", [[""], ["/etc/passwd"], ["../x"], ["a/../../x"], ["a" * 256], ["a", "a"], ["a\0"]])
def test_artifacts_need_names_of_their_own(
    database: Database, claimed: Callable[..., ClaimedJob], names: list[str]
) -> None:
    job = claimed()
    with pytest.raises(ValueError, match="artifact"), database.session() as session:
        jobs.succeed(session, job.job_id, job.lease, {}, [NewArtifact(name, "a" * 64, 1) for name in names])


def test_unregistered_error_codes_are_a_defect(database: Database, claimed: Callable[..., ClaimedJob]) -> None:
    job = claimed()
    with pytest.raises(ValueError, match="unregistered"), database.session() as session:
        jobs.fail(session, job.job_id, job.lease, "out_of_luck", "")


# --- cancel


def test_a_waiting_job_is_cancelled_at_once(
    database: Database, new_job: Callable[..., UUID], view: Callable[..., JobView]
) -> None:
    job_id = new_job()
    with database.session() as session:
        assert jobs.cancel(session, "ann", job_id).state is JobState.CANCELLED
    assert view(job_id).finished_at is not None
    with database.session() as session:
        assert jobs.claim(session, job_id, "worker") is None
        with pytest.raises(UserError) as error:
            jobs.cancel(session, "ann", job_id)
        assert error.value.code == "invalid_transition"


def test_a_running_job_is_cancelled_when_its_worker_has_stopped(
    database: Database,
    local_store: ObjectStore,
    claimed: Callable[..., ClaimedJob],
    view: Callable[..., JobView],
    events: Callable[..., list[JobEvent]],
) -> None:
    job = claimed()
    with database.session() as session:
        assert not jobs.stop(session, job.job_id, job.lease), "nobody has cancelled"
    with database.session() as session:
        assert jobs.cancel(session, "ann", job.job_id).state is JobState.CANCELLING
    with database.session() as session:
        assert jobs.cancel(session, "ann", job.job_id).state is JobState.CANCELLING, "twice is no error"
    blob = local_store.put_bytes(b"too late")
    with database.session() as session:
        assert jobs.heartbeat(session, job.job_id, job.lease) is JobState.CANCELLING
        assert not jobs.succeed(session, job.job_id, job.lease, {}, [NewArtifact("a", blob.sha256, blob.size)])
        assert not jobs.fail(session, job.job_id, job.lease, "internal_error", "")
        assert jobs.stop(session, job.job_id, job.lease)
    shown = view(job.job_id)
    assert (shown.state, shown.artifacts, shown.result) == (JobState.CANCELLED, [], None)
    assert states(events(job.job_id)) == ["queued", "running", "cancelling", "cancelled"]


@pytest.mark.parametrize("action", ["retry", "cancel"])
def test_what_the_table_does_not_allow(
    database: Database, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView], action: str
) -> None:
    job = claimed()
    if action == "cancel":
        with database.session() as session:
            assert jobs.succeed(session, job.job_id, job.lease, {}, [])
    before = view(job.job_id)
    with database.session() as session, pytest.raises(UserError) as error:
        getattr(jobs, action)(session, "ann", job.job_id)
    assert error.value.code == "invalid_transition"
    assert view(job.job_id) == before


# --- lost workers


def test_a_silent_worker_loses_its_job_to_another(
    database: Database,
    local_store: ObjectStore,
    settings: Settings,
    claimed: Callable[..., ClaimedJob],
    view: Callable[..., JobView],
) -> None:
    job, lively = claimed(), claimed()
    fall_silent(database, job)
    with database.session() as session:
        lost = jobs.recover_lost(session, settings)
    assert [entry.job_id for entry in lost] == [job.job_id]
    assert (lost[0].kind, lost[0].service) == ("segmentation", "segmentation")
    assert view(lively.job_id).state is JobState.RUNNING
    shown = view(job.job_id)
    assert (shown.state, shown.attempt) == (JobState.QUEUED, 1)
    assert "6 s" in shown.message
    with database.session() as session:
        second = jobs.claim(session, job.job_id, "worker-2")
    assert second is not None
    assert second.attempt == 2
    blobs_ = [local_store.put_bytes(data) for data in (b"of the first", b"of the second")]
    with database.session() as session:
        # the first comes back to life and thinks that it still has the job
        assert jobs.heartbeat(session, job.job_id, job.lease) is None
        assert not jobs.succeed(
            session, job.job_id, job.lease, {"by": 1}, [NewArtifact("a", blobs_[0].sha256, blobs_[0].size)]
        )
    with database.session() as session:
        assert jobs.succeed(
            session, job.job_id, second.lease, {"by": 2}, [NewArtifact("a", blobs_[1].sha256, blobs_[1].size)]
        )
    shown = view(job.job_id)
    assert shown.result == {"by": 2}
    assert [entry.sha256 for entry in shown.artifacts] == [blobs_[1].sha256]


def test_a_job_that_kills_its_workers_crashes_after_the_bounded_number(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    job: ClaimedJob | None = claimed()
    for attempt in range(1, settings.max_attempts + 1):
        assert job is not None
        assert job.attempt == attempt
        fall_silent(database, job)
        with database.session() as session:
            requeued = len(jobs.recover_lost(session, settings))
            assert requeued == (1 if attempt < settings.max_attempts else 0)
        with database.session() as session:
            job = jobs.claim(session, job.job_id, "worker")
    assert job is None
    with database.session(readonly=True) as session:
        page, _ = jobs.list_jobs(session, "ann")
    shown = view(page[0].id)
    assert shown.state is JobState.CRASHED
    assert shown.error is not None
    assert shown.error.code == "worker_lost"
    assert "3 times" in shown.error.message
    # the user may try again, with as many attempts as before
    with database.session() as session:
        jobs.retry(session, "ann", shown.id)
        again = jobs.claim(session, shown.id, "worker")
        assert again is not None
        assert again.attempt == 1


def test_a_fault_of_ours_is_tried_again_and_then_crashes(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    job = claimed()
    for attempt in range(1, settings.max_attempts + 1):
        with database.session() as session:
            state = jobs.crash_or_requeue(session, job.job_id, job.lease, "ZeroDivisionError")
            assert state is (JobState.QUEUED if attempt < settings.max_attempts else JobState.CRASHED)
            if state is JobState.QUEUED:
                following = jobs.claim(session, job.job_id, "worker")
                assert following is not None
                job = following
    shown = view(job.job_id)
    assert shown.error is not None
    assert shown.error.code == "internal_error"
    assert "ZeroDivisionError" in shown.error.message


def test_a_cancelled_job_whose_worker_is_lost_ends_as_cancelled(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView]
) -> None:
    silent, broken, asked_to_go = claimed(), claimed(), claimed()
    with database.session() as session:
        for job in (silent, broken, asked_to_go):
            jobs.cancel(session, "ann", job.job_id)
    fall_silent(database, silent)
    with database.session() as session:
        assert jobs.recover_lost(session, settings) == []
        assert jobs.crash_or_requeue(session, broken.job_id, broken.lease, "oops") is JobState.CANCELLED
        assert jobs.release(session, asked_to_go.job_id, asked_to_go.lease) is JobState.CANCELLED
    for job in (silent, broken, asked_to_go):
        assert view(job.job_id).state is JobState.CANCELLED


def test_a_worker_that_is_asked_to_go_does_not_use_up_an_attempt(
    database: Database, claimed: Callable[..., ClaimedJob]
) -> None:
    job = claimed()
    for _ in range(5):
        with database.session() as session:
            assert jobs.release(session, job.job_id, job.lease) is JobState.QUEUED
            following = jobs.claim(session, job.job_id, "worker")
            assert following is not None
            assert following.attempt == 1
            job = following


def test_reapers_at_the_same_time_give_each_job_back_once(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob]
) -> None:
    lost = [claimed() for _ in range(10)]
    for job in lost:
        fall_silent(database, job)
    barrier = threading.Barrier(4)
    found: list[UUID] = []

    def reap() -> None:
        barrier.wait()
        with database.session() as session:
            found.extend(entry.job_id for entry in jobs.recover_lost(session, settings))

    threads = [threading.Thread(target=reap) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(found) == sorted(job.job_id for job in lost)


def test_a_heartbeat_keeps_the_lease(
    database: Database, settings: Settings, claimed: Callable[..., ClaimedJob]
) -> None:
    beats = [
        lambda session, job: jobs.heartbeat(session, job.job_id, job.lease),
        lambda session, job: jobs.report_progress(session, job.job_id, job.lease, "evolve", 0.5),
    ]
    for beat in beats:
        job = claimed()
        fall_silent(database, job)
        with database.session() as session:
            assert beat(session, job) is JobState.RUNNING
        with database.session() as session:
            assert jobs.recover_lost(session, settings) == []


# --- artifacts


def test_artifacts_are_found_by_name(
    database: Database, local_store: ObjectStore, claimed: Callable[..., ClaimedJob]
) -> None:
    job = claimed()
    blob = local_store.put_bytes(b"labels")
    with database.session() as session:
        assert jobs.succeed(session, job.job_id, job.lease, {}, [NewArtifact("labels.nii.gz", blob.sha256, blob.size)])
    with database.session(readonly=True) as session:
        found = jobs.artifact(session, "ann", job.job_id, "labels.nii.gz")
        assert isinstance(found, JobArtifact)
        assert (found.sha256, found.size) == (blob.sha256, blob.size)
        with pytest.raises(UserError) as error:
            jobs.artifact(session, "ann", job.job_id, "other")
        assert error.value.code == "not_found"


@pytest.mark.parametrize("fraction", [float("nan"), -1.0, 2.0])
def test_fractions_stay_between_nothing_and_all(
    database: Database, claimed: Callable[..., ClaimedJob], view: Callable[..., JobView], fraction: float
) -> None:
    job = claimed()
    with database.session() as session:
        jobs.report_progress(session, job.job_id, job.lease, "x" * 100, fraction, "y" * 10_000)
    shown = view(job.job_id)
    assert 0.0 <= shown.fraction <= 1.0
    assert len(shown.stage) == 64
    assert len(shown.message) == 4000

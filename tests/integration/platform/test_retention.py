"""What goes by itself, and what stays, on both databases."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from uuid import UUID

import pytest

from shapery_contracts.errors import UserError
from shapery_contracts.states import JobState
from shapery_platform import jobs, retention, uploads
from shapery_platform.db import Database
from shapery_platform.jobs import ClaimedJob, NewArtifact
from shapery_platform.retention import Swept
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore, UploadStaging

NOTHING = Swept(results=0, uploads=0, staged=0, blobs=0, temporary=0, workers=0)


def finish(database: Database, store: ObjectStore, job: ClaimedJob, data: bytes) -> str:
    blob = store.put_bytes(data)
    with database.session() as session:
        assert jobs.succeed(session, job.job_id, job.lease, {}, [NewArtifact("x", blob.sha256, blob.size)])
    return blob.key


def test_results_go_after_their_time_and_jobs_stay(
    database: Database, local_store: ObjectStore, settings: Settings, claimed: Callable[..., ClaimedJob]
) -> None:
    job, running = claimed(), claimed()
    key = finish(database, local_store, job, b"a surface")
    with database.session(readonly=True) as session:
        expires_at = jobs.get(session, "ann", job.job_id).expires_at
    assert expires_at is not None
    assert retention.run_once(database, local_store, settings, now=expires_at - timedelta(seconds=1)).results == 0
    swept = retention.run_once(database, local_store, settings, now=expires_at)
    assert (swept.results, swept.blobs) == (1, 1)
    assert not local_store.exists(key)
    with database.session(readonly=True) as session:
        view = jobs.view(jobs.get(session, "ann", job.job_id))
        assert (view.state, view.expired, view.expires_at) == (JobState.SUCCEEDED, True, expires_at)
        assert jobs.get(session, "ann", running.job_id).state is JobState.RUNNING
        assert len(jobs.events_after(session, "ann", job.job_id)) == 3, "the path that it went is still known"
    assert retention.run_once(database, local_store, settings, now=expires_at) == NOTHING


def test_bytes_shared_with_another_result_stay(
    database: Database, local_store: ObjectStore, settings: Settings, claimed: Callable[..., ClaimedJob]
) -> None:
    first, second = claimed(), claimed()
    key = finish(database, local_store, first, b"the same surface")
    with database.session(readonly=True) as session:
        expires_at = jobs.get(session, "ann", first.job_id).expires_at
    assert expires_at is not None
    finish(database, local_store, second, b"the same surface")
    swept = retention.run_once(database, local_store, settings, now=expires_at)
    assert (swept.results, swept.blobs) == (1, 0)
    assert local_store.exists(key)
    later = retention.run_once(database, local_store, settings, now=expires_at + timedelta(hours=1))
    assert (later.results, later.blobs) == (1, 1)
    assert not local_store.exists(key)


def test_a_failed_job_that_expired_can_still_be_retried(
    database: Database, local_store: ObjectStore, settings: Settings, claimed: Callable[..., ClaimedJob]
) -> None:
    job = claimed()
    with database.session() as session:
        assert jobs.fail(session, job.job_id, job.lease, "no_object_found", "Nothing was found.")
    late = datetime.now(UTC) + timedelta(seconds=settings.result_ttl + 1)
    assert retention.run_once(database, local_store, settings, now=late).results == 1
    with database.session() as session:
        view = jobs.view(jobs.retry(session, "ann", job.job_id))
    assert (view.state, view.expired, view.expires_at) == (JobState.QUEUED, False, None)


def test_uploads_go_after_their_time(database: Database, local_store: ObjectStore, settings: Settings) -> None:
    staging = UploadStaging.over(local_store)
    with database.session() as session:
        upload = uploads.create(session, staging, settings, "ann", 10, {})
    uploads.append(database, staging, settings, "ann", upload.id, 0, [b"12345"])
    assert retention.run_once(database, local_store, settings) == NOTHING
    late = datetime.now(UTC) + timedelta(seconds=settings.upload_ttl + 60)
    assert retention.run_once(database, local_store, settings, now=late).uploads == 1
    assert list(local_store.list("staging")) == []
    with database.session(readonly=True) as session, pytest.raises(UserError):
        uploads.get(session, "ann", upload.id)


def test_many_sweep_at_the_same_time(
    database: Database,
    local_store: ObjectStore,
    settings: Settings,
    new_job: Callable[..., UUID],
    claimed: Callable[..., ClaimedJob],
) -> None:
    keys = [finish(database, local_store, claimed(), b"surface %d" % (number // 2)) for number in range(12)]
    late = datetime.now(UTC) + timedelta(seconds=settings.result_ttl + 60)
    swept: list[Swept] = []
    faults: list[BaseException] = []
    barrier = threading.Barrier(3)

    def run() -> None:
        barrier.wait()
        try:
            swept.append(retention.run_once(database, local_store, settings, now=late))
        except BaseException as error:
            faults.append(error)

    threads = [threading.Thread(target=run) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert faults == []
    assert sum(entry.results for entry in swept) == 12
    # one may have looked at the blobs before another had let go of the last of them
    last = retention.run_once(database, local_store, settings, now=late)
    assert sum(entry.blobs for entry in swept) + last.blobs == 6
    assert not any(local_store.exists(key) for key in keys)

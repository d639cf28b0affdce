"""Bytes stay as long as something refers to them, and go when nothing does, also while others upload the same."""

from __future__ import annotations

import random
import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from uuid import UUID

import pytest

from shapery_contracts.api import JobCreate
from shapery_contracts.errors import UserError
from shapery_platform import assets, blobs, jobs, retention
from shapery_platform.db import Database
from shapery_platform.db.models import Blob
from shapery_platform.jobs import ClaimedJob, NewArtifact
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore, object_key
from tests.integration.platform.conftest import VOLUME

LATER = timedelta(seconds=2 * blobs.PIN_SECONDS)


def sweep(database: Database, store: ObjectStore, after: timedelta = LATER) -> int:
    return blobs.sweep(database, store, now=datetime.now(UTC) + after)


def delete(database: Database, asset_id: UUID, owner: str = "ann") -> None:
    with database.session() as session:
        assets.delete(session, owner, asset_id)


def sha_of(database: Database, asset_id: UUID, owner: str = "ann") -> str:
    with database.session(readonly=True) as session:
        return assets.get(session, owner, asset_id).sha256


def test_an_asset_keeps_its_bytes_and_its_deletion_frees_them(
    database: Database, local_store: ObjectStore, new_asset: Callable[..., UUID]
) -> None:
    asset_id = new_asset()
    key = object_key(sha_of(database, asset_id))
    assert sweep(database, local_store) == 0
    delete(database, asset_id)
    assert local_store.exists(key)
    assert sweep(database, local_store) == 1
    assert not local_store.exists(key)
    with database.session(readonly=True) as session:
        assert session.query(Blob).count() == 0
        with pytest.raises(UserError):
            assets.get(session, "ann", asset_id)


def test_the_same_bytes_of_two_owners_go_with_the_second(
    database: Database, local_store: ObjectStore, new_asset: Callable[..., UUID]
) -> None:
    one, two = new_asset("ann"), new_asset("bob")
    key = object_key(sha_of(database, one))
    delete(database, one)
    assert sweep(database, local_store) == 0
    assert local_store.exists(key)
    delete(database, two, "bob")
    assert sweep(database, local_store) == 1
    assert not local_store.exists(key)


def test_fresh_bytes_are_kept_for_the_row_to_come(database: Database, local_store: ObjectStore) -> None:
    blob = local_store.put_bytes(b"just uploaded")
    assert sweep(database, local_store, timedelta(0)) == 0
    assert sweep(database, local_store, timedelta(seconds=blobs.PIN_SECONDS + 60)) == 1
    assert not local_store.exists(blob.key)


def test_a_pin_saves_bytes_that_were_about_to_go(
    database: Database, local_store: ObjectStore, new_asset: Callable[..., UUID]
) -> None:
    delete(database, new_asset(data=b"twice"))
    blob = local_store.put_bytes(b"twice")
    assert sweep(database, local_store, timedelta(seconds=1)) == 0
    assert local_store.exists(blob.key)


def test_a_job_that_has_not_ended_keeps_its_deleted_input(
    database: Database, local_store: ObjectStore, settings: Settings, new_asset: Callable[..., UUID]
) -> None:
    asset_id = new_asset()
    key = object_key(sha_of(database, asset_id))
    with database.session() as session:
        request = JobCreate(kind="segmentation", inputs={"post": asset_id})
        job_id = jobs.create(session, settings, "ann", request)[0].id
    delete(database, asset_id)
    assert sweep(database, local_store) == 0
    with database.session() as session:
        job = jobs.claim(session, job_id, "worker")
        assert job is not None
    assert sweep(database, local_store, 2 * LATER) == 0
    assert local_store.exists(key)
    with database.session() as session:
        assert jobs.fail(session, job_id, job.lease, "no_object_found", "Nothing was found.")
    assert sweep(database, local_store, 3 * LATER) == 1
    assert not local_store.exists(key)
    with database.session() as session, pytest.raises(UserError) as error:
        jobs.retry(session, "ann", job_id)
    assert error.value.code == "input_expired"


def test_artifacts_keep_their_bytes_until_they_expire(
    database: Database, local_store: ObjectStore, settings: Settings, claimed: Callable[..., ClaimedJob]
) -> None:
    job = claimed()
    blob = local_store.put_bytes(b"a surface")
    with database.session() as session:
        artifacts = [NewArtifact("a.ply", blob.sha256, blob.size), NewArtifact("b.ply", blob.sha256, blob.size)]
        assert jobs.succeed(session, job.job_id, job.lease, {}, artifacts)
    assert sweep(database, local_store) == 0
    assert local_store.exists(blob.key)
    swept = retention.run_once(
        database, local_store, settings, now=datetime.now(UTC) + timedelta(seconds=settings.result_ttl + 60)
    )
    assert (swept.results, swept.blobs) == (1, 1)
    assert not local_store.exists(blob.key)
    with database.session(readonly=True) as session:
        view = jobs.view(jobs.get(session, "ann", job.job_id))
        assert (view.expired, view.artifacts, view.result) == (True, [], None)
        with pytest.raises(UserError) as error:
            jobs.artifact(session, "ann", job.job_id, "a.ply")
    assert error.value.code == "gone"


def test_an_asset_cannot_be_made_of_bytes_that_are_gone(
    database: Database, local_store: ObjectStore, settings: Settings
) -> None:
    blob = local_store.put_bytes(b"too late")
    assert sweep(database, local_store) == 1
    with pytest.raises(UserError) as error, database.session() as session:
        assets.create_from_upload(session, local_store, settings, "ann", blob.sha256, blob.size, "x", VOLUME)
    assert error.value.code == "gone"
    with database.session(readonly=True) as session:
        assert session.query(Blob).count() == 0


def test_a_store_that_fails_leaves_the_row_for_the_next_sweep(
    database: Database,
    local_store: ObjectStore,
    new_asset: Callable[..., UUID],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    delete(database, new_asset())
    with monkeypatch.context() as patch, pytest.raises(OSError, match="unreachable"):  # noqa: PT012
        patch.setattr(type(local_store), "delete", lambda self, key: (_ for _ in ()).throw(OSError("unreachable")))
        sweep(database, local_store)
    assert sweep(database, local_store) == 1


@pytest.mark.slow
def test_no_bytes_are_lost_while_the_last_asset_goes_and_the_same_comes(
    database: Database, local_store: ObjectStore, settings: Settings
) -> None:
    """Uploaders, deleters and sweepers of the same few bytes at once. What became an asset must stay readable.

    The sweeps run as if every pin had passed, so an upload may find its bytes gone before they become an asset; it is
    told so, and uploads them again.
    """
    contents = [b"content %d" % number for number in range(2)]
    faults: list[BaseException] = []
    done = threading.Event()
    swept: list[int] = []

    def make_asset(data: bytes) -> UUID:
        while True:
            blob = local_store.put_bytes(data)
            try:
                with database.session() as session:
                    return assets.create_from_upload(
                        session, local_store, settings, "ann", blob.sha256, blob.size, "x.nii", VOLUME
                    ).id
            except UserError as error:
                if error.code != "gone":
                    raise

    def upload(seed: int) -> None:
        rng = random.Random(seed)
        try:
            for _ in range(20):
                data = rng.choice(contents)
                asset_id = make_asset(data)
                with database.session(readonly=True) as session:
                    key = object_key(assets.get(session, "ann", asset_id).sha256)
                assert b"".join(local_store.iter_range(key)) == data
                delete(database, asset_id)
        except BaseException as error:
            faults.append(error)

    def clean() -> None:
        try:
            while not done.is_set():
                swept.append(sweep(database, local_store))
        except BaseException as error:
            faults.append(error)

    cleaners = [threading.Thread(target=clean) for _ in range(2)]
    uploaders = [threading.Thread(target=upload, args=(seed,)) for seed in range(4)]
    for thread in (*cleaners, *uploaders):
        thread.start()
    for thread in uploaders:
        thread.join()
    done.set()
    for thread in cleaners:
        thread.join()
    assert faults == []
    assert sum(swept) > 0, "nothing was put to the test"
    sweep(database, local_store)
    assert list(local_store.list("objects")) == []


@pytest.mark.parametrize("seed", range(3))
def test_a_sweep_between_any_two_steps_of_an_upload(
    database: Database, pinned_store: ObjectStore, settings: Settings, seed: int
) -> None:
    """The same with the order chosen by us: a sweep runs at each point at which an upload can be interrupted."""
    rng = random.Random(seed)
    data = b"interrupted"
    with database.session() as session:
        blob = pinned_store.put_bytes(data)
    with database.session() as session:
        first = assets.create_from_upload(
            session, pinned_store, settings, "ann", blob.sha256, blob.size, "x", VOLUME
        ).id
    sweep(database, pinned_store)
    delete(database, first)
    moments = [lambda: blobs.sweep(database, pinned_store) for _ in range(3)]
    rng.shuffle(moments)
    pinned = pinned_store.pin
    assert pinned is not None

    def pin_between_sweeps(sha256: str, size: int) -> None:
        moments.pop()()
        pinned(sha256, size)
        moments.pop()()

    pinned_store.pin = pin_between_sweeps
    blob = pinned_store.put_bytes(data)
    moments.pop()()
    with database.session() as session:
        second = assets.create_from_upload(
            session, pinned_store, settings, "ann", blob.sha256, blob.size, "x", VOLUME
        ).id
    blobs.sweep(database, pinned_store)
    assert b"".join(pinned_store.iter_range(object_key(sha_of(database, second)))) == data

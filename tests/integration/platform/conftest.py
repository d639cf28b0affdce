"""Every test of this folder that asks for `database` runs on SQLite and on PostgreSQL, and one that asks for `store`
on a local folder and on S3."""

from __future__ import annotations

import itertools
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from uuid import UUID

import psycopg
import pytest
from psycopg import sql
from sqlalchemy import event

from shapery_contracts.api import JobCreate, JobEvent, JobView
from shapery_contracts.formats import AssetKind, FileFormat
from shapery_platform import assets, jobs
from shapery_platform.db import Database
from shapery_platform.db.models import Base, Shape
from shapery_platform.jobs import ClaimedJob
from shapery_platform.settings import Settings, load_settings
from shapery_platform.storage import ObjectStore, UploadStaging
from shapery_platform.storage.opening import open_store
from tests.support import shapes as fake
from tests.support.postgres import PostgresServer
from tests.support.redis import RedisServer, redis_server
from tests.support.s3 import S3Server

Index = Callable[..., UUID]
Claim = Callable[..., ClaimedJob]

VOLUME = FileFormat(kind=AssetKind.VOLUME, format="nifti1", media_type="application/x-nifti", extension=".nii")
DATABASES = ["sqlite", pytest.param("postgresql", marks=pytest.mark.server)]
STORES = ["local", pytest.param("s3", marks=pytest.mark.server)]


@pytest.fixture(scope="session")
def redis_session() -> Iterator[RedisServer]:
    with redis_server() as server:
        yield server


@pytest.fixture
def redis(redis_session: RedisServer) -> RedisServer:
    redis_session.clear()
    return redis_session


@pytest.fixture(scope="session")
def emptied_postgres(postgres: PostgresServer, migrated_postgres: str) -> str:
    """The address of a database that tests use one after the other."""
    return postgres.create_database(template=migrated_postgres)


def empty(url: str) -> None:
    """Delete all rows: quicker than a new database for every test."""
    with psycopg.connect(url) as connection:
        for table in reversed(Base.metadata.sorted_tables):
            connection.execute(sql.SQL("DELETE FROM {}").format(sql.Identifier(table.name)))


@pytest.fixture(params=DATABASES)
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    if request.param == "sqlite":
        target = tmp_path / "shapery.db"
        shutil.copyfile(request.getfixturevalue("migrated_sqlite"), target)
        yield f"sqlite:///{target}"
        return
    url: str = request.getfixturevalue("emptied_postgres")
    yield url
    empty(url)


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    database = Database(database_url)
    if database.dialect == "sqlite":
        # test data needs to survive nothing
        event.listen(database.engine, "connect", lambda connection, _: connection.execute("PRAGMA synchronous = OFF"))
    yield database
    database.dispose()


@pytest.fixture
def settings(tmp_path: Path, database_url: str) -> Settings:
    return load_settings(home=tmp_path, database_url=database_url, min_free_bytes=0)


@pytest.fixture(params=STORES)
def storage_settings(request: pytest.FixtureRequest, tmp_path: Path) -> Settings:
    """Settings of a store without a database."""
    if request.param == "s3":
        server: S3Server = request.getfixturevalue("s3")
        return load_settings(home=tmp_path, **server.settings())
    return load_settings(home=tmp_path, min_free_bytes=0)


@pytest.fixture
def store(storage_settings: Settings) -> ObjectStore:
    """A store that pins nothing."""
    return open_store(storage_settings)


@pytest.fixture
def pinned_store(storage_settings: Settings, database: Database) -> ObjectStore:
    """A store that pins in the database."""
    return open_store(storage_settings, database)


@pytest.fixture
def local_store(settings: Settings, database: Database) -> ObjectStore:
    """A local store, where a test is about the database alone."""
    return open_store(settings, database)


@pytest.fixture
def staging(pinned_store: ObjectStore) -> UploadStaging:
    return UploadStaging.over(pinned_store)


@pytest.fixture
def new_asset(database: Database, local_store: ObjectStore, settings: Settings) -> Callable[..., UUID]:
    """A function that stores bytes and makes an asset of them."""

    def make(
        owner: str = "ann", data: bytes = b"voxels", found: FileFormat = VOLUME, filename: str = "head.nii"
    ) -> UUID:
        blob = local_store.put_bytes(data)
        with database.session() as session:
            return assets.create_from_upload(
                session, local_store, settings, owner, blob.sha256, blob.size, filename, found
            ).id

    return make


@pytest.fixture
def new_job(database: Database, settings: Settings, new_asset: Callable[..., UUID]) -> Callable[..., UUID]:
    """A function that queues a job."""
    known: dict[str, UUID] = {}

    def make(owner: str = "ann", **params: object) -> UUID:
        if owner not in known:
            known[owner] = new_asset(owner)
        with database.session() as session:
            request = JobCreate(kind="segmentation", inputs={"post": known[owner]}, params=params)
            return jobs.create(session, settings, owner, request)[0].id

    return make


@pytest.fixture
def claimed(database: Database, new_job: Callable[..., UUID]) -> Callable[..., ClaimedJob]:
    """A function that queues a job and claims it."""

    def make(owner: str = "ann", worker: str = "worker-1") -> ClaimedJob:
        job_id = new_job(owner)
        with database.session() as session:
            job = jobs.claim(session, job_id, worker)
        assert job is not None
        return job

    return make


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


@pytest.fixture
def claim(database: Database, settings: Settings, new_asset: Callable[..., UUID]) -> Claim:
    """A function that asks for a mesh to be indexed, and takes the job."""
    assets_: dict[tuple[str, int], UUID] = {}

    def make(seed: int = 1, owner: str = "ann", **params: Any) -> ClaimedJob:
        key = owner, seed
        if key not in assets_:
            assets_[key] = new_asset(owner, b"mesh %d" % seed, fake.MESH)
        with database.session() as session:
            request = JobCreate(kind="shape-index", inputs={"mesh": assets_[key]}, params=params)
            job_id = jobs.create(session, settings, owner, request)[0].id
        with database.session() as session:
            job = jobs.claim(session, job_id, "worker")
        assert job is not None
        return job

    return make


@pytest.fixture
def index(database: Database, local_store: ObjectStore, claim: Claim, tmp_path: Path) -> Index:
    """A function that indexes a mesh and returns the shape's id."""
    folders = itertools.count()

    def make(
        seed: int = 1,
        owner: str = "ann",
        changed: dict[str, Any] | None = None,
        found: int | None = None,
        **params: Any,
    ) -> UUID:
        """`found` is what the handler takes the mesh for, where it is another number."""
        job = claim(seed, owner, **params)
        folder = tmp_path / f"out{next(folders)}"
        assert fake.publish(database, local_store, job, folder, seed if found is None else found, **(changed or {}))
        with database.session(readonly=True) as session:
            return session.query(Shape.id).where(Shape.job_id == job.job_id).scalar()

    return make

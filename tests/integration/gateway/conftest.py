"""A served gateway: what asks for `http` runs on SQLite with a local folder and on PostgreSQL with S3; what is about
HTTP alone asks for `local` and runs on the first."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import UUID

import httpx
import pytest

from shapery_contracts.api import Scope
from shapery_platform import jobs, keys
from shapery_platform.db import Database
from shapery_platform.jobs import NewArtifact
from shapery_platform.settings import Settings, load_settings
from shapery_platform.storage import ObjectStore
from shapery_platform.storage.opening import open_store
from tests.support import shapes as fake
from tests.support.gateway import nifti, served
from tests.support.postgres import PostgresServer
from tests.support.s3 import S3Server

Make = Callable[..., Settings]


@pytest.fixture
def local_settings(tmp_path: Path, migrated_sqlite: Path) -> Make:
    """A function that gives settings of a fresh platform in one folder."""

    def make(**overrides: Any) -> Settings:
        shutil.copyfile(migrated_sqlite, tmp_path / "shapery.db")
        return load_settings(home=tmp_path, port=0, min_free_bytes=0, event_poll=0.02, **overrides)

    return make


@pytest.fixture(params=["embedded", pytest.param("production", marks=pytest.mark.server)])
def make_settings(request: pytest.FixtureRequest, local_settings: Make) -> Iterator[Make]:
    """The same for both kinds of platforms."""
    if request.param == "embedded":
        yield local_settings
        return
    server: PostgresServer = request.getfixturevalue("postgres")
    s3: S3Server = request.getfixturevalue("s3")
    url = server.create_database(template=request.getfixturevalue("migrated_postgres"))
    yield lambda **overrides: local_settings(database_url=url, **s3.settings(), **overrides)
    server.drop_database(url)


@dataclass
class Platform:
    """What lies behind a served gateway, for a test that plays the worker."""

    settings: Settings
    database: Database
    store: ObjectStore
    url: str

    def client(self, secret: str | None = None, **options: Any) -> httpx.Client:
        """Return a client, with a key where one is given."""
        headers = {"Authorization": f"Bearer {secret}"} if secret else {}
        return httpx.Client(base_url=self.url, headers=headers, **{"timeout": 60, **options})

    def key(self, owner: str, *scopes: Scope) -> str:
        """Make a key."""
        with self.database.session() as session:
            return keys.create(session, "test", scopes or tuple(Scope), owner=owner)[1]

    def claim(self, job_id: str) -> UUID:
        """Take a job, and return its lease."""
        with self.database.session() as session:
            claimed = jobs.claim(session, UUID(job_id), "test")
        assert claimed is not None
        return claimed.lease

    def progress(self, job_id: str, lease: UUID, stage: str, fraction: float, preview: bytes | None = None) -> None:
        """Report progress."""
        with self.database.session() as session:
            assert jobs.report_progress(session, UUID(job_id), lease, stage, fraction, "", preview)

    def succeed(self, job_id: str, artifacts: dict[str, bytes] | None = None, media_type: str = "model/ply") -> None:
        """End a job, queued until now, with artifacts."""
        lease = self.claim(job_id)
        made = []
        for name, data in (artifacts or {}).items():
            blob = self.store.put_bytes(data)
            made.append(NewArtifact(name, blob.sha256, blob.size, media_type))
        with self.database.session() as session:
            assert jobs.succeed(session, UUID(job_id), lease, {"objects": []}, made)

    def index(self, job_id: str, seed: int = 1, **said: Any) -> None:
        """End a ``shape-index`` job, queued until now, with a shape."""
        with self.database.session() as session:
            job = jobs.claim(session, UUID(job_id), "test")
        assert job is not None
        assert fake.publish(self.database, self.store, job, self.settings.home / f"out-{job_id}", seed, **said)

    def fail(self, job_id: str) -> None:
        """End a job, queued until now, with a failure."""
        lease = self.claim(job_id)
        with self.database.session() as session:
            assert jobs.fail(session, UUID(job_id), lease, "no_object_found", "Nothing was found.", "Set a seed.")


Serve = Callable[[Settings], Platform]


@pytest.fixture
def serve() -> Iterator[Serve]:
    """A function that serves a platform until the test is over."""
    from contextlib import ExitStack

    with ExitStack() as stack:

        def start(settings: Settings) -> Platform:
            database = Database(settings.database_url)
            stack.callback(database.dispose)
            store = open_store(settings, database)
            return Platform(settings, database, store, stack.enter_context(served(settings)))

        yield start


@pytest.fixture
def platform(make_settings: Make, serve: Serve) -> Platform:
    """Both kinds, local mode."""
    return serve(make_settings())


@pytest.fixture
def http(platform: Platform) -> Iterator[httpx.Client]:
    with platform.client() as client:
        yield client


@pytest.fixture
def local_platform(local_settings: Make, serve: Serve) -> Platform:
    return serve(local_settings())


@pytest.fixture
def local(local_platform: Platform) -> Iterator[httpx.Client]:
    with local_platform.client() as client:
        yield client


def upload(client: httpx.Client, data: bytes | None = None, name: str = "head.nii") -> dict[str, Any]:
    """Send a file at once and return the asset."""
    response = client.post("/v1/assets", files={"file": (name, nifti() if data is None else data)})
    assert response.status_code == 201, response.text
    asset: dict[str, Any] = response.json()
    return asset


def submit(client: httpx.Client, asset: dict[str, Any] | None = None, **headers: str) -> dict[str, Any]:
    """Ask for a job and return it."""
    asset = asset or upload(client)
    response = client.post("/v1/jobs", json={"kind": "segmentation", "inputs": {"post": asset["id"]}}, headers=headers)
    assert response.status_code == 202, response.text
    job: dict[str, Any] = response.json()
    return job

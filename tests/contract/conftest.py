"""A served gateway with one of each thing in it."""

from __future__ import annotations

from collections.abc import Iterator
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
from shapery_platform.settings import load_settings
from shapery_platform.storage import ObjectStore
from shapery_platform.storage.opening import open_store
from tests.support import shapes as fake
from tests.support.gateway import TUS, nifti, served, triangle
from tests.support.redis import redis_server


@dataclass(frozen=True)
class World:
    """A served gateway, a key to it, and ids of what is there."""

    url: str
    secret: str
    ids: dict[str, str]


def _populate(url: str, secret: str, database: Database, store: ObjectStore, folder: Path) -> dict[str, str]:
    with httpx.Client(base_url=url, headers={"X-API-Key": secret}) as client:
        asset = client.post("/v1/assets", files={"file": ("head.nii", nifti())}).json()
        inputs = {"post": asset["id"]}
        job = client.post("/v1/jobs", json={"kind": "segmentation", "inputs": inputs}).json()
        batch = client.post("/v1/batches", json={"kind": "segmentation", "items": [{"inputs": inputs}]}).json()
        # a stream of its events ends at once
        client.post(f"/v1/batches/{batch['id']}/cancel")
        location = client.post("/v1/uploads", headers={**TUS, "Upload-Length": "1000000"}).headers["location"]
        key = client.post("/v1/keys", json={"name": "other"}).json()
    with database.session() as session:
        claimed = jobs.claim(session, UUID(job["id"]), "test")
    assert claimed is not None
    blob = store.put_bytes(b"{}")
    with database.session() as session:
        made = [NewArtifact("report.json", blob.sha256, blob.size, "application/json")]
        jobs.succeed(session, claimed.job_id, claimed.lease, {"objects": []}, made)
    with httpx.Client(base_url=url, headers={"X-API-Key": secret}) as client:
        mesh = client.post("/v1/assets", files={"file": ("shape.obj", triangle())}).json()
        request = {"kind": "shape-index", "inputs": {"mesh": mesh["id"]}, "params": {"collection": "bones"}}
        indexing = client.post("/v1/jobs", json=request).json()
    with database.session() as session:
        claimed = jobs.claim(session, UUID(indexing["id"]), "test")
    assert claimed is not None
    assert fake.publish(database, store, claimed, folder, 1)
    with httpx.Client(base_url=url, headers={"X-API-Key": secret}) as client:
        (shape,) = client.get("/v1/shapes").json()["items"]
        search = client.post("/v1/search", params={"wait": 0}, json={"shape_id": shape["id"]}).json()
    return {
        "shape_id": shape["id"],
        "collection_id": shape["collection_id"],
        "asset_id": asset["id"],
        "job_id": job["id"],
        "search_id": search["id"],
        "batch_id": batch["id"],
        "upload_id": location.rsplit("/", 1)[1],
        "key_id": key["id"],
        "name": "report.json",
    }


@pytest.fixture(scope="session")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    home: Path = tmp_path_factory.mktemp("contract")
    overrides: dict[str, Any] = {"auth": "keys", "rate_limit_per_minute": 0, "min_free_bytes": 0, "event_poll": 0.02}
    settings = load_settings(home=home, port=0, **overrides)
    database = Database(settings.database_url)
    database.migrate()
    with database.session() as session:
        _, secret = keys.create(session, "contract", list(Scope), owner="ann")
    with redis_server() as redis, served(settings.model_copy(update={"redis_url": redis.url})) as url:
        store = open_store(settings, database)
        yield World(url, secret, _populate(url, secret, database, store, home / "out"))
    database.dispose()

"""What belongs to somebody else does not exist: every public function that names an owner is walked."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from types import ModuleType
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import select

from shapery_contracts.api import BatchHeader, BatchItem, JobCreate
from shapery_contracts.errors import UserError
from shapery_contracts.retrieval import INDEX_VERSION
from shapery_contracts.shapes import CollectionCreate, CollectionUpdate, ShapeUpdate
from shapery_platform import assets, batches, collections, jobs, keys, shapes, uploads
from shapery_platform.db import Database
from shapery_platform.db.models import Base
from shapery_platform.jobs import ClaimedJob, NewArtifact
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore, UploadStaging
from tests.integration.platform.conftest import Index

MODULES: tuple[ModuleType, ...] = (assets, batches, collections, jobs, keys, shapes, uploads)

MAKES_SOMETHING_NEW = {"assets.create_from_upload", "collections.create", "keys.create", "uploads.create"}
"""They name whose the new thing shall be, and read nothing."""
LISTS = {
    "assets.list_assets",
    "batches.list_batches",
    "collections.list_collections",
    "jobs.list_jobs",
    "keys.list_keys",
    "shapes.list_shapes",
}
GIVES_NOTHING = {"jobs.events_after", "shapes.labels", "shapes.outdated", "shapes.some"}
"""An empty list and not an error: whoever asks knows already that the job or the collection exists."""
FILTERS = {"name", "batch_id", "job_id"}
"""Where a function can do without them, they narrow a list."""


def owned_functions() -> dict[str, Callable[..., Any]]:
    found = {}
    for module in MODULES:
        names = getattr(module, "__all__", [name for name in vars(module) if not name.startswith("_")])
        for name in names:
            function = getattr(module, name)
            if (
                inspect.isfunction(function)
                and function.__module__.startswith(module.__name__)
                and "owner" in inspect.signature(function).parameters
            ):
                found[f"{module.__name__.rsplit('.', 1)[-1]}.{name}"] = function
    return found


@pytest.fixture
def things(
    database: Database,
    local_store: ObjectStore,
    settings: Settings,
    new_asset: Callable[..., UUID],
    claimed: Callable[..., ClaimedJob],
    index: Index,
) -> dict[str, Any]:
    """One of everything that Ann has."""
    job = claimed("ann")
    blob = local_store.put_bytes(b"labels")
    staging = UploadStaging.over(local_store)
    asset_id = new_asset("ann", b"another")
    changed = {"index_version": INDEX_VERSION - 1}
    labels = {"side": "left"}
    shape_id = index(1, "ann", changed, collection="bones", name="labels.nii.gz", labels=labels)
    with database.session() as session:
        jobs.succeed(session, job.job_id, job.lease, {}, [NewArtifact("labels.nii.gz", blob.sha256, blob.size)])
        upload = uploads.create(session, staging, settings, "ann", 10, {})
        key, _ = keys.create(session, "key", ["read"], owner="ann")
        header = BatchHeader(kind="segmentation")
        batch, _ = batches.create(session, settings, "ann", header, [BatchItem(inputs={"post": asset_id})])
        collection_id = collections.named(session, "ann", "bones")
    return {
        "database": database,
        "store": local_store,
        "settings": settings,
        "staging": staging,
        "asset_id": asset_id,
        "job_id": job.job_id,
        "batch_id": batch.id,
        "upload_id": upload.id,
        "key_id": key.id,
        "name": "labels.nii.gz",
        "offset": 0,
        "chunks": [b"0123456789"],
        "shape_id": shape_id,
        "collection_id": collection_id,
        "ids": [shape_id],
        "limit": 10,
        "with_shapes": True,
        "JobCreate": JobCreate(kind="segmentation", inputs={"post": asset_id}),
        "CollectionCreate": CollectionCreate(name="mine"),
        "CollectionUpdate": CollectionUpdate(name="mine"),
        "ShapeUpdate": ShapeUpdate(name="mine"),
        "header": header,
        "items": [BatchItem(inputs={"post": asset_id})],
    }


def everything(database: Database) -> dict[str, list[Any]]:
    with database.session(readonly=True) as session:
        return {
            table.name: sorted(map(repr, session.execute(select(table)).all())) for table in Base.metadata.sorted_tables
        }


def call(function: Callable[..., Any], things: dict[str, Any], owner: str) -> Any:
    parameters = inspect.signature(function).parameters
    with things["database"].session() as session:
        known = {**things, "session": session, "owner": owner}
        if "request" in parameters:
            known["request"] = things[parameters["request"].annotation]
        needed = {name for name, value in parameters.items() if value.default is inspect.Parameter.empty}
        arguments = {
            name: known[name] for name in parameters if name in known and name in needed | known.keys() - FILTERS
        }
        assert needed <= arguments.keys(), f"this test must learn what {needed - arguments.keys()} is"
        found = function(**arguments)
        return list(found) if inspect.isgenerator(found) else found


@pytest.mark.parametrize("name", sorted(owned_functions().keys() - MAKES_SOMETHING_NEW - LISTS - GIVES_NOTHING))
def test_somebody_else_finds_nothing_and_changes_nothing(things: dict[str, Any], name: str) -> None:
    function = owned_functions()[name]
    before = everything(things["database"])
    # those that take the database open sessions of their own, so none may be open here
    if "session" in inspect.signature(function).parameters:
        with pytest.raises(UserError) as error:
            call(function, things, "bob")
    else:
        arguments = {key: value for key, value in things.items() if key in inspect.signature(function).parameters}
        with pytest.raises(UserError) as error:
            function(**arguments, owner="bob")
    assert error.value.code == "not_found"
    assert everything(things["database"]) == before


@pytest.mark.parametrize("name", sorted(LISTS | GIVES_NOTHING))
def test_lists_of_somebody_else_are_empty(things: dict[str, Any], name: str) -> None:
    def rows(found: Any) -> list[Any]:
        return list(found[0] if isinstance(found, tuple) else found)

    assert rows(call(owned_functions()[name], things, "ann")) != []
    assert rows(call(owned_functions()[name], things, "bob")) == []


def test_the_walk_finds_the_functions() -> None:
    names = owned_functions().keys()
    assert names >= {"jobs.get", "jobs.cancel", "jobs.retry", "jobs.artifact", "assets.get", "assets.delete"}
    assert names >= {"shapes.get", "shapes.update", "shapes.delete", "shapes.graph", "collections.delete"}
    assert names >= {"batches.results", "batches.cancel", "uploads.get", "uploads.append", "uploads.finish"}
    assert names >= MAKES_SOMETHING_NEW | LISTS | GIVES_NOTHING

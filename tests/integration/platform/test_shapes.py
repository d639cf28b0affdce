"""The shape database on SQLite and on PostgreSQL: a job gives one shape, whatever happens."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest

from shapery_contracts.errors import UserError
from shapery_contracts.retrieval import INDEX_VERSION, VECTOR_DIMENSION
from shapery_contracts.shapes import CollectionCreate, CollectionUpdate, ShapeUpdate
from shapery_contracts.states import JobState
from shapery_platform import assets, blobs, collections, jobs, publication, retention, shapes
from shapery_platform.db import Database
from shapery_platform.db.models import Bank, Blob, Shape, ShapeFile, ShapeGraph, ShapeLabel
from shapery_platform.db.types import unpack_vector
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore, object_key
from tests.integration.platform.conftest import Claim, Index
from tests.support import shapes as fake

LATER = timedelta(seconds=2 * blobs.PIN_SECONDS)


def count(database: Database, table: type) -> int:
    with database.session(readonly=True) as session:
        return session.query(table).count()


def code_of(action: Callable[[], object]) -> str:
    with pytest.raises(UserError) as raised:
        action()
    return raised.value.code


def test_a_finished_job_is_a_shape(database: Database, index: Index) -> None:
    shape_id = index(7, collection="bones", labels={"side": "left"}, metadata={"year": 1999})
    with database.session(readonly=True) as session:
        seen = shapes.detail(shapes.get(session, "ann", shape_id))
        assert seen.collection == "bones"
        assert seen.name == "head.nii"  # the file's, whose extension is not that of its content
        assert seen.labels == {"side": "left"}
        assert seen.metadata == {"year": 1999}
        assert seen.area == 7.5
        assert not seen.outdated
        assert seen.levels[0].parts == 1
        assert shapes.graph(session, "ann", shape_id) == fake.graph(7)
        assert shapes.file(session, "ann", shape_id, "preview.png").size == len(fake.files(7)["preview.png"])
        job = jobs.get(session, "ann", seen.job_id)
        assert job.state is JobState.SUCCEEDED
        kept = session.query(Shape.vector).where(Shape.id == shape_id).scalar()
    assert unpack_vector(kept) == fake.vector(7)


def test_a_job_gives_one_shape_whoever_ends_it(
    database: Database, local_store: ObjectStore, claim: Claim, tmp_path: Path
) -> None:
    lost = claim()
    with database.session() as session:
        assert jobs.crash_or_requeue(session, lost.job_id, lost.lease, "lost") is JobState.QUEUED
    with database.session() as session:
        second = jobs.claim(session, lost.job_id, "another")
    assert second is not None
    assert not fake.publish(database, local_store, lost, tmp_path / "a", 1)
    assert count(database, Shape) == 0
    assert fake.publish(database, local_store, second, tmp_path / "b", 1)
    assert not fake.publish(database, local_store, second, tmp_path / "c", 1)
    assert not fake.publish(database, local_store, lost, tmp_path / "d", 1)
    assert count(database, Shape) == count(database, ShapeGraph) == 1
    assert count(database, ShapeFile) == 3


def test_a_cancelled_job_leaves_no_shape(
    database: Database, local_store: ObjectStore, claim: Claim, tmp_path: Path
) -> None:
    job = claim()
    with database.session() as session:
        jobs.cancel(session, "ann", job.job_id)
    assert not fake.publish(database, local_store, job, tmp_path / "a", 1)
    assert count(database, Shape) == 0


def test_what_breaks_while_it_is_written_leaves_neither_shape_nor_end(
    database: Database, claim: Claim, tmp_path: Path
) -> None:
    job = claim()
    fake.leave(tmp_path, 1)
    said = fake.result(1).model_dump(mode="json")
    shape = publication.read_shape(job, said, tmp_path)

    def write_and_break() -> None:
        with database.session() as session:
            assert publication.succeed(session, job, said, [], shape)
            raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match="broken"):
        write_and_break()
    assert count(database, Shape) == count(database, Bank) == 0
    with database.session(readonly=True) as session:
        assert jobs.get(session, "ann", job.job_id).state is JobState.RUNNING


@pytest.mark.parametrize(
    "vector",
    [[0.0] * VECTOR_DIMENSION, [1e6] + [0.0] * (VECTOR_DIMENSION - 1), [float("inf")] * VECTOR_DIMENSION],
    ids=["zeros", "too large", "infinite"],
)
@pytest.mark.parametrize("name", ["vector", "part_vector"])
def test_a_vector_that_says_nothing_is_refused(claim: Claim, tmp_path: Path, name: str, vector: list[float]) -> None:
    fake.leave(tmp_path, 1)
    said = fake.result(1).model_dump() | {name: vector}
    with pytest.raises(ValueError, match="vector"):
        publication.read_shape(claim(), said, tmp_path)


@pytest.mark.parametrize("name", ["shape.arg", "mesh.glb", "preview.png", "components.json"])
def test_a_shape_without_one_of_its_files_is_refused(claim: Claim, tmp_path: Path, name: str) -> None:
    fake.leave(tmp_path, 1)
    (tmp_path / name).unlink()
    with pytest.raises(ValueError, match=name):
        publication.read_shape(claim(), fake.result(1).model_dump(mode="json"), tmp_path)


def test_indexing_again_replaces_in_place(database: Database, index: Index) -> None:
    old = INDEX_VERSION - 1
    shape_id = index(1, changed={"index_version": old}, collection="bones", labels={"side": "left"}, name="femur")
    with database.session(readonly=True) as session:
        before = shapes.view(shapes.get(session, "ann", shape_id))
    assert before.outdated
    assert index(1, found=2, replaces=str(shape_id)) == shape_id
    with database.session(readonly=True) as session:
        after = shapes.view(shapes.get(session, "ann", shape_id))
        assert shapes.graph(session, "ann", shape_id) == fake.graph(2)
    assert not after.outdated
    assert (after.name, after.collection, after.labels) == ("femur", "bones", {"side": "left"})
    assert after.created_at == before.created_at
    assert after.job_id != before.job_id
    assert count(database, Shape) == count(database, ShapeGraph) == 1
    assert count(database, ShapeFile) == 3


def test_a_newer_version_is_not_replaced_by_an_older_one(database: Database, index: Index) -> None:
    shape_id = index(1)
    assert index(1, found=2, changed={"index_version": INDEX_VERSION - 1}, replaces=str(shape_id)) is None
    with database.session(readonly=True) as session:
        assert shapes.graph(session, "ann", shape_id) == fake.graph(1)


def test_a_shape_deleted_while_it_is_indexed_again_stays_deleted(
    database: Database, local_store: ObjectStore, index: Index, claim: Claim, tmp_path: Path
) -> None:
    shape_id = index(1)
    job = claim(1, replaces=str(shape_id))
    with database.session() as session:
        shapes.delete(session, "ann", shape_id)
    assert fake.publish(database, local_store, job, tmp_path / "again", 1)
    assert count(database, Shape) == 0


def test_a_shape_is_not_replaced_by_another_mesh(
    database: Database, local_store: ObjectStore, index: Index, claim: Claim, tmp_path: Path
) -> None:
    shape_id = index(1)
    job = claim(2, replaces=str(shape_id))
    assert fake.publish(database, local_store, job, tmp_path / "other", 2) is JobState.FAILED
    with database.session(readonly=True) as session:
        assert shapes.graph(session, "ann", shape_id) == fake.graph(1)
        ended = jobs.view(jobs.get(session, "ann", job.job_id))
    assert ended.error is not None
    assert ended.error.code == "conflict"


def test_somebody_elses_shape_is_not_replaced(database: Database, index: Index) -> None:
    shape_id = index(1, "ann")
    assert index(2, "bob", replaces=str(shape_id)) is None
    with database.session(readonly=True) as session:
        assert shapes.graph(session, "ann", shape_id) == fake.graph(1)


def test_a_shape_outlives_its_job_and_its_asset_and_frees_its_bytes(
    database: Database, local_store: ObjectStore, settings: Settings, index: Index
) -> None:
    shape_id = index(1)
    with database.session() as session:
        shape = shapes.get(session, "ann", shape_id)
        assets.delete(session, "ann", shape.asset_id)
        key = object_key(shapes.file(session, "ann", shape_id, "mesh.glb").sha256)
    long_after = datetime.now(UTC) + timedelta(days=400)
    swept = retention.run_once(database, local_store, settings, now=long_after)
    assert swept.results == 1
    assert swept.blobs == 2  # the mesh as uploaded, and the graph, which the row has
    assert local_store.exists(key)
    with database.session() as session:
        assert shapes.graph(session, "ann", shape_id) == fake.graph(1)
        shapes.delete(session, "ann", shape_id)
    assert blobs.sweep(database, local_store, now=long_after + LATER) == 3
    assert not local_store.exists(key)
    for table in (Shape, ShapeGraph, ShapeFile, ShapeLabel, Blob):
        assert count(database, table) == 0


def test_two_shapes_of_the_same_bytes_share_them(
    database: Database, local_store: ObjectStore, settings: Settings, index: Index
) -> None:
    one, two = index(1), index(1)
    assert one != two
    with database.session() as session:
        key = object_key(shapes.file(session, "ann", one, "mesh.glb").sha256)
        shapes.delete(session, "ann", one)
    long_after = datetime.now(UTC) + timedelta(days=400)
    retention.run_once(database, local_store, settings, now=long_after)
    assert local_store.exists(key)
    with database.session() as session:
        shapes.delete(session, "ann", two)
    blobs.sweep(database, local_store, now=long_after + LATER)
    assert not local_store.exists(key)


def test_lists_are_narrowed_and_paged(database: Database, index: Index) -> None:
    ids = [
        index(seed, collection="even" if seed % 2 == 0 else "odd", labels={"third": str(seed % 3)}, name=f"No {seed}%")
        for seed in range(1, 8)
    ]
    index(99, changed={"index_version": INDEX_VERSION - 1})
    index(1, "bob")

    def listed(**filters: Any) -> list[int]:
        with database.session(readonly=True) as session:
            found, cursor = [], None
            while True:
                page, cursor = shapes.list_shapes(session, "ann", cursor, 2, **filters)
                found += [ids.index(shape.id) + 1 if shape.id in ids else 0 for shape in page]
                if cursor is None:
                    return found

    assert listed() == [0, 7, 6, 5, 4, 3, 2, 1]
    assert listed(collection="even") == [6, 4, 2]
    assert listed(labels={"third": "1"}) == [7, 4, 1]
    assert listed(collection="odd", labels={"third": "0"}) == [3]
    assert listed(labels={"third": "1", "other": "1"}) == []
    assert listed(name="no 3%") == [3]
    assert listed(name="%") == [7, 6, 5, 4, 3, 2, 1]
    assert listed(outdated=True) == [0]
    with database.session(readonly=True) as session:
        assert code_of(lambda: shapes.list_shapes(session, "ann", collection="none")) == "not_found"


def test_shapes_are_changed_and_moved(database: Database, index: Index) -> None:
    shape_id = index(1, labels={"a": "1", "b": "2"}, metadata={"x": 1})
    with database.session() as session:
        collections.create(session, "ann", CollectionCreate(name="second"))
        changed = shapes.view(
            shapes.update(session, "ann", shape_id, ShapeUpdate(collection="second", labels={"b": "3"}))
        )
    assert changed.collection == "second"
    assert changed.labels == {"b": "3"}
    assert changed.metadata == {"x": 1}
    with database.session() as session:
        assert code_of(lambda: shapes.update(session, "ann", shape_id, ShapeUpdate(collection="third"))) == "not_found"
    with database.session() as session:
        assert shapes.view(shapes.update(session, "ann", shape_id, ShapeUpdate(name="n", metadata={}))).name == "n"


def test_collections(database: Database, index: Index) -> None:
    with database.session() as session:
        made = collections.create(session, "ann", CollectionCreate(name="bones", description="of apes"))
        collections.create(session, "bob", CollectionCreate(name="bones"))
        assert code_of(lambda: collections.create(session, "ann", CollectionCreate(name="bones"))) == "conflict"
    one = index(1, collection="bones")
    index(2, collection="bones", changed={"index_version": INDEX_VERSION - 1})
    index(3)
    with database.session() as session:
        listed, _ = collections.list_collections(session, "ann")
        seen = {view.name: view for view in collections.views(session, listed)}
        assert {name: (view.shapes, view.outdated) for name, view in seen.items()} == {
            "bones": (2, 1),
            "default": (1, 0),
        }
        assert seen["bones"].id == made.id
        assert (
            code_of(lambda: collections.update(session, "ann", made.id, CollectionUpdate(name="default"))) == "conflict"
        )
    with database.session() as session:
        assert collections.update(session, "ann", made.id, CollectionUpdate(name="skulls")).description == "of apes"
        assert code_of(lambda: collections.delete(session, "ann", made.id, with_shapes=False)) == "conflict"
    with database.session() as session:
        collections.delete(session, "ann", made.id, with_shapes=True)
    with database.session(readonly=True) as session:
        assert code_of(lambda: shapes.get(session, "ann", one)) == "not_found"
        assert code_of(lambda: collections.get(session, "ann", made.id)) == "not_found"
    assert count(database, Shape) == 1


def test_nothing_of_somebody_else_exists(database: Database, index: Index) -> None:
    shape_id = index(1, "ann", collection="bones")
    with database.session() as session:
        collection_id = collections.named(session, "ann", "bones")
        attempts: list[Callable[[], object]] = [
            lambda: shapes.get(session, "bob", shape_id),
            lambda: shapes.graph(session, "bob", shape_id),
            lambda: shapes.file(session, "bob", shape_id, "mesh.glb"),
            lambda: shapes.update(session, "bob", shape_id, ShapeUpdate(name="mine")),
            lambda: shapes.delete(session, "bob", shape_id),
            lambda: shapes.list_shapes(session, "bob", collection="bones"),
            lambda: collections.get(session, "bob", collection_id),
            lambda: collections.update(session, "bob", collection_id, CollectionUpdate(name="mine")),
            lambda: collections.delete(session, "bob", collection_id, with_shapes=True),
        ]
        assert [code_of(attempt) for attempt in attempts] == ["not_found"] * len(attempts)
        assert shapes.list_shapes(session, "bob") == ([], None)
        assert shapes.some(session, "bob", [shape_id, uuid4()]) == {}
        assert list(shapes.some(session, "ann", [shape_id, uuid4()])) == [shape_id]
    assert count(database, Shape) == 1


def test_workers_that_publish_at_the_same_time_do_not_lose_each_others_shapes(
    database: Database, local_store: ObjectStore, claim: Claim, tmp_path: Path
) -> None:
    """All into one collection that does not exist yet, some with the same bytes."""
    waiting = [claim(seed % 3, collection="new") for seed in range(8)]
    faults: list[BaseException] = []

    def work(number: int) -> None:
        try:
            assert fake.publish(database, local_store, waiting[number], tmp_path / str(number), number % 3)
        except BaseException as error:
            faults.append(error)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(len(waiting))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert faults == []
    with database.session(readonly=True) as session:
        assert session.query(Shape).count() == 8
        assert sorted(row.revision for row in session.query(Shape)) == list(range(1, 9))
        assert session.query(Bank).one().revision == 8

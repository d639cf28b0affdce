"""What a search reads of the bank, in memory over SQLite and by pgvector in PostgreSQL."""

from __future__ import annotations

import random
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from uuid import UUID, uuid4

import pytest
from sqlalchemy import text, update

from shapery_contracts.retrieval import INDEX_VERSION, VECTOR_DIMENSION, By, Nearest, ShapeBank, ShapeFilter
from shapery_contracts.shapes import ShapeUpdate
from shapery_platform import shapes
from shapery_platform.db import Database
from shapery_platform.db.models import Shape
from shapery_platform.storage import ObjectStore
from shapery_worker.bank import Banks, VectorTable
from shapery_worker.bank_line import BankClient, BankServer
from tests.integration.platform.conftest import Claim, Index
from tests.support import shapes as fake

EVERYTHING = ShapeFilter()


def found(
    bank: ShapeBank, seed: int, limit: int = 100, only: ShapeFilter = EVERYTHING, by: By = "whole"
) -> list[tuple[str, float]]:
    asked = Nearest(vector=fake.vector(seed), limit=limit, only=only, by=by)
    return [(near.shape_id, near.distance) for near in bank.candidates(asked)]


def expected(ids: dict[str, int], seed: int, limit: int = 100) -> list[tuple[str, float]]:
    measured = [(shape_id, fake.distance(other, seed)) for shape_id, other in ids.items()]
    return sorted(measured, key=lambda pair: (pair[1], pair[0]))[:limit]


def test_the_nearest_are_found_while_shapes_come_and_go(database: Database, index: Index) -> None:
    """Every change is seen by the next search, in the same process, and by one that has kept nothing."""
    rng = random.Random(4)
    there: dict[str, int] = {}
    banks = Banks(database)
    for step in range(30):
        if there and rng.random() < 0.3:
            gone = rng.choice(sorted(there))
            with database.session() as session:
                shapes.delete(session, "ann", UUID(gone))
            del there[gone]
        elif there and rng.random() < 0.2:
            with database.session() as session:
                shapes.update(session, "ann", UUID(rng.choice(sorted(there))), ShapeUpdate(name=f"step {step}"))
        else:
            seed = rng.randrange(1 << 24)
            there[str(index(seed))] = seed
        query = rng.randrange(1 << 24)
        kinds: list[tuple[By, int]] = [("whole", query)]
        if step > 10:  # what was never asked for is read then
            kinds.append(("parts", query ^ 1))  # vectors of parts have the lowest digit turned over
        for bank, (by, like) in product((banks.of("ann"), Banks(database).of("ann")), kinds):
            seen = found(bank, query, by=by)
            assert [shape_id for shape_id, _ in seen] == [shape_id for shape_id, _ in expected(there, like)]
            assert [d for _, d in seen] == pytest.approx([d for _, d in expected(there, like)], abs=1e-6)
            assert {
                shape_id: fake.seed_of(graph) for shape_id, graph in bank.args([*there, str(uuid4())]).items()
            } == there
    assert [shape_id for shape_id, _ in found(banks.of("ann"), 5, 3)] == [i for i, _ in expected(there, 5, 3)]


def test_filters_and_owners(database: Database, index: Index) -> None:
    ann = {
        seed: str(index(seed, collection="even" if seed % 2 == 0 else "odd", labels={"third": str(seed % 3)}))
        for seed in range(9)
    }
    index(3, "bob", collection="odd")
    banks = Banks(database)

    def seeds(owner: str, **only: object) -> set[int]:
        bank = banks.of(owner)
        ids = [shape_id for shape_id, _ in found(bank, 0, only=ShapeFilter.model_validate(only))]
        return {fake.seed_of(graph) for graph in bank.args(ids).values()}

    assert seeds("ann") == set(range(9))
    assert seeds("ann", collection="odd") == {1, 3, 5, 7}
    assert seeds("ann", collection="odd", labels={"third": "0"}) == {3}
    odd = ShapeFilter(collection="odd")
    assert found(banks.of("ann"), 2, 2, odd, "parts") == [(ann[3], 0.0), (ann[1], 1.0)]
    assert found(banks.of("ann"), 2, 2, odd) == [(ann[3], 1.0), (ann[1], pytest.approx(2**0.5))]
    assert seeds("ann", collection="none") == set()
    assert seeds("bob") == {3}
    assert seeds("bob", collection="even") == set()
    assert seeds("eve") == set()
    assert banks.of("bob").args(ann.values()) == {}
    with database.session() as session:
        shapes.update(session, "ann", UUID(ann[3]), ShapeUpdate(collection="even"))
    assert seeds("ann", collection="odd") == {1, 5, 7}


def test_versions_never_mix(database: Database, index: Index) -> None:
    old = str(index(1, changed={"index_version": INDEX_VERSION - 1}))
    new = str(index(2))
    banks = Banks(database)
    assert [shape_id for shape_id, _ in found(banks.of("ann"), 1)] == [new]
    assert list(banks.of("ann").args([old, new])) == [new]
    before = banks.of("ann").candidates(Nearest(vector=fake.vector(1), limit=9, version=INDEX_VERSION - 1))
    assert [candidate.shape_id for candidate in before] == [old]
    with database.session() as session:  # shapes of former versions have no vector of parts
        session.execute(update(Shape).where(Shape.id == UUID(old)).values(part_vector=None))
    for bank in (banks.of("ann"), Banks(database).of("ann")):
        assert bank.candidates(Nearest(vector=fake.vector(1), limit=9, version=INDEX_VERSION - 1, by="parts")) == []
        assert [shape_id for shape_id, _ in found(bank, 1, by="parts")] == [new]
    index(1, replaces=old)
    assert {shape_id for shape_id, _ in found(banks.of("ann"), 1, by="parts")} == {old, new}
    assert {shape_id for shape_id, _ in found(banks.of("ann"), 1)} == {old, new}
    assert list(banks.of("ann").args([old])) == [old]
    assert banks.of("ann").candidates(Nearest(vector=fake.vector(1), limit=9, version=INDEX_VERSION - 1)) == []


@pytest.mark.slow
def test_searches_run_beside_changes(
    database: Database, local_store: ObjectStore, index: Index, claim: Claim, tmp_path: Path
) -> None:
    """What is there all the time is found all the time, with its graph, while others come and go and it is indexed
    again."""
    steady = {str(index(seed)): seed for seed in range(1, 6)}
    again = [(claim(seed, replaces=shape_id), seed) for shape_id, seed in steady.items()]
    coming = [claim(seed) for seed in range(100, 120)]
    faults: list[BaseException] = []
    done = threading.Event()

    def change() -> None:
        try:
            for number, job in enumerate(coming):
                assert fake.publish(database, local_store, job, tmp_path / str(job.job_id), 1 << 20)
                if number % 4 == 0:
                    renewed, seed = again[number // 4]
                    assert fake.publish(database, local_store, renewed, tmp_path / str(renewed.job_id), seed)
                with database.session() as session:
                    (newest,), _ = shapes.list_shapes(session, "ann", None, 1)
                    shapes.delete(session, "ann", newest.id)
        except BaseException as error:
            faults.append(error)
        finally:
            done.set()

    thread = threading.Thread(target=change)
    thread.start()
    banks = Banks(database)
    searches = 0
    while not done.is_set() or searches < 3:
        bank = banks.of("ann")
        ids = [shape_id for shape_id, _ in found(bank, 3)]
        assert steady.keys() <= {shape_id for shape_id, _ in found(bank, 3, by="parts")}
        graphs = bank.args(ids)
        assert steady.items() <= {shape_id: fake.seed_of(graph) for shape_id, graph in graphs.items()}.items()
        assert set(ids) - set(steady) == set() or len(set(ids) - set(steady)) == 1
        searches += 1
    thread.join()
    assert faults == []
    assert {shape_id for shape_id, _ in found(banks.of("ann"), 3)} == set(steady)


def test_little_room_changes_nothing_but_what_is_kept(database: Database, index: Index) -> None:
    ids = {owner: {str(index(seed, owner)): seed for seed in range(4)} for owner in ("ann", "bob")}
    banks = Banks(database, room=3000)
    for _ in range(2):
        for owner, there in ids.items():
            bank = banks.of(owner)
            assert {shape_id for shape_id, _ in found(bank, 1)} == set(there)
            assert {shape_id: fake.seed_of(graph) for shape_id, graph in bank.args(there).items()} == there


@contextmanager
def line(bank: ShapeBank) -> Iterator[BankClient]:
    ours, theirs = socket.socketpair()
    client = BankClient(theirs.detach())
    try:
        with BankServer(ours, bank):
            yield client
    finally:
        client.close()


def test_a_handler_reads_the_same_over_its_line(database: Database, index: Index) -> None:
    there = {str(index(seed, collection="even" if seed % 2 == 0 else "odd")): seed for seed in range(6)}
    bank = Banks(database).of("ann")
    with line(bank) as client:
        assert found(client, 3) == found(bank, 3)
        odd = ShapeFilter(collection="odd")
        assert found(client, 3, 2, odd) == found(bank, 3, 2, odd)
        assert found(client, 3, 2, odd, "parts") == found(bank, 3, 2, odd, "parts")
        four = Nearest(vector=fake.vector(3), limit=4)
        assert client.candidates(four) == bank.candidates(four), "with their vectors"
        assert client.args([*there, str(uuid4())]) == bank.args(there)
        assert client.args([]) == {}
        assert client.args(["no id", next(iter(there)).upper()]).keys() <= there.keys()
        assert client.args(["no id"]) == {}
        assert client.candidates(Nearest(vector=fake.vector(1), limit=3, version=99)) == []


def test_a_line_that_breaks_is_told(database: Database, index: Index) -> None:
    index(1)
    with line(Banks(database).of("ann")) as client:
        with pytest.raises(ConnectionError, match="cannot be read"):
            client.args([5])  # type: ignore[list-item]
        assert len(found(client, 1)) == 1  # the line goes on


def test_a_handler_whose_watcher_is_gone_is_told() -> None:
    ours, theirs = socket.socketpair()
    client = BankClient(theirs.detach())
    ours.close()
    with pytest.raises(OSError):  # noqa: PT011 (which one depends on the moment)
        client.args([])
    client.close()


def test_the_index_of_neighbours_is_used(database: Database) -> None:
    """Where there are many shapes, PostgreSQL walks its graph instead of measuring them all."""
    if database.dialect != "postgresql":
        pytest.skip("SQLite has none: its vectors are compared in memory")
    with database.session() as session:
        session.execute(text("SET LOCAL enable_seqscan = off"))
        session.execute(text("SET LOCAL enable_sort = off"))
        asked = f"WHERE owner = 'ann' AND vector IS NOT NULL ORDER BY vector <-> '{fake.vector(1)}' LIMIT 5"
        plan = session.execute(text(f"EXPLAIN SELECT id FROM shapes {asked}")).scalars()
        assert "ix_shapes_vector" in "\n".join(plan)


@pytest.mark.slow
def test_a_walk_that_gives_up_early_loses_nothing(database: Database, index: Index) -> None:
    """However few shapes a filter lets through, and whatever PostgreSQL thinks how many, all of them are found."""
    if database.dialect != "postgresql":
        pytest.skip("SQLite has no index to walk")
    far = (1 << 24) - 1
    rare = {str(index(seed, collection="rare", labels={"kept": "yes"})): seed for seed in (far, far - 1)}
    for seed in range(120):  # more than a walk sees at first
        index(seed, collection="frequent")
    hasty = Database(database.url.render_as_string(hide_password=False), pool_size=1)
    with hasty.engine.connect() as connection:  # the pool's only one: what is set stays
        for setting in ("enable_seqscan", "enable_sort", "enable_bitmapscan"):
            connection.exec_driver_sql(f"SET {setting} = off")
        connection.exec_driver_sql("SET hnsw.max_scan_tuples = 1")
        connection.commit()
    bank = Banks(hasty).of("ann")
    for only in (ShapeFilter(collection="rare"), ShapeFilter(labels={"kept": "yes"})):
        assert [shape_id for shape_id, _ in found(bank, 0, 2, only)] == [i for i, _ in expected(rare, 0)]
    assert len(found(bank, 0, 50, ShapeFilter(collection="frequent"))) == 50
    assert found(bank, 0, 2, ShapeFilter(collection="nowhere")) == []
    hasty.dispose()


def test_what_filters_let_through_is_kept_within_bounds(database: Database, index: Index) -> None:
    if database.dialect != "sqlite":
        pytest.skip("PostgreSQL is asked each time")
    there = str(index(1, labels={"third": "1"}))
    banks = Banks(database)
    bank = banks.of("ann")
    for number in range(100):
        asked = ShapeFilter(labels={"third": str(number)})
        assert [shape_id for shape_id, _ in found(bank, 1, only=asked)] == ([there] if number == 1 else [])
    assert len(banks._kept["ann"].rows) == 64
    assert [shape_id for shape_id, _ in found(bank, 1, only=ShapeFilter(labels={"third": "1"}))] == [there]


def test_vectors_of_a_table_against_all_of_them() -> None:
    """Any order of additions, replacements and removals gives the distances of what is left."""
    import numpy as np

    rng = np.random.default_rng(1)
    table = VectorTable()
    there: dict[UUID, np.ndarray] = {}
    for _ in range(400):
        if there and rng.random() < 0.35:
            gone = sorted(there)[rng.integers(len(there))]
            table.drop(gone)
            del there[gone]
        else:
            known = sorted(there)
            chosen = known[rng.integers(len(known))] if known and rng.random() < 0.2 else uuid4()
            there[chosen] = rng.normal(size=VECTOR_DIMENSION).astype("<f4")
            table.put(chosen, there[chosen].tobytes())
    table.drop(uuid4())
    query = rng.normal(size=VECTOR_DIMENSION)
    measured = sorted((float(np.linalg.norm(v.astype(float) - query)), shape_id) for shape_id, v in there.items())
    nearest = table.nearest(query, 10, None)
    assert [near.shape_id for near in nearest] == [str(shape_id) for _, shape_id in measured[:10]]
    assert [near.distance for near in nearest] == pytest.approx([d for d, _ in measured[:10]], rel=1e-12)
    assert [near.vector for near in nearest] == [there[shape_id].tobytes() for _, shape_id in measured[:10]]
    some = {shape_id for _, shape_id in measured[5:50]}
    among = table.nearest(query, 10, table.rows(some))
    assert [near.shape_id for near in among] == [str(shape_id) for _, shape_id in measured[5:15]]

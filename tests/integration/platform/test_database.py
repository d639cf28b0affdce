"""Sessions, transactions and types behave alike on both databases."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from uuid import UUID

import pytest
from sqlalchemy import select, text, update
from sqlalchemy.exc import DBAPIError, IntegrityError, StatementError

from shapery_contracts.states import JobState
from shapery_platform import keys
from shapery_platform.db import Database, database_now, new_id
from shapery_platform.db.models import Blob, Job, Upload


def test_a_session_commits_on_success_and_rolls_back_on_an_error(database: Database) -> None:
    with database.session() as session:
        session.add(Blob(sha256="a" * 64, size=1))
    with pytest.raises(RuntimeError, match="on the way"), database.session() as session:  # noqa: PT012
        session.add(Blob(sha256="b" * 64, size=1))
        session.flush()
        raise RuntimeError("on the way")
    with database.session(readonly=True) as session:
        assert session.scalars(select(Blob.sha256)).all() == ["a" * 64]


def test_a_readonly_session_cannot_write_and_the_next_writer_can(database: Database) -> None:
    with pytest.raises(DBAPIError), database.session(readonly=True) as session:  # noqa: PT012
        session.add(Blob(sha256="a" * 64, size=1))
        session.flush()
    with database.session() as session:
        session.add(Blob(sha256="a" * 64, size=1))


def test_a_reader_does_not_wait_for_a_writer(database: Database) -> None:
    with database.session() as writer:
        writer.add(Blob(sha256="a" * 64, size=1))
        writer.flush()
        with database.session(readonly=True) as reader:
            assert reader.scalars(select(Blob.sha256)).all() == []


def test_writers_wait_for_each_other_and_none_is_lost(database: Database) -> None:
    with database.session() as session:
        session.add(Blob(sha256="a" * 64, size=0))

    def add_twenty() -> None:
        for _ in range(20):
            with database.session() as session:
                # read first, then write: in SQLite this fails for a transaction that began as a reader
                size = session.scalars(select(Blob.size).with_for_update()).one()
                session.execute(update(Blob).values(size=size + 1))

    threads = [threading.Thread(target=add_twenty) for _ in range(5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    with database.session(readonly=True) as session:
        assert session.scalars(select(Blob.size)).one() == 100


def test_times_come_back_aware_and_equal(database: Database) -> None:
    at = datetime(2026, 3, 29, 2, 30, 0, 123456, tzinfo=timezone(timedelta(hours=5, minutes=30)))
    upload_id = new_id()
    with database.session() as session:
        session.add(Upload(id=upload_id, owner="ann", details={"filename": "ä\ud800.nii\0"}, expires_at=at))
    with database.session(readonly=True) as session:
        upload = session.get_one(Upload, upload_id)
        assert upload.expires_at == at
        assert upload.expires_at.utcoffset() == timedelta(0)
        assert upload.details == {"filename": "ä\ud800.nii\0"}
        assert session.scalars(select(Upload.id).where(Upload.expires_at <= at)).all() == [upload_id]
        assert session.scalars(select(Upload.id).where(Upload.expires_at < at)).all() == []


def test_a_time_without_a_zone_is_refused(database: Database) -> None:
    with pytest.raises(StatementError, match="without a time zone"), database.session() as session:
        session.add(Upload(owner="ann", details={}, expires_at=datetime(2026, 1, 1)))  # noqa: DTZ001


def test_numbers_that_json_does_not_have_are_refused(database: Database) -> None:
    with pytest.raises((StatementError, ValueError), match="not JSON compliant"), database.session() as session:
        session.add(Upload(owner="ann", details={"x": float("nan")}, expires_at=datetime.now(UTC)))


def test_the_database_refuses_a_lease_in_a_terminal_state(database: Database, new_job: Callable[..., UUID]) -> None:
    job_id = new_job()
    for values in (
        {"state": JobState.RUNNING},
        {"lease": new_id()},
        {"state": JobState.SUCCEEDED},
        {"finished_at": datetime.now(UTC)},
    ):
        with pytest.raises(IntegrityError), database.session() as session:
            session.execute(update(Job).where(Job.id == job_id).values(**values))


def test_foreign_keys_hold(database: Database) -> None:
    with pytest.raises(IntegrityError), database.session() as session:
        session.execute(
            text("INSERT INTO job_inputs (job_id, name, position, asset_id) VALUES (:one, 'post', 0, :two)"),
            {"one": new_id().hex, "two": new_id().hex},
        )


def test_ids_sort_in_the_order_in_which_they_were_made(database: Database) -> None:
    made = []
    with database.session() as session:
        for number in range(50):
            made.append(keys.create(session, f"key {number}", ["read"], owner="ann")[0].id)
    with database.session(readonly=True) as session:
        assert [key.id for key in keys.list_keys(session, "ann")] == made[::-1]


def test_the_time_of_leases_is_close_to_ours(database: Database) -> None:
    before = datetime.now(UTC) - timedelta(seconds=1)
    with database.session(readonly=True) as session:
        assert before < database_now(session) < datetime.now(UTC) + timedelta(seconds=1)


def test_a_transaction_that_hangs_does_not_hold_up_others_for_ever(database: Database) -> None:
    with database.session(readonly=True) as session:
        if database.dialect == "sqlite":
            assert session.execute(text("PRAGMA busy_timeout")).scalar_one() == 30_000
            assert session.execute(text("PRAGMA journal_mode")).scalar_one() == "wal"
            assert session.execute(text("PRAGMA foreign_keys")).scalar_one() == 1
        else:
            assert session.execute(text("SHOW lock_timeout")).scalar_one() == "30s"
            assert session.execute(text("SHOW idle_in_transaction_session_timeout")).scalar_one() == "10min"
            assert session.execute(text("SHOW transaction_isolation")).scalar_one() == "read committed"


def test_what_was_answered_survives_the_loss_of_power(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path}/shapery.db")
    with database.session() as session:
        assert session.execute(text("PRAGMA synchronous")).scalar_one() == 2, "FULL"
    database.dispose()


def test_a_database_in_memory_is_refused() -> None:
    for url in ("sqlite://", "sqlite:///:memory:"):
        with pytest.raises(ValueError, match="needs a file"):
            Database(url)

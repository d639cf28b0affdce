"""What is asked every second, or by everybody, reads an index and not the table of all jobs there ever were."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import event
from sqlalchemy.orm import Session

from shapery_contracts.states import JobState
from shapery_platform.db import Database, new_id, utc_now
from shapery_platform.db.repositories import bank, batches, blobs, collections, jobs, shapes


def page_of_shapes(session: Session, **filters: Any) -> Any:
    narrowed = {"collection_id": None, "labels": {}, "name": None, "outdated_at": None, **filters}
    return shapes.page(session, "ann", new_id(), 10, **narrowed)


QUERIES: dict[str, tuple[Callable[[Session], Any], str]] = {
    "silent workers": (lambda s: jobs.silent_since(s, utc_now(), 10), "ix_jobs_live"),
    "waiting jobs": (lambda s: jobs.waiting(s, "motion", 10), "ix_jobs_live"),
    "lost messages": (lambda s: jobs.waiting(s, "motion", 10, sent_before=utc_now()), "ix_jobs_live"),
    "results to expire": (lambda s: jobs.due_to_expire(s, utc_now(), 10), "ix_jobs_expires_at"),
    "a page": (
        lambda s: jobs.page(s, "ann", new_id(), 10, state=None, kind=None, batch_id=None),
        "ix_jobs_owner_id",
    ),
    "a page of a state": (
        lambda s: jobs.page(s, "ann", new_id(), 10, state=JobState.FAILED, kind=None, batch_id=None),
        "ix_jobs_owner_state_id",
    ),
    "a page of a kind": (
        lambda s: jobs.page(s, "ann", None, 10, state=None, kind="motion", batch_id=None),
        "ix_jobs_owner_kind_id",
    ),
    "a page of a batch": (
        lambda s: jobs.page(s, "ann", new_id(), 10, state=None, kind=None, batch_id=new_id()),
        "ix_jobs_batch_id_state",
    ),
    "counts of a batch": (lambda s: batches.counts(s, [new_id()]), "ix_jobs_batch_id_state"),
    "results of a batch": (lambda s: batches.jobs_after(s, new_id(), 3, 10), "sqlite_autoindex_jobs"),
    "a page of shapes": (lambda s: page_of_shapes(s), "ix_shapes_owner_id"),
    "a page of a collection": (
        lambda s: page_of_shapes(s, collection_id=new_id()),
        "ix_shapes_collection_id_id",
    ),
    "a page of labelled shapes": (
        lambda s: page_of_shapes(s, labels={"side": "left"}),
        "sqlite_autoindex_shape_labels",
    ),
    "counts of collections": (
        lambda s: collections.counts(s, [new_id()], 1),
        "COVERING INDEX ix_shapes_collection_id_index_version",
    ),
    "shapes changed since": (lambda s: list(bank.vectors_after(s, "ann", 7)), "ix_shapes_owner_revision"),
    "whether a blob is kept": (lambda s: blobs.is_kept(s, "a" * 64), "ix_shape_files_sha256"),
    "blobs to sweep": (lambda s: blobs.due(s, utc_now(), 10), "ix_blobs_check_after"),
    "whether a blob is read": (lambda s: blobs.is_read(s, "a" * 64), "ix_assets_sha256"),
}


@pytest.mark.parametrize("name", QUERIES)
def test_sqlite_uses_the_index(migrated_sqlite: Path, name: str) -> None:
    query, index = QUERIES[name]
    database = Database(f"sqlite:///{migrated_sqlite}")
    asked: list[tuple[str, Any]] = []
    event.listen(database.engine, "before_cursor_execute", lambda *args: asked.append((args[2], args[3])))
    with database.session(readonly=True) as session:
        query(session)
        text, parameters = next(entry for entry in asked if entry[0].startswith("SELECT"))
        plan = session.connection().exec_driver_sql(f"EXPLAIN QUERY PLAN {text}", parameters).all()
    database.dispose()
    steps = " | ".join(row[-1] for row in plan)
    assert index in steps
    assert "SCAN jobs" not in steps
    assert "SCAN blobs" not in steps
    assert "SCAN shapes" not in steps

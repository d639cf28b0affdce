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
from shapery_platform.db.repositories import assets, bank, batches, blobs, collections, jobs, shapes
from shapery_platform.paging import Sort

AFTER = Sort(after=new_id())


def page_of_jobs(session: Session, sort: Sort = AFTER, **filters: Any) -> Any:
    return jobs.page(session, "ann", sort, 10, **{"state": None, "kind": None, "batch_id": None, **filters})


def page_of_shapes(session: Session, sort: Sort = AFTER, **filters: Any) -> Any:
    narrowed = {"collection_id": None, "labels": {}, "name": None, "outdated_at": None, **filters}
    return shapes.page(session, "ann", sort, 10, **narrowed)


QUERIES: dict[str, tuple[Callable[[Session], Any], str]] = {
    "silent workers": (lambda s: jobs.silent_since(s, utc_now(), 10), "ix_jobs_live"),
    "waiting jobs": (lambda s: jobs.waiting(s, "motion", 10), "ix_jobs_live"),
    "lost messages": (lambda s: jobs.waiting(s, "motion", 10, sent_before=utc_now()), "ix_jobs_live"),
    "results to expire": (lambda s: jobs.due_to_expire(s, utc_now(), 10), "ix_jobs_expires_at"),
    "a page": (lambda s: page_of_jobs(s), "ix_jobs_owner_id"),
    "a page of a state": (lambda s: page_of_jobs(s, state=JobState.FAILED), "ix_jobs_owner_state_id"),
    "a page of a kind": (lambda s: page_of_jobs(s, Sort(), kind="motion"), "ix_jobs_owner_kind_id"),
    "a page of a batch": (lambda s: page_of_jobs(s, batch_id=new_id()), "ix_jobs_batch_id_state"),
    "a page by name": (
        lambda s: page_of_jobs(s, Sort("name", descending=False, after=("head.nii", new_id()))),
        "ix_jobs_owner_name_id",
    ),
    "a page by state": (lambda s: page_of_jobs(s, Sort("state", after=("failed", new_id()))), "ix_jobs_owner_state_id"),
    "a page by duration": (lambda s: page_of_jobs(s, Sort("took", after=(3.5, new_id()))), "ix_jobs_owner_took_id"),
    "a page of files by name": (
        lambda s: assets.page(s, "ann", Sort("name", after=("head.nii", new_id())), 10, None),
        "ix_assets_owner_filename_id",
    ),
    "a page of shapes by name": (
        lambda s: page_of_shapes(s, Sort("name", after=("horse", new_id()))),
        "ix_shapes_owner_name_id",
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
    "shapes changed since": (lambda s: list(bank.vectors_after(s, "ann", 7, "whole")), "ix_shapes_owner_revision"),
    "whether a blob is kept": (lambda s: blobs.is_kept(s, "a" * 64), "ix_shape_files_sha256"),
    "blobs to sweep": (lambda s: blobs.due(s, utc_now(), 10), "ix_blobs_check_after"),
    "whether a blob is read": (lambda s: blobs.is_read(s, "a" * 64), "ix_assets_sha256"),
}


ORDERED = {name for name in QUERIES if name.startswith("a page") and "batch" not in name and "labelled" not in name}
"""Lists whose index has their order already: nothing is sorted."""


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
    assert "TEMP B-TREE" not in steps or name not in ORDERED
    assert "SCAN blobs" not in steps
    assert "SCAN shapes" not in steps

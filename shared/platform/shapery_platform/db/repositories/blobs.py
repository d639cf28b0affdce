"""Queries about blobs: which bytes are stored, and whether anything still refers to them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from datetime import datetime
from typing import Any

from sqlalchemy import exists, func, literal, select, update
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from shapery_platform.db.models import LIVE_STATES, Asset, Blob, Job, JobArtifact, JobInput, ShapeFile
from shapery_platform.db.types import UtcDateTime


def upsert(session: Session, sha256: str, size: int, check_after: datetime) -> None:
    """Make sure the row exists, locked, and is not looked at by the sweep before `check_after`."""
    on_postgresql = session.get_bind().dialect.name == "postgresql"
    insert: Any = postgresql.insert if on_postgresql else sqlite.insert
    later: Any = func.greatest if on_postgresql else func.max
    statement = insert(Blob).values(sha256=sha256, size=size, check_after=check_after)
    moment = literal(check_after, UtcDateTime())
    session.execute(
        statement.on_conflict_do_update(
            index_elements=[Blob.sha256],
            # null means that something refers to it: the sweep finds that out again
            set_={"check_after": later(func.coalesce(Blob.check_after, moment), moment)},
        )
    )


def mark(session: Session, hashes: Collection[str], at: datetime) -> None:
    """Say that something stopped referring to these blobs: the sweep shall look at them from `at` on."""
    # locked in one order first: two that mark the same blobs would otherwise wait for each other
    present = lock(session, hashes)
    for some in _chunks(sorted(present)):
        session.execute(
            update(Blob)
            .where(Blob.sha256.in_(some))
            .values(check_after=func.coalesce(Blob.check_after, literal(at, UtcDateTime())))
            .execution_options(synchronize_session=False)
        )


def due(session: Session, now: datetime, limit: int) -> Sequence[str]:
    """Return blobs that the sweep shall look at."""
    return session.scalars(
        select(Blob.sha256).where(Blob.check_after <= now).order_by(Blob.check_after).limit(limit)
    ).all()


def lock_due(session: Session, sha256: str, now: datetime) -> Blob | None:
    """Lock the row of a blob if it is still due; None where it is not, or another sweep has it."""
    return session.scalars(
        select(Blob)
        .where(Blob.sha256 == sha256, Blob.check_after <= now)
        .with_for_update(skip_locked=True)
        .execution_options(populate_existing=True)
    ).one_or_none()


def is_kept(session: Session, sha256: str) -> bool:
    """Tell whether an asset that is not deleted, an artifact, or a shape refers to the blob."""
    return bool(
        session.scalar(
            select(
                exists().where(Asset.sha256 == sha256, Asset.deleted_at.is_(None))
                | exists().where(JobArtifact.sha256 == sha256)
                | exists().where(ShapeFile.sha256 == sha256)
            )
        )
    )


def is_read(session: Session, sha256: str) -> bool:
    """Tell whether a job that has not ended reads the blob as an input."""
    return bool(
        session.scalar(
            select(
                exists(
                    select(JobInput.job_id)
                    .join(Job, Job.id == JobInput.job_id)
                    .join(Asset, Asset.id == JobInput.asset_id)
                    .where(Asset.sha256 == sha256, Job.state.in_(LIVE_STATES))
                )
            )
        )
    )


def lock(session: Session, hashes: Iterable[str]) -> set[str]:
    """Lock the rows of these blobs in one order against their removal, and return those that exist."""
    present: set[str] = set()
    for some in _chunks(sorted(set(hashes))):
        present.update(
            session.scalars(select(Blob.sha256).where(Blob.sha256.in_(some)).order_by(Blob.sha256).with_for_update())
        )
    return present


def _chunks(hashes: Sequence[str], size: int = 500) -> Iterator[Sequence[str]]:
    for begin in range(0, len(hashes), size):
        yield hashes[begin : begin + size]

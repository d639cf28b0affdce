"""What an owner has: sums over jobs, assets and artifacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sqlalchemy import Row, func, select
from sqlalchemy.orm import Session

from shapery_platform.db.models import Asset, Job, JobArtifact


def jobs(session: Session, owner: str) -> Sequence[Row[Any]]:
    """Return per state: number of jobs."""
    return session.execute(
        select(Job.state, func.count().label("jobs")).where(Job.owner == owner).group_by(Job.state)
    ).all()


def assets(session: Session, owner: str) -> Sequence[Row[Any]]:
    """Return per kind: number of assets that are not deleted, and their bytes."""
    return session.execute(
        select(Asset.kind, func.count().label("files"), func.sum(Asset.size).label("bytes"))
        .where(Asset.owner == owner, Asset.deleted_at.is_(None))
        .group_by(Asset.kind)
    ).all()


def artifacts(session: Session, owner: str) -> Row[Any]:
    """Return the number of artifacts, and their bytes (null where there is none)."""
    return session.execute(
        select(func.count().label("files"), func.sum(JobArtifact.size).label("bytes"))
        .join(Job, Job.id == JobArtifact.job_id)
        .where(Job.owner == owner)
    ).one()

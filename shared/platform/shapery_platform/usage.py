"""What an owner has on the server."""

from __future__ import annotations

from sqlalchemy.orm import Session

from shapery_contracts.api import StoredView, UsageView
from shapery_contracts.formats import AssetKind
from shapery_platform.db.repositories import usage as repository


def view(session: Session, owner: str) -> UsageView:
    """Return how many jobs there are in which state, and how much is kept."""
    results = repository.artifacts(session, owner)
    return UsageView(
        jobs={row.state: row.jobs for row in repository.jobs(session, owner)},
        assets={
            AssetKind(row.kind): StoredView(files=row.files, bytes=int(row.bytes))
            for row in repository.assets(session, owner)
        },
        results=StoredView(files=results.files, bytes=int(results.bytes or 0)),
    )

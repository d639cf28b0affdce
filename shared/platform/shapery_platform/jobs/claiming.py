"""How a worker takes a job: at most one gets it, whatever the queue delivers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy.orm import Session

from shapery_contracts.states import JobAction, JobState, target_state
from shapery_platform.db import database_now
from shapery_platform.db.models import Job
from shapery_platform.db.repositories import jobs as repository
from shapery_platform.storage import object_key


@dataclass(frozen=True, slots=True)
class ClaimedInput:
    """One file that a job reads."""

    asset_id: UUID
    sha256: str
    size: int
    kind: str
    format: str
    extension: str
    filename: str
    media_type: str

    @property
    def key(self) -> str:
        """Where the store has it."""
        return object_key(self.sha256)


@dataclass(frozen=True, slots=True)
class ClaimedJob:
    """A job that its worker holds the lease of."""

    job_id: UUID
    lease: UUID
    owner: str
    kind: str
    service: str
    params: dict[str, Any]
    attempt: int
    max_attempts: int
    inputs: Mapping[str, tuple[ClaimedInput, ...]] = field(default_factory=lambda: MappingProxyType({}))


def waiting_attempt(session: Session, job_id: UUID) -> int | None:
    """Return how often a job that waits was claimed before, or None where there is nothing to claim.

    For a worker that runs a job which broke off before apart from others, and so waits before it claims.
    """
    return repository.waiting_attempt(session, job_id)


def claim(session: Session, job_id: UUID, worker_id: str) -> ClaimedJob | None:
    """Take a queued job, or return None where there is nothing to take: it runs, has ended, or was cancelled."""
    row = repository.lock(session, job_id)
    if row is None or row.state is not JobState.QUEUED:
        return None
    now = database_now(session)
    lease = uuid4()
    values = {
        "state": target_state(row.state, JobAction.CLAIM),
        "lease": lease,
        "worker_id": worker_id[:200],
        "attempt": Job.attempt + 1,
        "started_at": now,
        "heartbeat_at": now,
        "stage": "",
        "fraction": 0.0,
        "message": "",
    }
    if not repository.update_state(session, job_id, row.state, None, values, now):
        return None
    params = session.scalars(repository.params_of(job_id)).one()
    inputs: dict[str, list[ClaimedInput]] = {}
    for name, asset in repository.inputs_with_assets(session, job_id):
        inputs.setdefault(name, []).append(
            ClaimedInput(
                asset_id=asset.id,
                sha256=asset.sha256,
                size=asset.size,
                kind=asset.kind,
                format=asset.format,
                extension=asset.extension,
                filename=asset.filename,
                media_type=asset.media_type,
            )
        )
    return ClaimedJob(
        job_id=job_id,
        lease=lease,
        owner=row.owner,
        kind=row.kind,
        service=row.service,
        params=params,
        attempt=row.attempt + 1,
        max_attempts=row.max_attempts,
        inputs=MappingProxyType({name: tuple(listed) for name, listed in inputs.items()}),
    )

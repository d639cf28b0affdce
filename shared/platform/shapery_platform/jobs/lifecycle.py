"""What happens to a job after it was created. Each function is one transition of `shapery_contracts.states`.

What a worker calls takes effect only under the lease that `claim` gave: a worker that was taken for lost, and comes
back after another has taken over, changes nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import PurePosixPath
from typing import Any
from uuid import UUID

from sqlalchemy import Row
from sqlalchemy.orm import Session

from shapery_contracts.errors import ERROR_CODES, InvalidInput
from shapery_contracts.states import JobAction, JobState, target_state
from shapery_platform import blobs
from shapery_platform.db import database_now
from shapery_platform.db.models import Job
from shapery_platform.db.repositories import assets as asset_repository
from shapery_platform.db.repositories import jobs as repository
from shapery_platform.db.text import canonical_json, storable
from shapery_platform.jobs.views import get, not_found

_LONGEST_MESSAGE = 4000
_LONGEST_STAGE = 64
_LONGEST_NAME = 255


@dataclass(frozen=True, slots=True)
class NewArtifact:
    """A file that a job made and the store has by its hash."""

    name: str
    """Its path relative to the job's output folder, with forward slashes."""
    sha256: str
    size: int
    media_type: str = "application/octet-stream"


def heartbeat(session: Session, job_id: UUID, lease: UUID) -> JobState | None:
    """Say that the worker lives. ``CANCELLING`` asks it to stop; None: the lease is lost, and all work is in vain."""
    return repository.touch(session, job_id, lease, database_now(session))


def report_progress(
    session: Session,
    job_id: UUID,
    lease: UUID,
    stage: str,
    fraction: float,
    message: str = "",
    preview: bytes | None = None,
) -> JobState | None:
    """Record stage, fraction and message, which also is a heartbeat; returns what `heartbeat` returns.

    A new preview takes the place of the one before; None keeps that. The caller limits rate and size.
    """
    fraction = 0.0 if math.isnan(fraction) else min(1.0, max(0.0, fraction))
    return repository.write_progress(
        session,
        job_id,
        lease,
        storable(stage, _LONGEST_STAGE),
        fraction,
        storable(message, _LONGEST_MESSAGE),
        database_now(session),
        preview,
    )


def succeed(
    session: Session, job_id: UUID, lease: UUID, result: Mapping[str, Any], artifacts: Iterable[NewArtifact]
) -> bool:
    """End a job with its result and artifacts, all in this transaction.

    False where the lease is lost or the job is being cancelled: then call `stop`, which is harmless in both cases.

    Raises
    ------
    ValueError
        Where the result is not JSON (NaN, for instance), or artifacts have names that are empty, too long, not
        relative, or not different from each other: defects of the handler.
    """
    listed = sorted(artifacts, key=lambda artifact: artifact.sha256)
    _check_names([artifact.name for artifact in listed])
    canonical_json(result)
    row = repository.lock(session, job_id, lease=lease)
    if row is None or row.state is not JobState.RUNNING:
        return False
    now = database_now(session)
    values = {**_ended(row, now), "result": dict(result), "fraction": 1.0, "message": ""}
    if not _change(session, row, JobAction.SUCCEED, values, now):
        return False
    for artifact in listed:
        # the row must exist before an artifact can refer to it, and stays locked until this commits
        blobs.pin(session, artifact.sha256, artifact.size)
    repository.add_artifacts(
        session,
        (
            {
                "job_id": job_id,
                "name": artifact.name,
                "sha256": artifact.sha256,
                "size": artifact.size,
                "media_type": artifact.media_type,
            }
            for artifact in listed
        ),
    )
    return True


def fail(session: Session, job_id: UUID, lease: UUID, code: str, message: str, hint: str = "") -> bool:
    """End a job with what the user can mend. False as in `succeed`."""
    row = repository.lock(session, job_id, lease=lease)
    if row is None or row.state is not JobState.RUNNING:
        return False
    now = database_now(session)
    return _change(session, row, JobAction.FAIL, {**_ended(row, now), **_error(code, message, hint)}, now)


def stop(session: Session, job_id: UUID, lease: UUID) -> bool:
    """End a job that was cancelled, after its work has stopped. False where the lease is lost or nobody cancelled."""
    row = repository.lock(session, job_id, lease=lease)
    if row is None or row.state is not JobState.CANCELLING:
        return False
    now = database_now(session)
    return _change(session, row, JobAction.STOP, _ended(row, now), now)


def crash_or_requeue(
    session: Session, job_id: UUID, lease: UUID, reason: str, code: str = "internal_error"
) -> JobState | None:
    """Give a job back whose work broke by a fault of ours, or end it as crashed when that happened too often.

    Returns
    -------
    The new state (``QUEUED``: send its message again), or None where the lease is lost.
    """
    row = repository.lock(session, job_id, lease=lease)
    return None if row is None else give_back(session, row, reason, code, database_now(session))


def release(session: Session, job_id: UUID, lease: UUID) -> JobState | None:
    """Give a job back whose worker is asked to go, without counting the attempt; returns as `crash_or_requeue`."""
    row = repository.lock(session, job_id, lease=lease)
    if row is None:
        return None
    now = database_now(session)
    if row.state is JobState.CANCELLING:
        return JobState.CANCELLED if _change(session, row, JobAction.STOP, _ended(row, now), now) else None
    values = {**_requeued(""), "attempt": Job.attempt - 1}
    return JobState.QUEUED if _change(session, row, JobAction.REQUEUE, values, now) else None


def give_back(session: Session, row: Row[Any], reason: str, code: str, now: datetime) -> JobState | None:
    """Requeue, crash or stop the locked job of a worker that cannot go on."""
    if row.state is JobState.CANCELLING:
        return JobState.CANCELLED if _change(session, row, JobAction.STOP, _ended(row, now), now) else None
    if row.attempt < row.max_attempts:
        values = _requeued(f"Attempt {row.attempt} of {row.max_attempts} broke off: {reason}")
        return JobState.QUEUED if _change(session, row, JobAction.REQUEUE, values, now) else None
    times = "once" if row.attempt == 1 else f"{row.attempt} times"
    error = _error(
        code, f"The job was tried {times} and broke off each time: {reason}", "The fault is ours; it may be retried."
    )
    return JobState.CRASHED if _change(session, row, JobAction.CRASH, {**_ended(row, now), **error}, now) else None


def cancel(session: Session, owner: str, job_id: UUID) -> Job:
    """Cancel a job: at once where it waits, as soon as its worker notices where it runs.

    Raises
    ------
    UserError
        ``not_found``, or ``invalid_transition`` where it has ended.
    """
    row = repository.lock(session, job_id, owner=owner)
    if row is None:
        raise not_found(job_id)
    target = target_state(row.state, JobAction.CANCEL)
    if target is not row.state:
        now = database_now(session)
        changed = _change(session, row, JobAction.CANCEL, _ended(row, now) if target.terminal else {}, now)
        assert changed, "the row is locked"
    return get(session, owner, job_id)


def retry(session: Session, owner: str, job_id: UUID) -> Job:
    """Queue a job again that failed, crashed or was cancelled.

    Raises
    ------
    UserError
        ``not_found``, ``invalid_transition``, or ``input_expired`` where an input was deleted.
    """
    row = repository.lock(session, job_id, owner=owner)
    if row is None:
        raise not_found(job_id)
    target_state(row.state, JobAction.RETRY)
    wanted = set(session.scalars(repository.input_ids([job_id])))
    missing = wanted - asset_repository.for_use(session, owner, wanted).keys()
    if missing:
        raise InvalidInput(
            "input_expired",
            f"{len(missing)} of the job's {len(wanted)} inputs have been deleted.",
            "Upload them again and create a new job.",
        )
    now = database_now(session)
    changed = _change(session, row, JobAction.RETRY, retried(), now)
    assert changed, "the row is locked"
    return get(session, owner, job_id)


def retried() -> dict[str, Any]:
    """Return the columns of a job that begins anew."""
    return {
        **_requeued(""),
        "attempt": 0,
        "started_at": None,
        "finished_at": None,
        "took": -1.0,
        "expires_at": None,
        "expired": False,
        "result": None,
        "error_code": None,
        "error_message": None,
        "error_hint": None,
    }


def _change(session: Session, row: Row[Any], action: JobAction, values: Mapping[str, Any], now: datetime) -> bool:
    values = {**values, "state": target_state(row.state, action)}
    return repository.update_state(session, row.id, row.state, row.lease, values, now)


def _ended(row: Row[Any], now: datetime) -> dict[str, Any]:
    return {
        "lease": None,
        "heartbeat_at": None,
        "finished_at": now,
        "took": -1.0 if row.started_at is None else (now - row.started_at).total_seconds(),
        "expires_at": now + timedelta(seconds=row.result_ttl),
    }


def _requeued(message: str) -> dict[str, Any]:
    return {
        "lease": None,
        "worker_id": None,
        "heartbeat_at": None,
        "enqueued_at": None,
        "stage": "",
        "fraction": 0.0,
        "message": storable(message, _LONGEST_MESSAGE),
    }


def _check_names(names: Sequence[str]) -> None:
    for name in names:
        path = PurePosixPath(name)
        if not 0 < len(name) <= _LONGEST_NAME or path.is_absolute() or ".." in path.parts or storable(name) != name:
            raise ValueError(f"an artifact cannot be called {name!r}")
    if len(set(names)) != len(names):
        raise ValueError(f"two artifacts have the same name: {sorted(names)}")


def _error(code: str, message: str, hint: str) -> dict[str, Any]:
    if code not in ERROR_CODES:
        raise ValueError(f"unregistered error code {code!r}")
    return {
        "error_code": code,
        "error_message": storable(message, _LONGEST_MESSAGE),
        "error_hint": storable(hint, _LONGEST_MESSAGE),
    }

"""Job states and the one table of transitions between them.

Nothing else in the project decides whether a job may change its state: the repository asks `target_state` and writes
the change with the expected source state in its condition, so that two writers can never both succeed.
"""

from __future__ import annotations

from enum import StrEnum
from types import MappingProxyType
from typing import Final

from shapery_contracts.errors import UserError


class JobState(StrEnum):
    """Where a job is; see `TRANSITIONS`."""

    QUEUED = "queued"
    RUNNING = "running"
    CANCELLING = "cancelling"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CRASHED = "crashed"
    CANCELLED = "cancelled"

    @property
    def terminal(self) -> bool:
        """Whether nothing but a retry by the user leads out of this state."""
        return self in TERMINAL_STATES


class JobAction(StrEnum):
    """What can happen to a job."""

    CLAIM = "claim"
    """A worker takes it."""
    SUCCEED = "succeed"
    FAIL = "fail"
    """The user's to mend: a code, a message and a hint are stored."""
    CRASH = "crash"
    """Ours, after the bounded number of tries."""
    REQUEUE = "requeue"
    """Its worker was lost; another shall take it."""
    CANCEL = "cancel"
    """The user no longer wants it."""
    STOP = "stop"
    """Its worker has stopped after a cancel, or was lost before it could."""
    RETRY = "retry"
    """The user wants it again."""


TERMINAL_STATES: Final = frozenset({JobState.SUCCEEDED, JobState.FAILED, JobState.CRASHED, JobState.CANCELLED})

TRANSITIONS: Final = MappingProxyType(
    {
        (JobState.QUEUED, JobAction.CLAIM): JobState.RUNNING,
        (JobState.RUNNING, JobAction.SUCCEED): JobState.SUCCEEDED,
        (JobState.RUNNING, JobAction.FAIL): JobState.FAILED,
        (JobState.RUNNING, JobAction.CRASH): JobState.CRASHED,
        (JobState.RUNNING, JobAction.REQUEUE): JobState.QUEUED,
        (JobState.QUEUED, JobAction.CANCEL): JobState.CANCELLED,
        (JobState.RUNNING, JobAction.CANCEL): JobState.CANCELLING,
        (JobState.CANCELLING, JobAction.CANCEL): JobState.CANCELLING,
        (JobState.CANCELLING, JobAction.STOP): JobState.CANCELLED,
        (JobState.FAILED, JobAction.RETRY): JobState.QUEUED,
        (JobState.CRASHED, JobAction.RETRY): JobState.QUEUED,
        (JobState.CANCELLED, JobAction.RETRY): JobState.QUEUED,
    }
)


def sources(action: JobAction) -> frozenset[JobState]:
    """Return the states from which `action` is possible."""
    return frozenset(state for state, possible in TRANSITIONS if possible is action)


def target_state(state: JobState, action: JobAction) -> JobState:
    """Return the state that `action` leads to from `state`.

    Raises
    ------
    UserError
        ``invalid_transition`` where the table has no such entry.
    """
    try:
        return TRANSITIONS[state, action]
    except KeyError:
        allowed = ", ".join(sorted(sources(action)))
        raise UserError(
            "invalid_transition",
            f"A job that is {state} cannot {action}.",
            f"This is possible for a job that is {allowed}.",
        ) from None

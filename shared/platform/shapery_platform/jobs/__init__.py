"""Jobs: the only writer of their state.

Every function takes a session and never commits. Functions for users name the owner, and a job of somebody else does
not exist for them; functions for workers name the lease that `claim` gave, and tell whether they took effect.
"""

from shapery_platform.jobs.claiming import ClaimedInput, ClaimedJob, claim, waiting_attempt
from shapery_platform.jobs.creation import create
from shapery_platform.jobs.lifecycle import (
    NewArtifact,
    cancel,
    crash_or_requeue,
    fail,
    heartbeat,
    release,
    report_progress,
    retry,
    stop,
    succeed,
)
from shapery_platform.jobs.recovery import mark_enqueued, queued_without_message, recover_lost
from shapery_platform.jobs.views import Preview, artifact, events_after, get, list_jobs, preview, view

__all__ = [
    "ClaimedInput",
    "ClaimedJob",
    "NewArtifact",
    "Preview",
    "artifact",
    "cancel",
    "claim",
    "crash_or_requeue",
    "create",
    "events_after",
    "fail",
    "get",
    "heartbeat",
    "list_jobs",
    "mark_enqueued",
    "preview",
    "queued_without_message",
    "recover_lost",
    "release",
    "report_progress",
    "retry",
    "stop",
    "succeed",
    "view",
    "waiting_attempt",
]

"""Tells what the server can do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from shapery_contracts.api import JobKindView, ServerInfo
from shapery_contracts.kinds import JOB_KINDS, InputSpec, JobKind
from shapery_gateway import __version__
from shapery_platform.settings import Settings


def describe_input(spec: InputSpec) -> dict[str, Any]:
    """Return what an input of a job kind takes."""
    return {
        "kinds": sorted(spec.kinds),
        "description": spec.description,
        "required": spec.required,
        "many": spec.many,
    }


def describe_kind(kind: JobKind, settings: Settings, workers: int) -> JobKindView:
    """Return what is known of a job kind, with the limits that hold on this server."""
    return JobKindView(
        name=kind.name,
        service=kind.service,
        summary=kind.summary,
        inputs={name: describe_input(spec) for name, spec in kind.inputs.items()},
        params_schema=kind.params.model_json_schema(),
        result_schema=kind.result.model_json_schema(mode="serialization"),
        stages=list(kind.stages),
        time_limit=settings.job_time_limit.get(kind.name, kind.time_limit),
        memory_limit=settings.job_memory_limit.get(kind.name, kind.memory_limit),
        workers=workers,
    )


def kinds(settings: Settings, workers: Mapping[str, int]) -> list[JobKindView]:
    """Return all job kinds by name; `workers` counts the live ones per kind."""
    return [describe_kind(JOB_KINDS[name], settings, workers.get(name, 0)) for name in sorted(JOB_KINDS)]


def info(settings: Settings) -> ServerInfo:
    """Return the server's version, how one signs in, and its limits."""
    assert settings.auth is not None
    return ServerInfo(
        version=__version__,
        auth=settings.auth,
        max_upload_bytes=settings.max_upload_bytes,
        max_batch_items=settings.max_batch_items,
        result_ttl_seconds=settings.result_ttl,
        upload_ttl_seconds=settings.upload_ttl,
    )

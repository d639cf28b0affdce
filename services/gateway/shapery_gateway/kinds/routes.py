"""``/v1/kinds``, ``/v1/usage`` and ``/v1/info``."""

from __future__ import annotations

from fastapi import APIRouter

from shapery_contracts.api import JobKindView, ServerInfo, UsageView
from shapery_gateway.dependencies import BackendDep, PublicCaller, Reader, ReadSession
from shapery_gateway.kinds import service
from shapery_gateway.openapi import COMMON_PROBLEMS, problems
from shapery_platform import usage, workers

router = APIRouter(prefix="/v1", tags=["server"])


@router.get(
    "/kinds",
    operation_id="listKinds",
    summary="What jobs there are",
    responses=problems(*COMMON_PROBLEMS),
)
def list_kinds(backend: BackendDep, session: ReadSession, _: Reader) -> list[JobKindView]:
    """Each kind's inputs, parameters and result as JSON schemas, its limits, and how many workers serve it now."""
    return service.kinds(backend.settings, workers.live_by_kind(session, backend.settings))


@router.get(
    "/usage",
    operation_id="getUsage",
    summary="What you have on the server",
    responses=problems(*COMMON_PROBLEMS),
)
def get_usage(session: ReadSession, caller: Reader) -> UsageView:
    """Your jobs by state, and what your uploads and results take."""
    return usage.view(session, caller.owner)


@router.get(
    "/info",
    operation_id="getInfo",
    summary="Version and limits of the server",
    dependencies=[PublicCaller],
    responses=problems("rate_limited"),
)
def get_info(backend: BackendDep) -> ServerInfo:
    """Needs no key, since it tells whether one is needed."""
    return service.info(backend.settings)

"""``/healthz``, ``/readyz`` and ``/metrics``."""

from __future__ import annotations

from typing import Literal

from anyio.to_thread import run_sync
from fastapi import APIRouter, Response
from pydantic import BaseModel

from shapery_gateway.dependencies import BackendDep
from shapery_gateway.health.service import ReadyView
from shapery_gateway.metrics import CONTENT_TYPE
from shapery_gateway.openapi import problems
from shapery_gateway.problems import ProblemError

router = APIRouter(tags=["health"])


class HealthView(BaseModel):
    """The process answers."""

    status: Literal["ok"] = "ok"


@router.get("/healthz", operation_id="getHealth", summary="Whether the process answers")
async def get_health() -> HealthView:
    """Answers as long as the process runs, whatever else is down. For a liveness probe."""
    return HealthView()


@router.get(
    "/readyz",
    operation_id="getReadiness",
    summary="Whether requests can be served",
    responses=problems("service_unavailable"),
)
async def get_readiness(backend: BackendDep) -> ReadyView:
    """Asks the database, the queue and the object store. For a readiness probe.

    The queue being down does not make the gateway refuse jobs (they are kept in the database and sent later), but it
    is told here, since nothing would run.
    """
    if backend.closing:
        raise ProblemError("service_unavailable", "The server is shutting down.")
    view = await backend.readiness.view()
    if view.status == "down":
        down = sorted(name for name, check in view.checks.items() if check.status == "down")
        raise ProblemError(
            "service_unavailable",
            f"Not answering: {', '.join(down)}.",
            checks={name: check.model_dump() for name, check in view.checks.items()},
        )
    return view


@router.get(
    "/metrics",
    operation_id="getMetrics",
    summary="Metrics for Prometheus",
    response_class=Response,
    responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}, "description": "Metrics as text."}},
)
async def get_metrics(backend: BackendDep) -> Response:
    """Tell requests by route, queue lengths, jobs by state, live workers; no names, ids or secrets."""
    text = await run_sync(backend.metrics.render)
    return Response(text, headers={"Content-Type": CONTENT_TYPE})

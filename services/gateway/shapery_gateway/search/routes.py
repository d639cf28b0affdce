"""``/v1/search``."""

from __future__ import annotations

from typing import Annotated, Any
from uuid import UUID

from fastapi import APIRouter, Body, Query
from starlette.responses import JSONResponse, Response

from shapery_contracts.api import JobView
from shapery_contracts.shapes import SearchAnswer, SearchRequest
from shapery_gateway.dependencies import BackendDep, Reader
from shapery_gateway.http.parameters import IdempotencyKey
from shapery_gateway.jobs.routes import CREATION_PROBLEMS
from shapery_gateway.openapi import COMMON_PROBLEMS, problems
from shapery_gateway.search import service

router = APIRouter(prefix="/v1/search", tags=["shapes"])

_EXAMPLES: Any = {
    "stored": {
        "summary": "Like a stored shape, within a collection",
        "value": {"shape_id": "01890a5d-ac96-774b-bcce-b302099a8057", "collection": "bones", "limit": 10},
    },
    "uploaded": {
        "summary": "What contains a part like this mesh",
        "value": {"asset_id": "01890a5d-ac96-774b-bcce-b302099a8058", "mode": "partial"},
    },
}
_LATER: dict[int | str, dict[str, Any]] = {
    202: {
        "model": JobView,
        "description": "The job that searches; its address is `Location`, that of the answer `/v1/search/{job_id}`.",
        "headers": {"Location": {"description": "The job's address.", "schema": {"type": "string"}}},
    }
}


@router.post(
    "",
    operation_id="search",
    summary="Find shapes like an example",
    response_model=SearchAnswer,
    responses={
        **_LATER,
        **problems(*COMMON_PROBLEMS, *CREATION_PROBLEMS, "conflict", "input_expired", "service_unavailable"),
    },
)
async def search(
    backend: BackendDep,
    caller: Reader,
    request: Annotated[SearchRequest, Body(openapi_examples=_EXAMPLES)],
    wait: Annotated[float, Query(ge=0, le=30, description="Seconds to wait for the answer before a job is shown.")] = (
        service.WAIT_SECONDS
    ),
    idempotency_key: IdempotencyKey = None,
) -> Any:
    """Answer a query by a stored shape at once; an uploaded mesh is indexed first, in a job, which needs `write`.

    What takes longer than `wait` is answered with the job: follow it, then ask `/v1/search/{job_id}`.
    """
    return _answer(await service.search(backend, caller, request, wait, idempotency_key))


@router.get(
    "/{job_id}",
    operation_id="getSearch",
    summary="What a search's job has found",
    response_model=SearchAnswer,
    responses={**_LATER, **problems(*COMMON_PROBLEMS, "not_found", "gone")},
)
async def get_search(backend: BackendDep, caller: Reader, job_id: UUID) -> Any:
    """Return the answer, or the job as long as it has none. Shapes that were deleted meanwhile are left out."""
    return _answer(await service.get(backend, caller, job_id))


def _answer(found: SearchAnswer | JobView) -> Response:
    # written here: with a model FastAPI would go through hundreds of matched parts twice more
    if isinstance(found, SearchAnswer):
        return Response(found.model_dump_json(), media_type="application/json")
    return JSONResponse(found.model_dump(mode="json"), 202, headers={"Location": f"/v1/jobs/{found.id}"})

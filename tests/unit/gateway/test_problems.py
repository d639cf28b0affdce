from __future__ import annotations

import json
from typing import Any

import pytest
from fastapi.exceptions import RequestValidationError
from starlette.responses import Response

from shapery_contracts.api import Problem
from shapery_contracts.errors import ERROR_CODES
from shapery_gateway.problems import MAX_FIELD_PROBLEMS, _handle_validation, problem_response


def scope() -> dict[str, Any]:
    return {"type": "http", "method": "GET", "path": "/v1/x", "headers": [], "state": {"request_id": "r1"}}


def body(response: Response) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads(bytes(response.body))
    return loaded


@pytest.mark.parametrize("code", sorted(ERROR_CODES))
def test_every_code_makes_a_problem(code: str) -> None:
    response = problem_response(scope(), code, "It is so.", "Do this.")
    assert response.status_code == ERROR_CODES[code].status
    assert response.headers["content-type"] == "application/problem+json"
    problem = Problem.model_validate(body(response))
    assert (problem.code, problem.status, problem.instance, problem.request_id) == (
        code,
        response.status_code,
        "/v1/x",
        "r1",
    )


def test_text_that_cannot_be_encoded_is_told_all_the_same() -> None:
    response = problem_response(scope(), "bad_request", "half a pair: \ud800")
    assert body(response)["detail"] == "half a pair: \ud800"


def test_validation_tells_places_and_not_values() -> None:
    import asyncio

    from starlette.requests import Request

    errors = [
        {"loc": ("body", "items", i), "msg": "wrong", "input": "a secret", "type": "x"}
        for i in range(MAX_FIELD_PROBLEMS + 20)
    ]
    response = asyncio.run(_handle_validation(Request(scope()), RequestValidationError(errors)))
    told = body(response)
    assert len(told["errors"]) == MAX_FIELD_PROBLEMS
    assert told["error_count"] == MAX_FIELD_PROBLEMS + 20
    assert told["errors"][1] == {"location": "body.items.1", "message": "wrong"}
    assert "secret" not in str(told)

"""The whole interface, called as its own description says, and as it says one must not: no fault of ours, and every
answer is one that is described."""

from __future__ import annotations

import json

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, settings
from schemathesis.checks import CHECKS, load_all_checks

from tests.conftest import ROOT
from tests.contract.conftest import World

pytestmark = pytest.mark.server

load_all_checks()
UNUSED = CHECKS.get_by_names(
    [
        # what is well-formed may still be wrong: an unknown kind, an id of nothing, bytes that are no volume
        "positive_data_acceptance",
        # what a test deleted is not there for the next one, and that is tested on its own
        "use_after_free",
        "ensure_resource_availability",
        # sends one wrong key beside the right one, where either will do; `tests/integration/gateway/test_keys.py` asks
        # every route
        "ignored_auth",
    ]
)
REFUSALS = [400, 401, 403, 404, 405, 406, 409, 410, 411, 412, 413, 415, 416, 422, 423]
CONFIG = schemathesis.Config.from_dict(
    {
        "checks": {
            "negative_data_rejection": {"expected-statuses": REFUSALS},
            "missing_required_header": {"expected-statuses": REFUSALS},
        }
    }
)


@schemathesis.serializer("application/x-ndjson")
def as_lines(context: schemathesis.SerializationContext, value: object) -> bytes:
    """Send text as it is and anything else as lines of JSON."""
    if isinstance(value, str | bytes):
        return value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value
    rows = value if isinstance(value, list) else [value]
    return "".join(json.dumps(row, default=str) + "\n" for row in rows).encode()


@schemathesis.serializer("application/offset+octet-stream")
def as_bytes(context: schemathesis.SerializationContext, value: object) -> bytes:
    """Send bytes as they are."""
    return value if isinstance(value, bytes) else str(value).encode("utf-8", "replace")


# as it is recorded, which `tests/unit/gateway/test_schema.py` compares with the code
schema = schemathesis.openapi.from_path(ROOT / "api_schema" / "openapi.json", config=CONFIG)
bounded = settings(
    max_examples=10,
    derandomize=True,
    database=None,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)


def without_waiting(case: schemathesis.Case) -> schemathesis.Case:
    """Let no search wait for its job, which nobody runs here; what is no valid time stays."""
    wait = (case.query or {}).get("wait", 0)
    if case.path == "/v1/search" and isinstance(wait, int | float) and not isinstance(wait, bool) and 0 <= wait <= 30:
        case.query = {**(case.query or {}), "wait": 0}
    return case


@schema.parametrize()
@bounded
def test_as_a_stranger_would(case: schemathesis.Case, world: World) -> None:
    """Whatever fits the description or nearly does; ids lead to nothing."""
    without_waiting(case).call_and_validate(
        base_url=world.url, headers={"X-API-Key": world.secret}, excluded_checks=UNUSED, timeout=20
    )


# what is deleted here would be missed by the others
@schema.include(path_regex="{").exclude(operation_id_regex="^delete").parametrize()
@bounded
def test_on_what_is_there(case: schemathesis.Case, world: World) -> None:
    """The same on things that exist, so that more than 404 is answered."""
    ids = {**world.ids, "job_id": world.ids["search_id"]} if case.path.startswith("/v1/search") else world.ids
    known = {name: ids[name] for name in case.path_parameters or {} if name in ids}
    case.path_parameters = {**(case.path_parameters or {}), **known}
    # With an id that exists a case may be right although it was made to be wrong.
    unused = [*UNUSED, *CHECKS.get_by_names(["negative_data_rejection"])] if known else UNUSED
    case.call_and_validate(base_url=world.url, headers={"X-API-Key": world.secret}, excluded_checks=unused, timeout=20)

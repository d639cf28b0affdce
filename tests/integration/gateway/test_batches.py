from __future__ import annotations

import json
from uuid import UUID, uuid4

import httpx
import pytest

from shapery_platform import watching
from tests.integration.gateway.conftest import Make, Platform, Serve, upload

pytestmark = pytest.mark.server

NDJSON = {"Content-Type": "application/x-ndjson"}


def as_lines(header: dict[str, object], items: list[dict[str, object]]) -> bytes:
    return "".join(json.dumps(row) + "\n" for row in [header, *items]).encode()


def results(client: httpx.Client, batch_id: str) -> list[dict[str, dict[str, object]]]:
    response = client.get(f"/v1/batches/{batch_id}/results")
    assert response.status_code == 200
    assert response.headers["content-type"] == "application/x-ndjson"
    return [json.loads(line) for line in response.text.splitlines()]


@pytest.mark.parametrize("form", ["json", "ndjson"])
def test_a_batch(platform: Platform, http: httpx.Client, form: str) -> None:
    asset = upload(http)["id"]
    items: list[dict[str, object]] = [{"inputs": {"post": asset}, "params": {"max_objects": n}} for n in (1, 2, 3)]
    header: dict[str, object] = {"kind": "segmentation", "params": {"smoothing": 0.5}}
    if form == "json":
        response = http.post("/v1/batches", json={**header, "items": items})
    else:
        response = http.post("/v1/batches", content=as_lines(header, items), headers=NDJSON)
    assert response.status_code == 202, response.text
    batch = response.json()
    assert response.headers["location"] == f"/v1/batches/{batch['id']}"
    assert http.get(response.headers["location"]).json() == batch
    assert (batch["total"], batch["counts"]["queued"], batch["finished"]) == (3, 3, False)
    found = results(http, batch["id"])
    assert [row["index"] for row in found] == [0, 1, 2]
    assert [row["job"]["params"]["max_objects"] for row in found] == [1, 2, 3]  # type: ignore[index]
    assert {row["job"]["params"]["smoothing"] for row in found} == {0.5}  # type: ignore[index]
    assert {row["job"]["batch_id"] for row in found} == {batch["id"]}

    ids = [str(row["job"]["id"]) for row in found]
    platform.succeed(ids[0], {"report.json": b"{}"})
    platform.fail(ids[1])
    counts = http.get(f"/v1/batches/{batch['id']}").json()["counts"]
    assert (counts["succeeded"], counts["failed"], counts["queued"]) == (1, 1, 1)
    cancelled = http.post(f"/v1/batches/{batch['id']}/cancel").json()
    assert cancelled["finished"]
    assert (cancelled["counts"]["cancelled"], cancelled["counts"]["succeeded"]) == (1, 1)
    retried = http.post(f"/v1/batches/{batch['id']}/retry").json()
    assert retried["counts"]["queued"] == 1, "what failed, and neither what was cancelled nor what succeeded"
    assert {job["id"] for job in http.get("/v1/jobs", params={"batch_id": batch["id"]}).json()["items"]} == set(ids)


def test_all_or_nothing(http: httpx.Client) -> None:
    asset = upload(http)["id"]
    items: list[dict[str, object]] = [{"inputs": {"post": asset}}, {"inputs": {"post": str(uuid4())}}]
    response = http.post("/v1/batches", json={"kind": "segmentation", "items": items})
    assert response.status_code == 404
    assert "1" in response.json()["detail"]
    assert http.get("/v1/jobs").json()["items"] == []
    assert http.get("/v1/batches").json()["items"] == []


@pytest.mark.parametrize(
    ("body", "headers", "status"),
    [
        (b'{"kind": "segmentation", "items": []}', {"Content-Type": "application/json"}, 422),
        (b'{"kind": "segmentation"}', {"Content-Type": "application/json"}, 422),
        (b"{", {"Content-Type": "application/json"}, 422),
        (b'{"kind": "x", "items": [{"inputs": {}}]}', {"Content-Type": "application/json"}, 422),
        (b"", NDJSON, 422),
        (b'{"kind": "segmentation"}\n', NDJSON, 422),
        (b'{"kind": "segmentation"}\nnonsense\n', NDJSON, 422),
        (b"{}", {"Content-Type": "text/plain"}, 415),
        (b"{}", {}, 415),
    ],
)
def test_wrong_bodies(local: httpx.Client, body: bytes, headers: dict[str, str], status: int) -> None:
    response = local.post("/v1/batches", content=body, headers=headers)
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"


def test_too_many_items(local_settings: Make, serve: Serve) -> None:
    platform = serve(local_settings(max_batch_items=5))
    with platform.client() as client:
        item: dict[str, object] = {"inputs": {"post": upload(client)["id"]}}
        for body, headers in (
            (as_lines({"kind": "segmentation"}, [item] * 6), NDJSON),
            (
                json.dumps({"kind": "segmentation", "items": [item] * 6}).encode(),
                {"Content-Type": "application/json"},
            ),
        ):
            response = client.post("/v1/batches", content=body, headers=headers)
            assert (response.status_code, response.json()["code"]) == (413, "too_large")
        assert client.post(
            "/v1/batches", content=as_lines({"kind": "segmentation"}, [item] * 5), headers=NDJSON
        ).is_success


def test_idempotency(http: httpx.Client) -> None:
    item: dict[str, object] = {"inputs": {"post": upload(http)["id"]}}
    headers = {**NDJSON, "Idempotency-Key": "nightly"}
    first, again = (
        http.post("/v1/batches", content=as_lines({"kind": "segmentation"}, [item, item]), headers=headers).json()
        for _ in range(2)
    )
    assert first["id"] == again["id"]
    other = http.post("/v1/batches", content=as_lines({"kind": "segmentation"}, [item]), headers=headers)
    assert (other.status_code, other.json()["code"]) == (409, "idempotency_conflict")


def test_lists_and_unknown_ones(local: httpx.Client) -> None:
    item: dict[str, object] = {"inputs": {"post": upload(local)["id"]}}
    made = [local.post("/v1/batches", json={"kind": "segmentation", "items": [item]}).json()["id"] for _ in range(3)]
    page = local.get("/v1/batches", params={"limit": 2}).json()
    assert [batch["id"] for batch in page["items"]] == made[:0:-1]
    rest = local.get("/v1/batches", params={"cursor": page["next_cursor"]}).json()
    assert [batch["id"] for batch in rest["items"]] == made[:1]
    for method, path in [
        ("GET", ""),
        ("GET", "/results"),
        ("GET", "/events"),
        ("POST", "/cancel"),
        ("POST", "/retry"),
    ]:
        assert local.request(method, f"/v1/batches/{uuid4()}{path}").status_code == 404


def test_a_large_batch(local_platform: Platform, local: httpx.Client) -> None:
    """More than a page of results, and more items than one statement inserts."""
    item: dict[str, object] = {"inputs": {"post": upload(local)["id"]}}
    response = local.post("/v1/batches", content=as_lines({"kind": "segmentation"}, [item] * 1200), headers=NDJSON)
    assert response.status_code == 202
    batch = response.json()
    assert [row["index"] for row in results(local, batch["id"])] == list(range(1200))
    with local_platform.database.session(readonly=True) as session:
        event = watching.batch_events(session, [UUID(batch["id"])])[UUID(batch["id"])]
    assert event.counts["queued"] == 1200  # type: ignore[index]

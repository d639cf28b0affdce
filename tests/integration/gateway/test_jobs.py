from __future__ import annotations

import json
from datetime import timedelta
from urllib.parse import quote
from uuid import UUID, uuid4

import httpx
import pytest
from sqlalchemy import update

from shapery_platform import jobs, retention
from shapery_platform.db import utc_now
from shapery_platform.db.models import Job
from tests.integration.gateway.conftest import Platform, submit, upload
from tests.support.gateway import nifti, raw_request, triangle

pytestmark = pytest.mark.server


def test_a_job_is_there_when_it_is_told_of(http: httpx.Client) -> None:
    asset = upload(http)
    for _ in range(20):
        response = http.post("/v1/jobs", json={"kind": "segmentation", "inputs": {"post": asset["id"]}})
        assert response.status_code == 202
        told = response.json()
        assert response.headers["location"] == f"/v1/jobs/{told['id']}"
        assert http.get(response.headers["location"]).json() == told
    assert told["state"] == "queued"
    assert told["params"]["max_objects"] == 8, "defaults are filled in"


@pytest.mark.parametrize(
    ("change", "status", "code"),
    [
        ({"kind": "nonsense"}, 422, "unknown_job_kind"),
        ({"params": {"max_objects": 0}}, 422, "invalid_params"),
        ({"params": {"unknown": 1}}, 422, "invalid_params"),
        ({"params": {"a": "\0"}}, 422, "validation_failed"),
        ({"inputs": {}}, 422, "missing_input"),
        ({"inputs": {"post": str(uuid4())}}, 404, "not_found"),
        ({"inputs": {"post": "x"}}, 422, "validation_failed"),
        ({"inputs": {"post": []}}, 422, "validation_failed"),
        ({"more": 1}, 422, "validation_failed"),
        ({"kind": 1}, 422, "validation_failed"),
    ],
)
def test_requests_that_are_wrong(local: httpx.Client, change: dict[str, object], status: int, code: str) -> None:
    request = {"kind": "segmentation", "inputs": {"post": upload(local)["id"]}, **change}
    response = local.post("/v1/jobs", json=request)
    assert (response.status_code, response.json()["code"]) == (status, code)
    assert local.get("/v1/jobs").json()["items"] == []


def test_an_input_of_the_wrong_kind(local: httpx.Client) -> None:
    mesh = upload(local, triangle(), "a.obj")
    response = local.post("/v1/jobs", json={"kind": "segmentation", "inputs": {"post": mesh["id"]}})
    assert (response.status_code, response.json()["code"]) == (422, "wrong_input_kind")


@pytest.mark.parametrize(
    "body", [b"", b"{", b"null", b"[]", b"\xff", b"[" * 100_000, b'{"kind": "\\ud800", "inputs": {}}', b"1" * 5000]
)
def test_bodies_that_are_no_json(local: httpx.Client, body: bytes) -> None:
    response = local.post("/v1/jobs", content=body, headers={"Content-Type": "application/json"})
    assert response.status_code in {400, 422}
    assert response.json()["code"] in {"bad_request", "validation_failed", "unknown_job_kind"}


def test_numbers_that_are_not_finite(local: httpx.Client) -> None:
    asset = upload(local)["id"]
    for value in ("NaN", "Infinity", "1e999"):
        body = f'{{"kind": "segmentation", "inputs": {{"post": "{asset}"}}, "params": {{"edge_length": {value}}}}}'
        response = local.post("/v1/jobs", content=body, headers={"Content-Type": "application/json"})
        assert response.status_code == 422, value


def test_idempotency(http: httpx.Client) -> None:
    asset = upload(http)
    first = submit(http, asset, **{"Idempotency-Key": "run 1"})
    again = submit(http, asset, **{"Idempotency-Key": "run 1"})
    other = submit(http, asset, **{"Idempotency-Key": "run 2"})
    assert first["id"] == again["id"] != other["id"]
    request = {"kind": "segmentation", "inputs": {"post": asset["id"]}, "params": {"max_objects": 2}}
    conflict = http.post("/v1/jobs", json=request, headers={"Idempotency-Key": "run 1"})
    assert (conflict.status_code, conflict.json()["code"]) == (409, "idempotency_conflict")
    assert http.post("/v1/jobs", json=request, headers={"Idempotency-Key": "k" * 256}).status_code == 422


def test_lists(platform: Platform, http: httpx.Client) -> None:
    asset = upload(http)
    made = [submit(http, asset)["id"] for _ in range(5)]
    platform.succeed(made[0])
    platform.fail(made[1])
    seen, cursor = [], None
    while True:
        page = http.get("/v1/jobs", params={"limit": 2, **({"cursor": cursor} if cursor else {})}).json()
        seen += [job["id"] for job in page["items"]]
        cursor = page["next_cursor"]
        if cursor is None:
            break
    assert seen == made[::-1]
    ids = lambda **query: [job["id"] for job in http.get("/v1/jobs", params=query).json()["items"]]  # noqa: E731
    assert ids(state="succeeded") == made[:1]
    assert ids(state="queued") == made[:1:-1]
    assert ids(kind="segmentation", limit=200) == made[::-1]
    assert ids(kind="other") == []
    assert ids(batch_id=str(uuid4())) == []
    assert http.get("/v1/jobs", params={"state": "odd"}).status_code == 422


def test_a_failure_says_why(platform: Platform, http: httpx.Client) -> None:
    job = submit(http)
    platform.fail(job["id"])
    shown = http.get(f"/v1/jobs/{job['id']}").json()
    assert shown["state"] == "failed"
    assert shown["error"] == {"code": "no_object_found", "message": "Nothing was found.", "hint": "Set a seed."}
    assert shown["expires_at"] > shown["finished_at"]


def test_cancel_and_retry(platform: Platform, http: httpx.Client) -> None:
    job = submit(http)
    path = f"/v1/jobs/{job['id']}"
    assert http.post(f"{path}/cancel").json()["state"] == "cancelled"
    again = http.post(f"{path}/cancel")
    assert (again.status_code, again.json()["code"]) == (409, "invalid_transition")
    assert http.post(f"{path}/retry").json()["state"] == "queued"
    assert http.post(f"{path}/retry").status_code == 409
    platform.claim(job["id"])
    assert http.get(path).json()["state"] == "running"
    assert http.post(f"{path}/cancel").json()["state"] == "cancelling"
    assert http.post(f"{path}/cancel").json()["state"] == "cancelling"
    for action in ("cancel", "retry"):
        assert http.post(f"/v1/jobs/{uuid4()}/{action}").status_code == 404


def test_a_retry_needs_its_inputs(local: httpx.Client) -> None:
    asset = upload(local)
    job = submit(local, asset)
    local.post(f"/v1/jobs/{job['id']}/cancel")
    local.delete(f"/v1/assets/{asset['id']}")
    response = local.post(f"/v1/jobs/{job['id']}/retry")
    assert (response.status_code, response.json()["code"]) == (410, "input_expired")


# artifacts

FILES = {
    "labels.nii.gz": b"labels" * 1000,
    "surfaces/object 1 ä.ply": b"ply\n" * 300_000,
    "scene.glb": b"glTF",
    "report.json": b"{}",
}


def test_artifacts(platform: Platform, http: httpx.Client) -> None:
    job = submit(http)
    platform.succeed(job["id"], FILES)
    shown = http.get(f"/v1/jobs/{job['id']}").json()
    assert shown["state"] == "succeeded"
    assert [artifact["name"] for artifact in shown["artifacts"]] == sorted(FILES)
    for artifact in shown["artifacts"]:
        data = FILES[artifact["name"]]
        response = http.get(artifact["url"])
        assert response.content == data
        assert response.headers["etag"] == f'"{artifact["sha256"]}"'
        part = http.get(artifact["url"], headers={"Range": "bytes=1-2"})
        assert (part.status_code, part.content) == (206, data[1:3])
        assert http.get(artifact["url"], headers={"If-None-Match": response.headers["etag"]}).status_code == 304
        assert http.head(artifact["url"]).headers["content-length"] == str(len(data))


@pytest.mark.parametrize(
    "name",
    [
        "../report.json",
        "surfaces/../report.json",
        "%2e%2e/report.json",
        "..%2Freport.json",
        "/etc/passwd",
        "//report.json",
        "report.json/",
        "REPORT.JSON",
        "report.json%00",
        "report.json%0d%0aX-Evil:%201",
        "",
        "a" * 3000,
        "%ff",
        "%F0%9F%98%80",
    ],
)
def test_names_lead_nowhere_else(local_platform: Platform, local: httpx.Client, name: str) -> None:
    job = submit(local)
    local_platform.succeed(job["id"], {"report.json": b"{}"})
    # byte by byte: a client would tidy the path up before it sends it
    head = f"GET /v1/jobs/{job['id']}/artifacts/{name} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
    answer = raw_request(local_platform.url, head.encode())
    headers, _, body = answer.partition(b"\r\n\r\n")
    assert headers.startswith(b"HTTP/1.1 404"), answer
    assert json.loads(body)["code"] == "not_found"
    assert b"\nx-evil" not in headers.lower()


def test_names_with_odd_characters_are_found(local_platform: Platform, local: httpx.Client) -> None:
    job = submit(local)
    names = ["a b.ply", "100%.ply", "a?b#c.ply", "ü/ä.ply", "x+y&z=1.ply", "a;b.ply"]
    local_platform.succeed(job["id"], {name: name.encode() for name in names})
    for artifact in local.get(f"/v1/jobs/{job['id']}").json()["artifacts"]:
        assert artifact["url"].endswith(quote(artifact["name"]))
        assert local.get(artifact["url"]).content == artifact["name"].encode()


def test_results_that_expired(platform: Platform, http: httpx.Client) -> None:
    job = submit(http)
    platform.succeed(job["id"], {"report.json": b"{}"})
    [artifact] = http.get(f"/v1/jobs/{job['id']}").json()["artifacts"]
    with platform.database.session() as session:
        session.execute(update(Job).values(expires_at=utc_now() - timedelta(seconds=1)))
    retention.run_once(platform.database, platform.store, platform.settings)
    response = http.get(artifact["url"])
    assert (response.status_code, response.json()["code"]) == (410, "gone")
    shown = http.get(f"/v1/jobs/{job['id']}").json()
    assert (shown["expired"], shown["artifacts"], shown["result"]) == (True, [], None)


def test_artifacts_never_run_in_a_browser(local_platform: Platform, local: httpx.Client) -> None:
    job = submit(local)
    local_platform.succeed(job["id"], {"page.html": b"<script>alert(1)</script>"}, media_type="text/html")
    response = local.get(f"/v1/jobs/{job['id']}/artifacts/page.html")
    assert response.headers["content-type"] == "application/octet-stream"
    assert response.headers["content-disposition"].startswith("attachment")
    assert "sandbox" in response.headers["content-security-policy"]


def test_without_a_broker_jobs_are_kept(local_platform: Platform, local: httpx.Client) -> None:
    """There is no Redis behind this platform at all."""
    asset = upload(local, nifti(seed=3))
    jobs = [submit(local, asset)["id"] for _ in range(3)]
    assert [job["id"] for job in local.get("/v1/jobs", params={"state": "queued"}).json()["items"]] == jobs[::-1]
    with local_platform.database.session(readonly=True) as session:
        assert {job.enqueued_at for job in session.query(Job)} == {None}, "the reaper will send them"


def test_a_running_job_shows_how_its_result_looks_so_far(platform: Platform, http: httpx.Client) -> None:
    job = submit(http)
    path = f"/v1/jobs/{job['id']}/preview"
    assert http.get(path).status_code == 204
    lease = platform.claim(job["id"])
    shown = bytes(range(256)) * 700
    platform.progress(job["id"], lease, "evolve", 0.4, shown)
    answer = http.get(path)
    assert (answer.status_code, answer.content) == (200, shown)
    assert answer.headers["cache-control"] == "no-store"
    assert answer.headers["content-type"] == "application/octet-stream"
    number = int(answer.headers["shapery-preview"])
    assert http.get(f"/v1/jobs/{job['id']}").json()["preview"] == number
    assert http.get(path, params={"after": number}).status_code == 204
    platform.progress(job["id"], lease, "evolve", 0.5, b"next")
    assert http.get(path, params={"after": number}).content == b"next"
    assert http.get(path, params={"after": -1}).status_code == 422
    with platform.database.session() as session:
        assert jobs.succeed(session, UUID(job["id"]), lease, {"objects": []}, [])
    ended = http.get(path)
    assert (ended.status_code, ended.content) == (204, b"")
    assert http.get(f"/v1/jobs/{uuid4()}/preview").json()["code"] == "not_found"


def test_lists_come_in_the_order_that_is_asked_for(http: httpx.Client) -> None:
    """By name over several pages, for jobs and for files; the jobs keep their names when the files are gone."""
    names = ["b.nii", "c.nii", "a.nii"]
    for seed, name in enumerate(names):
        asset = http.post("/v1/assets", files={"file": (f"ordered {name}", nifti(seed=seed))}).json()
        http.post("/v1/jobs", json={"kind": "segmentation", "inputs": {"post": asset["id"]}}).raise_for_status()

    def listed(path: str, key: str, **query: str) -> list[str]:
        found: list[str] = []
        page: dict[str, object] = {"next_cursor": None}
        while not found or page["next_cursor"]:
            cursor = {"cursor": page["next_cursor"]} if page["next_cursor"] else {}
            page = http.get(path, params={"limit": 2, **query, **cursor}).raise_for_status().json()
            found += [item[key].removeprefix("ordered ") for item in page["items"]]
        return found

    assert listed("/v1/assets", "filename", order="name") == sorted(names)
    assert listed("/v1/assets", "filename", order="created") == names
    for asset in http.get("/v1/assets").json()["items"]:
        http.delete(f"/v1/assets/{asset['id']}").raise_for_status()
    assert listed("/v1/jobs", "name", order="-name", name="RED") == sorted(names, reverse=True)
    assert listed("/v1/jobs", "name", name="ordered a") == ["a.nii"]
    assert listed("/v1/jobs", "name", order="created") == names
    cursor = http.get("/v1/jobs", params={"limit": 1, "order": "name"}).json()["next_cursor"]
    for path, query in (
        ("/v1/jobs", [("order", "state"), ("cursor", cursor)]),
        ("/v1/jobs", [("order", "size")]),
        ("/v1/batches", [("order", "name")]),
        ("/v1/jobs", [("name", "a"), ("name", "b")]),
    ):
        refused = http.get(path, params=query)
        assert (refused.status_code, refused.json()["code"]) == (422, "validation_failed"), query
    assert http.get("/v1/batches", params={"order": "created"}).json()["items"] == []
    assert http.get("/v1/shapes", params=[("order", "name"), ("label", "a:b"), ("label", "c:d")]).status_code == 200

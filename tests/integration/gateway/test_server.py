"""Health, pages, and what is true of every answer."""

from __future__ import annotations

import gzip
import shutil
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from shapery_gateway.dashboard import routes
from tests.integration.gateway.conftest import Make, Platform, Serve, submit
from tests.support.redis import RedisServer, redis_server

pytestmark = pytest.mark.server


@pytest.fixture(scope="module")
def redis() -> Iterator[RedisServer]:
    with redis_server() as server:
        yield server


def test_health(local: httpx.Client) -> None:
    assert local.get("/healthz").json() == {"status": "ok"}


def test_readiness(make_settings: Make, serve: Serve, redis: RedisServer) -> None:
    platform = serve(make_settings(redis_url=redis.url))
    with platform.client() as client:
        ready = client.get("/readyz")
        assert ready.status_code == 200
        assert {name: check["status"] for name, check in ready.json()["checks"].items()} == {
            "database": "ok",
            "queue": "ok",
            "storage": "ok",
        }
        metrics = client.get("/metrics").text
        assert 'shapery_queue_length{queue="segmentation"} 0.0' in metrics


def test_what_is_down_is_told(local_platform: Platform, local: httpx.Client) -> None:
    shutil.rmtree(local_platform.settings.home / "objects")
    response = local.get("/readyz")
    problem = response.json()
    assert (response.status_code, problem["code"]) == (503, "service_unavailable")
    assert {name: check["status"] for name, check in problem["checks"].items()} == {
        "database": "ok",
        "queue": "down",
        "storage": "down",
    }
    assert str(local_platform.settings.home) not in response.text, "no inside is shown"
    assert local.get("/healthz").status_code == 200


def test_messages_reach_the_queue(make_settings: Make, serve: Serve, redis: RedisServer) -> None:
    redis.clear()
    platform = serve(make_settings(redis_url=redis.url))
    with platform.client() as client:
        job = submit(client)
        client.post(f"/v1/jobs/{job['id']}/cancel")
        client.post(f"/v1/jobs/{job['id']}/retry")
        item = {"inputs": {"post": job["inputs"]["post"][0]}}
        batch = client.post("/v1/batches", json={"kind": "segmentation", "items": [item] * 3}).json()
        jobs = client.get("/v1/jobs", params={"batch_id": batch["id"]}).json()["items"]
        wanted = {job["id"], *(item["id"] for item in jobs)}
        with redis.connect() as connection:
            for _ in range(1000):
                sent = b"".join(connection.lrange("segmentation", 0, -1)).decode()
                if all(job_id in sent for job_id in wanted):
                    break
                client.get("/healthz")
            else:
                raise AssertionError("not every job has a message")
            length = connection.llen("segmentation")
        assert f'shapery_queue_length{{queue="segmentation"}} {length}.0' in client.get("/metrics").text


def test_a_broker_that_comes_and_goes(local_settings: Make, serve: Serve, redis: RedisServer) -> None:
    redis.clear()
    platform = serve(local_settings(redis_url=redis.url))
    with platform.client() as client:
        submit(client)
        with redis.connect() as connection:
            while not connection.llen("segmentation"):
                client.get("/healthz")
        redis.stop()
        try:
            for _ in range(3):
                assert submit(client)["state"] == "queued"
            for _ in range(500):
                if "shapery_enqueue_failures_total 3.0" in client.get("/metrics").text:
                    break
            else:
                raise AssertionError("the messages that were dropped are not counted")
        finally:
            redis.start()
        last = submit(client)
        with redis.connect() as connection:
            for _ in range(500):
                if any(last["id"].encode() in m for m in connection.lrange("segmentation", 0, -1)):
                    return
                client.get("/healthz")
    raise AssertionError("the queue was not taken up again")


def test_metrics_count_by_route(platform: Platform, http: httpx.Client) -> None:
    job = submit(http)
    for _ in range(3):
        http.get(f"/v1/jobs/{job['id']}")
    http.get("/some/page")
    http.get("/v1/nothing")
    text = http.get("/metrics").text
    assert 'shapery_http_requests_total{method="GET",route="/v1/jobs/{job_id}",status="200"} 3.0' in text
    assert 'shapery_jobs{state="queued"} 1.0' in text
    assert job["id"] not in text
    assert "/some/page" not in text
    assert 'shapery_scrape_ok{source="shapery_jobs"} 1.0' in text
    assert 'shapery_scrape_ok{source="shapery_queue_length"} 0.0' in text, "no Redis, and the rest is told all the same"


def test_kinds_and_info(platform: Platform, http: httpx.Client) -> None:
    [kind] = [kind for kind in http.get("/v1/kinds").json() if kind["name"] == "segmentation"]
    assert kind["workers"] == 0
    assert kind["inputs"]["post"]["required"]
    assert kind["params_schema"]["properties"]["max_objects"]["default"] == 8
    with platform.database.session() as session:
        from shapery_platform import workers

        workers.register(session, "w1", "segmentation", ["segmentation"], "host", 1)
    [kind] = [kind for kind in http.get("/v1/kinds").json() if kind["name"] == "segmentation"]
    assert kind["workers"] == 1
    info = http.get("/v1/info").json()
    assert info["auth"] == "local"
    assert info["max_upload_bytes"] == 64 << 30


def test_errors_of_the_framework_are_problems_too(local: httpx.Client) -> None:
    for method, path, status, code in [
        ("GET", "/v1/nothing", 404, "not_found"),
        ("POST", "/v1/nothing", 404, "not_found"),
        ("POST", "/some/page", 404, "not_found"),
        ("GET", "/v1/jobs/", 404, "not_found"),
        ("PUT", "/v1/jobs", 405, "method_not_allowed"),
        ("TRACE", "/v1/jobs", 405, "method_not_allowed"),
        ("DELETE", "/healthz", 405, "method_not_allowed"),
        ("GET", "/v1/jobs/x", 422, "validation_failed"),
        ("GET", "/assets/missing.js", 404, "not_found"),
    ]:
        response = local.request(method, path)
        assert response.status_code == status, (method, path)
        problem = response.json()
        assert response.headers["content-type"] == "application/problem+json"
        assert (problem["code"], problem["status"], problem["instance"]) == (code, status, path)
        assert problem["request_id"] == response.headers["x-request-id"]
    assert local.put("/v1/jobs").headers["allow"] == "GET, POST"


def test_a_fault_of_ours(
    local: httpx.Client, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("the secret is 1234")

    monkeypatch.setattr("shapery_gateway.kinds.service.info", broken)
    response = local.get("/v1/info", headers={"X-Request-Id": "trace-me"})
    assert (response.status_code, response.json()["code"]) == (500, "internal_error")
    assert response.json()["request_id"] == "trace-me"
    assert "1234" not in response.text
    assert any(record.exc_info and getattr(record, "request_id", "") == "trace-me" for record in caplog.records)
    assert local.get("/healthz").status_code == 200


def test_the_reference(local: httpx.Client) -> None:
    document = local.get("/openapi.json").json()
    assert document["openapi"] == "3.1.0"
    page = local.get("/docs")
    assert page.headers["content-type"].startswith("text/html")
    assert "script-src" not in page.headers["content-security-policy"]
    assert "default-src 'none'" in page.headers["content-security-policy"]
    assert "<script" not in page.text
    for methods in document["paths"].values():
        for operation in methods.values():
            assert f'id="{operation["operationId"]}"' in page.text


# the dashboard


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    root = tmp_path / "static"
    (root / "assets").mkdir(parents=True)
    (root / "index.html").write_text("<!doctype html><title>built</title>")
    (root / "assets" / "index-Bx2k9fQz.js").write_text("export {}")
    monkeypatch.setattr(routes, "STATIC", root)
    return root


def test_a_dashboard_that_is_not_built_says_so(
    local: httpx.Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(routes, "STATIC", tmp_path / "nowhere")
    response = local.get("/")
    assert response.status_code == 200
    assert "make setup" in response.text


def test_the_dashboard(built: Path, local: httpx.Client) -> None:
    page = local.get("/")
    assert "built" in page.text
    assert page.headers["cache-control"] == "no-cache"
    policy = page.headers["content-security-policy"]
    for part in ("script-src 'self' 'wasm-unsafe-eval'", "worker-src 'self' blob:", "object-src 'none'"):
        assert part in policy
    assert "script-src 'self' 'unsafe-inline'" not in policy
    again = local.get("/", headers={"If-None-Match": page.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    script = local.get("/assets/index-Bx2k9fQz.js")
    assert script.headers["content-type"].startswith("text/javascript")
    assert "immutable" in script.headers["cache-control"]
    assert local.head("/").status_code == 200
    # the paths that the page routes by itself
    for path in ("/jobs", "/jobs/0190-abc", "/upload"):
        assert "built" in local.get(path, headers={"Accept": "text/html,*/*"}).text
        assert local.get(path, headers={"Accept": "application/json"}).status_code == 404
    assert local.get("/v1/x", headers={"Accept": "text/html"}).status_code == 404
    assert local.get("/assets/gone.js", headers={"Accept": "text/html"}).status_code == 404
    for path in ("/../secret", "/%2e%2e/%2e%2e/etc/passwd", "/assets/%2e%2e/%2e%2e/x"):
        assert local.get(path).status_code == 404


def test_the_dashboard_goes_compressed_to_whoever_takes_it(built: Path, local: httpx.Client) -> None:
    path = built / "assets" / "index-Bx2k9fQz.js"
    path.with_name(f"{path.name}.gz").write_bytes(gzip.compress(path.read_bytes()))
    small = local.get("/assets/index-Bx2k9fQz.js", headers={"Accept-Encoding": "br, gzip;q=0.8"})
    plain = local.get("/assets/index-Bx2k9fQz.js", headers={"Accept-Encoding": "br, gzip;q=0"})
    assert (small.headers["content-encoding"], small.text) == ("gzip", "export {}")
    assert "content-encoding" not in plain.headers
    assert plain.text == "export {}"
    assert small.headers["content-type"] == plain.headers["content-type"]
    assert {response.headers["vary"] for response in (small, plain)} == {"Accept-Encoding"}
    assert small.headers["etag"] != plain.headers["etag"]
    for before in (small, plain):
        headers = {
            "If-None-Match": before.headers["etag"],
            "Accept-Encoding": before.request.headers["accept-encoding"],
        }
        assert local.get("/assets/index-Bx2k9fQz.js", headers=headers).status_code == 304

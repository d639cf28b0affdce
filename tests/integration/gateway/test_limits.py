"""What the server does not put up with."""

from __future__ import annotations

import asyncio
import time

import httpx
import pytest

from shapery_gateway.backend import Backend
from tests.integration.gateway.conftest import Make, Platform, Serve, upload
from tests.support.gateway import TUS, raw_request

pytestmark = pytest.mark.server


def test_json_bodies_are_limited(local_settings: Make, serve: Serve) -> None:
    platform = serve(local_settings(max_request_bytes=1000))
    with platform.client() as client:
        response = client.post("/v1/jobs", json={"kind": "x" * 2000, "inputs": {}})
        assert (response.status_code, response.json()["code"]) == (413, "request_too_large")
        chunked = client.post(
            "/v1/jobs", content=(b"x" * 500 for _ in range(5)), headers={"Content-Type": "application/json"}
        )
        assert (chunked.status_code, chunked.json()["code"]) == (413, "request_too_large")
        lines = client.post(
            "/v1/batches", content=(b"{}\n" * 200 for _ in range(5)), headers={"Content-Type": "application/x-ndjson"}
        )
        assert lines.status_code in {413, 422}
        upload(client, name="files.have.a.limit.of.their.own.nii")


def test_filters_of_a_search_are_limited(local_platform: Platform) -> None:
    """Each label is a condition in a question to the database, which refuses a thousand and takes long for hundreds."""
    asked = {"shape_id": "01890a5d-ac96-774b-bcce-b302099a8057"}
    with local_platform.client() as client:
        for count, code in ((16, "not_found"), (17, "validation_failed"), (5000, "validation_failed")):
            labels = {f"n{number}": "v" for number in range(count)}
            assert client.post("/v1/search", json={**asked, "labels": labels}).json()["code"] == code
            if count > 16:
                params = {**asked, "filter": {"labels": labels}}
                job = client.post("/v1/jobs", json={"kind": "shape-search", "inputs": {}, "params": params})
                assert (job.status_code, job.json()["code"]) == (422, "invalid_params")


def test_a_body_too_large_is_refused_before_it_is_sent(local_platform: Platform) -> None:
    for path, size in (("/v1/jobs", 17 << 20), ("/v1/assets", 66 << 30)):
        answer = raw_request(
            local_platform.url,
            f"POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {size}\r\n\r\n".encode(),
        )
        assert answer.startswith(b"HTTP/1.1 413")
        assert b"request_too_large" in answer
        assert b"connection: close" in answer.lower()


def test_heads_are_limited(local_platform: Platform) -> None:
    endless = b"GET / HTTP/1.1\r\nHost: localhost\r\n" + b"X-Filler: " + b"x" * 100_000
    answer = raw_request(local_platform.url, endless)
    assert answer.startswith(b"HTTP/1.1 431")
    assert b"headers_too_large" in answer
    many = b"GET / HTTP/1.1\r\nHost: localhost\r\n" + b"".join(b"X-%d: y\r\n" % i for i in range(20_000))
    assert raw_request(local_platform.url, many).startswith(b"HTTP/1.1 431"), "also while the client is still sending"


def test_a_client_that_is_still_sending_reads_why_it_was_refused(local_platform: Platform) -> None:
    head = b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
    answer = raw_request(local_platform.url, head + b"Content-Length: 20000000\r\n\r\n" + bytes(3_000_000), timeout=10)
    assert answer.startswith(b"HTTP/1.1 413")
    assert answer.endswith(b"}")


def test_large_bodies_are_no_large_heads(local: httpx.Client) -> None:
    """Requests over one connection, each with a body larger than a head may be."""
    for number in range(5):
        response = local.post("/v1/jobs", content=b" " * 200_000, headers={"Content-Type": "application/json"})
        assert response.status_code == 422, number


def test_a_head_that_never_ends(local_platform: Platform, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shapery_gateway.server.HEADER_SECONDS", 0.3)
    assert raw_request(local_platform.url, b"GET / HTTP/1.1\r\nX: y").startswith(b"HTTP/1.1 408")
    assert raw_request(local_platform.url, b"") == b"", "who says nothing is shown out"


def test_a_slow_answer_is_not_a_slow_head(local_platform: Platform, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shapery_gateway.server.HEADER_SECONDS", 0.2)
    with local_platform.client() as client:
        for _ in range(3):
            assert client.get("/v1/info").status_code == 200
            time.sleep(0.3)


@pytest.mark.parametrize(
    "request_",
    [
        b"nonsense\r\n\r\n",
        b"GET  HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: x\r\nContent-Length: x\r\n\r\n",
        b"\0\0\0\0",
    ],
)
def test_what_is_no_http(local_platform: Platform, request_: bytes) -> None:
    assert raw_request(local_platform.url, request_, timeout=1).startswith(b"HTTP/1.1 400")


def test_rates(local_settings: Make, serve: Serve) -> None:
    platform = serve(local_settings(auth="keys", rate_limit_per_minute=5))
    with platform.client(platform.key("ann")) as ann, platform.client(platform.key("bob")) as bob:
        codes = [ann.get("/v1/jobs").status_code for _ in range(8)]
        assert codes == [200] * 5 + [429] * 3
        refused = ann.get("/v1/jobs")
        assert refused.json()["code"] == "rate_limited"
        assert 1 <= int(refused.headers["retry-after"]) <= 13
        assert bob.get("/v1/jobs").status_code == 200, "each key has an allowance of its own"
        assert ann.get("/healthz").status_code == 200, "probes are not counted"
        assert ann.get("/metrics").status_code == 200


def test_guessing_keys_is_slow(local_settings: Make, serve: Serve) -> None:
    platform = serve(local_settings(auth="keys", rate_limit_per_minute=5))
    right = platform.key("ann")
    codes = []
    for number in range(8):
        with platform.client(f"shp_guess{number}") as guess:
            codes.append(guess.get("/v1/jobs").status_code)
    assert codes == [401] * 5 + [429] * 3
    with platform.client(right) as ann:
        assert ann.get("/v1/jobs").status_code == 429, "also the right guess has to wait"


def test_one_user_alone_has_no_limit_unless_asked_for(local_settings: Make, serve: Serve) -> None:
    async def limit_of(**overrides: int) -> int:
        backend = Backend(local_settings(**overrides))
        backend.close()
        return backend.limiter.per_minute

    assert asyncio.run(limit_of()) == 0
    assert asyncio.run(limit_of(rate_limit_per_minute=9)) == 9
    limited = serve(local_settings(rate_limit_per_minute=3))
    with limited.client() as client:
        assert [client.get("/v1/jobs").status_code for _ in range(4)] == [200, 200, 200, 429]


# browsers


def test_foreign_pages_stay_out(local: httpx.Client) -> None:
    foreign = {"Origin": "http://evil.example"}
    for response in (
        local.post("/v1/jobs", json={}, headers=foreign),
        local.post("/v1/assets", files={"file": ("a", b"x")}, headers=foreign),
        local.delete("/v1/assets/x", headers=foreign),
        local.post("/v1/uploads", headers={**TUS, **foreign}),
    ):
        assert (response.status_code, response.json()["code"]) == (403, "untrusted_origin")
    rebound = local.get("/v1/jobs", headers={"Host": "evil.example"})
    assert (rebound.status_code, rebound.json()["code"]) == (421, "untrusted_host")
    read = local.get("/v1/jobs", headers=foreign)
    assert "access-control-allow-origin" not in read.headers
    assert read.headers["cross-origin-resource-policy"] == "same-origin"
    preflight = local.options("/v1/jobs", headers={**foreign, "Access-Control-Request-Method": "POST"})
    assert "access-control-allow-origin" not in preflight.headers


def test_own_pages_come_in(local_platform: Platform, local: httpx.Client) -> None:
    own = {"Origin": local_platform.url, "Sec-Fetch-Site": "same-origin"}
    assert local.post("/v1/uploads", headers={**TUS, **own, "Upload-Length": "5"}).status_code == 201


def test_origins_may_be_allowed(local_settings: Make, serve: Serve) -> None:
    platform = serve(local_settings(cors_origins="https://lab.example,https://other.example"))
    origin = {"Origin": "https://lab.example"}
    with platform.client() as client:
        preflight = client.options(
            "/v1/uploads",
            headers={
                **origin,
                "Access-Control-Request-Method": "PATCH",
                "Access-Control-Request-Headers": "tus-resumable,upload-offset,authorization",
            },
        )
        assert preflight.status_code == 200
        assert preflight.headers["access-control-allow-origin"] == "https://lab.example"
        assert "PATCH" in preflight.headers["access-control-allow-methods"]
        made = client.post("/v1/uploads", headers={**TUS, **origin, "Upload-Length": "5"})
        assert made.status_code == 201
        exposed = made.headers["access-control-expose-headers"].lower()
        assert "location" in exposed
        assert "upload-offset" in exposed
        refused = client.get("/v1/jobs/x", headers=origin)
        assert refused.headers["access-control-allow-origin"] == "https://lab.example", "problems can be read as well"
        evil = client.post("/v1/uploads", headers={**TUS, "Origin": "https://evil.example", "Upload-Length": "5"})
        assert evil.status_code == 403

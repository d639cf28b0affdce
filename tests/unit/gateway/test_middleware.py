"""The layers around the routes, each around an app of three lines."""

from __future__ import annotations

import asyncio
import json
import logging
from typing import Any

import pytest
from prometheus_client import CollectorRegistry
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from shapery_gateway.metrics import RequestMetrics
from shapery_gateway.middleware.context import RequestContextMiddleware
from shapery_gateway.middleware.limits import BodyLimitMiddleware
from shapery_gateway.middleware.trust import LOOPBACK_HOSTS, TrustMiddleware, host_name
from shapery_gateway.middleware.tus import TusMiddleware


class State:
    def __init__(self) -> None:
        self.state = self
        self.backend = self
        self.metrics = RequestMetrics(CollectorRegistry())


class Answer:
    def __init__(self, messages: list[Message]) -> None:
        self.status = messages[0]["status"]
        self.headers = {name.decode().lower(): value.decode() for name, value in messages[0]["headers"]}
        self.body = b"".join(message.get("body", b"") for message in messages[1:])

    @property
    def code(self) -> str:
        return str(json.loads(self.body)["code"])


def call(
    app: ASGIApp,
    method: str = "GET",
    path: str = "/",
    headers: dict[str, str] | None = None,
    body: list[bytes] | None = None,
    state: State | None = None,
) -> Answer:
    scope: dict[str, Any] = {
        "type": "http",
        "method": method,
        "path": path,
        "headers": [(k.lower().encode(), v.encode()) for k, v in (headers or {}).items()],
        "client": ("127.0.0.1", 1),
        "app": state or State(),
        "state": {},
    }
    pieces = list(body or [b""])
    sent: list[Message] = []

    async def receive() -> Message:
        if not pieces:
            await asyncio.sleep(60)
        return {"type": "http.request", "body": pieces.pop(0), "more_body": bool(pieces)}

    async def send(message: Message) -> None:
        sent.append(message)

    asyncio.run(app(scope, receive, send))  # type: ignore[arg-type]
    return Answer(sent)


async def hello(scope: Scope, receive: Receive, send: Send) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": [(b"x-method", scope["method"].encode())]})
    await send({"type": "http.response.body", "body": b"hello"})


async def swallow(scope: Scope, receive: Receive, send: Send) -> None:
    while (await receive()).get("more_body"):
        pass
    await hello(scope, receive, send)


async def broken(scope: Scope, receive: Receive, send: Send) -> None:
    raise RuntimeError("the password is 1234")


async def broken_later(scope: Scope, receive: Receive, send: Send) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})
    raise RuntimeError("too late")


def test_headers_that_keep_browsers_from_guessing() -> None:
    answer = call(RequestContextMiddleware(hello, secure_transport=False))
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert "default-src 'none'" in answer.headers["content-security-policy"]
    assert answer.headers["cache-control"] == "no-store"
    assert "strict-transport-security" not in answer.headers
    secure = call(RequestContextMiddleware(hello, secure_transport=True))
    assert secure.headers["strict-transport-security"].startswith("max-age=")


@pytest.mark.parametrize(
    ("given", "kept"), [("abc-1.2_3", True), ("a b", False), ("x" * 65, False), ("a\r\nb", False), ("", False)]
)
def test_request_ids(given: str, kept: bool) -> None:
    answer = call(RequestContextMiddleware(hello, secure_transport=False), headers={"X-Request-Id": given})
    assert (answer.headers["x-request-id"] == given) is kept
    assert len(answer.headers["x-request-id"]) >= 7


def test_what_nobody_caught(caplog: pytest.LogCaptureFixture) -> None:
    answer = call(RequestContextMiddleware(broken, secure_transport=False), path="/x")
    assert answer.status == 500
    assert answer.code == "internal_error"
    assert b"1234" not in answer.body
    problem = json.loads(answer.body)
    assert problem["request_id"] == answer.headers["x-request-id"]
    [record] = [record for record in caplog.records if record.exc_info]
    assert record.request_id == problem["request_id"]  # type: ignore[attr-defined]


def test_an_answer_that_broke_off_is_not_finished() -> None:
    with pytest.raises(RuntimeError, match="too late"):
        call(RequestContextMiddleware(broken_later, secure_transport=False))


def test_the_access_log_holds_no_forged_lines(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO, "shapery_gateway.access")
    call(
        RequestContextMiddleware(hello, secure_transport=False),
        path="/a\r\nforged",
        headers={"Authorization": "Bearer shp_secret"},
    )
    [record] = [record for record in caplog.records if record.name == "shapery_gateway.access"]
    assert record.getMessage() == "GET /a\\r\\nforged 200"
    assert "shp_secret" not in str(record.__dict__)
    assert record.status == 200  # type: ignore[attr-defined]
    assert record.bytes_sent == 5  # type: ignore[attr-defined]


def test_requests_are_counted_by_route_and_known_method() -> None:
    state = State()
    app = RequestContextMiddleware(hello, secure_transport=False)
    for number in range(5):
        call(app, "GET", f"/v1/jobs/{number}", state=state)
        call(app, f"NONSENSE{number}", "/", state=state)
    text = state.metrics.render().decode()
    assert 'shapery_http_requests_total{method="GET",route="unmatched",status="200"} 5.0' in text
    assert 'method="other",route="unmatched",status="200"} 5.0' in text
    assert "NONSENSE" not in text


# trust


def local(app: ASGIApp = hello) -> TrustMiddleware:
    return TrustMiddleware(app, allowed_hosts=LOOPBACK_HOSTS, allowed_origins=["https://lab.example"])


@pytest.mark.parametrize("host", ["localhost", "LOCALHOST:80", "127.0.0.1:8000", "[::1]:8000", "localhost."])
def test_own_hosts(host: str) -> None:
    assert call(local(), headers={"Host": host}).status == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example:80", "", "[::1", "10.0.0.1", "a@127.0.0.2"],
)
def test_foreign_hosts_are_refused(host: str) -> None:
    answer = call(local(), headers={"Host": host})
    assert answer.status == 421
    assert answer.code == "untrusted_host"


def test_with_keys_any_host_will_do() -> None:
    open_ = TrustMiddleware(hello, allowed_hosts=None, allowed_origins=[])
    assert call(open_, headers={"Host": "shapery.example"}).status == 200


@pytest.mark.parametrize(
    ("headers", "allowed"),
    [
        ({}, True),
        ({"Origin": "http://localhost:8000"}, True),
        ({"Origin": "https://lab.example"}, True),
        ({"Origin": "http://evil.example"}, False),
        ({"Origin": "http://localhost:9000"}, False),
        ({"Origin": "null"}, False),
        ({"Origin": "http://lab.example"}, False),
        ({"Sec-Fetch-Site": "same-origin"}, True),
        ({"Sec-Fetch-Site": "none"}, True),
        ({"Sec-Fetch-Site": "cross-site"}, False),
        ({"Sec-Fetch-Site": "same-site"}, False),
    ],
)
def test_origins_of_changes(headers: dict[str, str], allowed: bool) -> None:
    host = {"Host": "localhost:8000"}
    for method in ("POST", "PATCH", "DELETE", "PUT"):
        answer = call(local(), method, headers={**host, **headers})
        assert (answer.status == 200) is allowed
        assert allowed or answer.code == "untrusted_origin"
    assert call(local(), "GET", headers={**host, **headers}).status == 200


def test_host_names() -> None:
    assert host_name("A.example:80") == "a.example"
    assert host_name("[::1]:80") == "::1"
    assert host_name("[::1") == ""


# limits


def limited(limit: int = 10, idle: float = 5.0) -> BodyLimitMiddleware:
    return BodyLimitMiddleware(swallow, limit_for=lambda method, path: limit, idle_timeout=idle)


def test_a_declared_body_is_refused_unread() -> None:
    answer = call(limited(), "POST", headers={"Content-Length": "11"}, body=[])
    assert answer.status == 413
    assert answer.code == "request_too_large"
    assert answer.headers["connection"] == "close"
    assert call(limited(), "POST", headers={"Content-Length": "9" * 30}, body=[]).status == 413
    assert call(limited(), "POST", headers={"Content-Length": "ten"}, body=[]).status == 400


def test_bodies_up_to_the_limit_pass() -> None:
    assert call(limited(), "POST", body=[b"12345", b"67890"]).status == 200


def test_a_body_without_a_length_is_counted() -> None:
    from starlette.exceptions import HTTPException

    with pytest.raises(HTTPException) as caught:
        call(limited(), "POST", body=[b"12345", b"678901"])
    assert caught.value.status_code == 413


def test_a_client_that_falls_silent() -> None:
    from starlette.exceptions import HTTPException

    app = limited(idle=0.02)
    silent: list[bytes] = []

    async def run() -> None:
        async def receive() -> Message:
            await asyncio.sleep(60)
            return {"type": "http.disconnect"}

        async def send(message: Message) -> None:
            silent.append(message)  # type: ignore[arg-type]

        await app({"type": "http", "method": "POST", "path": "/", "headers": []}, receive, send)

    with pytest.raises(HTTPException) as caught:
        asyncio.run(run())
    assert caught.value.status_code == 408


# tus


def tus(app: ASGIApp = hello) -> TusMiddleware:
    return TusMiddleware(app, prefix="/v1/uploads")


def test_the_version_is_asked_for_and_told() -> None:
    answer = call(tus(), "POST", "/v1/uploads", headers={"Tus-Resumable": "1.0.0"})
    assert answer.status == 200
    assert answer.headers["tus-resumable"] == "1.0.0"
    for headers in ({}, {"Tus-Resumable": "0.2.2"}):
        refused = call(tus(), "PATCH", "/v1/uploads/x", headers=headers)
        assert refused.status == 412
        assert refused.headers["tus-version"] == "1.0.0"
        assert refused.headers["tus-resumable"] == "1.0.0"
    assert call(tus(), "OPTIONS", "/v1/uploads").status == 200


def test_only_uploads_speak_tus() -> None:
    answer = call(tus(), "POST", "/v1/uploadsomething")
    assert answer.status == 200
    assert "tus-resumable" not in answer.headers


def test_the_method_may_be_overridden() -> None:
    headers = {"Tus-Resumable": "1.0.0", "X-HTTP-Method-Override": "patch"}
    assert call(tus(), "POST", "/v1/uploads/x", headers=headers).headers["x-method"] == "PATCH"
    assert call(tus(), "GET", "/v1/uploads/x", headers=headers).headers["x-method"] == "GET"
    headers["X-HTTP-Method-Override"] = "TRACE"
    assert call(tus(), "POST", "/v1/uploads/x", headers=headers).headers["x-method"] == "POST"
    elsewhere = call(tus(), "POST", "/v1/jobs", headers={"X-HTTP-Method-Override": "DELETE"})
    assert elsewhere.headers["x-method"] == "POST"

"""The SDK retries what may be repeated, follows events across reconnections, and checks what it downloads."""

from __future__ import annotations

import hashlib
import json
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import Any

import pytest

from shapery_client import ApiError, Client, ConnectionFailed, JobEndedBadly, Preview, TransferError
from shapery_contracts.api import JobView
from shapery_contracts.states import JobState
from tests.unit.client.conftest import JOB, FlakyServer, answer, drop, problem

CONTENT = bytes(range(256)) * 1000


def job(state: str = "running", **more: Any) -> dict[str, Any]:
    return {
        "id": str(JOB),
        "kind": "segmentation",
        "state": state,
        "inputs": {},
        "params": {},
        "created_at": "2026-01-01T00:00:00Z",
        **more,
    }


def artifact(name: str = "report.json", content: bytes = CONTENT) -> dict[str, Any]:
    return {
        "name": name,
        "size": len(content),
        "sha256": hashlib.sha256(content).hexdigest(),
        "media_type": "application/octet-stream",
        "url": f"/v1/jobs/{JOB}/artifacts/{name}",
    }


def event(seq: int, state: str, kind: str = "state", fraction: float = 0.0) -> bytes:
    data = {
        "seq": seq,
        "type": kind,
        "job_id": str(JOB),
        "state": state,
        "fraction": fraction,
        "at": "2026-01-01T00:00:00Z",
    }
    return f"id: {seq}\nevent: {kind}\ndata: {json.dumps(data)}\n\n".encode()


def test_a_read_is_repeated_until_the_server_is_back(client: Client, server: FlakyServer) -> None:
    tries = iter(
        [drop, lambda h: problem(h, 503, "service_unavailable", Retry_After="0"), lambda h: answer(h, 200, job())]
    )
    server.routes["GET", f"/v1/jobs/{JOB}"] = lambda handler: next(tries)(handler)
    assert client.job(JOB).state is JobState.RUNNING


def test_a_job_is_submitted_once_however_often_the_request_is_sent(client: Client, server: FlakyServer) -> None:
    tries = iter([drop, lambda h: answer(h, 202, job("queued"))])

    def route(handler: BaseHTTPRequestHandler) -> None:
        handler.rfile.read(int(handler.headers["Content-Length"]))
        next(tries)(handler)

    server.routes["POST", "/v1/jobs"] = route
    client.submit("segmentation", {"post": JOB})
    keys = [headers["idempotency-key"] for method, _, headers in server.requests if method == "POST"]
    assert len(keys) == 2
    assert keys[0] == keys[1]


def test_a_preview_comes_with_its_number_or_not_at_all(client: Client, server: FlakyServer) -> None:
    def route(handler: BaseHTTPRequestHandler) -> None:
        if handler.path.endswith("?after=7"):
            answer(handler, 204, b"")
        else:
            answer(handler, 200, CONTENT, Shapery_Preview="7")

    server.routes["GET", f"/v1/jobs/{JOB}/preview"] = route
    assert client.preview(JOB) == Preview(7, CONTENT)
    assert client.preview(JOB, after=7) is None


def test_a_retry_by_the_user_is_not_repeated_blindly(client: Client, server: FlakyServer) -> None:
    server.routes["POST", f"/v1/jobs/{JOB}/retry"] = drop
    with pytest.raises(ConnectionFailed):
        client.retry(JOB)
    assert len(server.requests) == 1


def test_the_api_key_is_sent(server: FlakyServer) -> None:
    server.routes["GET", f"/v1/jobs/{JOB}"] = lambda handler: answer(handler, 200, job())
    with Client(server.address, api_key="shp_secret") as client:
        client.job(JOB)
    assert server.requests[0][2]["authorization"] == "Bearer shp_secret"


def test_an_answer_that_is_no_problem_document_is_still_explained(client: Client, server: FlakyServer) -> None:
    server.routes["GET", f"/v1/jobs/{JOB}"] = lambda handler: answer(handler, 418, b"<html>teapot</html>")
    with pytest.raises(ApiError, match="418") as caught:
        client.job(JOB)
    assert "Shapery server" in caught.value.problem.hint


def test_events_go_on_after_a_dropped_connection_without_repeating(client: Client, server: FlakyServer) -> None:
    def first(handler: BaseHTTPRequestHandler) -> None:
        handler.send_response(200)
        handler.send_header("Content-Type", "text/event-stream")
        handler.send_header("Content-Length", "100000")
        handler.end_headers()
        handler.wfile.write(b"retry: 1000\nid: 0\n\n: a comment\n\n")
        handler.wfile.write(event(1, "running") + event(2, "running", "progress", 0.5))
        handler.wfile.flush()
        drop(handler)

    def second(handler: BaseHTTPRequestHandler) -> None:
        assert handler.headers["Last-Event-ID"] == "2"
        answer(handler, 200, event(3, "succeeded"), Content_Type="text/event-stream")

    tries = iter([first, second])
    server.routes["GET", f"/v1/jobs/{JOB}/events"] = lambda handler: next(tries)(handler)
    server.routes["GET", f"/v1/jobs/{JOB}"] = lambda handler: answer(handler, 200, job("succeeded", event=3))
    assert [item.seq for item in client.events(JOB)] == [1, 2, 3]


def test_a_stream_that_ends_before_its_job_is_opened_again(client: Client, server: FlakyServer) -> None:
    """As where it has been open for long, or where it ends with a former run of the job."""
    streams = iter([event(1, "running") + event(2, "cancelled"), b"", event(3, "queued") + event(4, "succeeded")])
    asked = []

    def follow(handler: BaseHTTPRequestHandler) -> None:
        asked.append(handler.headers["Last-Event-ID"])
        answer(handler, 200, next(streams), Content_Type="text/event-stream")

    server.routes["GET", f"/v1/jobs/{JOB}/events"] = follow
    states = iter([job("queued", event=3), job("running", event=3), job("succeeded", event=4)])
    server.routes["GET", f"/v1/jobs/{JOB}"] = lambda handler: answer(handler, 200, next(states))
    assert [item.seq for item in client.events(JOB)] == [1, 2, 3, 4]
    assert asked == [None, "2", "2"]


def test_waiting_returns_the_ended_job_or_says_why_it_failed(client: Client, server: FlakyServer) -> None:
    told = {"code": "no_object_found", "message": "Nothing was found.", "hint": "Give a seed."}
    server.routes["GET", f"/v1/jobs/{JOB}"] = lambda handler: answer(handler, 200, job("failed", error=told))
    with pytest.raises(JobEndedBadly, match=r"Nothing was found\. Give a seed\."):
        client.wait(JOB)
    assert client.wait(JOB, check=False).state is JobState.FAILED


def test_lists_are_read_page_by_page(client: Client, server: FlakyServer) -> None:
    def page(handler: BaseHTTPRequestHandler) -> None:
        if "cursor=next" in handler.path:
            answer(handler, 200, {"items": [job("failed")], "next_cursor": None})
        else:
            answer(handler, 200, {"items": [job("queued"), job("running")], "next_cursor": "next"})

    server.routes["GET", "/v1/jobs"] = page
    found = client.jobs(kind="segmentation", order="-took")
    assert [item.state for item in found] == ["queued", "running", "failed"]
    assert all("kind=segmentation&order=-took" in path for _, path, _ in server.requests)


def test_a_download_resumes_and_is_checked(client: Client, server: FlakyServer, tmp_path: Path) -> None:
    def route(handler: BaseHTTPRequestHandler) -> None:
        told = handler.headers["Range"]
        if told is None:
            handler.send_response(200)
            handler.send_header("Content-Length", str(len(CONTENT)))
            handler.end_headers()
            handler.wfile.write(CONTENT[:100_000])
            handler.wfile.flush()
            drop(handler)
        else:
            start = int(told.removeprefix("bytes=").removesuffix("-"))
            assert 0 < start <= 100_000
            answer(handler, 206, CONTENT[start:], Content_Range=f"bytes {start}-{len(CONTENT) - 1}/{len(CONTENT)}")

    server.routes["GET", f"/v1/jobs/{JOB}/artifacts/surfaces/1.ply"] = route
    view = JobView.model_validate(job("succeeded", artifacts=[artifact("surfaces/1.ply")]))
    (path,) = client.download(view, tmp_path)
    assert path == tmp_path / "surfaces" / "1.ply"
    assert path.read_bytes() == CONTENT


def test_damaged_bytes_never_take_the_place_of_a_file(client: Client, server: FlakyServer, tmp_path: Path) -> None:
    server.routes["GET", f"/v1/jobs/{JOB}/artifacts/report.json"] = lambda handler: answer(handler, 200, b"damaged")
    (tmp_path / "report.json").write_text("the old one")
    with pytest.raises(TransferError, match="arrived damaged"):
        client.download(JobView.model_validate(job("succeeded", artifacts=[artifact()])), tmp_path)
    assert (tmp_path / "report.json").read_text() == "the old one"
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".part"] == []


@pytest.mark.parametrize("name", ["../evil", "/etc/passwd", "a/../../b"])
def test_an_artifact_never_leaves_the_folder(client: Client, tmp_path: Path, name: str) -> None:
    view = JobView.model_validate(job("succeeded", artifacts=[artifact(name)]))
    with pytest.raises(TransferError, match="would leave the folder"):
        client.download(view, tmp_path)

"""Server-sent events over HTTP."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from typing import Any
from uuid import UUID, uuid4

import httpx
import pytest
from httpx_sse import EventSource, ServerSentEvent

from shapery_platform.jobs import fail, stop
from tests.integration.gateway.conftest import Make, Platform, Serve, submit, upload

pytestmark = pytest.mark.server


def follow(client: httpx.Client, path: str, **headers: str) -> Iterator[ServerSentEvent]:
    with client.stream("GET", path, headers=headers) as response:
        assert response.status_code == 200
        assert response.headers["content-type"].startswith("text/event-stream")
        assert "no-transform" in response.headers["cache-control"]
        yield from EventSource(response).iter_sse()


def data(event: ServerSentEvent) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads(event.data)
    assert event.id == str(loaded["seq"])
    return loaded


def test_from_the_queue_to_the_end(platform: Platform, http: httpx.Client) -> None:
    job = submit(http)
    events = follow(http, f"/v1/jobs/{job['id']}/events")
    first = next(events)
    assert (first.event, data(first)["state"]) == ("state", "queued")
    lease = platform.claim(job["id"])
    assert data(next(events))["state"] == "running"
    platform.progress(job["id"], lease, "seed", 0.3)
    told = next(events)
    assert told.event == "progress"
    assert (data(told)["stage"], data(told)["fraction"]) == ("seed", 0.3)
    http.post(f"/v1/jobs/{job['id']}/cancel")
    assert data(next(events))["state"] == "cancelling"
    with platform.database.session() as session:
        assert stop(session, UUID(job["id"]), lease)
    last = next(events)
    assert data(last)["state"] == "cancelled"
    assert list(events) == [], "the stream ends by itself"


def test_resumed_after_the_last_one_seen(platform: Platform, http: httpx.Client) -> None:
    job = submit(http)
    path = f"/v1/jobs/{job['id']}/events"
    platform.succeed(job["id"])
    everything = [data(event)["seq"] for event in follow(http, path)]
    assert everything == [1, 2, 3]
    assert [data(event)["seq"] for event in follow(http, path, **{"Last-Event-ID": "1"})] == [2, 3]
    assert [data(event)["seq"] for event in follow(http, f"{path}?after=2")] == [3]
    assert [data(event)["seq"] for event in follow(http, f"{path}?after=0", **{"Last-Event-ID": "2"})] == [3]
    # a browser would ask for ever
    assert http.get(path, headers={"Last-Event-ID": "3"}).status_code == 204
    assert http.get(path, params={"after": 99}).status_code == 204


def test_a_retry_goes_on(local_platform: Platform, local: httpx.Client) -> None:
    job = submit(local)
    path = f"/v1/jobs/{job['id']}/events"
    local_platform.fail(job["id"])
    local.post(f"/v1/jobs/{job['id']}/retry")
    local_platform.succeed(job["id"])
    states = [data(event)["state"] for event in follow(local, path)]
    assert states == ["queued", "running", "failed", "queued", "running", "succeeded"]


@pytest.mark.parametrize(
    ("query", "headers"),
    [({"after": -1}, {}), ({"after": "x"}, {}), ({"after": 2**40}, {}), ({}, {"Last-Event-ID": "x"})],
)
def test_wrong_places_to_resume(local: httpx.Client, query: dict[str, str], headers: dict[str, str]) -> None:
    job = submit(local)
    response = local.get(f"/v1/jobs/{job['id']}/events", params=query, headers=headers)
    assert response.status_code == 422


def test_unknown_jobs_have_no_stream(local: httpx.Client) -> None:
    response = local.get(f"/v1/jobs/{uuid4()}/events")
    assert (response.status_code, response.json()["code"]) == (404, "not_found")


def test_many_idle_streams_hold_neither_threads_nor_connections(local_settings: Make, serve: Serve) -> None:
    """More streams than there are threads for routes and connections to the database together."""
    platform = serve(local_settings())
    limits = httpx.Limits(max_connections=400)
    with platform.client(limits=limits) as client:
        asset = upload(client)
        jobs = [submit(client, asset) for _ in range(4)]
        streams = [follow(client, f"/v1/jobs/{jobs[number % 4]['id']}/events") for number in range(150)]
        for stream in streams:
            assert data(next(stream))["seq"] == 1
        metrics = client.get("/metrics").text
        assert "shapery_event_streams 150.0" in metrics
        # everybody else is served as before
        for _ in range(50):
            assert client.get("/v1/jobs").status_code == 200
        for job in jobs:
            client.post(f"/v1/jobs/{job['id']}/cancel")
        for stream in streams:
            assert [data(event)["state"] for event in stream] == ["cancelled"]


def test_streams_are_limited(local: httpx.Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shapery_gateway.http.events.MAX_STREAMS", 2)
    path = f"/v1/jobs/{submit(local)['id']}/events"
    streams = [follow(local, path) for _ in range(2)]
    for stream in streams:
        next(stream)
    refused = local.get(path)
    assert (refused.status_code, refused.json()["code"]) == (503, "service_unavailable")
    assert int(refused.headers["retry-after"]) > 0
    for stream in streams:
        stream.close()  # type: ignore[attr-defined]


def test_a_client_that_leaves_frees_its_stream(local: httpx.Client) -> None:
    job = submit(local)
    stream = follow(local, f"/v1/jobs/{job['id']}/events")
    next(stream)
    assert "shapery_event_streams 1.0" in local.get("/metrics").text
    stream.close()  # type: ignore[attr-defined]
    for _ in range(500):
        if "shapery_event_streams 0.0" in local.get("/metrics").text:
            return
        time.sleep(0.01)
    raise AssertionError("the stream is still open")


def test_batches(platform: Platform, http: httpx.Client) -> None:
    item = {"inputs": {"post": upload(http)["id"]}}
    batch = http.post("/v1/batches", json={"kind": "segmentation", "items": [item] * 3}).json()
    path = f"/v1/batches/{batch['id']}/events"
    jobs = [job["id"] for job in http.get("/v1/jobs", params={"batch_id": batch["id"]}).json()["items"]]
    events = follow(http, path)
    first = next(events)
    assert first.event == "counts"
    assert data(first)["counts"]["queued"] == 3
    lease = platform.claim(jobs[0])
    assert data(next(events))["counts"]["running"] == 1
    platform.progress(jobs[0], lease, "seed", 0.5)
    platform.succeed(jobs[1])
    told = data(next(events))
    while not told["counts"]["succeeded"]:
        told = data(next(events))
    assert told["counts"]["running"] == 1
    http.post(f"/v1/batches/{batch['id']}/cancel")
    with platform.database.session() as session:
        assert stop(session, UUID(jobs[0]), lease)
    rest = [data(event) for event in events]
    assert rest[-1]["finished"]
    assert (rest[-1]["counts"]["cancelled"], rest[-1]["counts"]["succeeded"]) == (2, 1)
    last = str(rest[-1]["seq"])
    assert http.get(path, headers={"Last-Event-ID": last}).status_code == 204
    [again] = list(follow(http, path))
    assert data(again) == rest[-1]


def test_progress_alone_is_no_news_of_a_batch(local_platform: Platform, local: httpx.Client) -> None:
    item = {"inputs": {"post": upload(local)["id"]}}
    batch = local.post("/v1/batches", json={"kind": "segmentation", "items": [item]}).json()
    [job] = local.get("/v1/jobs", params={"batch_id": batch["id"]}).json()["items"]
    lease = local_platform.claim(job["id"])
    found: list[dict[str, Any]] = []
    with local_platform.client() as other:
        thread = threading.Thread(
            target=lambda: found.extend(data(e) for e in follow(other, f"/v1/batches/{batch['id']}/events"))
        )
        thread.start()
        while not found and thread.is_alive():
            time.sleep(0.01)
        for number in range(10):
            local_platform.progress(job["id"], lease, "seed", number / 10)
            time.sleep(0.1)
        with local_platform.database.session() as session:
            assert fail(session, UUID(job["id"]), lease, "no_object_found", "x", "y")
        thread.join(10)
    assert [(e["counts"]["running"], e["counts"]["failed"]) for e in found] == [(1, 0), (0, 1)]

"""What the gateway answers while a part of the platform is away, and that it needs no restart afterwards."""

from __future__ import annotations

import threading

import httpx
import pytest
from httpx_sse import EventSource

from tests.integration.gateway.conftest import Make, Serve, submit, upload
from tests.support.gateway import OFFSET_STREAM, TUS, nifti
from tests.support.postgres import PostgresServer
from tests.support.s3 import s3_server

pytestmark = pytest.mark.server


def test_a_database_that_restarts(
    local_settings: Make, serve: Serve, postgres: PostgresServer, migrated_postgres: str
) -> None:
    platform = serve(local_settings(database_url=postgres.create_database(template=migrated_postgres)))
    states: list[str] = []
    with platform.client() as client:
        job = submit(client)

        def follow() -> None:
            with httpx.stream("GET", f"{platform.url}/v1/jobs/{job['id']}/events", timeout=60) as response:
                states.extend(event.json()["state"] for event in EventSource(response).iter_sse())

        thread = threading.Thread(target=follow)
        thread.start()
        while not states:
            thread.join(0.01)
        postgres.stop()
        try:
            for method, path in (("GET", "/v1/jobs"), ("POST", f"/v1/jobs/{job['id']}/cancel")):
                response = client.request(method, path)
                assert (response.status_code, response.json()["code"]) == (503, "service_unavailable")
                assert response.headers["retry-after"] == "2"
                assert "postgres" not in response.text.lower()
            ready = client.get("/readyz")
            assert ready.status_code == 503
            assert ready.json()["checks"]["database"]["status"] == "down"
            assert client.get("/healthz").status_code == 200
            assert client.get("/metrics").status_code == 200
        finally:
            postgres.start()
        assert client.get(f"/v1/jobs/{job['id']}").json()["state"] == "queued"
        client.post(f"/v1/jobs/{job['id']}/cancel")
        thread.join(30)
    assert states == ["queued", "cancelled"], "the stream lived through it"


def test_an_object_store_that_restarts(local_settings: Make, serve: Serve) -> None:
    data = nifti((200, 200, 200))
    with s3_server() as s3:
        platform = serve(local_settings(**s3.settings()))
        with platform.client() as client:
            where = client.post("/v1/uploads", headers={**TUS, "Upload-Length": str(len(data))}).headers["location"]
            headers = {**TUS, "Upload-Offset": "0", "Content-Type": OFFSET_STREAM}
            s3.stop()
            response = client.patch(where, headers=headers, content=data)
            assert (response.status_code, response.json()["code"]) == (503, "service_unavailable")
            assert str(s3.port) not in response.text
            assert client.head(where, headers=TUS).headers["upload-offset"] == "0"
            assert client.get("/v1/jobs").status_code == 200, "what needs no objects goes on"
            s3.start()
            bucket = platform.settings.storage_url.split("/")[2]
            httpx.put(f"{s3.endpoint}/{bucket}")
            assert "upload-asset-id" in client.patch(where, headers=headers, content=data).headers
            upload(client)

"""The gateway as a process: killed, stopped, and filled with large files."""

from __future__ import annotations

import hashlib
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest

from shapery_platform.db import Database
from shapery_platform.jobs import claim
from tests.integration.gateway.conftest import submit, upload
from tests.support.gateway import OFFSET_STREAM, TUS, GatewayProcess, nifti

pytestmark = pytest.mark.server

MIB = 1 << 20


@pytest.fixture
def process(tmp_path: Path) -> Iterator[GatewayProcess]:
    server = GatewayProcess(tmp_path, {"SHAPERY_HOME": str(tmp_path), "SHAPERY_MIN_FREE_BYTES": "0"})
    server.start()
    yield server
    server.kill()


def eventually(attempt: Callable[[], bool], seconds: float = 30.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if attempt():
            return True
        time.sleep(0.05)
    return False


def test_an_upload_survives_kills(process: GatewayProcess) -> None:
    """Killed in the middle of a PATCH, twice; the client asks where it stands, and goes on."""
    data = nifti((256, 256, 200))
    client = httpx.Client(base_url=process.base_url, timeout=20)
    where = client.post("/v1/uploads", headers={**TUS, "Upload-Length": str(len(data))}).headers["location"]
    headers = {**TUS, "Content-Type": OFFSET_STREAM}
    offset = 0
    for _ in range(2):
        # something is durable before each kill
        step = len(data) // 5
        sent = client.patch(
            where, headers={**headers, "Upload-Offset": str(offset)}, content=data[offset : offset + step]
        )
        assert sent.status_code == 204
        offset += step

        def slow(begin: int = offset) -> Iterator[bytes]:
            for start in range(begin, len(data), 65536):
                yield data[start : start + 65536]
                time.sleep(0.02)

        def send(begin: int = offset, body: Iterator[bytes] | None = None) -> None:
            with pytest.raises(httpx.TransportError):
                httpx.patch(
                    process.base_url + where,
                    headers={**headers, "Upload-Offset": str(begin)},
                    content=body,
                    timeout=20,
                )

        thread = threading.Thread(target=send, args=(offset, slow()))
        thread.start()
        time.sleep(0.4)
        process.kill()
        thread.join()
        process.start()
        head = client.head(where, headers=TUS)
        assert int(head.headers["upload-offset"]) >= offset
        offset = int(head.headers["upload-offset"])

        def unlocked(at: int = offset) -> bool:
            # the dead process holds its lock for some seconds
            answer = client.patch(where, headers={**headers, "Upload-Offset": str(at)}, content=b"")
            return answer.status_code == 204

        assert eventually(unlocked)
    last = client.patch(where, headers={**headers, "Upload-Offset": str(offset)}, content=data[offset:])
    assert last.status_code == 204, last.text
    asset = client.get(f"/v1/assets/{last.headers['upload-asset-id']}").json()
    assert asset["sha256"] == hashlib.sha256(data).hexdigest()
    client.close()


def test_a_stream_is_taken_up_again_after_a_kill(process: GatewayProcess, tmp_path: Path) -> None:
    with httpx.Client(base_url=process.base_url, timeout=20) as client:
        job = submit(client)
        path = f"/v1/jobs/{job['id']}/events"
        with client.stream("GET", path) as response:
            lines = response.iter_lines()
            assert next(line for line in lines if line.startswith("id: ")) == "id: 1"
            process.kill()
            with pytest.raises(httpx.TransportError):
                list(lines)
        database = Database(f"sqlite:///{tmp_path / 'shapery.db'}")
        with database.session() as session:
            from uuid import UUID

            assert claim(session, UUID(job["id"]), "w") is not None
        database.dispose()
        process.start()
        client.post(f"/v1/jobs/{job['id']}/cancel")
        with client.stream("GET", path, headers={"Last-Event-ID": "1"}) as response:
            ids = []
            for line in response.iter_lines():
                if line.startswith("id: "):
                    ids.append(line)
                if len(ids) == 2:
                    break
        assert ids == ["id: 2", "id: 3"], "nothing is missed and nothing comes twice"


def test_stopping_ends_streams_and_keeps_bytes(process: GatewayProcess) -> None:
    data = nifti((128, 128, 128))
    with httpx.Client(base_url=process.base_url, timeout=20) as client:
        job = submit(client)
        ended = threading.Event()

        def follow() -> None:
            with httpx.stream("GET", f"{process.base_url}/v1/jobs/{job['id']}/events", timeout=30) as response:
                for _ in response.iter_lines():
                    pass
            ended.set()

        thread = threading.Thread(target=follow)
        thread.start()
        where = client.post("/v1/uploads", headers={**TUS, "Upload-Length": str(len(data))}).headers["location"]
        client.patch(
            where, headers={**TUS, "Upload-Offset": "0", "Content-Type": OFFSET_STREAM}, content=data[: 1 << 20]
        )
        time.sleep(0.3)
    assert process.stop() in {0, -signal.SIGTERM}
    thread.join(10)
    assert ended.is_set(), "the stream ended in order and was not cut"
    assert "Traceback" not in process.log.read_text()
    process.start()
    with httpx.Client(base_url=process.base_url, timeout=20) as client:
        assert client.head(where, headers=TUS).headers["upload-offset"] == str(1 << 20)


@pytest.mark.slow
def test_large_files_need_no_memory(process: GatewayProcess) -> None:
    """300 MiB each way, through both kinds of uploads and a download."""
    size = 352 + 300 * MIB
    head = nifti((1024, 1024, 300))[:352]

    def body() -> Iterator[bytes]:
        yield head
        for _ in range(300):
            yield bytes(MIB)

    with httpx.Client(base_url=process.base_url, timeout=300) as client:
        upload(client)
        before = process.peak_memory()
        where = client.post("/v1/uploads", headers={**TUS, "Upload-Length": str(size)}).headers["location"]
        sent = client.patch(
            where,
            headers={
                **TUS,
                "Upload-Offset": "0",
                "Content-Type": OFFSET_STREAM,
                "Content-Length": str(size),
            },
            content=body(),
        )
        assert sent.status_code == 204, sent.text

        opening = b'--b\r\nContent-Disposition: form-data; name="file"; filename="large.nii"\r\n\r\n'

        def form() -> Iterator[bytes]:
            yield opening
            yield from body()
            yield b"\r\n--b--\r\n"

        made = client.post(
            "/v1/assets", headers={"Content-Type": "multipart/form-data; boundary=b"}, content=form()
        ).json()
        assert made["size"] == size
        assert client.get(f"/v1/assets/{sent.headers['upload-asset-id']}").json()["sha256"] == made["sha256"]
        received = 0
        with client.stream("GET", made["content_url"]) as response:
            for chunk in response.iter_raw():
                received += len(chunk)
        assert received == size
    grown = process.peak_memory() - before
    assert grown < 40 * MIB, f"{grown / MIB:.0f} MiB more than before"

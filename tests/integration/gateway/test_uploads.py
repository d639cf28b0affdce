"""tus 1.0, as its text demands it, and what happens when connections break."""

from __future__ import annotations

import base64
import hashlib
import socket
import time
from collections.abc import Iterator
from datetime import timedelta
from uuid import UUID, uuid4

import httpx
import pytest
from sqlalchemy import select, update

from shapery_platform import retention, uploads
from shapery_platform.db import utc_now
from shapery_platform.db.models import Upload
from tests.integration.gateway.conftest import Make, Platform, Serve
from tests.support.gateway import OFFSET_STREAM, TUS, metadata, nifti

pytestmark = pytest.mark.server

DATA = nifti((120, 100, 90))


def checksum(data: bytes, algorithm: str = "sha256") -> str:
    return f"{algorithm} {base64.b64encode(hashlib.new(algorithm, data, usedforsecurity=False).digest()).decode()}"


def create(client: httpx.Client, length: int | None = len(DATA), **headers: str) -> str:
    declared = {"Upload-Defer-Length": "1"} if length is None else {"Upload-Length": str(length)}
    response = client.post("/v1/uploads", headers={**TUS, **declared, **headers})
    assert response.status_code == 201, response.text
    return response.headers["location"]


def patch(client: httpx.Client, where: str, offset: int, data: bytes, **headers: str) -> httpx.Response:
    return client.patch(
        where,
        headers={**TUS, "Upload-Offset": str(offset), "Content-Type": OFFSET_STREAM, **headers},
        content=data,
    )


def offset_of(client: httpx.Client, where: str) -> int:
    response = client.head(where, headers=TUS)
    assert response.status_code == 200
    return int(response.headers["upload-offset"])


def code(response: httpx.Response) -> tuple[int, str]:
    assert response.headers["content-type"] == "application/problem+json"
    assert response.headers["tus-resumable"] == "1.0.0"
    return response.status_code, response.json()["code"]


def test_capabilities(local: httpx.Client) -> None:
    response = local.options("/v1/uploads")
    assert response.status_code == 204
    assert response.headers["tus-version"] == "1.0.0"
    assert response.headers["tus-resumable"] == "1.0.0"
    assert response.headers["tus-max-size"] == str(64 << 30)
    assert set(response.headers["tus-extension"].split(",")) == {
        "creation",
        "creation-with-upload",
        "creation-defer-length",
        "checksum",
        "termination",
        "expiration",
    }
    assert "sha1" in response.headers["tus-checksum-algorithm"].split(",")
    assert local.options(f"/v1/uploads/{uuid4()}").status_code == 204


def test_a_whole_upload_in_pieces(http: httpx.Client) -> None:
    where = create(http, **{"Upload-Metadata": f"{metadata('brain.nii')},other {base64.b64encode(b'x').decode()}"})
    offset = 0
    for end in (1, 70_000, 700_000, len(DATA)):
        head = http.head(where, headers=TUS)
        assert head.headers["upload-offset"] == str(offset)
        assert head.headers["upload-length"] == str(len(DATA))
        assert head.headers["cache-control"] == "no-store"
        assert head.headers["upload-metadata"].startswith("filename ")
        assert "upload-expires" in head.headers
        assert "upload-asset-id" not in head.headers
        response = patch(http, where, offset, DATA[offset:end])
        assert response.status_code == 204, response.text
        assert response.headers["upload-offset"] == str(end)
        offset = end
    asset_id = response.headers["upload-asset-id"]
    assert http.head(where, headers=TUS).headers["upload-asset-id"] == asset_id
    asset = http.get(f"/v1/assets/{asset_id}").json()
    assert asset["sha256"] == hashlib.sha256(DATA).hexdigest()
    assert asset["filename"] == "brain.nii"
    assert http.get(asset["content_url"]).content == DATA


def test_creation_with_upload(http: httpx.Client) -> None:
    headers = {**TUS, "Upload-Length": str(len(DATA)), "Content-Type": OFFSET_STREAM}
    part = http.post("/v1/uploads", headers=headers, content=DATA[:500])
    assert (part.status_code, part.headers["upload-offset"]) == (201, "500")
    rest = patch(http, part.headers["location"], 500, DATA[500:])
    whole = http.post(
        "/v1/uploads",
        headers={**headers, "Upload-Checksum": checksum(DATA), "Upload-Metadata": metadata("a.nii")},
        content=DATA,
    )
    assert whole.status_code == 201
    first, second = (http.get(f"/v1/assets/{r.headers['upload-asset-id']}").json()["sha256"] for r in (rest, whole))
    assert first == second == hashlib.sha256(DATA).hexdigest()


def test_deferred_length(http: httpx.Client) -> None:
    where = create(http, None)
    head = http.head(where, headers=TUS)
    assert head.headers["upload-defer-length"] == "1"
    assert "upload-length" not in head.headers
    assert patch(http, where, 0, DATA[:1000]).status_code == 204
    assert code(patch(http, where, 1000, b"", **{"Upload-Length": "10"})) == (400, "bad_request")
    assert patch(http, where, 1000, DATA[1000:2000], **{"Upload-Length": str(len(DATA))}).status_code == 204
    assert code(patch(http, where, 2000, b"", **{"Upload-Length": "999999999"})) == (400, "bad_request")
    assert "upload-asset-id" in patch(http, where, 2000, DATA[2000:]).headers


@pytest.mark.parametrize("algorithm", ["sha1", "sha256", "md5"])
def test_checksums(local: httpx.Client, algorithm: str) -> None:
    where = create(local)
    good = {"Upload-Checksum": checksum(DATA[:1000], algorithm)}
    assert patch(local, where, 0, DATA[:1000], **good).status_code == 204
    damaged = patch(local, where, 1000, DATA[1000:3000], **{"Upload-Checksum": checksum(b"else", algorithm)})
    assert code(damaged) == (460, "checksum_mismatch")
    assert offset_of(local, where) == 1000, "damaged bytes are dropped"
    assert "upload-asset-id" in patch(local, where, 1000, DATA[1000:]).headers


def test_a_checksum_nobody_knows(local: httpx.Client) -> None:
    where = create(local)
    assert code(patch(local, where, 0, b"x", **{"Upload-Checksum": "crc32 AAAA"})) == (400, "bad_request")
    headers = {**TUS, "Upload-Length": "1", "Content-Type": OFFSET_STREAM, "Upload-Checksum": "crc32 AAAA"}
    assert code(local.post("/v1/uploads", headers=headers, content=b"x")) == (400, "bad_request")


def test_a_wrong_offset(http: httpx.Client) -> None:
    where = create(http)
    assert patch(http, where, 0, DATA[:100]).status_code == 204
    for wrong in (0, 99, 101, 10**12):
        assert code(patch(http, where, wrong, DATA[100:])) == (409, "upload_offset_mismatch")
    assert offset_of(http, where) == 100


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Upload-Offset": "x"}, 400),
        ({"Upload-Offset": "-1"}, 400),
        ({"Upload-Offset": "1" * 30}, 400),
        ({"Content-Type": "application/octet-stream"}, 415),
        ({"Tus-Resumable": "0.2.0"}, 412),
    ],
)
def test_patches_that_say_something_wrong(local: httpx.Client, headers: dict[str, str], status: int) -> None:
    assert patch(local, create(local), 0, b"x", **headers).status_code == status


def test_a_patch_without_an_offset(local: httpx.Client) -> None:
    response = local.patch(create(local), headers={**TUS, "Content-Type": OFFSET_STREAM}, content=b"x")
    assert code(response) == (400, "bad_request")


@pytest.mark.parametrize(
    ("headers", "expected"),
    [
        ({}, (400, "bad_request")),
        ({"Upload-Length": "-1"}, (400, "bad_request")),
        ({"Upload-Length": "5", "Upload-Defer-Length": "1"}, (400, "bad_request")),
        ({"Upload-Defer-Length": "2"}, (400, "bad_request")),
        ({"Upload-Length": str(65 << 30)}, (413, "too_large")),
        ({"Upload-Length": "5", "Upload-Metadata": "a ???"}, (400, "bad_request")),
        ({"Upload-Length": "5", "Upload-Concat": "partial"}, (400, "bad_request")),
    ],
)
def test_creations_that_are_refused(local: httpx.Client, headers: dict[str, str], expected: tuple[int, str]) -> None:
    assert code(local.post("/v1/uploads", headers={**TUS, **headers})) == expected


def test_more_bytes_than_declared(local: httpx.Client) -> None:
    where = create(local)
    assert code(patch(local, where, 0, DATA + b"x")) == (413, "request_too_large")
    offset = offset_of(local, where)
    assert offset < len(DATA), "it is not finished with bytes that nobody declared"
    assert "upload-asset-id" in patch(local, where, offset, DATA[offset:]).headers


def test_an_upload_of_nothing(local: httpx.Client) -> None:
    assert code(local.post("/v1/uploads", headers={**TUS, "Upload-Length": "0"})) == (422, "empty_content")


def test_what_is_no_known_file_is_refused_and_removed(platform: Platform, http: httpx.Client) -> None:
    where = create(http, 20)
    assert code(patch(http, where, 0, b"this is not a volume"[:20])) == (422, "unknown_format")
    assert http.head(where, headers=TUS).status_code == 404
    assert list(platform.store.list("staging")) == []


def test_termination(platform: Platform, http: httpx.Client) -> None:
    where = create(http)
    patch(http, where, 0, DATA[:1000])
    assert http.delete(where, headers=TUS).status_code == 204
    assert http.head(where, headers=TUS).status_code == 404
    assert code(patch(http, where, 1000, b"x")) == (404, "not_found")
    assert code(http.delete(where, headers=TUS)) == (404, "not_found")
    assert list(platform.store.list("staging")) == []


def test_the_asset_outlives_its_upload(local: httpx.Client) -> None:
    where = create(local)
    asset = patch(local, where, 0, DATA).headers["upload-asset-id"]
    assert local.delete(where, headers=TUS).status_code == 204
    assert local.get(f"/v1/assets/{asset}").status_code == 200


def test_expiry(local_platform: Platform, local: httpx.Client) -> None:
    where = create(local)
    patch(local, where, 0, DATA[:10])
    with local_platform.database.session() as session:
        session.execute(update(Upload).values(expires_at=utc_now() - timedelta(seconds=1)))
    assert local.head(where, headers=TUS).status_code == 410
    assert code(patch(local, where, 10, DATA[10:])) == (410, "upload_expired")
    retention.run_once(local_platform.database, local_platform.store, local_platform.settings)
    assert local.head(where, headers=TUS).status_code == 404
    assert list(local_platform.store.list("staging")) == []


def test_method_override(local: httpx.Client) -> None:
    where = create(local)
    headers = {**TUS, "Upload-Offset": "0", "Content-Type": OFFSET_STREAM, "X-HTTP-Method-Override": "PATCH"}
    assert local.post(where, headers=headers, content=DATA[:10]).headers["upload-offset"] == "10"
    assert local.post(where, headers={**TUS, "X-HTTP-Method-Override": "DELETE"}).status_code == 204


def test_unknown_uploads(local: httpx.Client) -> None:
    assert local.head(f"/v1/uploads/{uuid4()}", headers=TUS).status_code == 404
    assert code(local.delete("/v1/uploads/x", headers=TUS)) == (422, "validation_failed")
    response = local.put(f"/v1/uploads/{uuid4()}", headers=TUS)
    assert code(response) == (405, "method_not_allowed")
    assert response.headers["allow"] == "DELETE, HEAD, OPTIONS, PATCH"


def test_the_answer_to_the_last_bytes_may_get_lost(local: httpx.Client) -> None:
    where = create(local)
    asset = patch(local, where, 0, DATA).headers["upload-asset-id"]
    assert code(patch(local, where, len(DATA) - 10, DATA[-10:])) == (409, "upload_offset_mismatch")
    head = local.head(where, headers=TUS)
    assert (head.headers["upload-offset"], head.headers["upload-asset-id"]) == (str(len(DATA)), asset)


# broken connections


class Half:
    """A PATCH of which only a part is sent."""

    def __init__(self, url: str, where: str, offset: int, declared: int, *headers: str) -> None:
        host, port = url.removeprefix("http://").split(":")
        self.socket = socket.create_connection((host, int(port)), timeout=10)
        lines = [
            f"PATCH {where} HTTP/1.1",
            "Host: localhost",
            "Tus-Resumable: 1.0.0",
            f"Upload-Offset: {offset}",
            f"Content-Type: {OFFSET_STREAM}",
            f"Content-Length: {declared}",
            *headers,
        ]
        self.socket.sendall("\r\n".join(lines).encode() + b"\r\n\r\n")

    def send(self, data: bytes) -> None:
        self.socket.sendall(data)

    def close(self) -> None:
        self.socket.close()


def is_locked(platform: Platform) -> bool:
    with platform.database.session(readonly=True) as session:
        return session.scalars(select(Upload.lease)).one() is not None


def settle(client: httpx.Client, where: str, at_least: int = 0) -> int:
    """Wait until nobody is writing any more, and return the offset."""
    for _ in range(400):
        offset = offset_of(client, where)
        # an empty patch takes the lock, and changes nothing
        if offset >= at_least and patch(client, where, offset, b"").status_code == 204:
            return offset
        time.sleep(0.01)
    raise AssertionError("the upload stays locked")


def test_what_arrived_is_kept(platform: Platform, http: httpx.Client) -> None:
    where = create(http)
    half = Half(platform.url, where, 0, len(DATA))
    half.send(DATA[:600_000])
    time.sleep(0.2)
    half.close()
    offset = settle(http, where, 1)
    # up to one read buffer of the server may be lost with the connection
    assert 600_000 - (256 << 10) <= offset <= 600_000
    last = patch(http, where, offset, DATA[offset:])
    asset = http.get(f"/v1/assets/{last.headers['upload-asset-id']}").json()
    assert asset["sha256"] == hashlib.sha256(DATA).hexdigest()


def test_with_a_checksum_half_a_piece_is_dropped(platform: Platform, http: httpx.Client) -> None:
    where = create(http)
    patch(http, where, 0, DATA[:1000])
    half = Half(platform.url, where, 1000, len(DATA) - 1000, f"Upload-Checksum: {checksum(DATA[1000:])}")
    half.send(DATA[1000:600_000])
    time.sleep(0.1)
    half.close()
    assert settle(http, where) == 1000
    assert "upload-asset-id" in patch(http, where, 1000, DATA[1000:]).headers


def test_broken_again_and_again(local_platform: Platform, local: httpx.Client) -> None:
    where = create(local)
    offset = 0
    for step in range(6):
        half = Half(local_platform.url, where, offset, len(DATA) - offset)
        half.send(DATA[offset : offset + 150_000 + step])
        time.sleep(0.03)
        half.close()
        offset = settle(local, where, offset)
    last = patch(local, where, offset, DATA[offset:])
    asset = local.get(f"/v1/assets/{last.headers['upload-asset-id']}").json()
    assert asset["sha256"] == hashlib.sha256(DATA).hexdigest()


def test_one_writer_at_a_time(platform: Platform, http: httpx.Client) -> None:
    where = create(http)
    half = Half(platform.url, where, 0, len(DATA))
    half.send(DATA[:1000])
    while not is_locked(platform):
        time.sleep(0.01)
    assert code(patch(http, where, 0, DATA)) == (423, "upload_locked")
    assert code(http.delete(where, headers=TUS)) == (423, "upload_locked")
    assert offset_of(http, where) == 0, "reading needs no lock"
    half.send(DATA[1000:])
    assert b"204" in half.socket.recv(1000).split(b"\r\n")[0]
    half.close()


def test_a_lock_ends_with_its_writer(local_platform: Platform, local: httpx.Client) -> None:
    """A gateway that was killed cannot give its lock back."""
    where = create(local)
    dead = uploads.open_patch(
        local_platform.database,
        uploads.UploadStaging.over(local_platform.store),
        local_platform.settings,
        "local",
        UUID(where.rsplit("/", 1)[1]),
        0,
    )
    assert code(patch(local, where, 0, DATA)) == (423, "upload_locked")
    dead._patch.close()
    with local_platform.database.session() as session:
        session.execute(update(Upload).values(lease_until=utc_now() - timedelta(seconds=1)))
    assert "upload-asset-id" in patch(local, where, 0, DATA).headers


def test_a_silent_client_is_given_up_and_its_bytes_are_kept(
    local_settings: Make, serve: Serve, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shapery_gateway.app.IDLE_SECONDS", 0.3)
    platform = serve(local_settings())
    with platform.client() as client:
        where = create(client)
        half = Half(platform.url, where, 0, len(DATA))
        half.send(DATA[:200_000])
        answer = b""
        while chunk := half.socket.recv(65536):
            answer += chunk
        half.close()
        assert b" 408 " in answer.split(b"\r\n")[0]
        assert b"request_timeout" in answer
        assert settle(client, where) == 200_000


def test_a_body_without_a_length(local: httpx.Client) -> None:
    def chunks() -> Iterator[bytes]:
        for begin in range(0, len(DATA), 100_000):
            yield DATA[begin : begin + 100_000]

    where = create(local)
    headers = {**TUS, "Upload-Offset": "0", "Content-Type": OFFSET_STREAM}
    assert "upload-asset-id" in local.patch(where, headers=headers, content=chunks()).headers

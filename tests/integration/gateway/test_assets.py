from __future__ import annotations

import hashlib
import threading
from uuid import uuid4

import httpx
import pytest

from tests.integration.gateway.conftest import Make, Platform, Serve, submit, upload
from tests.support.gateway import nifti, raw_request, triangle

pytestmark = pytest.mark.server


def test_a_file_comes_back_as_it_was(http: httpx.Client) -> None:
    data = nifti((80, 80, 80))
    asset = upload(http, data, "brain.nii")
    assert asset["sha256"] == hashlib.sha256(data).hexdigest()
    assert asset["size"] == len(data)
    assert (asset["kind"], asset["format"], asset["filename"]) == ("volume", "nifti1", "brain.nii")
    assert asset["details"]["shape"] == [80, 80, 80]
    got = http.get(asset["content_url"])
    assert got.content == data
    assert got.headers["content-length"] == str(len(data))
    assert got.headers["etag"] == f'"{asset["sha256"]}"'
    assert got.headers["content-disposition"] == 'attachment; filename="brain.nii"'
    assert http.get(f"/v1/assets/{asset['id']}").json() == asset


def test_the_location_is_the_asset(local: httpx.Client) -> None:
    response = local.post("/v1/assets", files={"file": ("a.obj", triangle())})
    assert local.get(response.headers["location"]).json() == response.json()


def test_the_same_bytes_are_stored_once(platform: Platform, http: httpx.Client) -> None:
    first = upload(http, name="a.nii")
    second = upload(http, name="b.nii")
    assert first["sha256"] == second["sha256"]
    assert first["id"] != second["id"]
    assert len(list(platform.store.list("objects"))) == 1
    http.delete(f"/v1/assets/{first['id']}")
    assert http.get(second["content_url"]).content == nifti()


def test_many_at_once_with_the_same_bytes(http: httpx.Client) -> None:
    found: list[int] = []

    def send() -> None:
        found.append(http.post("/v1/assets", files={"file": ("a.nii", nifti())}).status_code)

    threads = [threading.Thread(target=send) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [201] * 8


def test_lists_page_by_cursor(http: httpx.Client) -> None:
    made = [upload(http, nifti(seed=i))["id"] for i in range(4)] + [upload(http, triangle(), "t.obj")["id"]]
    seen, cursor = [], None
    while True:
        page = http.get("/v1/assets", params={"limit": 2, **({"cursor": cursor} if cursor else {})}).json()
        seen += [item["id"] for item in page["items"]]
        cursor = page["next_cursor"]
        if cursor is None:
            break
    assert seen == made[::-1]
    meshes = http.get("/v1/assets", params={"kind": "mesh"}).json()["items"]
    assert [item["id"] for item in meshes] == made[-1:]


@pytest.mark.parametrize(
    "query", [{"limit": 0}, {"limit": 201}, {"cursor": "nonsense"}, {"kind": "car"}, {"limit": "x"}]
)
def test_wrong_queries(local: httpx.Client, query: dict[str, str]) -> None:
    response = local.get("/v1/assets", params=query)
    assert response.status_code == 422
    assert response.json()["code"] == "validation_failed"


def test_deleted_is_gone(http: httpx.Client) -> None:
    asset = upload(http)
    assert http.delete(f"/v1/assets/{asset['id']}").status_code == 204
    for path in (f"/v1/assets/{asset['id']}", asset["content_url"]):
        assert http.get(path).status_code == 404
    assert http.delete(f"/v1/assets/{asset['id']}").status_code == 404
    assert http.get("/v1/assets").json()["items"] == []


@pytest.mark.parametrize(
    ("data", "code", "status"),
    [
        (b"", "empty_content", 422),
        (b"hello, this is a letter", "unknown_format", 422),
        (b"\x89PNG\r\n\x1a\n" + bytes(100), "unsupported_format", 422),
        (nifti((100, 100, 100))[:5000], "corrupt_file", 422),
    ],
)
def test_what_is_no_known_file_is_refused(
    local_platform: Platform, local: httpx.Client, data: bytes, code: str, status: int
) -> None:
    response = local.post("/v1/assets", files={"file": ("a.nii", data)})
    assert (response.status_code, response.json()["code"]) == (status, code)
    assert local.get("/v1/assets").json()["items"] == []
    assert list(local_platform.store.list("tmp")) == []


def test_names_cannot_break_headers_or_paths(local: httpx.Client) -> None:
    hostile = {
        "../../etc/passwd": "passwd",
        "a\\b\\c.nii": "c.nii",
        "ä ö\u202e.nii": None,
        "x" * 400 + ".nii": None,
        "semi;colon.nii": "semi;colon.nii",
    }
    for name, expected in hostile.items():
        body = (
            b'--b\r\nContent-Disposition: form-data; name="file"; filename="'
            + name.replace("\\", "\\\\").encode()
            + b'"\r\n\r\n'
            + nifti()
            + b"\r\n--b--\r\n"
        )
        response = local.post("/v1/assets", content=body, headers={"content-type": "multipart/form-data; boundary=b"})
        assert response.status_code == 201, response.text
        asset = response.json()
        assert "/" not in asset["filename"]
        assert "\\" not in asset["filename"]
        assert len(asset["filename"].encode()) <= 255
        if expected:
            assert asset["filename"] == expected
        disposition = local.get(asset["content_url"]).headers["content-disposition"]
        assert disposition.isascii()
        assert disposition.isprintable()
        assert disposition.startswith("attachment; ")


@pytest.mark.parametrize(
    ("content_type", "status"),
    [("application/json", 415), ("multipart/form-data", 400), ("text/plain", 415)],
)
def test_bodies_that_are_no_form(local: httpx.Client, content_type: str, status: int) -> None:
    response = local.post("/v1/assets", content=b"{}", headers={"Content-Type": content_type})
    assert response.status_code == status
    assert local.post("/v1/assets").status_code == 415


def test_a_form_that_breaks_off_leaves_nothing(local_platform: Platform, local: httpx.Client) -> None:
    head = b'--b\r\nContent-Disposition: form-data; name="file"; filename="a.nii"\r\n\r\n'
    raw_request(
        local_platform.url,
        b"POST /v1/assets HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5000000\r\n"
        b"Content-Type: multipart/form-data; boundary=b\r\n\r\n" + head + bytes(3_000_000),
        read=False,
    )
    for _ in range(200):
        # answered after the broken request, since both write to the same database
        if not list(local_platform.store.list("tmp")):
            break
        local.get("/healthz")
    assert list(local_platform.store.list("tmp")) == []
    assert local.get("/v1/assets").json()["items"] == []


# content


@pytest.fixture
def content(http: httpx.Client) -> tuple[str, bytes, str]:
    data = nifti((100, 90, 80))
    asset = upload(http, data)
    return asset["content_url"], data, f'"{asset["sha256"]}"'


def test_ranges(http: httpx.Client, content: tuple[str, bytes, str]) -> None:
    url, data, _ = content
    size = len(data)
    for header, start, stop in [
        ("bytes=0-0", 0, 1),
        ("bytes=10-19", 10, 20),
        (f"bytes={size - 5}-", size - 5, size),
        ("bytes=-7", size - 7, size),
        (f"bytes=5-{size * 2}", 5, size),
        (f"bytes=-{size * 2}", 0, size),
        ("bytes=300000-500000", 300_000, 500_001),
    ]:
        response = http.get(url, headers={"Range": header})
        assert response.status_code == 206, header
        assert response.headers["content-range"] == f"bytes {start}-{stop - 1}/{size}"
        assert response.content == data[start:stop]


def test_several_ranges(http: httpx.Client, content: tuple[str, bytes, str]) -> None:
    url, data, _ = content
    response = http.get(url, headers={"Range": "bytes=0-9,100-109,-10"})
    assert response.status_code == 206
    assert len(response.content) == int(response.headers["content-length"])
    kind, _, boundary = response.headers["content-type"].partition("; boundary=")
    assert kind == "multipart/byteranges"
    parts = response.content.split(f"--{boundary}".encode())
    assert parts[0] == b""
    assert parts[-1] == b"--\r\n"
    bodies = [part.partition(b"\r\n\r\n")[2].removesuffix(b"\r\n") for part in parts[1:-1]]
    assert bodies == [data[:10], data[100:110], data[-10:]]
    assert f"bytes 100-109/{len(data)}".encode() in parts[2]


def test_a_range_outside(http: httpx.Client, content: tuple[str, bytes, str]) -> None:
    url, data, _ = content
    response = http.get(url, headers={"Range": f"bytes={len(data)}-"})
    assert response.status_code == 416
    assert response.headers["content-range"] == f"bytes */{len(data)}"
    assert response.json()["code"] == "range_not_satisfiable"
    malformed = http.get(url, headers={"Range": "bytes=9-3"})
    assert malformed.status_code == 200
    assert malformed.content == data


def test_conditions(http: httpx.Client, content: tuple[str, bytes, str]) -> None:
    url, data, etag = content
    fresh = http.get(url, headers={"If-None-Match": f'"x", W/{etag}'})
    assert (fresh.status_code, fresh.content, fresh.headers["etag"]) == (304, b"", etag)
    assert http.get(url, headers={"If-None-Match": '"x"'}).content == data
    assert http.get(url, headers={"If-Match": etag}).status_code == 200
    refused = http.get(url, headers={"If-Match": '"x"'})
    assert (refused.status_code, refused.json()["code"]) == (412, "precondition_failed")
    # If-None-Match comes before Range
    assert http.get(url, headers={"If-None-Match": etag, "Range": "bytes=0-1"}).status_code == 304
    assert http.get(url, headers={"If-Range": etag, "Range": "bytes=0-1"}).content == data[:2]
    for other in ('"x"', f"W/{etag}", "Wed, 21 Oct 2015 07:28:00 GMT"):
        whole = http.get(url, headers={"If-Range": other, "Range": "bytes=0-1"})
        assert (whole.status_code, whole.content) == (200, data)


def test_head(http: httpx.Client, content: tuple[str, bytes, str]) -> None:
    url, data, etag = content
    response = http.head(url, headers={"Range": "bytes=0-1"})
    assert (response.status_code, response.content) == (200, b"")
    assert response.headers["content-length"] == str(len(data))
    assert response.headers["etag"] == etag
    assert http.head(f"/v1/assets/{uuid4()}/content").status_code == 404


def test_no_browser_runs_what_was_uploaded(local: httpx.Client) -> None:
    asset = upload(local, b"# <script>alert(1)</script>\n" + triangle(), "page.html")
    response = local.get(asset["content_url"])
    assert response.headers["content-type"] == "model/obj"
    assert response.headers["content-disposition"].startswith("attachment")
    assert response.headers["x-content-type-options"] == "nosniff"
    assert "sandbox" in response.headers["content-security-policy"]
    assert response.headers["cross-origin-resource-policy"] == "same-origin"


def test_bytes_that_vanished(local_platform: Platform, local: httpx.Client) -> None:
    asset = upload(local)
    for entry in list(local_platform.store.list("objects")):
        local_platform.store.delete(entry.key)
    response = local.get(asset["content_url"])
    assert (response.status_code, response.json()["code"]) == (410, "gone")


def test_an_asset_in_use_may_be_deleted(http: httpx.Client) -> None:
    asset = upload(http)
    job = submit(http, asset)
    assert http.delete(f"/v1/assets/{asset['id']}").status_code == 204
    assert http.get(f"/v1/jobs/{job['id']}").json()["inputs"]["post"] == [asset["id"]]


def test_a_file_larger_than_allowed(local_settings: Make, serve: Serve) -> None:
    platform = serve(local_settings(max_upload_bytes=1000))
    with platform.client() as client:
        assert client.post("/v1/assets", files={"file": ("a.nii", nifti())}).status_code == 201
        response = client.post("/v1/assets", files={"file": ("a.nii", nifti((20, 20, 20)))})
        assert (response.status_code, response.json()["code"]) == (413, "request_too_large")
        assert list(platform.store.list("tmp")) == []


def test_a_disk_that_is_nearly_full(local_settings: Make, serve: Serve) -> None:
    platform = serve(local_settings().model_copy(update={"min_free_bytes": 1 << 60}))
    with platform.client() as client:
        response = client.post("/v1/assets", files={"file": ("a.nii", nifti())})
        assert (response.status_code, response.json()["code"]) == (507, "storage_full")

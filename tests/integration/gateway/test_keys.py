"""Who may do what, and to whose things."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import timedelta
from uuid import UUID

import httpx
import pytest

from shapery_contracts.api import Scope
from shapery_platform import keys
from shapery_platform.db import utc_now
from tests.conftest import ROOT
from tests.integration.gateway.conftest import Make, Platform, Serve, submit, upload
from tests.support.gateway import OFFSET_STREAM, TUS, nifti, triangle

pytestmark = pytest.mark.server

DOCUMENT = json.loads((ROOT / "api_schema" / "openapi.json").read_text("utf-8"))
OPERATIONS = {
    op["operationId"]: (method.upper(), path)
    for path, methods in DOCUMENT["paths"].items()
    for method, op in methods.items()
}
PUBLIC = {"getHealth", "getReadiness", "getMetrics", "getInfo", "getUploadCapabilities"}

NEEDS = {
    Scope.READ: {
        "listKinds",
        "getUsage",
        "listAssets",
        "getAsset",
        "getAssetContent",
        "listJobs",
        "getJob",
        "streamJobEvents",
        "getJobPreview",
        "getArtifact",
        "listBatches",
        "getBatch",
        "streamBatchEvents",
        "streamBatchResults",
        "listCollections",
        "getCollection",
        "listShapes",
        "getShape",
        "listShapeLabels",
        "getShapeFile",
        "search",
        "getSearch",
    },
    Scope.WRITE: {
        "createUpload",
        "getUpload",
        "appendToUpload",
        "deleteUpload",
        "createAsset",
        "deleteAsset",
        "createJob",
        "cancelJob",
        "retryJob",
        "createBatch",
        "cancelBatch",
        "retryBatch",
        "createCollection",
        "updateCollection",
        "deleteCollection",
        "reindexCollection",
        "updateShape",
        "deleteShape",
        "reindexShape",
    },
    Scope.ADMIN: {"listKeys", "createKey", "deleteKey"},
}


@dataclass
class Things:
    """One of each kind, all of one owner."""

    ids: dict[str, str] = field(default_factory=dict)

    def path(self, template: str) -> str:
        for name, value in self.ids.items():
            template = template.replace(f"{{{name}}}", value)
        assert "{" not in template, template
        return template


@pytest.fixture
def keyed(make_settings: Make, serve: Serve) -> Platform:
    return serve(make_settings(auth="keys"))


@pytest.fixture
def local_keyed(local_settings: Make, serve: Serve) -> Platform:
    return serve(local_settings(auth="keys"))


@pytest.fixture
def ann(keyed: Platform) -> Iterator[httpx.Client]:
    with keyed.client(keyed.key("ann")) as client:
        yield client


@pytest.fixture
def bob(keyed: Platform) -> Iterator[httpx.Client]:
    with keyed.client(keyed.key("bob")) as client:
        yield client


def make_things(platform: Platform, client: httpx.Client) -> Things:
    asset = upload(client)
    job = submit(client, asset)
    platform.succeed(job["id"], {"report.json": b"{}"})
    batch = client.post(
        "/v1/batches", json={"kind": "segmentation", "items": [{"inputs": {"post": asset["id"]}}]}
    ).json()
    location = client.post("/v1/uploads", headers={**TUS, "Upload-Length": "10"}).headers["location"]
    key = client.post("/v1/keys", json={"name": "other"}).json()
    mesh = upload(client, triangle(1), "femur.obj")
    indexing = client.post("/v1/jobs", json={"kind": "shape-index", "inputs": {"mesh": mesh["id"]}}).json()
    platform.index(indexing["id"], 1)
    (shape,) = client.get("/v1/shapes").json()["items"]
    return Things(
        {
            "asset_id": asset["id"],
            "mesh_id": mesh["id"],
            "job_id": job["id"],
            "batch_id": batch["id"],
            "upload_id": location.rsplit("/", 1)[1],
            "key_id": key["id"],
            "name": "report.json",
            "shape_id": shape["id"],
            "file": "arg",
            "collection_id": shape["collection_id"],
        }
    )


def send(client: httpx.Client, operation: str, things: Things) -> httpx.Response:
    method, template = OPERATIONS[operation]
    headers = {**TUS}
    if operation in {"appendToUpload"}:
        headers |= {"Upload-Offset": "0", "Content-Type": OFFSET_STREAM}
    body = {} if operation in {"updateShape", "updateCollection"} else None
    return client.request(method, things.path(template), headers=headers, json=body)


def test_the_table_above_is_complete() -> None:
    assert set(OPERATIONS) == PUBLIC.union(*NEEDS.values())


def test_nobody_without_a_key(local_keyed: Platform) -> None:
    with local_keyed.client(local_keyed.key("ann")) as ann:
        things = make_things(local_keyed, ann)
    wrong = [
        {},
        {"Authorization": "Bearer shp_wrong"},
        {"Authorization": "Basic YTpi"},
        {"X-API-Key": "x" * 5000},
        {"X-API-Key": ""},
        {"Authorization": "Bearer ü".encode("latin-1").decode("latin-1")},
    ]
    with local_keyed.client() as nobody:
        for operation in set(OPERATIONS) - PUBLIC:
            response = send(nobody, operation, things)
            assert response.status_code == 401, operation
            assert response.headers["www-authenticate"].startswith("Bearer")
            if OPERATIONS[operation][0] != "HEAD":
                assert response.json()["code"] == "unauthenticated"
        for headers in wrong:
            encoded = {name: value.encode("latin-1") for name, value in headers.items()}
            assert nobody.get("/v1/jobs", headers=encoded).status_code == 401, headers
        for operation in PUBLIC:
            assert send(nobody, operation, things).status_code in {200, 204, 503}, operation


def test_scopes(local_keyed: Platform) -> None:
    with local_keyed.client(local_keyed.key("ann")) as ann:
        things = make_things(local_keyed, ann)
    for scope in Scope:
        with local_keyed.client(local_keyed.key("ann", scope)) as client:
            for needed, operations in NEEDS.items():
                allowed = {
                    Scope.READ: True,
                    Scope.WRITE: scope in {Scope.WRITE, Scope.ADMIN},
                    Scope.ADMIN: scope is Scope.ADMIN,
                }[needed]
                if allowed:
                    continue
                for operation in operations:
                    response = send(client, operation, things)
                    assert response.status_code == 403, (scope, operation)
                    if OPERATIONS[operation][0] != "HEAD":
                        assert response.json()["code"] == "forbidden"
            assert client.get("/v1/jobs").status_code == 200


def test_usage_counts_what_is_ones_own(keyed: Platform, ann: httpx.Client, bob: httpx.Client) -> None:
    nothing = {"jobs": {}, "assets": {}, "results": {"files": 0, "bytes": 0}}
    assert ann.get("/v1/usage").json() == nothing
    asset = upload(ann)
    keyed.succeed(submit(ann, asset)["id"], {"report.json": b"{}", "labels.nii.gz": b"12345"})
    submit(ann, asset)
    deleted = upload(ann, nifti(seed=2))
    assert ann.get("/v1/usage").json()["assets"] == {"volume": {"files": 2, "bytes": asset["size"] + deleted["size"]}}
    assert ann.delete(f"/v1/assets/{deleted['id']}").status_code == 204
    assert ann.get("/v1/usage").json() == {
        "jobs": {"queued": 1, "succeeded": 1},
        "assets": {"volume": {"files": 1, "bytes": asset["size"]}},
        "results": {"files": 2, "bytes": 7},
    }
    assert bob.get("/v1/usage").json() == nothing


def test_others_do_not_even_exist(keyed: Platform, ann: httpx.Client, bob: httpx.Client) -> None:
    things = make_things(keyed, ann)
    for operation, (method, template) in OPERATIONS.items():
        if "{" not in template or operation in PUBLIC:
            continue
        response = send(bob, operation, things)
        assert response.status_code == 404, (operation, response.text)
        if method != "HEAD":
            assert response.json()["code"] == "not_found"
    for path in ("/v1/assets", "/v1/jobs", "/v1/batches", "/v1/shapes", "/v1/collections"):
        assert bob.get(path).json()["items"] == []
        assert ann.get(path).json()["items"] != []
    assert [key["name"] for key in bob.get("/v1/keys").json()["items"]] == ["test"]
    asset = things.ids["asset_id"]
    for request in (
        bob.post("/v1/jobs", json={"kind": "segmentation", "inputs": {"post": asset}}),
        bob.post("/v1/batches", json={"kind": "segmentation", "items": [{"inputs": {"post": asset}}]}),
        bob.post("/v1/search", json={"shape_id": things.ids["shape_id"]}),
        bob.post("/v1/search", json={"asset_id": things.ids["mesh_id"]}),
    ):
        assert request.status_code == 404
    # and nothing of Ann's was harmed by the attempts
    assert ann.get(f"/v1/assets/{asset}").status_code == 200
    assert ann.head(things.path("/v1/uploads/{upload_id}"), headers=TUS).headers["upload-offset"] == "0"
    assert ann.get(things.path("/v1/batches/{batch_id}")).json()["counts"]["queued"] == 1
    assert ann.get("/v1/jobs", params={"batch_id": things.ids["batch_id"]}).json()["items"]
    assert bob.get("/v1/jobs", params={"batch_id": things.ids["batch_id"]}).json()["items"] == []


def test_the_same_bytes_of_two_owners(keyed: Platform, ann: httpx.Client, bob: httpx.Client) -> None:
    hers, his = upload(ann), upload(bob)
    assert hers["sha256"] == his["sha256"]
    assert len(list(keyed.store.list("objects"))) == 1
    ann.delete(f"/v1/assets/{hers['id']}")
    assert bob.get(his["content_url"]).status_code == 200
    assert bob.get(hers["content_url"]).status_code == 404


def test_idempotency_keys_are_the_owners_own(keyed: Platform, ann: httpx.Client, bob: httpx.Client) -> None:
    jobs = [submit(client, **{"Idempotency-Key": "same"})["id"] for client in (ann, bob)]
    assert jobs[0] != jobs[1]


def test_a_key_from_its_making_to_its_end(keyed: Platform, ann: httpx.Client) -> None:
    asset = upload(ann)
    made = ann.post("/v1/keys", json={"name": "viewer", "scopes": ["read"]})
    assert made.status_code == 201
    key = made.json()
    assert key["secret"].startswith("shp_")
    listed = ann.get("/v1/keys").json()["items"]
    assert {entry["name"] for entry in listed} == {"viewer", "test"}
    assert all("secret" not in entry for entry in listed)
    for headers in ({"Authorization": f"Bearer {key['secret']}"}, {"X-API-Key": key["secret"]}):
        with keyed.client(None) as client:
            client.headers.update(headers)
            assert client.get(f"/v1/assets/{asset['id']}").status_code == 200, "it opens its owner's things"
            assert client.delete(f"/v1/assets/{asset['id']}").status_code == 403
    assert ann.get("/v1/keys").json()["items"][0]["last_used_at"] is not None
    assert ann.delete(f"/v1/keys/{key['id']}").status_code == 204
    with keyed.client(key["secret"]) as client:
        assert client.get("/v1/jobs").status_code == 401, "revoked at once"
    assert ann.delete(f"/v1/keys/{key['id']}").status_code == 404


def test_keys_expire(local_keyed: Platform) -> None:
    with local_keyed.client(local_keyed.key("ann")) as ann:
        past = ann.post("/v1/keys", json={"name": "x", "expires_at": "2001-01-01T00:00:00Z"})
        assert (past.status_code, past.json()["code"]) == (422, "validation_failed")
        naive = ann.post("/v1/keys", json={"name": "x", "expires_at": "2101-01-01T00:00:00"})
        assert naive.status_code == 422
        soon = (utc_now() + timedelta(seconds=60)).isoformat()
        key = ann.post("/v1/keys", json={"name": "x", "expires_at": soon}).json()
    with local_keyed.client(key["secret"]) as client:
        assert client.get("/v1/jobs").status_code == 200
    with local_keyed.database.session() as session:
        from shapery_platform.db.models import ApiKey

        session.get_one(ApiKey, UUID(key["id"])).expires_at = utc_now() - timedelta(seconds=1)
    with local_keyed.client(key["secret"]) as client:
        assert client.get("/v1/jobs").status_code == 401


@pytest.mark.parametrize(
    "body",
    [
        {},
        {"name": ""},
        {"name": "x" * 101},
        {"name": "a\0b"},
        {"name": "x", "scopes": []},
        {"name": "x", "scopes": ["root"]},
        {"name": "x", "expires_at": "tomorrow"},
        {"name": "x", "owner": "bob"},
    ],
)
def test_keys_that_cannot_be_made(local: httpx.Client, body: dict[str, object]) -> None:
    response = local.post("/v1/keys", json=body)
    assert (response.status_code, response.json()["code"]) == (422, "validation_failed")


def test_the_first_key_of_an_installation(local_settings: Make, serve: Serve) -> None:
    secret = "k3Jd8-first-key-of-this-installation-9sQ"
    platform = serve(local_settings(auth="keys", bootstrap_admin_key=secret))
    with platform.client(secret) as client:
        made = client.post("/v1/keys", json={"name": "first", "scopes": ["admin"]})
        assert made.status_code == 201
    with platform.database.session(readonly=True) as session:
        assert keys.authenticate(session, made.json()["secret"]) is not None


def test_secrets_are_neither_logged_nor_counted(local_keyed: Platform, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("DEBUG")
    secret = local_keyed.key("ann")
    with local_keyed.client(secret) as ann:
        made = ann.post("/v1/keys", json={"name": "x"}).json()
        ann.get("/v1/jobs", params={"kind": "UPPER"})
        text = ann.get("/metrics").text
    with local_keyed.client("shp_guess-of-a-stranger") as stranger:
        stranger.get("/v1/jobs")
    logged = "\n".join(str(record.__dict__) for record in caplog.records) + text
    assert "key_id" in logged
    for hidden in (secret, made["secret"], "shp_guess-of-a-stranger"):
        assert hidden not in logged

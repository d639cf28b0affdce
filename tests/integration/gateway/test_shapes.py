"""Collections and shapes over HTTP. What they mean is tested in `tests/integration/platform/test_shapes.py`."""

from __future__ import annotations

import hashlib
from typing import Any

import httpx

from shapery_contracts.retrieval import INDEX_VERSION
from tests.integration.gateway.conftest import Make, Platform, Serve, upload
from tests.support import shapes as fake
from tests.support.gateway import triangle


def ask(client: httpx.Client, seed: int = 1, **params: Any) -> dict[str, Any]:
    """Upload a mesh, ask for it to be indexed, and return the job."""
    asset = upload(client, triangle(seed), "femur.obj")
    request = {"kind": "shape-index", "inputs": {"mesh": asset["id"]}, "params": params}
    response = client.post("/v1/jobs", json=request)
    assert response.status_code == 202, response.text
    job: dict[str, Any] = response.json()
    return job


def index(
    platform: Platform, client: httpx.Client, seed: int = 1, said: dict[str, Any] | None = None, **params: Any
) -> dict[str, Any]:
    """Index a mesh and return the shape."""
    job = ask(client, seed, **params)
    platform.index(job["id"], seed, **(said or {}))
    shapes = client.get("/v1/shapes").json()["items"]
    (shape,) = [shape for shape in shapes if shape["job_id"] == job["id"]]
    assert isinstance(shape, dict)
    return shape


def test_a_shape_and_its_files(platform: Platform, http: httpx.Client) -> None:
    shape = index(platform, http, 5, collection="bones", labels={"side": "left"})
    assert (shape["name"], shape["collection"], shape["labels"]) == ("femur", "bones", {"side": "left"})
    detail = http.get(f"/v1/shapes/{shape['id']}").json()
    assert detail["levels"][0]["parts"] == 1
    assert {key: detail[key] for key in shape} == shape
    made = fake.files(5)
    for url, name in (
        ("arg_url", "shape.arg"),
        ("mesh_url", "mesh.glb"),
        ("preview_url", "preview.png"),
        ("components_url", "components.json"),
    ):
        response = http.get(shape[url])
        assert response.content == made[name], url
        assert response.headers["etag"] == f'"{hashlib.sha256(made[name]).hexdigest()}"'
        assert http.get(shape[url], headers={"Range": "bytes=1-3"}).content == made[name][1:4]
        assert http.head(shape[url]).status_code == 200
        assert http.get(shape[url], headers={"If-None-Match": response.headers["etag"]}).status_code == 304
    assert http.get(shape["components_url"]).headers["content-type"] == "application/json"
    assert http.get(f"/v1/shapes/{shape['id']}/report.json").status_code == 404


def test_shapes_are_listed_changed_and_deleted(platform: Platform, http: httpx.Client) -> None:
    one = index(platform, http, 1, collection="bones", labels={"side": "left", "sex": "f"})
    two = index(platform, http, 2, collection="skulls", labels={"sex": "f"}, name="Skull: 2")
    old = index(platform, http, 3, {"index_version": INDEX_VERSION - 1}, collection="skulls")

    def ids(**query: Any) -> list[str]:
        response = http.get("/v1/shapes", params=query)
        assert response.status_code == 200, response.text
        return [shape["id"] for shape in response.json()["items"]]

    assert ids() == [old["id"], two["id"], one["id"]]
    assert ids(collection="bones") == [one["id"]]
    assert ids(label=["sex:f"]) == [two["id"], one["id"]]
    assert ids(label=["sex:f", "side:left"]) == [one["id"]]
    assert ids(name="skull:") == [two["id"]]
    assert ids(outdated="true") == [old["id"]]
    assert ids(job_id=two["job_id"]) == [two["id"]]
    first = http.get("/v1/shapes", params={"limit": 2}).json()
    assert ids(cursor=first["next_cursor"]) == [one["id"]]
    assert http.get("/v1/shapes", params={"label": "sex"}).json()["code"] == "validation_failed"
    assert http.get("/v1/shapes", params={"collection": "none"}).status_code == 404

    address = f"/v1/shapes/{one['id']}"
    changed = http.patch(address, json={"collection": "skulls", "labels": {"side": "right"}}).json()
    assert (changed["collection"], changed["labels"], changed["name"]) == ("skulls", {"side": "right"}, "femur")
    assert http.patch(address, json={"labels": {"a:b": "c"}}).status_code == 422
    assert http.patch(address, json={"name": "a\0b"}).status_code == 422
    assert http.delete(address).status_code == 204
    assert http.delete(address).status_code == 404
    assert http.get(f"{address}/arg").status_code == 404


def test_labels_are_counted(platform: Platform, http: httpx.Client) -> None:
    for seed, (collection, labels) in enumerate(
        [("bones", {"sex": "f"}), ("bones", {"sex": "m"}), ("skulls", {"sex": "f", "a": "b"})]
    ):
        index(platform, http, seed, collection=collection, labels=labels)
    found = http.get("/v1/labels").json()
    assert found == [
        {"name": "sex", "value": "f", "shapes": 2},
        {"name": "a", "value": "b", "shapes": 1},
        {"name": "sex", "value": "m", "shapes": 1},
    ]
    assert http.get("/v1/labels", params={"limit": 1}).json() == found[:1]
    narrowed = http.get("/v1/labels", params={"collection": "bones"}).json()
    assert [(label["value"], label["shapes"]) for label in narrowed] == [("f", 1), ("m", 1)]
    assert http.get("/v1/labels", params={"collection": "none"}).status_code == 404


def test_collections(platform: Platform, http: httpx.Client) -> None:
    made = http.post("/v1/collections", json={"name": "bones", "metadata": {"year": 2024}})
    assert made.status_code == 201
    assert made.headers["location"] == f"/v1/collections/{made.json()['id']}"
    assert http.post("/v1/collections", json={"name": "bones"}).json()["code"] == "conflict"
    assert http.post("/v1/collections", json={"name": " "}).status_code == 422
    shape = index(platform, http, collection="bones")
    address = made.headers["location"]
    assert http.get(address).json() == {**made.json(), "shapes": 1}
    assert http.patch(address, json={"name": "skulls"}).json()["metadata"] == {"year": 2024}
    assert [found["name"] for found in http.get("/v1/collections").json()["items"]] == ["skulls"]
    assert http.delete(address).status_code == 409
    assert http.delete(address, params={"shapes": "true"}).status_code == 204
    assert http.get(address).status_code == 404
    assert http.get(f"/v1/shapes/{shape['id']}").status_code == 404


def test_indexing_again(platform: Platform, http: httpx.Client) -> None:
    shape = index(platform, http, 1, {"index_version": INDEX_VERSION - 1})
    assert shape["outdated"]
    collection = f"/v1/collections/{shape['collection_id']}"
    assert http.get(collection).json()["outdated"] == 1
    batch = http.post(f"{collection}/reindex")
    assert batch.status_code == 202
    assert batch.json()["total"] == 1
    (job,) = http.get("/v1/jobs", params={"batch_id": batch.json()["id"]}).json()["items"]
    platform.index(job["id"], 2)
    again = http.get(f"/v1/shapes/{shape['id']}").json()
    assert not again["outdated"]
    assert http.get(again["arg_url"]).content == fake.graph(2)
    assert http.post(f"{collection}/reindex").json()["code"] == "conflict"
    job = http.post(f"/v1/shapes/{shape['id']}/reindex")
    assert job.status_code == 202
    platform.index(job.json()["id"], 3)
    assert http.get(again["arg_url"]).content == fake.graph(3)
    assert len(http.get("/v1/shapes").json()["items"]) == 1
    http.delete(f"/v1/assets/{shape['asset_id']}")
    assert http.post(f"/v1/shapes/{shape['id']}/reindex").json()["code"] == "input_expired"


def test_a_batch_of_many(local_platform: Platform, local: httpx.Client) -> None:
    """Each item has a name and labels of its own."""
    asset = upload(local, triangle(1), "many.obj")
    items = [
        {"inputs": {"mesh": asset["id"]}, "params": {"name": f"No {number}", "labels": {"half": str(number % 2)}}}
        for number in range(20)
    ]
    request = {"kind": "shape-index", "params": {"collection": "many"}, "items": items}
    batch = local.post("/v1/batches", json=request).json()
    for job in local.get("/v1/jobs", params={"batch_id": batch["id"], "limit": 100}).json()["items"]:
        local_platform.index(job["id"], 1)
    found = local.get("/v1/shapes", params={"collection": "many", "label": "half:1", "limit": 100}).json()["items"]
    assert {shape["name"] for shape in found} == {f"No {number}" for number in range(1, 20, 2)}


def test_nothing_of_somebody_else_exists(local_settings: Make, serve: Serve) -> None:
    platform = serve(local_settings(auth="keys", rate_limit_per_minute=0))
    with platform.client(platform.key("ann")) as ann, platform.client(platform.key("bob")) as bob:
        shape = index(platform, ann, collection="bones", labels={"side": "left"})
        addresses = [
            f"/v1/shapes/{shape['id']}",
            *(shape[url] for url in ("arg_url", "mesh_url", "preview_url", "components_url")),
            f"/v1/collections/{shape['collection_id']}",
        ]
        for address in addresses:
            assert ann.get(address).status_code == 200
            assert bob.get(address).status_code == 404
        for address in (addresses[0], addresses[-1]):
            assert bob.patch(address, json={"name": "mine"}).status_code == 404
            assert bob.delete(address).status_code == 404
            assert bob.post(f"{address}/reindex").status_code == 404
        assert bob.get("/v1/shapes").json()["items"] == []
        assert bob.get("/v1/labels").json() == []
        assert bob.get("/v1/collections").json()["items"] == []
        assert ann.get(addresses[0]).json()["name"] == "femur"

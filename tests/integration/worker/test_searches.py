"""Searches and indexing over HTTP with a real worker: what is answered at once, what by a job, what kills change."""

from __future__ import annotations

import json
import os
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest

from shapery_client import ApiError, Client
from shapery_client._uploads import UploadJournal
from shapery_contracts.api import Scope
from shapery_platform import keys
from shapery_platform.queue import connect
from tests.integration.worker.conftest import QUICK
from tests.support import bank_handlers, measures
from tests.support import shapes as fake
from tests.support.databases import migrated
from tests.support.gateway import served, triangle
from tests.support.redis import redis_server
from tests.support.stack import Stack, running_stack

pytestmark = pytest.mark.server

SEEDS = [1, 2, 3, 5, 8, 13]


class Bench:
    """A stack with a gateway and a worker of the retrieval service, and a client."""

    def __init__(self, stack: Stack, address: str, http: httpx.Client) -> None:
        self.stack = stack
        self.address = address
        self.http = http
        self.ids: dict[int, str] = {}

    def upload(self, seed: int) -> str:
        response = self.http.post("/v1/assets", files={"file": (f"shape {seed}.obj", triangle(seed))})
        assert response.status_code == 201, response.text
        return str(response.json()["id"])

    def index(self, seed: int, **params: Any) -> dict[str, Any]:
        """Index a mesh and return the job at its end."""
        request = {"kind": "shape-index", "inputs": {"mesh": self.upload(seed)}, "params": params}
        job = self.http.post("/v1/jobs", json=request).json()
        return self.ended(job["id"])

    def ended(self, job_id: str, seconds: float = 60) -> dict[str, Any]:
        deadline = time.monotonic() + seconds
        while True:
            job: dict[str, Any] = self.http.get(f"/v1/jobs/{job_id}").json()
            if job["state"] in ("succeeded", "failed", "crashed", "cancelled"):
                return job
            assert time.monotonic() < deadline, f"{job}\n{self.stack.logs()}"
            time.sleep(0.05)

    def search(self, wait: float = 2.0, **request: Any) -> httpx.Response:
        return self.http.post("/v1/search", json=request, params={"wait": wait})

    def resident(self) -> psutil.Process | None:
        """Return the process that answers at once, as soon as it does."""
        with connect(self.stack.settings) as redis:
            if not redis.exists("shapery.resident.retrieval"):
                return None
        found = []
        for process in self.stack.processes:
            for child in psutil.Process(process.pid).children(recursive=True):
                if "shapery_worker.resident" in " ".join(child.cmdline()):
                    found.append(child)
        return found[0] if found else None

    def wait_for_resident(self) -> psutil.Process:
        self.stack.until(lambda: self.resident() is not None, "the resident process is there", 60)
        process = self.resident()
        assert process is not None
        return process


@contextmanager
def running_bench(home: Path, url: str) -> Iterator[Bench]:
    with (
        redis_server() as redis,
        running_stack(home, url, redis, plugins=[bank_handlers.MODULE], **QUICK) as stack,
        served(stack.settings.model_copy(update={"port": 0})) as address,
        httpx.Client(base_url=address, timeout=60) as http,
    ):
        stack.start_worker(service="retrieval", concurrency=1)
        stack.start_reaper()
        bench = Bench(stack, address, http)
        for seed in SEEDS:
            assert bench.index(seed, collection="fibonacci")["state"] == "succeeded"
        shapes = http.get("/v1/shapes", params={"limit": 100}).json()["items"]
        bench.ids = {int(shape["name"].split()[1]): shape["id"] for shape in shapes}
        bench.wait_for_resident()
        yield bench


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    home = tmp_path_factory.mktemp("home")
    with running_bench(home, migrated(f"sqlite:///{home / 'shapery.db'}")) as bench:
        yield bench


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def any_bench(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    if request.param == "sqlite":
        yield request.getfixturevalue("bench")
        return
    url = migrated(request.getfixturevalue("postgres").create_database())
    with running_bench(tmp_path_factory.mktemp("home"), url) as bench:
        yield bench


def nearest(seed: int, among: Any) -> list[float]:
    return sorted(fake.distance(seed, other) for other in among)


def distances(answer: dict[str, Any]) -> list[float]:
    return [1 / hit["score"] - 1 for hit in answer["hits"]]


def jobs_of(bench: Bench, kind: str) -> int:
    return len(bench.http.get("/v1/jobs", params={"kind": kind, "limit": 200}).json()["items"])


def test_a_stored_shape_is_answered_at_once_and_without_a_job(any_bench: Bench) -> None:
    before = jobs_of(any_bench, "shape-search")
    response = any_bench.search(shape_id=any_bench.ids[5], limit=3)
    assert response.status_code == 200, response.text
    answer = response.json()
    others = [seed for seed in any_bench.ids if seed != 5]
    assert distances(answer) == pytest.approx(nearest(5, others)[:3], abs=1e-9)
    assert any_bench.ids[5] not in {hit["shape_id"] for hit in answer["hits"]}
    assert all(hit["shape"]["id"] == hit["shape_id"] for hit in answer["hits"])
    assert answer["job_id"] is None
    assert jobs_of(any_bench, "shape-search") == before


def test_what_a_search_costs_over_http(bench: Bench) -> None:
    """The platform's share: the handler takes nearly no time. The figures are recorded for the log of the tests."""
    times = []
    for _ in range(40):
        began = time.perf_counter()
        assert bench.search(shape_id=bench.ids[5]).status_code == 200
        times.append(time.perf_counter() - began)
    ordered = sorted(times)
    measures.record("a search by a stored shape over HTTP, median", statistics.median(ordered))
    measures.record("a search by a stored shape over HTTP, p95", ordered[int(0.95 * len(ordered))])


def test_an_uploaded_mesh_is_answered_by_a_job(any_bench: Bench) -> None:
    response = any_bench.search(wait=30, asset_id=any_bench.upload(4))
    assert response.status_code == 200, response.text
    answer = response.json()
    assert distances(answer) == pytest.approx(nearest(4, any_bench.ids), abs=1e-9)
    again = any_bench.http.get(f"/v1/search/{answer['job_id']}")
    assert again.json() == answer


def test_what_takes_longer_is_answered_with_its_job(bench: Bench) -> None:
    response = bench.search(wait=0.2, shape_id=bench.ids[5], parts=[bank_handlers.SLEEP, 15])
    assert response.status_code == 202
    job = response.json()
    assert response.headers["location"] == f"/v1/jobs/{job['id']}"
    assert job["name"] == bench.http.get(f"/v1/shapes/{bench.ids[5]}").json()["name"] != ""
    early = bench.http.get(f"/v1/search/{job['id']}")
    assert early.status_code == 202
    assert bench.ended(job["id"])["state"] == "succeeded"
    late = bench.http.get(f"/v1/search/{job['id']}")
    assert late.status_code == 200
    assert len(late.json()["hits"]) == len(bench.ids) - 1
    index_job = bench.http.get("/v1/jobs", params={"kind": "shape-index"}).json()["items"][0]
    assert bench.http.get(f"/v1/search/{index_job['id']}").status_code == 404


def test_filters_and_faults(bench: Bench) -> None:
    assert bench.search(shape_id=bench.ids[5], collection="none").status_code == 404
    assert bench.search(shape_id=bench.ids[5], labels={"a": "b"}).json()["hits"] == []
    assert len(bench.search(shape_id=bench.ids[5], collection="fibonacci").json()["hits"]) == len(bench.ids) - 1
    assert bench.search(shape_id="01890a5d-ac96-774b-bcce-b302099a8057").status_code == 404
    assert bench.search().status_code == 422
    elsewhere = {"kind": "shape-search", "inputs": {}, "params": {"shape_id": "of another bank"}}
    assert bench.http.post("/v1/jobs", json=elsewhere).json()["name"] == ""
    batch = {"kind": "shape-search", "items": [{"inputs": {}, "params": {"shape_id": bench.ids[5]}}]}
    batch_id = bench.http.post("/v1/batches", json=batch).json()["id"]
    (item,) = bench.http.get("/v1/jobs", params={"batch_id": batch_id}).json()["items"]
    assert item["name"] == bench.http.get(f"/v1/shapes/{bench.ids[5]}").json()["name"]
    assert bench.search(shape_id=bench.ids[5], asset_id=bench.ids[5]).status_code == 422
    assert bench.search(asset_id=bench.ids[5]).status_code == 404


def test_what_is_added_and_deleted_is_seen_by_the_next_search(any_bench: Bench) -> None:
    job = any_bench.index(21, collection="guests")
    assert job["state"] == "succeeded"
    (guest,) = any_bench.http.get("/v1/shapes", params={"collection": "guests"}).json()["items"]
    found = {hit["shape_id"] for hit in any_bench.search(shape_id=any_bench.ids[5]).json()["hits"]}
    assert guest["id"] in found
    any_bench.http.delete(f"/v1/shapes/{guest['id']}")
    found = {hit["shape_id"] for hit in any_bench.search(shape_id=any_bench.ids[5]).json()["hits"]}
    assert found == set(any_bench.ids.values()) - {any_bench.ids[5]}


def test_each_owner_finds_their_own(bench: Bench) -> None:
    """Another gateway on the same platform, which asks for keys: the shapes there are belong to nobody who has one."""
    stack = bench.stack
    settings = stack.settings.model_copy(update={"port": 0, "auth": "keys", "rate_limit_per_minute": 0})
    with stack.database.session() as session:
        secrets = {
            name: keys.create(session, name, scopes, owner=owner)[1]
            for name, owner, scopes in (
                ("ann", "ann", [Scope.READ, Scope.WRITE]),
                ("ann's reader", "ann", [Scope.READ]),
                ("bob", "bob", [Scope.READ, Scope.WRITE]),
            )
        }
    with served(settings) as address:
        clients = {
            name: httpx.Client(base_url=address, headers={"X-API-Key": secret}, timeout=60)
            for name, secret in secrets.items()
        }
        ids = {}
        assets = {}
        for name in ("ann", "bob"):
            one = Bench(stack, address, clients[name])
            assert one.index(5)["state"] == one.index(6)["state"] == "succeeded"
            found = clients[name].get("/v1/shapes", params={"name": "shape 5"}).json()["items"]
            ids[name], assets[name] = found[0]["id"], found[0]["asset_id"]

        def search(name: str, **request: Any) -> httpx.Response:
            return clients[name].post("/v1/search", json=request, params={"wait": 20})

        for name in ("ann", "ann's reader", "bob"):
            owner = name.partition("'")[0]
            answer = search(name, shape_id=ids[owner])
            assert answer.status_code == 200, answer.text
            assert [hit["shape"]["name"] for hit in answer.json()["hits"]] == ["shape 6"]
        by_mesh = search("bob", asset_id=assets["bob"]).json()
        assert {hit["shape"]["name"] for hit in by_mesh["hits"]} == {"shape 5", "shape 6"}
        assert search("bob", shape_id=ids["ann"]).status_code == 404
        assert search("bob", asset_id=assets["ann"]).status_code == 404
        assert clients["ann"].get(f"/v1/search/{by_mesh['job_id']}").status_code == 404
        assert search("ann's reader", asset_id=assets["ann"]).json()["code"] == "forbidden"
        for client in clients.values():
            client.close()


def test_the_sdk_and_the_command_line_say_the_same(bench: Bench, tmp_path: Path) -> None:
    mesh = tmp_path / "guest.obj"
    mesh.write_bytes(triangle(55))
    with Client(bench.address, journal=UploadJournal(tmp_path / "journal.json")) as client:
        asset = client.upload(mesh)
        made = client.create_collection("sdk", "by the SDK")
        job = client.submit("shape-index", {"mesh": asset.id}, {"collection": "sdk", "labels": {"by": "sdk"}})
        client.wait(job.id)
        (shape,) = client.shapes(collection="sdk", labels={"by": "sdk"}, name="guest")
        assert client.shape(shape.id).levels[0].parts == 1
        assert client.shape_file(shape.id, "arg") == fake.graph(55)
        assert client.update_shape(shape.id, labels={"by": "hand"}).labels == {"by": "hand"}
        assert client.update_collection(made.id, description="changed").shapes == 1
        by_shape = client.search(shape=shape.id, collection="fibonacci", limit=3)
        by_mesh = client.search(asset=asset.id, collection="fibonacci", limit=3)
        assert [hit.shape_id for hit in by_shape.hits] == [hit.shape_id for hit in by_mesh.hits]
        assert by_mesh.hits[0].shape.collection == "fibonacci"
        client.wait(client.reindex_shape(shape.id).id)
        assert list(client.shapes(outdated=True)) == []
        with pytest.raises(ApiError, match="outdated"):
            client.reindex_collection(made.id)

        def shapery(*words: object) -> str:
            program = [sys.executable, "-m", "shapery_client", *map(str, words), "--server", bench.address]
            done = subprocess.run(program, capture_output=True, text=True, timeout=60, check=False)
            assert done.returncode == 0, done.stderr
            return done.stdout

        (listed,) = json.loads(shapery("shapes", "list", "--label", "by:hand", "--json"))
        assert listed["id"] == str(shape.id)
        assert "guest" in shapery("shapes", "list", "--collection", "sdk")
        assert json.loads(shapery("shapes", "show", shape.id))["asset_id"] == str(asset.id)
        shapery("shapes", "fetch", shape.id, "--out", tmp_path / "fetched")
        assert (tmp_path / "fetched" / "mesh.glb").read_bytes() == fake.files(55)["mesh.glb"]
        by_id = json.loads(shapery("search", shape.id, "--collection", "fibonacci", "--limit", 3, "--json"))
        assert [hit["shape_id"] for hit in by_id["hits"]] == [hit.shape_id for hit in by_shape.hits]
        by_parts = json.loads(shapery("search", shape.id, "--limit", 3, "--part", 1, "--part", 2, "--json"))
        assert len(by_parts["hits"]) == 3
        found = shapery("search", mesh, "--label", "by:hand")
        assert str(shape.id) in found
        assert "guest" in found
        (told,) = json.loads(shapery("index", mesh, "--collection", "sdk", "--label", "by:index", "--json"))
        assert told == {"name": "guest.obj", "indexed": True, "error": None}
        (told,) = json.loads(shapery("index", mesh, "--collection", "sdk", "--json"))
        assert told == {"name": "guest.obj", "indexed": False, "error": None}, "it is there already"
        (indexed,) = client.shapes(collection="sdk", labels={"by": "index"})
        client.delete_shape(indexed.id)
        (told,) = json.loads(shapery("index", mesh, "--collection", "begun by it", "--json"))
        assert told["indexed"], "a collection that is not there yet is made"
        (begun,) = client.shapes(collection="begun by it")
        client.delete_shape(begun.id)
        assert "sdk" in shapery("collections", "list")
        shapery("shapes", "delete", shape.id)
        shapery("collections", "delete", made.id)
        assert client.collection(json.loads(shapery("collections", "create", "cli", "--json"))["id"]).shapes == 0
        with pytest.raises(ApiError):
            client.collection(made.id)


@pytest.mark.parametrize("victim", ["self", "watcher"])
def test_a_worker_killed_while_it_indexes_gives_one_shape(any_bench: Bench, tmp_path: Path, victim: str) -> None:
    job = any_bench.index(
        34, collection="killed", metadata={"kill_once": str(tmp_path / "once"), "victim": victim}, name=victim
    )
    assert job["state"] == "succeeded", job
    assert job["attempt"] == 2
    found = any_bench.http.get("/v1/shapes", params={"collection": "killed", "name": victim}).json()["items"]
    assert [shape["job_id"] for shape in found] == [job["id"]]
    assert any_bench.http.get(found[0]["arg_url"]).content == fake.graph(34)
    any_bench.http.delete(f"/v1/shapes/{found[0]['id']}")


def test_a_resident_process_that_is_killed_comes_back_and_jobs_fill_the_gap(bench: Bench) -> None:
    resident = bench.wait_for_resident()
    response = bench.search(wait=0.5, shape_id=bench.ids[5], parts=[bank_handlers.KILL])
    assert response.status_code == 202  # a job, which is killed, too
    bench.stack.until(lambda: not resident.is_running(), "the resident process is dead", 10)
    assert bench.ended(response.json()["id"])["state"] == "crashed"
    assert bench.search(wait=30, shape_id=bench.ids[5]).status_code == 200
    bench.stack.until(
        lambda: (new := bench.resident()) is not None and new.pid != resident.pid, "another resident process", 30
    )
    answer = bench.search(wait=5, shape_id=bench.ids[5]).json()
    assert len(answer["hits"]) == len(bench.ids) - 1


def test_a_resident_process_that_hangs_holds_nobody_up(bench: Bench) -> None:
    resident = bench.wait_for_resident()
    os.kill(resident.pid, signal.SIGSTOP)
    try:
        response = bench.search(wait=30, shape_id=bench.ids[5])
        assert response.status_code == 200
        assert response.json()["job_id"] is not None
    finally:
        os.kill(resident.pid, signal.SIGCONT)
    assert len(bench.search(wait=5, shape_id=bench.ids[5]).json()["hits"]) == len(bench.ids) - 1

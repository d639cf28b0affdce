"""Real shapes through the real service: uploaded, indexed as a batch, searched by example, over HTTP."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from shapery_client import ApiError, Client, JobEndedBadly
from shapery_client._uploads import UploadJournal
from shapery_contracts.api import BatchItem
from shapery_contracts.retrieval import DEFAULT_COLLECTION
from shapery_contracts.states import JobState
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io import read_mesh, write_mesh
from tests.support.databases import migrated
from tests.support.gateway import served
from tests.support.redis import redis_server
from tests.support.stack import running_stack
from tests.unit.retrieval.conftest import cylinder, egg, torus

pytestmark = [pytest.mark.server, pytest.mark.slow]

TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


def bent(mesh: TriangleMesh) -> TriangleMesh:
    """The same in another size, place and orientation."""
    return mesh.with_vertices(2.5 * mesh.vertices @ TURN.T + [3.0, -1.0, 7.0])


MESHES = {
    "egg": egg(),
    "egg turned": bent(egg()),
    "torus": torus(),
    "torus coarse": torus(44, 20),
    "cylinder": cylinder(),
    "cylinder turned": bent(cylinder()),
}


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    home = tmp_path_factory.mktemp("home")
    url = migrated(f"sqlite:///{home / 'shapery.db'}")
    with (
        redis_server() as redis,
        running_stack(home, url, redis, plugins=()) as stack,
        served(stack.settings.model_copy(update={"port": 0})) as address,
        Client(address, journal=UploadJournal(home / "journal.json")) as client,
    ):
        stack.start_worker(service="retrieval", concurrency=1, SHAPERY_WORKER_NICENESS="0")
        items = []
        for name, mesh in MESHES.items():
            path = home / f"{name}.ply"
            write_mesh(mesh, path)
            labels = {"family": name.split()[0]}
            items.append(BatchItem(inputs={"mesh": client.upload(path).id}, params={"name": name, "labels": labels}))
        batch = client.wait_batch(client.submit_batch("shape-index", items, {"collection": "bodies"}).id)
        assert batch.counts[JobState.SUCCEEDED] == len(MESHES), stack.logs()
        yield client


def test_each_shape_finds_its_sibling(client: Client) -> None:
    for shape in client.shapes(collection="bodies"):
        answer = client.search(shape=shape.id, limit=5)
        assert answer.hits[0].shape.labels["family"] == shape.labels["family"]
        assert len(answer.hits) == len(MESHES) - 1
        scores = [hit.score for hit in answer.hits]
        assert scores == sorted(scores, reverse=True)
        best = answer.hits[0]
        levels = {level.level: level for level in client.shape(best.shape.id).levels}
        assert best.matches
        assert all(0 <= match.found < levels[best.level].parts for match in best.matches)


def test_what_is_shown_of_a_shape_fits_together(client: Client) -> None:
    (shape,) = client.shapes(name="egg turned")
    detail = client.shape(shape.id)
    assert (detail.vertices, detail.faces) == (len(MESHES["egg"].vertices), len(MESHES["egg"].faces))
    assert detail.closed
    assert detail.genus == 0
    assert detail.area == pytest.approx(2.5**2 * MESHES["egg"].area)
    parts = json.loads(client.shape_file(shape.id, "components"))
    for level in parts["levels"]:
        assert level["level"] in {known.level for known in detail.levels}
    assert client.shape_file(shape.id, "preview.png").startswith(b"\x89PNG")
    assert client.shape_file(shape.id, "mesh.glb").startswith(b"glTF")


def test_an_uploaded_mesh_finds_what_is_like_it(client: Client, tmp_path: Path) -> None:
    write_mesh(bent(torus(52, 26)), tmp_path / "query.obj")
    asset = client.upload(tmp_path / "query.obj")
    answer = client.search(asset=asset.id, limit=2)
    assert {hit.shape.name for hit in answer.hits} == {"torus", "torus coarse"}
    narrowed = client.search(asset=asset.id, labels={"family": "egg"})
    assert {hit.shape.labels["family"] for hit in narrowed.hits} == {"egg"}


def test_a_region_of_a_stored_shape_finds_others_and_not_itself(client: Client) -> None:
    (shape,) = [known for known in client.shapes() if known.name == "egg"]
    mesh = MESHES["egg"]
    upper = np.flatnonzero(mesh.vertices[mesh.faces].mean(axis=1)[:, 2] > 0).tolist()
    answer = client.search(shape=shape.id, region=upper, limit=5)
    assert answer.mode == "partial"
    assert answer.hits
    assert str(shape.id) not in {hit.shape_id for hit in answer.hits}
    assert answer.hits[0].shape.name == "egg turned"


def test_what_cannot_be_indexed_is_told_and_not_kept(client: Client, tmp_path: Path) -> None:
    path = tmp_path / "flat.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
    asset = client.upload(path)
    with pytest.raises(JobEndedBadly) as ended:
        client.wait(client.submit("shape-index", {"mesh": asset.id}).id)
    assert ended.value.job.state is JobState.FAILED
    assert ended.value.job.error is not None
    assert ended.value.job.error.message
    with pytest.raises(ApiError):
        client.search(asset=asset.id)
    assert [shape for shape in client.shapes() if shape.collection == DEFAULT_COLLECTION] == []


def test_the_mesh_that_was_read_is_the_one_that_is_shown(client: Client, tmp_path: Path) -> None:
    (shape,) = client.shapes(name="torus coarse")
    (tmp_path / "mesh.glb").write_bytes(client.shape_file(shape.id, "mesh.glb"))
    shown = read_mesh(tmp_path / "mesh.glb")
    parts = json.loads(client.shape_file(shape.id, "components"))
    assert {len(level["labels"]) for level in parts["levels"]} == {len(shown.vertices)} == {parts["vertices"]}

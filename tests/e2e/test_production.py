"""The settings of docker-compose.yml, against real PostgreSQL, Redis and S3 servers: one job from upload to surface."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from shapery_client import ApiError, Client
from shapery_client._uploads import UploadJournal
from shapery_contracts.api import Scope
from shapery_contracts.segmentation import SegmentationResult
from tests.conftest import ROOT
from tests.support import processes
from tests.support.postgres import postgres_server
from tests.support.redis import RedisServer
from tests.support.s3 import s3_server

pytestmark = pytest.mark.server

ADMIN_KEY = "4d1f0a6c9be27358c1d0e4f7a2b69358"


@pytest.fixture(scope="module")
def platform(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Gateway, segmentation worker and reaper with the variables that compose gives them."""
    folder = tmp_path_factory.mktemp("production")
    redis = RedisServer(folder, tcp=True)
    with postgres_server() as postgres, s3_server() as s3:
        redis.start()
        values = {
            **{f"SHAPERY_{name.upper()}": value for name, value in s3.settings().items()},
            "SHAPERY_DATABASE_URL": postgres.create_database(),
            "SHAPERY_REDIS_URL": redis.url,
            "SHAPERY_BOOTSTRAP_ADMIN_KEY": ADMIN_KEY,
        }
        port = processes.free_port()
        running: list[subprocess.Popen[bytes]] = []
        try:
            subprocess.run(module("shapery_platform", "migrate"), env=env("migrate", values), check=True)
            for name, words in {
                "gateway": ("shapery_gateway", "--port", str(port)),
                "segmentation": ("shapery_worker", "run", "--service", "segmentation"),
                "reaper": ("shapery_worker", "reaper"),
            }.items():
                environment = {**env(name, values), "SHAPERY_SCRATCH": str(folder / "scratch")}
                running.append(processes.spawn(module(*words), folder / f"{name}.log", environment=environment))
            processes.wait_until(lambda: answers(port), running[0], folder / "gateway.log")
            yield f"http://127.0.0.1:{port}"
        finally:
            for process in running:
                processes.end(process)
            redis.stop()


def module(*words: str) -> list[str]:
    return [sys.executable, "-m", *words]


def env(name: str, values: dict[str, str]) -> dict[str, str]:
    """Return a compose service's variables, with the addresses and secrets of this test in the place of compose's."""
    compose: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text())
    wanted = compose["services"][name]["environment"]
    unfilled = {key for key, value in wanted.items() if "$" in str(value)} - values.keys()
    kept = {key: str(value) for key, value in wanted.items() if key not in values and key not in unfilled}
    ours = {key: value for key, value in values.items() if key in wanted}
    clean = {key: value for key, value in os.environ.items() if not key.startswith("SHAPERY_")}
    return {**clean, **kept, **ours}


def answers(port: int) -> bool:
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/readyz", timeout=2) as response:
            return bool(response.status == 200)
    except OSError:
        return False


def connect(address: str, key: str | None, tmp_path: Path) -> Client:
    return Client(address, api_key=key, journal=UploadJournal(tmp_path / "journal.json"))


@pytest.fixture(scope="module")
def phantom(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("phantom")
    size = ["--shape", "80", "96", "80", "--spacing", "2", "2", "2", "--stripped"]
    command = module("shapery_segmentation.phantoms", str(folder), "--seed", "3", *size)
    subprocess.run(command, check=True, capture_output=True)
    return folder


def test_without_a_key_nobody_gets_in(platform: str, tmp_path: Path) -> None:
    with connect(platform, None, tmp_path) as stranger:
        assert stranger.info().auth == "keys"
        with pytest.raises(ApiError) as caught:
            list(stranger.jobs())
    assert caught.value.code == "unauthenticated"


def test_a_job_runs_from_upload_to_surface_and_belongs_to_its_owner(
    platform: str, phantom: Path, tmp_path: Path
) -> None:
    with connect(platform, ADMIN_KEY, tmp_path) as admin:
        key = admin.create_key("scanner", [Scope.READ, Scope.WRITE])
        reader = admin.create_key("reader", [Scope.READ])
    with connect(platform, key.secret, tmp_path) as client:
        post = client.upload(phantom / "post.nii.gz")
        pre = client.upload(phantom / "pre.nii.gz")
        job = client.submit("segmentation", {"post": post.id, "pre": pre.id})
        stages = {event.stage for event in client.events(job.id)}
        job = client.wait(job.id)
        result = SegmentationResult.model_validate(job.result)
        assert result.objects
        assert "evolve" in stages
        names = {path.relative_to(tmp_path / "out").as_posix() for path in client.download(job, tmp_path / "out")}
        assert {"labels.nii.gz", "surface.ply", "scene.glb", "report.json"} <= names
    with connect(platform, reader.secret, tmp_path) as client, pytest.raises(ApiError) as caught:
        client.submit("segmentation", {"post": post.id})
    assert caught.value.code == "forbidden"


def test_a_revoked_key_is_refused_at_once(platform: str, tmp_path: Path) -> None:
    with connect(platform, ADMIN_KEY, tmp_path) as admin:
        key = admin.create_key("short-lived", [Scope.READ])
        with connect(platform, key.secret, tmp_path) as client:
            list(client.jobs())
            admin.revoke_key(key.id)
            with pytest.raises(ApiError) as caught:
                list(client.jobs())
    assert caught.value.code == "unauthenticated"


def test_the_metrics_tell_of_workers_and_no_secrets(platform: str) -> None:
    deadline = time.monotonic() + 30
    while True:
        with urllib.request.urlopen(f"{platform}/metrics", timeout=5) as response:
            text = response.read().decode()
        if "shapery_" in text or time.monotonic() > deadline:
            break
        time.sleep(0.2)
    assert "shapery_" in text
    assert ADMIN_KEY not in text

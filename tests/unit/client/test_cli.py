"""The command line: exit codes, JSON, and sentences instead of tracebacks."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.unit.client.conftest import JOB, FlakyServer, answer, problem
from tests.unit.client.test_sdk import job


def shapery(*arguments: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "shapery_client", *map(str, arguments)],
        capture_output=True,
        text=True,
        env={"PATH": "/usr/bin:/bin", "COLUMNS": "120", **environment},
        timeout=60,
        check=False,
    )


def test_help_lists_the_commands_of_the_design() -> None:
    done = shapery("--help")
    assert done.returncode == 0
    for command in ("up", "segment", "upload", "jobs", "batch", "keys"):
        assert f" {command} " in done.stdout


def test_wrong_usage_is_exit_code_2() -> None:
    assert shapery("segment").returncode == 2
    assert shapery("no-such-command").returncode == 2


def test_a_missing_file_is_refused_in_one_sentence(tmp_path: Path) -> None:
    done = shapery("segment", "--post", tmp_path / "none.nii.gz", "--out", tmp_path / "out")
    assert done.returncode == 3
    assert "does not exist" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_wrong_seed_is_refused_with_an_example(tmp_path: Path) -> None:
    done = shapery("segment", "--post", tmp_path, "--out", tmp_path, "--seed", "-1,2", "--json")
    assert done.returncode == 3
    error = json.loads(done.stdout)["error"]
    assert error["code"] == "invalid_params"
    assert "--seed 12,-30,8.5" in error["hint"]


@pytest.mark.slow
def test_a_server_that_is_away_is_exit_code_4() -> None:
    done = shapery("jobs", "list", "--server", "http://127.0.0.1:1")
    assert done.returncode == 4
    assert "does not answer" in done.stderr


def test_jobs_are_listed_for_people_and_for_programs(server: FlakyServer) -> None:
    server.routes["GET", "/v1/jobs"] = lambda handler: answer(
        handler, 200, {"items": [job("running", stage="evolve", fraction=0.25)], "next_cursor": None}
    )
    people = shapery("jobs", "list", SHAPERY_SERVER=server.address)
    assert people.returncode == 0
    assert str(JOB) in people.stdout
    assert "25%" in people.stdout
    programs = shapery("jobs", "list", "--state", "running", "--order", "name", "--json", "--server", server.address)
    assert json.loads(programs.stdout)[0]["id"] == str(JOB)
    assert "state=running&order=name" in server.requests[-1][1]


def test_watching_a_job_that_fails_is_exit_code_5(server: FlakyServer) -> None:
    told = {"code": "no_object_found", "message": "Nothing was found.", "hint": "Give a seed."}
    server.routes["GET", f"/v1/jobs/{JOB}"] = lambda handler: answer(handler, 200, job("failed", error=told))
    done = shapery("jobs", "watch", str(JOB), "--server", server.address, "--json")
    assert done.returncode == 5
    assert json.loads(done.stdout)["error"]["code"] == "no_object_found"


def test_a_missing_key_is_told_by_the_server(server: FlakyServer) -> None:
    server.routes["GET", "/v1/keys"] = lambda handler: problem(handler, 401, "unauthenticated")
    done = shapery("keys", "list", "--server", server.address)
    assert done.returncode == 3
    assert "This is unauthenticated." in done.stderr


def test_a_batch_line_that_is_no_item_is_named(server: FlakyServer, tmp_path: Path) -> None:
    items = tmp_path / "items.ndjson"
    items.write_text(f'{{"inputs": {{"post": "{JOB}"}}}}\n{{"imputs": {{}}}}\n')
    done = shapery("batch", "submit", items, "--server", server.address)
    assert done.returncode == 3
    assert "Line 2" in done.stderr
    assert not server.requests

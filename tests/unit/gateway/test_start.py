"""What the gateway's process loads, and what it says when it cannot start."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
from pathlib import Path

import pytest

from shapery_gateway.logs import JsonFormatter


def test_no_numerics_and_no_celery_are_loaded() -> None:
    code = (
        "import sys, shapery_gateway.server\n"
        "heavy = {'numpy', 'scipy', 'numba', 'trimesh', 'nibabel', 'SimpleITK', 'celery', 'kombu', 'alembic',"
        " 'shapery_geometry', 'shapery_segmentation', 'shapery_worker'}\n"
        "print(sorted(heavy & {name.partition('.')[0] for name in sys.modules}))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("environment", "said"),
    [
        ({"SHAPERY_AUTH": "local", "SHAPERY_HOST": "0.0.0.0"}, "loopback"),
        ({"SHAPERY_PROFILE": "production"}, "SHAPERY_DATABASE_URL"),
    ],
)
def test_wrong_settings_are_told_in_a_sentence(environment: dict[str, str], said: str, tmp_path: Path) -> None:
    result = subprocess.run(
        [sys.executable, "-m", "shapery_gateway"],
        capture_output=True,
        text=True,
        env={"PATH": "", "SHAPERY_HOME": str(tmp_path), **environment},
        timeout=60,
    )
    assert result.returncode == 2
    assert said in result.stderr
    assert "Traceback" not in result.stderr


def test_a_log_line_is_one_line_of_json() -> None:
    try:
        raise ValueError("line\nbreak")
    except ValueError:
        record = logging.LogRecord("a.b", logging.ERROR, "", 1, "said %s\n", ("ü\r\n",), sys.exc_info())
    record.request_id = "r1"
    line = JsonFormatter().format(record)
    assert "\n" not in line
    entry = json.loads(line)
    assert entry["message"] == "said ü\r\n\n"
    assert entry["request_id"] == "r1"
    assert entry["level"] == "error"
    assert "ValueError" in entry["traceback"]

"""``make demo ONCE=1``: the program that a newcomer runs first."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ROOT


@pytest.mark.server
@pytest.mark.slow
def test_the_demo_finds_its_tumor_and_leaves(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "demo", "--once", "--home", str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found = re.search(r"enhancing tumor\s+([\d.]+)\s+([\d.]+)", done.stdout)
    assert found, done.stdout
    assert float(found.group(1)) > 0.5
    assert (tmp_path / "results" / "labels.nii.gz").exists()


def test_a_volume_that_does_not_exist_is_refused_before_anything_starts(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "demo", "--post", str(tmp_path / "none.nii.gz"), "--home", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "does not exist" in done.stderr

"""``shapery segment`` on the raw files of real cases, with no option but the two volumes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from shapery_geometry.intersections import self_intersections
from shapery_geometry.mask_metrics import intersection_over_union
from shapery_geometry.mesh_io import read_mesh
from shapery_geometry.volume_io import read_volume

pytestmark = [pytest.mark.data, pytest.mark.slow]

# The expert's labels: 1 necrotic or non-enhancing core, 2 edema, 4 enhancing tumor.
CASES = [("tumor_brats18_tcia01_231_1", 0.80, 0.85), ("tumor_brats21_00006", 0.77, 0.88)]


@pytest.mark.parametrize(("case", "least_enhancing", "least_core"), CASES)
def test_real_tumors_are_recovered_from_the_two_volumes_alone(
    shared_data: Path, tmp_path: Path, case: str, least_enhancing: float, least_core: float
) -> None:
    folder = shared_data / "volumes" / case
    words = ["segment", "--post", folder / "t1c.nii.gz", "--pre", folder / "t1.nii.gz", "--out", tmp_path, "--json"]
    done = subprocess.run(
        [sys.executable, "-m", "shapery_client", *map(str, words)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report == json.loads((tmp_path / "report.json").read_text())

    labels, expert = read_volume(tmp_path / "labels.nii.gz"), read_volume(folder / "seg.nii.gz")
    assert labels.same_grid(read_volume(folder / "t1c.nii.gz"))
    assert intersection_over_union(labels.data == 1, expert.data == 4) >= least_enhancing
    core = intersection_over_union(np.isin(labels.data, (1, 2)), np.isin(expert.data, (1, 4)))
    assert core >= least_core

    assert report["objects"]
    for item in report["objects"]:
        surface = read_mesh(tmp_path / item["surface"])
        assert surface.closed
        assert surface.manifold
        assert surface.oriented
        assert len(self_intersections(surface)) == 0
        assert item["self_intersections"] == 0
    assert (tmp_path / "surface.ply").stat().st_size > 0
    assert (tmp_path / "scene.glb").read_bytes()[:4] == b"glTF"

"""three.js shows an exported scene as the motion file decodes; the dashboard has the package."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from shapery_motion import open_motion
from shapery_motion.container.connectivity import sorted_faces
from shapery_motion.exporting import DEFAULT_FPS, export
from tests.conftest import ROOT

NODE = shutil.which("node")
THREE = ROOT / "services" / "dashboard" / "node_modules" / "three"
SCRIPT = ROOT / "tests" / "support" / "three" / "scene.mjs"
GOLDEN = Path(__file__).parent / "golden" / "trajectory-1.3"

pytestmark = [
    pytest.mark.skipif(NODE is None, reason="Node.js is not on the path"),
    pytest.mark.skipif(not THREE.is_dir(), reason="the dashboard's packages are not set up"),
]


@pytest.mark.parametrize("name", ["waving", "bodies", "repeated", "triangle"])
def test_three_shows_what_is_decoded(name: str, tmp_path: Path) -> None:
    motion = open_motion(GOLDEN / f"{name}.smc")
    scene, found = tmp_path / "scene.glb", tmp_path / "shown.json"
    export(motion, scene, "glb", scratch=tmp_path)
    numbers = sorted({0, 1, len(motion) // 2, len(motion) - 2})
    times = [str(number / (motion.header.fps or DEFAULT_FPS)) for number in numbers]
    done = subprocess.run(
        [str(NODE), SCRIPT, THREE, scene, found, *times], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(found.read_text())
    assert told["meshes"] == 1
    assert told["targets"] == len(motion) - 1  # the first frame is the mesh itself
    assert np.array_equal(sorted_faces(np.array(told["faces"], dtype=np.int32).reshape(-1, 3)), motion.faces)
    expected = np.stack([motion.frame(number) for number in numbers])
    assert np.abs(np.array(told["vertices"]) - expected).max() <= 1e-6 * np.abs(expected).max()

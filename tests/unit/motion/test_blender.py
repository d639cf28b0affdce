"""Blender shows an exported scene as the motion file decodes.

Blender is no part of the project: ``SHAPERY_BLENDER`` names its program, or a Python in which its module ``bpy`` is
installed (``pip install bpy``).
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from shapery_motion import open_motion
from shapery_motion.container.connectivity import sorted_faces
from shapery_motion.exporting import DEFAULT_FPS, export
from tests.conftest import ROOT

BLENDER = os.environ.get("SHAPERY_BLENDER", "")
SCRIPT = ROOT / "tests" / "support" / "blender" / "scene.py"
GOLDEN = Path(__file__).parent / "golden" / "trajectory-1.3"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not BLENDER, reason="SHAPERY_BLENDER names neither Blender nor a Python with bpy"),
]


@pytest.mark.parametrize("name", ["waving", "bodies", "repeated", "triangle"])
def test_blender_shows_what_is_decoded(name: str, tmp_path: Path) -> None:
    motion = open_motion(GOLDEN / f"{name}.smc")
    scene, found = tmp_path / "scene.glb", tmp_path / "shown.npz"
    export(motion, scene, "glb", scratch=tmp_path)
    numbers = sorted({0, 1, len(motion) // 2, len(motion) - 1})
    times = [str(number / (motion.header.fps or DEFAULT_FPS)) for number in numbers]
    start = [BLENDER] if "python" in Path(BLENDER).name else [BLENDER, "--background", "--python"]
    done = subprocess.run(
        [*start, SCRIPT, "--", scene, found, *times], capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stderr
    told = np.load(found)
    assert told["keys"] == len(motion)
    assert np.array_equal(sorted_faces(told["faces"].astype(np.int32)), motion.faces)
    expected = np.stack([motion.frame(number) for number in numbers])
    assert np.abs(told["vertices"] - expected).max() <= 1e-6 * np.abs(expected).max()

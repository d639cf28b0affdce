"""The adapter from a job to the library."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from shapery_contracts.errors import InvalidInput, JobCancelled
from shapery_contracts.handler import MAX_PREVIEW
from shapery_contracts.kinds import get_kind
from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.volume_io import write_nifti
from shapery_segmentation.evolution import read_evolution
from shapery_segmentation.job import SegmentationHandler
from shapery_segmentation.phantoms import HeadPhantom


class Context:
    """What the runtime would offer."""

    bank = None

    def __init__(self, folder: Path, cancel_in: str = "") -> None:
        self.output = folder / "output"
        self.scratch = folder / "scratch"
        self.output.mkdir()
        self.stages: list[str] = []
        self.fractions: list[float] = []
        self.previews: list[bytes] = []
        self.cancel_in = cancel_in

    def stage(self, name: str, fraction: float, message: str = "") -> None:
        self.stages.append(name)
        self.fractions.append(fraction)

    def progress(self, fraction: float, message: str = "") -> None:
        self.fractions.append(fraction)

    def preview(self, make: Callable[[], bytes]) -> None:
        self.previews.append(make())

    def check_cancelled(self) -> None:
        if self.stages and self.stages[-1] == self.cancel_in:
            raise JobCancelled


@pytest.fixture(scope="module")
def files(head: HeadPhantom, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("inputs")
    for name, volume in (("post", head.post), ("pre", head.pre)):
        write_nifti(volume, folder / f"{name}.nii.gz")
    return {name: folder / f"{name}.nii.gz" for name in ("post", "pre")}


@pytest.mark.slow
def test_a_job_leaves_its_files_and_returns_its_report(files: dict[str, Path], tmp_path: Path) -> None:
    context = Context(tmp_path)
    result = SegmentationHandler().run(SegmentationParams(), files, context)
    kind = get_kind(SegmentationHandler.kind)
    # Without a volume that shows vessels there is no such stage.
    stages = tuple(stage for stage in kind.stages if stage != "vessels")
    assert tuple(context.stages) == stages
    assert tuple(stage.name for stage in result.stages) == stages
    assert context.fractions == sorted(context.fractions)
    assert context.fractions[0] == 0.0
    assert context.fractions[-1] == 1.0
    assert len(result.objects) == 1
    written = {str(p.relative_to(context.output)) for p in context.output.rglob("*") if p.is_file()}
    assert written == {
        "labels.nii.gz", "surface.ply", "surfaces/1.ply", "scene.glb", "evolution.bin", "report.json",
    }  # fmt: skip
    assert json.loads((context.output / "report.json").read_text()) == result.model_dump(mode="json")

    # What was shown meanwhile is how it grew, and in the end what came out.
    (tmp_path / "preview").write_bytes(context.previews[-1])
    (shown,) = read_evolution(tmp_path / "preview")
    assert shown.mesh.volume == pytest.approx(result.objects[0].volume_mm3, rel=0.05)
    assert len(context.previews) > 3
    assert max(map(len, context.previews)) <= MAX_PREVIEW


@pytest.mark.parametrize("stage", ["read", "seed", "evolve"])
@pytest.mark.slow
def test_cancelling_ends_the_job(files: dict[str, Path], tmp_path: Path, stage: str) -> None:
    context = Context(tmp_path, cancel_in=stage)
    with pytest.raises(JobCancelled):
        SegmentationHandler().run(SegmentationParams(), files, context)
    assert not list(context.output.iterdir())


def test_the_volume_after_contrast_is_needed(files: dict[str, Path], tmp_path: Path) -> None:
    with pytest.raises(InvalidInput) as caught:
        SegmentationHandler().run(SegmentationParams(), {"pre": files["pre"]}, Context(tmp_path))
    assert caught.value.code == "missing_input"


def test_importing_the_handler_loads_no_numerics() -> None:
    code = "import sys, shapery_segmentation.job; print([m for m in ('numpy', 'scipy', 'numba') if m in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"

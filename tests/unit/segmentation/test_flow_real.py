"""The normal flow on heads with an expert's labels: from the enhancing rim to the enhancing tumor."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import icosphere
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume
from shapery_segmentation.brain import find_brain
from shapery_segmentation.calibration import calibrate
from shapery_segmentation.flow import normal_flow
from shapery_segmentation.gate import reach

pytestmark = pytest.mark.data


@pytest.mark.parametrize(
    ("case", "least"),
    [("tumor_brats18_tcia01_231_1", 0.83), ("tumor_brats21_00006", 0.77)],
    ids=["tcia01_231", "00006"],
)
@pytest.mark.slow
def test_a_ball_in_the_rim_becomes_the_enhancing_tumor(shared_data: Path, case: str, least: float) -> None:
    folder = shared_data / "volumes" / case
    pre, post, labels = (read_volume(folder / f"{name}.nii.gz") for name in ("t1", "t1c", "seg"))
    brain = find_brain(pre, post)
    field = calibrate(brain, post, pre).field
    expert = brain.grid.sample(labels.with_data((labels.data == 4).astype(np.float32))) > 0.5

    # The expert chooses where to start, and judges; nothing else.
    depth = ndimage.distance_transform_edt(expert)
    start = np.unravel_index(int(depth.argmax()), depth.shape)
    ball = np.zeros(expert.shape, dtype=np.bool_)
    ball[tuple(slice(i - 2, i + 3) for i in start)] = True
    region = reach(field, brain.mask, ball & (field > 2.25), brain.grid.spacing)
    affine = brain.grid.affine.copy()
    affine[:3, 3] += affine[:3, :3] @ [s.start for s in region.box]
    center = brain.grid.affine[:3, :3] @ start + brain.grid.affine[:3, 3]
    result = normal_flow(
        field[region.box], region.allowed, affine, icosphere(center, 2.0, 2), threshold=region.threshold
    )

    assert result.converged
    assert result.mesh.closed
    assert result.mesh.manifold
    assert result.mesh.oriented
    assert result.mesh.genus == 0
    assert len(self_intersections(result.mesh)) == 0
    inside = np.zeros(expert.shape, dtype=np.bool_)
    inside[region.box] = rasterize(result.mesh, Volume(field[region.box], affine))
    # Without the seam closed that the fronts leave, which costs a ball more than a seed of the whole region.
    assert (inside & expert).sum() / (inside | expert).sum() >= least

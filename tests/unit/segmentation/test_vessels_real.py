"""Vessels of real volumes: no truth, but what a vessel tree is can be told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from shapery_geometry.intersections import self_intersections
from shapery_geometry.volume_io import read_volume
from shapery_segmentation.vessels import segment_vessels

pytestmark = [pytest.mark.data, pytest.mark.slow]


def test_aorta_in_ct(shared_data: Path) -> None:
    folder = shared_data / "volumes" / "vessel_aorta_ct_vmtk"
    found = segment_vessels(read_volume(folder / "aorta.mha"))
    assert found.polarity == "bright"
    # The reference is a signed distance of one segment only, so it tells what must be in, not what must not.
    reference = read_volume(folder / "reference_levelset.mha").data < 0
    assert found.mask[reference].mean() > 0.95
    assert found.mask.mean() < 0.05
    largest = found.trees[0]
    assert largest.radius_range_mm[1] == pytest.approx(10.5, abs=1.5)
    assert largest.length_mm > 300
    for tree in found.trees:
        assert tree.surface.closed
        assert tree.surface.manifold
        assert len(self_intersections(tree.surface)) == 0


def test_arteries_in_mra(shared_data: Path) -> None:
    volume = read_volume(shared_data / "volumes" / "vessel_mra_chris" / "chris_MRA.nii.gz")
    found = segment_vessels(volume)
    assert found.polarity == "bright"
    assert 1 <= len(found.trees) <= 16
    # Without the brain all that is left is vessel: what is bright is in.
    bright = volume.data > 100
    assert found.mask[bright].mean() > 0.8
    assert (volume.data[found.mask] > 0).mean() > 0.95
    assert found.trees[0].length_mm > 250
    assert found.trees[0].forks > 10
    assert 0.5 < found.trees[0].mean_radius_mm < 2.0
    for tree in found.trees:
        assert tree.surface.closed
        assert tree.surface.oriented
        assert len(self_intersections(tree.surface)) == 0
    assert not np.isnan(found.branches[0].radii).any()

"""Agreement of masks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mask_metrics import dice, intersection_over_union, mask_metrics, surface_distances


def block(start: int, stop: int, shape: tuple[int, int, int] = (20, 12, 12)) -> np.ndarray:
    mask = np.zeros(shape, bool)
    mask[start:stop, 3:9, 3:9] = True
    return mask


def test_identical_masks() -> None:
    m = mask_metrics(block(3, 9), block(3, 9), (1, 2, 3))
    assert (m.iou, m.dice, m.volume_difference, m.assd_mm, m.hd95_mm, m.hd_mm) == (1, 1, 0, 0, 0, 0)
    assert m.result_mm3 == m.reference_mm3 == 6**3 * 6


def test_overlap_of_shifted_blocks() -> None:
    a, b = block(3, 9), block(5, 11)
    assert intersection_over_union(a, b) == pytest.approx(4 / 8)
    assert dice(a, b) == pytest.approx(2 * 4 / 12)
    assert mask_metrics(a, block(3, 12)).volume_difference == pytest.approx(6 / 9 - 1)


def test_distances_follow_the_spacing() -> None:
    # Two slabs a voxel thick, 4 voxels apart along the first axis.
    a, b = np.zeros((9, 5, 5), bool), np.zeros((9, 5, 5), bool)
    a[2], b[6] = True, True
    for step in (1.0, 2.5):
        m = mask_metrics(a, b, (step, 1, 1))
        assert m.assd_mm == m.hd95_mm == m.hd_mm == pytest.approx(4 * step)
    assert mask_metrics(a, b, (1, 7, 7)).assd_mm == pytest.approx(4)


def test_percentile_forgives_few_far_voxels_and_is_symmetric() -> None:
    a = block(3, 15)
    b = a.copy()
    b[19, 0, 0] = True
    there, back = mask_metrics(a, b), mask_metrics(b, a)
    assert there.hd_mm == back.hd_mm == pytest.approx(math.sqrt(5**2 + 3**2 + 3**2))
    assert there.hd95_mm == back.hd95_mm == 0
    assert there.assd_mm == back.assd_mm > 0


def test_surface_is_found_at_the_border_of_the_array() -> None:
    full = np.ones((4, 4, 4), bool)
    distances, _ = surface_distances(full, full)
    assert len(distances) == 4**3 - 2**3


def test_empty_masks() -> None:
    none, some = np.zeros((5, 5, 5), bool), np.ones((5, 5, 5), bool)
    both = mask_metrics(none, none)
    assert both.iou == both.dice == 1
    assert both.volume_difference == 0
    assert math.isnan(both.hd95_mm)
    missed, invented = mask_metrics(none, some), mask_metrics(some, none)
    assert missed.iou == invented.iou == missed.dice == 0
    assert missed.volume_difference == -1
    assert invented.volume_difference == math.inf
    assert missed.assd_mm == invented.hd_mm == math.inf
    with pytest.raises(ValueError, match="without voxels"):
        surface_distances(none, some)


def test_refuses_what_cannot_be_compared() -> None:
    with pytest.raises(InvalidInput) as caught:
        mask_metrics(np.zeros((2, 3, 4)), np.zeros((2, 3, 5)))
    assert caught.value.code == "grid_mismatch"
    with pytest.raises(ValueError, match="three positive lengths"):
        mask_metrics(np.ones((2, 2, 2)), np.ones((2, 2, 2)), (1, 0, 1))

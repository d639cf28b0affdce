"""The mask of the brain."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Volume
from shapery_segmentation.brain import closed, find_brain, largest_part, otsu
from shapery_segmentation.phantoms import HeadPhantom


def cavity_of(head: HeadPhantom) -> np.ndarray:
    """Whether a voxel lies inside the skull of an unrotated phantom, from the formula it was drawn by."""
    from shapery_segmentation.phantoms import _anatomy_kernels as kernels

    inside = np.zeros(head.pre.shape, bool)
    kernels.within_cavity(np.ascontiguousarray(head.pre.affine[:3]), 0.0, inside)
    return inside


@pytest.mark.slow
def test_brain_of_a_whole_head(head: HeadPhantom) -> None:
    brain = find_brain(head.pre, head.post)
    assert not brain.stripped
    mask = brain.grid.to_source(brain.mask)
    inside = cavity_of(head)
    # No scalp and no bone, most of the brain, and every voxel of the tumor.
    assert np.count_nonzero(mask & inside) > 0.97 * np.count_nonzero(mask)
    assert np.count_nonzero(mask & inside) > 0.75 * np.count_nonzero(inside)
    assert mask[head.truth.data > 0].mean() > 0.97


def test_stripped_brain_is_taken_as_it_is(tilted_head: HeadPhantom) -> None:
    brain = find_brain(tilted_head.pre, tilted_head.post)
    assert brain.stripped
    mask = brain.grid.to_source(brain.mask)
    given = tilted_head.pre.data > 0
    assert np.count_nonzero(mask ^ given) < 0.01 * np.count_nonzero(given)


def test_any_constant_may_be_the_background(tilted_head: HeadPhantom) -> None:
    given = (tilted_head.pre, tilted_head.post)
    pre, post = (v.with_data(np.where(v.data > 0, v.data / 500.0 - 1.0, -3.25)) for v in given)
    brain = find_brain(pre, post)
    assert brain.stripped
    expected = find_brain(tilted_head.pre, tilted_head.post)
    assert np.count_nonzero(brain.mask ^ expected.mask) < 0.005 * np.count_nonzero(expected.mask)


def test_a_volume_without_a_brain_is_refused() -> None:
    rng = np.random.default_rng(0)
    data = rng.normal(10, 1, (60, 60, 60)).astype(np.float32)
    data[20:40, 20:40, 20:40] += 500
    volume = Volume(data, np.eye(4))
    with pytest.raises(InvalidInput, match="too little") as caught:
        find_brain(volume, volume)
    assert caught.value.code == "invalid_volume"
    assert caught.value.hint


def test_volumes_of_different_places_are_refused(tilted_head: HeadPhantom) -> None:
    away = tilted_head.pre.affine.copy()
    away[:3, 3] += 500.0
    with pytest.raises(InvalidInput, match="no place in common") as caught:
        find_brain(Volume(tilted_head.pre.data, away), tilted_head.post)
    assert caught.value.hint


def test_otsu_lies_between_two_classes() -> None:
    rng = np.random.default_rng(1)
    values = np.concatenate((rng.normal(0, 1, 5000), rng.normal(20, 2, 3000)))
    assert 4 < otsu(values) < 14
    # A few extreme voxels do not move it out of the range of the others.
    assert 4 < otsu(np.concatenate((values, [1e6]))) < 14
    assert otsu(np.full(10, 3.0)) == 3.0


def test_largest_part_and_closing() -> None:
    mask = np.zeros((20, 20, 20), bool)
    mask[2:5, 2:5, 2:5] = True
    mask[8:16, 8:16, 8:16] = True
    assert largest_part(mask).sum() == 8**3
    shell = mask.copy()
    shell[10:14, 10:14, 10:14] = False
    shell[12, 12, 14:] = False
    filled = closed(largest_part(shell), 2)
    assert filled[8:16, 8:16, 8:16].all()
    assert ndimage.label(filled)[1] == 1
    assert not largest_part(np.zeros((3, 3, 3), bool)).any()

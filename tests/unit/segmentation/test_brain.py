"""The mask of the brain."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Volume
from shapery_segmentation.brain import closed, find_brain, largest_part, otsu, surrounded
from shapery_segmentation.phantoms import HeadPhantom, head_phantom


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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "rotation", "noise"),
    [
        # The scalp is the largest part of what is bright, and the neck is cut off askew.
        (90007, (13.0, -10.0, 12.0), 0.05),
        (90055, (2.0, 15.0, -3.0), 0.05),
        # The base of the skull is thin: face and brain hang together.
        (50015, (10.0, -10.0, -3.0), 0.025),
        (50026, (13.0, -8.0, 10.0), 0.025),
    ],
)
def test_brain_of_a_tilted_head(seed: int, rotation: tuple[float, float, float], noise: float) -> None:
    def drawn(*, stripped: bool) -> HeadPhantom:
        rng = np.random.default_rng(seed)
        return head_phantom(
            rng, (136, 160, 136), (1.25, 1.25, 1.25), tumors=(), rotation=rotation, noise=noise, stripped=stripped
        )

    whole, inside = drawn(stripped=False), drawn(stripped=True).pre.data > 0
    brain = find_brain(whole.pre, whole.post)
    mask = brain.grid.to_source(brain.mask)
    assert not brain.stripped
    assert np.count_nonzero(mask & inside) > 0.9 * np.count_nonzero(inside)
    assert np.count_nonzero(mask & ~inside) < 0.15 * np.count_nonzero(inside)


def test_what_is_met_from_four_sides_is_surrounded() -> None:
    ring = np.zeros((9, 9, 9), bool)
    ring[1:8, 1:8, 2:7] = True
    ring[2:7, 2:7] = False  # a tube, open at both ends
    filled = ring.copy()
    filled[2:7, 2:7, 2:7] = True
    np.testing.assert_array_equal(surrounded(ring), filled)
    ring[1:3] = False  # and at one side
    assert not surrounded(ring)[4, 4].any()


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

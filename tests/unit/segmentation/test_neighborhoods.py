"""Sets of voxels, beside what SciPy makes of the same."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from shapery_segmentation.neighborhoods import (
    connected,
    depths,
    dilated,
    eroded,
    filled,
    parts,
    within,
    within_each,
    without_small,
)

FACES, EDGES, CORNERS = (ndimage.generate_binary_structure(3, reach) for reach in (1, 2, 3))


@pytest.fixture(params=[(20, 31, 17), (1, 9, 12), (40, 40, 40)])
def mask(request: pytest.FixtureRequest) -> np.ndarray:
    random = np.random.default_rng(7).normal(size=request.param)
    return np.asarray(ndimage.gaussian_filter(random, 1.5) > 0.02)


@pytest.mark.parametrize("steps", [0, 1, 2, 5])
def test_growing_and_shrinking_alternate_between_faces_and_edges(mask: np.ndarray, steps: int) -> None:
    grown = shrunk = mask
    for step in range(steps):
        grown = ndimage.binary_dilation(grown, EDGES if step % 2 else FACES)
        shrunk = ndimage.binary_erosion(shrunk, EDGES if step % 2 else FACES)
    np.testing.assert_array_equal(dilated(mask, steps), grown)
    np.testing.assert_array_equal(eroded(mask, steps), shrunk)


def test_depths_are_distances_from_what_is_outside(mask: np.ndarray) -> None:
    expected = ndimage.distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1, 1:-1]
    np.testing.assert_allclose(depths(mask), expected, rtol=1e-6)


def test_the_middle_of_a_large_ball_is_as_deep_as_its_radius() -> None:
    place = np.indices((95, 95, 95)) - 47.0
    ball = (place**2).sum(axis=0) <= 45.0**2
    np.testing.assert_allclose(depths(ball), ndimage.distance_transform_edt(ball), rtol=1e-6)


def test_depths_beyond_what_is_asked_for_are_only_more_than_that() -> None:
    ball = ((np.indices((41, 41, 41)) - 20.0) ** 2).sum(axis=0) <= 19.0**2
    far, near = depths(ball), depths(ball, 6)
    np.testing.assert_array_equal(near[far <= 6], far[far <= 6])
    assert near[far > 6].min() > 6


def test_within_is_the_distance_transform() -> None:
    mask = np.random.default_rng(2).random((20, 19, 18)) < 0.01
    for radius in (1.0, 2.9, 4.2):
        np.testing.assert_array_equal(within(mask, radius), ndimage.distance_transform_edt(~mask) <= radius)
    solid = np.pad(np.ones((6, 6, 6), bool), 5)
    np.testing.assert_array_equal(within(solid, 2.9), ndimage.distance_transform_edt(~solid) <= 2.9)


def test_several_radii_at_once_are_those_one_by_one() -> None:
    mask = np.random.default_rng(3).random((9, 30, 12)) < 0.003
    near, far = within_each(mask, (2.0, 6.5))
    np.testing.assert_array_equal(near, within(mask, 2.0))
    np.testing.assert_array_equal(far, within(mask, 6.5))
    with pytest.raises(ValueError, match="distances"):
        within(mask, 100.0)


def test_connected_parts_are_those_of_scipy() -> None:
    noise = ndimage.gaussian_filter(np.random.default_rng(4).normal(size=(20, 17, 23)), 1.5)
    mask = noise > 0.1
    labels, count = ndimage.label(mask)
    assert count > 3
    start = np.isin(labels, (1, 3)) & (np.random.default_rng(5).random(mask.shape) < 0.3)
    start |= ~mask
    expected = np.isin(labels, np.unique(labels[start & mask])) & mask
    np.testing.assert_array_equal(connected(mask, start), expected)
    np.testing.assert_array_equal(connected(np.asfortranarray(mask), start), expected)
    assert not connected(mask, np.zeros_like(mask)).any()


def test_parts_are_those_of_scipy(mask: np.ndarray) -> None:
    sparse = mask & (np.random.default_rng(6).random(mask.shape) < 0.3)
    labels, count = ndimage.label(sparse, CORNERS)
    found = parts(sparse)
    assert len(found) == count > 1
    for number, part in enumerate(found, start=1):
        np.testing.assert_array_equal(np.sort(part), np.flatnonzero(labels == number))
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    np.testing.assert_array_equal(without_small(sparse, 3), sizes[labels] >= 3)
    nothing = np.zeros_like(mask)
    assert parts(nothing) == []
    assert not without_small(nothing, 1).any()


def test_holes_are_filled_and_bays_are_not(mask: np.ndarray) -> None:
    np.testing.assert_array_equal(filled(mask), ndimage.binary_fill_holes(mask))
    shell = np.zeros((9, 9, 9), dtype=np.bool_)
    shell[1:8, 1:8, 1:8] = True
    shell[3:6, 3:6, 3:6] = False
    assert filled(shell)[4, 4, 4]
    shell[4, 4, :4] = False
    assert not filled(shell)[4, 4, 4]

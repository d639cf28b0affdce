"""Whose the voxels of a box are: the object's in its middle, or its surroundings'."""

from __future__ import annotations

import numpy as np

from shapery_geometry.mask_metrics import intersection_over_union
from shapery_segmentation.competition import around, compete


def ball(center: tuple[float, float, float], radius: float) -> np.ndarray:
    at = np.moveaxis(np.indices((30, 30, 30)), 0, -1)
    return np.asarray(np.linalg.norm(at - center, axis=-1) < radius)


def box_of(mask: np.ndarray) -> np.ndarray:
    index = np.argwhere(mask)
    box = np.zeros(mask.shape, dtype=np.bool_)
    box[tuple(slice(a, b + 1) for a, b in zip(index.min(axis=0), index.max(axis=0), strict=True))] = True
    return box


def test_a_ball_in_its_box_is_told_from_both_sides() -> None:
    truth = ball((14.0, 15.0, 13.0), 7.0)
    noise = np.random.default_rng(0).normal(0.0, 0.2, truth.shape)
    for sign in (1.0, -1.0):
        likely = compete((sign * truth + noise).astype(np.float32), box_of(truth))
        assert likely.min() >= 0.0
        assert likely.max() <= 1.0
        assert not likely[~box_of(truth)].any()
        assert intersection_over_union(likely > 0.5, truth) > 0.95


def test_a_neighbour_of_the_same_intensity_is_left_outside() -> None:
    truth, other = ball((10.0, 15.0, 15.0), 7.0), ball((23.0, 15.0, 15.0), 7.0)
    values = (truth | other) + np.random.default_rng(1).normal(0.0, 0.2, truth.shape)
    likely = compete(values.astype(np.float32), box_of(truth))
    assert intersection_over_union(likely > 0.5, truth) > 0.9


def test_values_that_tell_nothing_leave_the_expectation() -> None:
    box = box_of(ball((15.0, 15.0, 15.0), 8.0))
    found = compete(np.zeros(box.shape, dtype=np.float32), box) > 0.5
    assert found[15, 15, 15]
    assert not found[box.nonzero()[0].min(), box.nonzero()[1].min(), box.nonzero()[2].min()]


def test_bins_hold_equal_parts_so_that_air_in_the_box_does_not_hide_tissue() -> None:
    """Soft tissues that differ by a fiftieth of what air and bone span."""
    rng = np.random.default_rng(2)
    truth = ball((15.0, 15.0, 15.0), 9.0)
    values = 20.0 + 30.0 * truth + rng.normal(0.0, 10.0, truth.shape)
    at = np.indices(truth.shape)
    values[(at[0] < 9) & ~truth] = -1000.0 + rng.normal(0.0, 20.0)
    values[(at[0] > 21) & (at[1] > 20) & ~truth] = 700.0
    assert intersection_over_union(compete(values.astype(np.float32), box_of(truth)) > 0.5, truth) > 0.85


def test_what_is_one_tissue_does_not_win_another_that_lies_in_the_middle_too() -> None:
    """Half a ball fills its box badly: there is as much fat in the middle as there is organ."""
    rng = np.random.default_rng(3)
    at = np.indices((30, 30, 30))
    truth = ball((15.0, 15.0, 15.0), 11.0) & ~ball((19.0, 15.0, 15.0), 8.0)
    values = np.where(truth, 50.0, -90.0) + rng.normal(0.0, 12.0, truth.shape)
    values[(at[0] > 25) & ~truth] = 20.0
    assert intersection_over_union(compete(values.astype(np.float32), box_of(truth)) > 0.5, truth) > 0.85


def test_an_object_of_two_tissues_is_still_one() -> None:
    """A dark core in a bright rim, both unlike what is around."""
    rng = np.random.default_rng(4)
    truth, core = ball((15.0, 15.0, 15.0), 10.0), ball((12.0, 15.0, 15.0), 7.0)
    values = np.where(core, 0.0, np.where(truth, 100.0, 50.0)) + rng.normal(0.0, 8.0, truth.shape)
    assert intersection_over_union(compete(values.astype(np.float32), box_of(truth)) > 0.5, truth) > 0.85


def test_a_seed_tells_of_which_tissue_an_object_is_that_leaves_the_middle_of_its_box() -> None:
    """A bowl: the middle of its box is what lies in it, which is unlike all else."""
    rng = np.random.default_rng(5)
    content = ball((17.0, 15.0, 15.0), 9.0)
    truth = ball((15.0, 15.0, 15.0), 12.0) & ~content
    values = np.where(content, 150.0, np.where(truth, 50.0, -90.0)) + rng.normal(0.0, 12.0, truth.shape)
    seed = np.array((4, 15, 15))
    assert truth[tuple(seed)]
    found = compete(values.astype(np.float32), box_of(truth), around(box_of(truth), seed)) > 0.5
    assert intersection_over_union(found, truth) > 0.85
    assert intersection_over_union(compete(values.astype(np.float32), box_of(truth)) > 0.5, truth) < 0.7

"""The density gate."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from shapery_geometry.mask_metrics import intersection_over_union
from shapery_segmentation.gate import LEVEL, Region, dense, on_even_ground, reach, running_threshold
from shapery_segmentation.ground import ground_of, shell, standing_out, unevenness
from shapery_segmentation.neighborhoods import connected, eroded

SHAPE = (70, 60, 60)
INDEX = np.stack(np.meshgrid(*map(np.arange, SHAPE), indexing="ij"), axis=-1)


def ball(centre: tuple[int, int, int], radius: float) -> np.ndarray:
    return np.linalg.norm(INDEX - np.array(centre), axis=-1) <= radius


def tube(radius: float) -> np.ndarray:
    """Along the first axis, through the middle."""
    return np.hypot(INDEX[..., 1] - 30, INDEX[..., 2] - 30) <= radius


def test_vessels_and_sheets_are_not_dense() -> None:
    assert dense(ball((30, 30, 30), 8), 1.0).sum() > 0.85 * ball((30, 30, 30), 8).sum()
    assert not dense(tube(1.5), 1.0).any()
    sheet = np.abs(INDEX[..., 0] - 30) <= 0.6
    assert not dense(sheet, 1.0).any()
    # In finer voxels the same millimetres are more of them.
    assert not dense(tube(3.0), 0.5).any()


def test_threshold_runs_between_its_bounds() -> None:
    assert running_threshold(np.full(5, 4.0)) == pytest.approx(1.8)
    assert running_threshold(np.full(5, 1.0)) == 1.2
    assert running_threshold(np.full(5, 50.0)) == 2.25
    assert running_threshold(np.full(5, 4.0), -1.0) == pytest.approx(1.25)


def test_reach_fills_the_object_and_stops_at_a_vessel() -> None:
    first, second = ball((15, 30, 30), 9), ball((55, 30, 30), 9)
    field = np.where(first | second | tube(1.5), 6.0, 0.0).astype(np.float32)
    field = ndimage.gaussian_filter(field, 0.6)
    region = reach(field, np.ones(SHAPE, bool), ball((15, 30, 30), 2), 1.0)
    inside = np.zeros(SHAPE, bool)
    inside[region.box] = region.inside
    assert inside[first & ~tube(2.5)].mean() > 0.97
    assert not inside[second].any()
    # A stub of the vessel within reach of the ball belongs to what is allowed, no more.
    assert np.argwhere(inside)[:, 0].max() <= 15 + 9 + 4
    assert region.threshold == pytest.approx(2.25)
    assert not (region.inside & ~region.allowed).any()


def test_reach_follows_an_object_beyond_its_first_box() -> None:
    long = np.hypot(INDEX[..., 1] - 30, INDEX[..., 2] - 30) <= 6
    field = np.where(long & (INDEX[..., 0] > 1) & (INDEX[..., 0] < 68), 5.0, 0.0).astype(np.float32)
    region = reach(field, np.ones(SHAPE, bool), ball((4, 30, 30), 2), 1.0)
    inside = np.zeros(SHAPE, bool)
    inside[region.box] = region.inside
    assert inside[66, 30, 30]


def test_in_growing_boxes_an_object_is_what_it_is_in_one(monkeypatch: pytest.MonkeyPatch) -> None:
    # It gets weaker along its length, so that each round takes in more of it.
    noise = ndimage.gaussian_filter(np.random.default_rng(4).normal(size=SHAPE), 1.0)
    field = (np.where(tube(7), np.maximum(4.3 - 0.12 * INDEX[..., 0], 0.0), 0.0) + noise).astype(np.float32)
    brain, seed = np.ones(SHAPE, dtype=bool), ball((3, 30, 30), 3)
    boxes: list[tuple[int, ...]] = []

    def likely(inside: np.ndarray) -> float:
        boxes.append(inside.shape)
        return 1.0

    def found() -> tuple[np.ndarray, float, float, float]:
        boxes.clear()
        region = reach(field, brain, seed, 1.0, likely_shape=likely)
        inside = np.zeros(SHAPE, dtype=bool)
        inside[region.box] = region.inside
        return inside, region.threshold, region.ground, region.stands_out

    growing = found()
    assert boxes[1] != boxes[2]
    monkeypatch.setattr("shapery_segmentation.gate._MARGIN", 100)
    at_once = found()
    assert boxes[1:] == [SHAPE] * len(boxes[1:])
    assert growing[0].any()
    np.testing.assert_array_equal(growing[0], at_once[0])
    assert growing[1:] == at_once[1:]


def test_reach_gives_up_what_has_left_its_box_and_is_no_object() -> None:
    field = np.where(tube(6), 5.0, 0.0).astype(np.float32)
    brain = np.ones(SHAPE, dtype=bool)
    seed = ball((10, 30, 30), 3)
    asked: list[int] = []

    def hopeless(inside: np.ndarray) -> float:
        asked.append(int(inside.sum()))
        return 0.0

    region = reach(field, brain, seed, 1.0, likely_shape=hopeless)
    # About the seed, then about the region in the first box.
    assert asked == [int(seed.sum()), int(region.inside.sum())]
    whole = reach(field, brain, seed, 1.0, likely_shape=lambda inside: 1.0)
    assert asked[1] < whole.inside.sum() == tube(6).sum()
    # A doubtful shape is followed only if it began as an object's.
    assert reach(field, brain, seed, 1.0, likely_shape=lambda inside: 0.2).inside.sum() == asked[1]
    began = reach(field, brain, seed, 1.0, likely_shape=lambda inside: 0.9 if inside.sum() == seed.sum() else 0.2)
    assert began.inside.sum() > asked[1]
    # What lies in its first box is asked about in the end only.
    asked.clear()
    small = np.where(ball((35, 30, 30), 8), 5.0, 0.0).astype(np.float32)

    def likely(inside: np.ndarray) -> float:
        asked.append(int(inside.sum()))
        return 1.0

    reach(small, brain, ball((35, 30, 30), 3), 1.0, likely_shape=likely)
    assert len(asked) == 2


def test_what_is_reached_through_a_thick_sheet_is_left_out_again() -> None:
    # Meninges that slices of 3 mm have made thick: too dense for the usual gate.
    tumor = ball((30, 30, 30), 12)
    sheet = (INDEX[..., 0] >= 41) & (INDEX[..., 0] < 44)
    field = np.where(tumor | sheet, 6.0, 0.0).astype(np.float32)
    brain = np.ones(SHAPE, dtype=bool)
    assert connected(dense(tumor | sheet, 1.0) & eroded(tumor | sheet), tumor)[42, 5, 5]
    region = reach(field, brain, ball((30, 30, 30), 4), 1.0)
    inside = np.zeros(SHAPE, bool)
    inside[region.box] = region.inside
    # A stub of the sheet within reach of the tumor is left.
    assert intersection_over_union(inside, tumor) > 0.85
    # The same where the shape is refused.
    kept = reach(
        field, brain, ball((30, 30, 30), 4), 1.0, likely_shape=lambda there: float(there.sum() < 1.2 * tumor.sum())
    )
    assert intersection_over_union(kept.inside, tumor[kept.box]) > 0.85
    assert kept.parted
    assert not region.parted


def test_a_rim_is_followed_where_it_is_thin_and_a_meninx_beside_it_is_not() -> None:
    outer, necrosis = ball((35, 30, 30), 14), ball((37, 30, 30), 11)
    rim = outer & ~necrosis
    # 5 mm on the one side, 1 mm on the other; a sheet as bright touches it where it is thin.
    sheet = np.abs(INDEX[..., 0] - 50) <= 0.6
    field = np.where(rim | sheet, 6.0, 0.0).astype(np.float32)
    region = reach(field, np.ones(SHAPE, bool), ball((23, 30, 30), 2), 1.0)
    inside = np.zeros(SHAPE, bool)
    inside[region.box] = region.inside
    assert inside[rim].mean() > 0.97
    assert (inside & sheet & ~rim).sum() < 0.05 * (sheet & ~rim).sum()
    # An open cup encloses nothing on its other side, and stays as it is.
    cup = rim & (INDEX[..., 0] <= 35)
    region = reach(np.where(cup, 6.0, 0.0).astype(np.float32), np.ones(SHAPE, bool), ball((23, 30, 30), 2), 1.0)
    assert not (region.inside & ~cup[region.box]).any()


def test_a_weak_margin_is_no_leak() -> None:
    tumor, margin = ball((30, 30, 30), 9), ball((30, 30, 40), 9)
    rng = np.random.default_rng(6)
    field = np.where(tumor, 5.0, np.where(margin, 2.6, 0.0)).astype(np.float32) + rng.normal(0, 0.7, SHAPE).astype("f4")
    field = ndimage.gaussian_filter(field, 0.6)
    region = reach(field, np.ones(SHAPE, bool), ball((30, 30, 30), 4), 1.0)
    assert intersection_over_union(region.inside, (tumor | margin)[region.box]) > 0.85


def test_reach_of_a_speck_is_the_speck() -> None:
    field = np.zeros(SHAPE, np.float32)
    field[30, 30, 30] = 9.0
    region = reach(field, np.ones(SHAPE, bool), ball((30, 30, 30), 0.5), 1.0)
    assert region.inside.sum() == 1


def test_reach_keeps_to_the_brain() -> None:
    field = np.full(SHAPE, 5.0, np.float32)
    brain = ball((35, 30, 30), 12)
    region = reach(field, brain, ball((35, 30, 30), 2), 1.0)
    inside = np.zeros(SHAPE, bool)
    inside[region.box] = region.inside
    np.testing.assert_array_equal(inside, brain)


def tissue(level: float, seed: int = 0) -> np.ndarray:
    """Normal tissue with a deviation of 0.65 about `level`, mottled."""
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=SHAPE), 1.5)
    return np.asarray(level + 0.65 * noise / noise.std(), np.float32)


def test_reach_takes_in_weak_margins_but_no_bright_tissue() -> None:
    tumor, brain, seed = ball((35, 30, 30), 11), np.ones(SHAPE, bool), ball((35, 30, 30), 3)
    strength = np.clip(6.4 - 0.4 * np.linalg.norm(INDEX - np.array((35, 30, 30)), axis=-1), 1.8, 4.6)
    dark = reach(np.where(tumor, strength, tissue(-0.9)).astype(np.float32), brain, seed, 1.0)
    assert intersection_over_union(dark.inside, tumor[dark.box]) > 0.9
    assert dark.floor == 1.2
    # The border is looked for between what is inside and what is around, not above zero.
    bright = reach(np.where(tumor, strength, tissue(0.95)).astype(np.float32), brain, seed, 1.0)
    assert intersection_over_union(bright.inside, tumor[bright.box]) > 0.8
    assert dark.ground < -0.7
    assert bright.ground > 0.7
    # A bias field that differs between the volumes raises a lobe; the threshold that falls must not reach it.
    lobe = tissue(0.0) + np.where(INDEX[..., 0] > 40, 1.2, 0.0)
    beside = reach(np.where(tumor, strength, lobe).astype(np.float32), brain, seed, 1.0)
    assert intersection_over_union(beside.inside, tumor[beside.box]) > 0.75
    assert beside.floor == beside.threshold > 1.2


def contrast(field: np.ndarray, brain: np.ndarray, inside: np.ndarray, whole: np.ndarray) -> float:
    return standing_out(field[inside], ground_of(field[shell(whole, brain, 1.0)]))


def test_contrast_tells_objects_from_the_tail_of_normal_tissue() -> None:
    field, brain, part = tissue(0.0), np.ones(SHAPE, bool), ball((35, 30, 30), 8)
    assert contrast(np.where(part, field + 5.0, field), brain, part, part) > 4.0
    tail = field > 1.2
    assert contrast(field, brain, tail, tail) < 3.0
    assert contrast(np.zeros(SHAPE, np.float32), brain, part, part) == np.inf
    # What the object encloses is no surrounding.
    hollow = part & ~ball((35, 30, 30), 5)
    field = np.where(hollow, 5.0, np.where(part, -9.0, field)).astype(np.float32)
    assert contrast(field, brain, hollow, part) > contrast(field, brain, hollow, hollow)


def test_ground_is_uneven_only_where_it_differs() -> None:
    everywhere, whole = np.ones(SHAPE, bool), ball((35, 30, 30), 9)
    around = shell(whole, everywhere, 1.0)
    assert np.abs(unevenness(np.where(whole, 9.0, 0.7).astype(np.float32), around, 1.0)).max() < 1e-5
    slope = (0.1 * (INDEX[..., 0] - 35)).astype(np.float32)
    uneven = unevenness(np.where(whole, 9.0, slope), around, 1.0)
    # An average over 8 mm follows a slope less far; the middle lies where it was.
    left, right = uneven[25, 30, 30], uneven[45, 30, 30]
    assert right == pytest.approx(-left, abs=0.02)
    assert 0.3 < right < 1.0
    assert abs(uneven[35, 30, 30]) < 0.02
    # Nothing is known of the ground where there is no brain around, nor far from it.
    assert not unevenness(slope, shell(whole, whole, 1.0), 1.0).any()
    assert not unevenness(slope, shell(ball((8, 8, 8), 3), everywhere, 1.0), 1.0)[60:, 50:, 50:].any()


def test_border_lies_at_one_share_of_the_way_on_uneven_ground() -> None:
    whole, step = ball((35, 30, 30), 10), 1.4
    ground = np.where(INDEX[..., 0] < 35, -step / 2, step / 2)
    field = ndimage.gaussian_filter(np.where(whole, 4.0, ground), 1.5).astype(np.float32)
    everywhere = np.ones(SHAPE, bool)
    around = shell(whole, everywhere, 1.0)
    box = (slice(0, SHAPE[0]), slice(0, SHAPE[1]), slice(0, SHAPE[2]))
    region = Region(box, whole, everywhere, threshold=LEVEL * 4.0)

    def ends(values: np.ndarray) -> tuple[float, float]:
        """Where the line through the middle falls below the threshold, to the left and to the right of it."""
        line = values[:, 30, 30] - region.threshold
        left = np.interp(0.0, line[18:30], np.arange(18, 30))
        right = np.interp(0.0, -line[40:52], np.arange(40, 52))
        return 35.0 - float(left), float(right) - 35.0

    left, right = ends(field)
    assert right - left > 0.4
    even = on_even_ground(field, region, around, 1.0)
    assert even.dtype == np.float32
    left, right = ends(even)
    assert abs(right - left) < 0.2
    # A threshold at its lower bound is higher than this share already, by more than the ground rises.
    bounded = Region(box, whole, everywhere, threshold=3.0, floor=3.0)
    kept = on_even_ground(field, bounded, around, 1.0)
    assert np.array_equal(kept[40:], field[40:])
    assert (kept[24:30, 30, 30] > field[24:30, 30, 30]).all()

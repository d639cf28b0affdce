"""Fit of one volume to the other, and the calibrated difference."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Volume
from shapery_segmentation.brain import Brain, find_brain
from shapery_segmentation.calibration import STEADIER, _light, calibrate, compare, evened, trimmed_fit
from shapery_segmentation.phantoms import HeadPhantom
from shapery_segmentation.preparation import working_grid


def test_trimmed_fit_ignores_what_enhances() -> None:
    rng = np.random.default_rng(0)
    x = rng.normal(100, 20, 20_000)
    y = 3.0 * x + 50 + rng.normal(0, 5, x.size)
    y[:2000] += rng.uniform(100, 500, 2000)
    slope, offset = trimmed_fit(x, y)
    # A tenth of outliers pulls plain least squares to an offset of 80; noise alone leaves 0.01 and 1.
    assert slope == pytest.approx(3.0, abs=0.03)
    assert offset == pytest.approx(50.0, abs=3.0)


def test_trimmed_fit_of_a_constant_has_no_slope() -> None:
    assert trimmed_fit(np.full(500, 3.0), np.arange(500.0)) == (0.0, pytest.approx(249.5))


def test_evening_takes_out_the_coil_and_leaves_the_tissue() -> None:
    index = np.stack(np.meshgrid(*(np.arange(70),) * 3, indexing="ij"), axis=-1)
    mask = np.linalg.norm(index - 34.5, axis=-1) < 33
    tissue = np.where((index // 7).sum(axis=-1) % 2, 100.0, 80.0)
    tissue[np.linalg.norm(index - (34, 34, 50), axis=-1) < 6] = 200.0
    coil = np.exp((index[..., 0] - 34.5) / 70.0)
    even = evened((tissue * coil).astype(np.float32), mask, 2.2)
    plain = evened(tissue.astype(np.float32), mask, 2.2)
    assert not even[~mask].any()
    # The coil makes a factor of 2.6 from side to side; a part of it remains near the edge.
    ratio = even[mask] / plain[mask]
    assert np.percentile(ratio, 95) / np.percentile(ratio, 5) < 1.35
    assert np.median(even[34, 34, 48:53]) / np.median(even[mask]) == pytest.approx(200 / 90, rel=0.1)


def test_field_does_not_depend_on_either_scale(head: HeadPhantom) -> None:
    brain = find_brain(head.pre, head.post)
    field = calibrate(brain, head.post, head.pre).field
    other = calibrate(
        brain,
        head.post.with_data(head.post.data.astype(np.float64) * 0.013 + 5.0),
        head.pre.with_data(head.pre.data.astype(np.float64) * 41.0 - 900.0),
    ).field
    # float32 arithmetic on other magnitudes.
    np.testing.assert_allclose(other, field, atol=2e-3)


def test_noise_that_is_smoothed_away_does_not_change_the_scale(head: HeadPhantom) -> None:
    brain = find_brain(head.pre, head.post)
    rim = brain.grid.sample(head.truth) == 1
    quiet = calibrate(brain, head.post, head.pre)
    rng = np.random.default_rng(7)
    # Alone it has 1.2 of the difference's deviation: before the smoothing it makes that 1.6 times as large.
    noise = rng.normal(0.0, 1.2 * quiet.noise, head.post.shape).astype(np.float32)
    noisy = calibrate(brain, head.post.with_data(head.post.data + noise), head.pre)
    assert np.median(noisy.field[rim]) > 0.75 * np.median(quiet.field[rim])


def test_field_is_zero_in_normal_brain_and_high_in_the_rim(head: HeadPhantom) -> None:
    brain = find_brain(head.pre, head.post)
    calibration = calibrate(brain, head.post, head.pre)
    rim = brain.grid.sample(head.truth) == 1
    assert np.median(calibration.field[brain.mask]) == pytest.approx(0.0, abs=0.2)
    assert np.median(calibration.field[rim]) > 2.5
    assert np.median(np.abs(calibration.field[brain.mask])) < 1.0
    assert (calibration.field[~brain.mask] <= calibration.field.max() / 2).all()
    assert calibration.subtracted


def test_a_drift_between_the_volumes_is_taken_out_where_that_is_asked_for(head: HeadPhantom) -> None:
    brain = find_brain(head.pre, head.post)
    plain = calibrate(brain, head.post, head.pre)
    u, v, w = np.meshgrid(*(np.linspace(-1, 1, n) for n in head.post.shape), indexing="ij", sparse=True)
    drifted = head.post.with_data(head.post.data + plain.noise * (u - 4.0 * v * w + 6.0 * v * v))
    rim = head.truth.data == 1
    rim = (brain.grid.sample(head.truth.with_data(rim.astype(np.float32))) > 0.5) & brain.mask
    normal = ndimage.binary_erosion(brain.mask & ~ndimage.binary_dilation(rim, iterations=12), iterations=3)

    def parted(field: np.ndarray) -> float:
        return float((np.median(field[rim]) - np.median(field[normal])) / field[normal].std())

    once, twice = (calibrate(brain, post, head.pre, without_drift=True) for post in (head.post, drifted))
    assert np.corrcoef(once.field[normal], twice.field[normal])[0, 1] > 0.96
    assert parted(twice.field) > 1.1 * parted(calibrate(brain, drifted, head.pre).field)
    assert twice.noise < 0.9 * calibrate(brain, drifted, head.pre).noise


def test_light_that_differs_between_the_volumes_is_taken_out(head: HeadPhantom) -> None:
    brain = find_brain(head.pre, head.post)
    u, v, w = np.meshgrid(*(np.linspace(-1, 1, n) for n in head.post.shape), indexing="ij", sparse=True)
    lit = head.post.with_data((head.post.data * np.exp(0.3 * u - 0.2 * v + 0.1 * w)).astype(np.float32))
    usual, comparison = compare(brain, head.post, head.pre), compare(brain, lit, head.pre)
    assert comparison.fit.steadier > 1.5
    fields = [each.calibrated().field[brain.mask] for each in (usual, comparison)]
    assert np.corrcoef(*fields)[0, 1] > 0.97
    # The same wherever a file has its zero.
    moved = compare(brain, lit.with_data(lit.data + 3000.0), head.pre)
    assert moved.fit.steadier == pytest.approx(comparison.fit.steadier, rel=1e-3)
    np.testing.assert_allclose(moved.calibrated().field[brain.mask], fields[1], atol=5e-3)


def test_a_large_tumor_on_one_side_is_not_taken_for_light() -> None:
    rng = np.random.default_rng(3)
    place = rng.uniform(-1.0, 1.0, (60_000, 3))
    before = rng.choice([300.0, 450.0, 500.0], len(place)) + rng.normal(0.0, 20.0, len(place))
    expected = 1.4 * before + 80.0
    after = expected + rng.normal(0.0, 30.0, len(place))
    tumor = np.linalg.norm(place - (0.6, 0.2, 0.0), axis=1) < 0.55
    assert 0.07 < tumor.mean() < 0.12
    after[tumor] += 150.0
    light, steadier = _light(before, after, expected, place)
    assert steadier < STEADIER
    # What is light by as much is told, tumor or no.
    shades = (0.25, -0.1, 0.0)
    light, steadier = _light(before, after * (1.0 + place @ shades), expected, place)
    assert steadier > 2.0
    np.testing.assert_allclose(light, shades, atol=0.03)


def test_voxels_that_are_not_finite_do_not_spread(head: HeadPhantom) -> None:
    brain = find_brain(head.pre, head.post)
    holes = head.post.data.astype(np.float32)
    holes[::7, ::5, ::6] = np.nan
    calibration = calibrate(brain, head.post.with_data(holes), head.pre)
    assert np.isfinite(calibration.field).all()
    assert np.isfinite(calibration.before).all()


def test_flat_brain_and_foreign_coverage_are_refused() -> None:
    data = np.zeros((40, 40, 40), np.float32)
    data[5:35, 5:35, 5:35] = 100.0
    volume = Volume(data, np.eye(4))
    grid = working_grid(volume)
    brain = Brain(grid, data > 0, True)
    with pytest.raises(InvalidInput, match="one and the same intensity"):
        calibrate(brain, volume, None)
    missing = volume.with_data(np.full(data.shape, np.nan, np.float32))
    with pytest.raises(InvalidInput, match="Only 0 voxels") as caught:
        calibrate(brain, volume, missing)
    assert caught.value.code == "grid_mismatch"

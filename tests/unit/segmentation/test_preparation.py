"""Working grids."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Volume
from shapery_segmentation.preparation import averaged, check_overlap, check_volume, working_grid

RNG = np.random.default_rng(11)
COUNT = np.arange(8000.0).reshape(20, 20, 20)
DATA = RNG.integers(0, 1000, (20, 24, 28)).astype(np.int16)


Triple = tuple[float, float, float]


def affine(scale: Triple = (1.0, 1.1, 0.9), origin: Triple = (-8, 5, 40)) -> np.ndarray:
    matrix = np.diag([*scale, 1.0])
    matrix[:3, 3] = origin
    return matrix


def orientations(volume: Volume) -> list[Volume]:
    """The same volume with its array stored in all 48 orders."""
    found = []
    for axes in itertools.permutations(range(3)):
        for flips in itertools.product((False, True), repeat=3):
            data = volume.data.transpose(axes)[tuple(slice(None, None, -1 if f else 1) for f in flips)]
            matrix = np.eye(4)
            matrix[:3, 3] = volume.affine[:3, 3]
            for k, (axis, flip) in enumerate(zip(axes, flips, strict=True)):
                column = volume.affine[:3, axis]
                matrix[:3, k] = -column if flip else column
                if flip:
                    matrix[:3, 3] += column * (volume.shape[axis] - 1)
            found.append(Volume(np.ascontiguousarray(data), matrix))
    return found


@pytest.mark.parametrize("scale", [(1.0, 1.1, 0.9), (0.5, 1.0, 3.0)])
def test_all_48_orientations_give_one_working_volume(scale: tuple[float, float, float]) -> None:
    oblique = affine(scale)
    angle = 0.2
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    oblique[:3, :3] = turn @ oblique[:3, :3]
    source = Volume(DATA, oblique)
    reference = working_grid(source)
    expected = reference.sample(source)
    mask = RNG.random(reference.shape) < 0.3
    back = reference.to_source(mask)
    for stored in orientations(source):
        grid = working_grid(stored)
        assert grid.shape == reference.shape
        np.testing.assert_allclose(grid.affine, reference.affine, atol=1e-9)
        np.testing.assert_allclose(grid.sample(stored), expected, atol=1e-3)
        # The mask comes back on the stored grid: at the same places in space.
        returned = Volume(grid.to_source(mask), stored.affine).canonical()[0]
        assert np.count_nonzero(returned.data != Volume(back, source.affine).canonical()[0].data) == 0


def test_voxels_near_a_millimetre_are_kept_bit_for_bit() -> None:
    source = Volume(DATA, affine())
    grid = working_grid(source)
    assert grid.reorientation is not None
    np.testing.assert_array_equal(grid.sample(source), DATA.astype(np.float32))
    mask = DATA > 500
    np.testing.assert_array_equal(grid.to_source(mask), mask)


def test_a_mask_on_another_grid_is_worked_out_where_it_is_and_is_the_same() -> None:
    turn = np.diag([0.6, 0.5, 2.0]) @ np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    placed = np.eye(4)
    placed[:3] = np.column_stack((turn.T, (-30.0, 10.0, 4.0)))
    source = Volume(np.zeros((60, 50, 20), np.int16), placed)
    grid = working_grid(source)
    for corner in ((18, 14, 10), (2, 3, 0), (26, 22, 30)):
        mask = np.zeros(grid.shape, bool)
        mask[tuple(slice(c, c + 9) for c in corner)] = True
        whole = Volume(mask.astype(np.float32), grid.affine).resampled_to(source, fill=0.0).data >= 0.5
        np.testing.assert_array_equal(grid.to_source(mask), whole)


def test_other_voxels_are_resampled_to_a_millimetre() -> None:
    source = Volume(DATA, affine((0.5, 1.0, 3.0)))
    grid = working_grid(source)
    assert grid.reorientation is None
    assert grid.spacing == pytest.approx(1.0)
    # A linear ramp in space is the same ramp on any grid, and averaging does not move it.
    points = np.stack(np.meshgrid(*map(np.arange, source.shape), indexing="ij"), axis=-1)
    ramp = source.to_world(points) @ np.array([2.0, -1.0, 0.5])
    values = grid.sample(source.with_data(ramp.astype(np.float32)))
    where = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing="ij"), axis=-1)
    expected = (where @ grid.affine[:3, :3].T + grid.affine[:3, 3]) @ np.array([2.0, -1.0, 0.5])
    inner = (slice(1, -1),) * 3
    np.testing.assert_allclose(values[inner], expected[inner], atol=1e-3)


def test_cropping_moves_the_origin_and_the_way_back() -> None:
    source = Volume(DATA, affine())
    grid = working_grid(source).cropped(np.array([3, 4, 5]), np.array([13, 20, 21]))
    assert grid.shape == (10, 16, 16)
    np.testing.assert_array_equal(grid.sample(source), DATA[3:13, 4:20, 5:21])
    np.testing.assert_allclose(grid.affine[:3, 3], source.to_world((3, 4, 5)))
    back = grid.to_source(np.ones(grid.shape, bool))
    expected = np.zeros(DATA.shape, bool)
    expected[3:13, 4:20, 5:21] = True
    np.testing.assert_array_equal(back, expected)


def test_sheared_volumes_are_resampled_not_kept() -> None:
    sheared = affine((1.0, 1.0, 1.0))
    sheared[0, 2] = 0.3
    grid = working_grid(Volume(DATA, sheared))
    assert grid.reorientation is None
    axes = grid.affine[:3, :3]
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-9)


def test_averaging_keeps_the_mean_and_the_place() -> None:
    source = Volume(DATA, affine((0.5, 0.5, 2.0)))
    coarse = averaged(source, 1.0)
    assert coarse.shape == (10, 12, 28)
    np.testing.assert_allclose(coarse.data, DATA.reshape(10, 2, 12, 2, 28).mean(axis=(1, 3)))
    np.testing.assert_allclose(coarse.to_world((0, 0, 0)), source.to_world((0.5, 0.5, 0)))


@pytest.mark.parametrize(
    ("data", "scale", "said"),
    [
        (np.full((20, 20, 20), 7.0), (1, 1, 1), "Every voxel"),
        (np.full((20, 20, 20), np.nan), (1, 1, 1), "None of the 8000"),
        (np.where(COUNT % 5, np.nan, COUNT), (1, 1, 1), "Only 1600"),
        (DATA[:4, :4, :4], (1, 1, 1), "too small"),
        (DATA[:, :, :2], (1, 1, 20), "too small"),
    ],
)  # fmt: skip
def test_unusable_volumes_are_refused_with_figures(data: np.ndarray, scale: Triple, said: str) -> None:
    with pytest.raises(InvalidInput, match=said) as caught:
        check_volume(Volume(data, affine(scale)), "post-contrast")
    assert caught.value.code == "invalid_volume"
    assert caught.value.hint or said == "None of the 8000"


def test_volumes_elsewhere_are_refused_and_resampling_is_told() -> None:
    post = Volume(DATA, affine())
    assert check_overlap(Volume(DATA, affine()), post) == []
    assert "resampled" in check_overlap(Volume(DATA, affine(origin=(-7, 5, 40))), post)[0]
    with pytest.raises(InvalidInput, match="covers 0%") as caught:
        check_overlap(Volume(DATA, affine(origin=(300, 5, 40))), post)
    assert caught.value.code == "grid_mismatch"

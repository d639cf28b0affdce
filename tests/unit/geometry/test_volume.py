"""Volume, reorientation and resampling."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_geometry import _resampling_kernels
from shapery_geometry.volume import Reorientation, Volume
from tests.support.volumes import ORIENTATIONS, all_orientations, oblique_rotation, phantom, stored_as


def test_index_and_world_are_what_the_affine_says() -> None:
    volume = Volume(np.zeros((4, 5, 6), np.uint8), [[0, 0, -2, 10], [1, 0, 0, 3], [0, 3, 0, 1], [0, 0, 0, 1]])
    assert volume.spacing == (1.0, 3.0, 2.0)
    assert volume.voxel_volume == pytest.approx(6.0)
    np.testing.assert_array_equal(volume.to_world([1, 2, 3]), [4, 4, 7])
    np.testing.assert_allclose(volume.to_index([[4, 4, 7], [10, 3, 1]]), [[1, 2, 3], [0, 0, 0]], atol=1e-12)


def test_a_sheared_affine_is_kept_exactly_and_its_voxels_have_the_parallelepiped_volume() -> None:
    affine = np.array([[0.5, 0, 0, 1], [0, 0.5, 0, 2], [0, 0.2, 2, 3], [0, 0, 0, 1]])
    volume = Volume(np.zeros((2, 2, 2)), affine)
    np.testing.assert_array_equal(volume.affine, affine)
    assert volume.voxel_volume == pytest.approx(0.5)


def test_the_affine_of_a_volume_cannot_be_changed_from_outside() -> None:
    affine = np.eye(4)
    volume = Volume(np.zeros((2, 2, 2)), affine)
    affine[0, 0] = 7
    assert volume.affine[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        volume.affine[0, 0] = 7


@pytest.mark.parametrize(
    ("data", "affine", "code", "part"),
    [
        (np.zeros((3, 3)), np.eye(4), "invalid_volume", "(3, 3)"),
        (np.zeros((3, 3, 3, 2)), np.eye(4), "invalid_volume", "(3, 3, 3, 2)"),
        (np.zeros((3, 3, 3), complex), np.eye(4), "invalid_volume", "complex128"),
        (np.zeros((3, 0, 3)), np.eye(4), "empty_content", "no voxels"),
        (np.zeros((3, 3, 3)), np.diag([1, 1, 0, 1]), "invalid_volume", "spacing 1, 1, 0 mm"),
        (np.zeros((3, 3, 3)), np.diag([1, 1, np.nan, 1]), "invalid_volume", "not finite"),
        (np.zeros((3, 3, 3)), [[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "invalid_volume", "no space"),
        (np.zeros((3, 3, 3)), np.ones((4, 4)), "invalid_volume", "last row"),
        (np.zeros((3, 3, 3)), np.eye(3), "invalid_volume", "(3, 3)"),
    ],
)
def test_what_is_no_volume_is_refused(data: np.ndarray, affine: np.ndarray, code: str, part: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        Volume(data, affine)
    assert caught.value.code == code
    assert part in str(caught.value)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_flatness_does_not_depend_on_the_unit(scale: float) -> None:
    assert Volume(np.zeros((2, 2, 2)), np.diag([scale, scale, scale, 1])).voxel_volume == pytest.approx(scale**3)


def test_the_phantom_in_all_48_orientations_has_one_canonical_form() -> None:
    expected = phantom()
    seen = set()
    for stored in all_orientations(expected):
        canonical, reorientation = stored.canonical()
        np.testing.assert_array_equal(canonical.data, expected.data)
        np.testing.assert_allclose(canonical.affine, expected.affine, rtol=0, atol=1e-12)
        assert canonical.data.flags.c_contiguous
        back = reorientation.undo(canonical)
        np.testing.assert_array_equal(back.data, stored.data)
        assert back.affine.tobytes() == stored.affine.tobytes()
        seen.add((reorientation.axes, reorientation.flips))
    assert len(seen) == 48


def test_a_result_computed_on_the_canonical_grid_lies_where_the_input_says() -> None:
    # The voxel of value 100 is found on the canonical grid; on each input grid its place in the world is the same.
    place = phantom().to_world(np.argwhere(phantom().data == 100)[0])
    for stored in all_orientations(phantom()):
        canonical, reorientation = stored.canonical()
        labels = stored.with_data(
            np.ascontiguousarray(reorientation.undo_array((canonical.data == 100).astype(np.uint8)))
        )
        assert stored.same_grid(labels)
        np.testing.assert_allclose(labels.to_world(np.argwhere(labels.data)[0]), place, atol=1e-9)


def test_reorientation_carries_further_axes_along() -> None:
    stored = stored_as(phantom(), (2, 0, 1), (True, False, True))
    reorientation = Reorientation.to_canonical(stored)
    field = np.stack([stored.data, -stored.data], axis=-1)
    moved = reorientation.apply_array(field)
    np.testing.assert_array_equal(moved[..., 1], -phantom().data)
    np.testing.assert_array_equal(reorientation.undo_array(moved), field)


@pytest.mark.parametrize("codes", ["RAS", "LPS", "LAS", "SAR", "PIR", "ASL"])
def test_axes_can_be_ordered_by_codes(codes: str) -> None:
    signs = {"R": (0, 1), "L": (0, -1), "A": (1, 1), "P": (1, -1), "S": (2, 1), "I": (2, -1)}
    for axes, flips in ORIENTATIONS[::7]:
        stored = stored_as(phantom(), axes, flips)
        moved = Reorientation.to_codes(stored, codes).apply(stored)
        for column, code in enumerate(codes):
            world, sign = signs[code]
            axis = moved.affine[:3, column]
            assert int(np.abs(axis).argmax()) == world
            assert np.sign(axis[world]) == sign
        np.testing.assert_array_equal(moved.canonical()[0].data, phantom().data)


def test_codes_that_name_no_axes_are_refused() -> None:
    for codes in ("RA", "RAL", "XYZ", "RRS"):
        with pytest.raises(ValueError, match="axis codes"):
            Reorientation.to_codes(phantom(), codes)


def test_a_rotation_by_45_degrees_has_one_canonical_form_in_all_orientations() -> None:
    turn = np.sqrt(0.5)
    for rows in (
        [[turn, -turn, 0], [turn, turn, 0], [0, 0, 1]],
        [[turn, turn, 0], [-turn, turn, 0], [0, 0, 1]],
        [[1, 0, 0], [0, turn, -turn], [0, turn, turn]],
        [[turn, 0, turn], [0, 1, 0], [-turn, 0, turn]],
    ):
        affine = np.eye(4)
        affine[:3, :3] = rows
        tied = Volume(phantom().data, affine)
        forms = {stored.canonical()[0].data.tobytes() for stored in all_orientations(tied)}
        assert len(forms) == 1


def test_arrays_of_another_shape_are_refused_with_both_shapes() -> None:
    volume = phantom()
    with pytest.raises(InvalidInput, match=r"\(7, 5\).*\(7, 5, 6\)"):
        Reorientation.to_canonical(volume).apply_array(np.zeros((7, 5)))
    with pytest.raises(InvalidInput, match=r"\(6, 5, 7\).*\(7, 5, 6\)") as caught:
        volume.with_data(np.zeros((6, 5, 7)))
    assert caught.value.code == "grid_mismatch"


def test_same_grid_forgives_rounding_and_nothing_more() -> None:
    volume = phantom()
    rounded = Volume(volume.data, volume.affine.astype(np.float32))
    assert volume.same_grid(rounded)
    moved = np.array(volume.affine)
    moved[0, 3] += 0.01
    assert not volume.same_grid(Volume(volume.data, moved))
    wider = np.array(volume.affine)
    wider[:3, 2] *= 1.01
    assert not volume.same_grid(Volume(volume.data, wider))
    assert not volume.same_grid(Volume(volume.data[:-1], volume.affine))
    assert not volume.same_grid(stored_as(volume, (0, 1, 2), (True, False, False)))


def test_statistics_leave_out_what_is_not_finite() -> None:
    data = np.array([1.0, 2.0, 3.0, np.nan, np.inf, -np.inf, 4.0, 5.0], np.float32).reshape(2, 2, 2)
    figures = Volume(data, np.eye(4)).statistics()
    assert (figures.finite, figures.non_finite) == (5, 3)
    assert (figures.minimum, figures.maximum) == (1.0, 5.0)


def test_filled_replaces_only_what_is_not_finite() -> None:
    data = np.array([1.0, np.nan, 3.0, np.inf, 2.0, 2.0, 2.0, 2.0], np.float32).reshape(2, 2, 2)
    volume = Volume(data, np.eye(4))
    np.testing.assert_array_equal(volume.filled().data.ravel(), [1, 1, 3, 1, 2, 2, 2, 2])
    assert volume.filled(-7).data.ravel()[1] == -7
    assert volume.filled().data.dtype == np.float32
    whole = phantom()
    assert whole.filled() is whole
    with pytest.raises(InvalidInput, match="None of the 8 voxels"):
        Volume(np.full((2, 2, 2), np.nan), np.eye(4)).filled()


def test_contains_counts_the_outermost_voxels_in_full() -> None:
    volume = Volume(np.zeros((2, 3, 4)), np.diag([2.0, 1.0, 1.0, 1.0]))
    assert volume.contains([-0.99, 0, 0])
    assert not volume.contains([-1.01, 0, 0])
    assert volume.contains([2.99, 2.49, 3.49])
    assert not volume.contains([2.99, 2.51, 3.49])
    np.testing.assert_array_equal(volume.contains([[0, 0, 0], [0, 0, 4]]), [True, False])


class TestResampling:
    def test_onto_the_own_grid_is_the_identity_in_every_orientation(self) -> None:
        for stored in all_orientations(phantom()):
            np.testing.assert_array_equal(phantom().resampled_to(stored).data, stored.data)
            np.testing.assert_array_equal(phantom().resampled_to(stored, method="nearest").data, stored.data)

    def test_a_linear_field_is_reproduced_to_rounding(self) -> None:
        # Trilinear interpolation is exact on fields that are linear in the world; borders are left out by the margin.
        volume = phantom()
        weights = np.array([0.3, -0.7, 0.2])
        field = volume.with_data(volume.to_world(np.moveaxis(np.indices(volume.shape), 0, -1)) @ weights + 5)
        affine = np.eye(4)
        affine[:3, :3] = oblique_rotation().T * 0.31
        affine[:3, 3] = volume.to_world([2.5, 1.5, 2.0])
        grid = Volume(np.zeros((4, 3, 5), np.uint8), affine)
        result = field.resampled_to(grid)
        inside = grid.to_world(np.moveaxis(np.indices(grid.shape), 0, -1))
        assert volume.contains(inside).all()
        assert result.data.dtype == np.float64
        np.testing.assert_allclose(result.data, inside @ weights + 5, rtol=0, atol=1e-10)

    def test_outside_the_field_of_view_is_fill_and_its_margin_is_the_border(self) -> None:
        volume = Volume(np.array([1, 2, 3, 4] * 4, np.int16).reshape(4, 2, 2)[:, :, :], np.eye(4))
        grid = Volume(np.zeros((1, 1, 1), np.uint8), np.eye(4))

        def at(x: float, **options: float) -> float:
            affine = np.eye(4)
            affine[0, 3] = x
            return float(volume.resampled_to(Volume(grid.data, affine), **options).data[0, 0, 0])

        assert at(-0.4) == volume.data[0, 0, 0]
        assert np.isnan(at(-0.6))
        assert at(3.4) == volume.data[3, 0, 0]
        assert at(3.6, fill=-1.0) == -1.0

    def test_values_that_are_not_finite_carry_no_weight(self) -> None:
        data = np.array([[[1.0, 1.0], [1.0, 1.0]], [[np.nan, 5.0], [np.inf, 5.0]]], np.float32)
        volume = Volume(data, np.eye(4))
        affine = np.eye(4)
        affine[:3, 3] = (0.5, 0.0, 0.5)
        value = volume.resampled_to(Volume(np.zeros((1, 1, 1)), affine)).data[0, 0, 0]
        assert value == pytest.approx((1 + 1 + 5) / 3)
        affine[:3, 3] = (0.8, 0.0, 0.0)
        assert np.isnan(volume.resampled_to(Volume(np.zeros((1, 1, 1)), affine)).data[0, 0, 0])

    @pytest.mark.parametrize("scale", [(1 / 3, 0.4, 0.5), (-0.7, 1.9, 1.0)])
    def test_parallel_axes_take_a_shorter_way_to_the_same_values(self, scale: tuple[float, float, float]) -> None:
        rng = np.random.default_rng(3)
        data = rng.normal(size=(9, 7, 8))
        data[rng.random(data.shape) < 0.1] = np.nan
        offset = np.array([4.6, -0.4, 0.0])
        way, shorter = np.empty((14, 12, 20)), np.empty((14, 12, 20))
        _resampling_kernels.linear(data, np.diag(scale), offset, way, -9.0, 0, len(way))
        _resampling_kernels.linear_aligned(data, np.array(scale), offset, shorter, -9.0)
        assert (way == -9.0).any()
        np.testing.assert_allclose(shorter, way, rtol=0, atol=1e-12)

    def test_labels_keep_their_type_and_get_no_new_values(self) -> None:
        labels = Volume(np.array([0, 4, 4, 0, 1, 0, 4, 1], np.uint8).reshape(2, 2, 2), np.eye(4))
        grid = Volume(np.zeros((9, 9, 9), np.uint8), np.diag([0.25, 0.25, 0.25, 1.0]))
        moved = labels.resampled_to(grid, method="nearest")
        assert moved.data.dtype == np.uint8
        assert set(np.unique(moved.data)) == {0, 1, 4}
        assert labels.resampled_to(grid, method="nearest", fill=9).data[8, 8, 8] == 9
        # NaN is no label: what cannot be held becomes 0.
        assert labels.resampled_to(grid, method="nearest").data[8, 8, 8] == 0

    def test_an_unknown_method_is_refused(self) -> None:
        with pytest.raises(ValueError, match="cubic"):
            phantom().resampled_to(phantom(), method="cubic")  # type: ignore[arg-type]

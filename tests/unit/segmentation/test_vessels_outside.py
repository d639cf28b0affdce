"""Vessels in volumes that were never measured everywhere: stripped skulls, grids that reach beyond the scan."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Volume
from shapery_segmentation.labels import MICROHEMORRHAGE, OBJECT, VESSEL
from shapery_segmentation.microhemorrhage import find_microhemorrhages
from shapery_segmentation.phantoms.vessels import VesselPhantom, vessel_tree_phantom
from shapery_segmentation.vessels import segment_vessels
from shapery_segmentation.vessels.outside import find_outside, measured

BoolArray = NDArray[np.bool_]


def ball(shape: tuple[int, ...], radius: float) -> BoolArray:
    middle = (np.array(shape) - 1) / 2
    return np.asarray(sum((axis - m) ** 2 for axis, m in zip(np.ogrid[tuple(map(slice, shape))], middle, strict=True))
                      <= radius**2)  # fmt: skip


@pytest.fixture(scope="module")
def tree() -> VesselPhantom:
    """Dark veins beside a tumor, with bleedings."""
    return vessel_tree_phantom(
        np.random.default_rng(3), polarity="dark", bias=0.4, tumor_radius=9.0, microhemorrhages=3
    )


def stripped(phantom: VesselPhantom, kept: BoolArray, value: float) -> Volume:
    return phantom.volume.with_data(np.where(kept, phantom.volume.data, np.float32(value)).astype(np.float32))


def test_one_value_that_reaches_the_border_is_outside() -> None:
    rng = np.random.default_rng(1)
    kept = ball((40, 44, 48), 17.0)
    values = np.where(kept, rng.normal(100.0, 5.0, kept.shape), 0.0).astype(np.float32)
    values[20, 20, 20] = -1.0
    # A hole of the same value within is no outside.
    values[19:22, 21:24, 23:26] = 0.0
    outside = find_outside(values)
    assert outside is not None
    assert (outside == ~kept).all()
    filled, again = measured(Volume(values, np.eye(4)))
    assert again is not None
    assert (again == outside).all()
    assert (filled[kept] == values[kept]).all()
    # Nothing sharp is left at the border.
    assert abs(filled[~kept] - 100.0).max() < 8.0


def test_what_was_measured_everywhere_has_no_outside() -> None:
    rng = np.random.default_rng(2)
    values = rng.normal(size=(24, 24, 24)).astype(np.float32)
    assert find_outside(values) is None
    assert find_outside(np.zeros((8, 8, 8), dtype=np.float32)) is None
    values[0, 0, 0] = np.nan
    filled, outside = measured(Volume(values, np.eye(4)))
    assert outside is not None
    assert outside.sum() == 1
    assert np.isfinite(filled).all()


def test_where_only_vessels_are_left_all_else_is_their_background(tree: VesselPhantom) -> None:
    vessel = tree.truth.data == VESSEL
    assert find_outside(np.where(vessel, tree.volume.data, 0.0).astype(np.float32)) is None


@pytest.mark.slow
@pytest.mark.parametrize("value", [0.0, np.nan])
def test_vessels_and_bleedings_are_found_in_what_is_left_of_a_volume(tree: VesselPhantom, value: float) -> None:
    kept = ball(tree.volume.shape, 44.0)
    truth = tree.truth.data
    volume = stripped(tree, kept, value)
    found = segment_vessels(volume, around=truth == OBJECT)
    assert found.polarity == "dark"
    own, drawn = found.mask, (truth == VESSEL) & kept
    assert np.count_nonzero(own & drawn) > 0.9 * np.count_nonzero(own | drawn)
    bleedings = find_microhemorrhages(volume, vessels=own, tumor=truth == OBJECT, polarity="dark")
    bled = (truth == MICROHEMORRHAGE) & kept
    assert np.count_nonzero(bleedings.mask & bled) > 0.8 * np.count_nonzero(bleedings.mask | bled)


@pytest.mark.slow
def test_what_has_leaked_is_no_vessel() -> None:
    rng = np.random.default_rng(4)
    # Half of it is bright, with a thin bright tube that leads there.
    values = rng.normal(0.0, 1.0, (64, 64, 64)).astype(np.float32)
    values[:, :, 30:] += 100.0
    values[30:33, 30:33, 8:30] += 100.0
    volume = Volume(values, np.eye(4))
    with pytest.raises(InvalidInput, match="leaked") as refused:
        segment_vessels(volume, [(31.0, 31.0, 20.0)], polarity="bright")
    assert refused.value.code == "no_object_found"
    found = segment_vessels(volume, polarity="bright")
    assert not found.mask.any()
    assert any("leaked" in warning for warning in found.warnings)

"""Bad input: a code, a sentence and a hint, or a result that says why it is empty; never an empty success."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_contracts.errors import ERROR_CODES, InvalidInput
from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.volume import Volume
from shapery_segmentation import segment
from shapery_segmentation.phantoms import HeadPhantom
from shapery_segmentation.phantoms.blob import blob_phantom


def cube(values: np.ndarray) -> Volume:
    return Volume(values, np.diag([4.0, 4.0, 4.0, 1.0]))


RNG = np.random.default_rng(0)
BAD = {
    "constant": (lambda: cube(np.full((40, 40, 40), 7, np.int16)), "invalid_volume"),
    "zeros": (lambda: cube(np.zeros((40, 40, 40), np.int16)), "invalid_volume"),
    "not a number": (lambda: cube(np.full((40, 40, 40), np.nan, np.float32)), "invalid_volume"),
    "mostly not a number": (
        lambda: cube(np.where(RNG.random((40, 40, 40)) < 0.7, np.nan, 1.0).astype(np.float32)),
        "invalid_volume",
    ),
    "without voxels": (lambda: cube(np.zeros((0, 40, 40), np.int16)), "empty_content"),
    "spacing of 0": (lambda: Volume(np.zeros((40, 40, 40), np.int16), np.diag([1.0, 1.0, 0.0, 1.0])), "invalid_volume"),
    "too small": (lambda: Volume(np.arange(1000.0).reshape(10, 10, 10), np.eye(4)), "invalid_volume"),
    "no tissue": (
        lambda: cube(np.pad(np.full((2, 2, 2), 9, np.int16), 19)),
        "invalid_volume",
    ),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_volumes_are_refused_with_a_sentence(kind: str) -> None:
    make, code = BAD[kind]
    with pytest.raises(InvalidInput) as caught:
        segment(make())
    assert caught.value.code == code
    assert caught.value.code in ERROR_CODES
    assert caught.value.message.endswith(".")


def test_a_bad_volume_before_contrast_is_refused_by_its_name(head: HeadPhantom) -> None:
    with pytest.raises(InvalidInput, match="pre-contrast") as caught:
        segment(head.post, head.pre.with_data(np.zeros_like(head.pre.data)))
    assert caught.value.hint
    with pytest.raises(InvalidInput, match="vessel"):
        segment(head.post, head.pre, head.pre.with_data(np.zeros_like(head.pre.data)))


def test_a_head_without_a_bimodal_cell_is_an_empty_result_that_says_so(head: HeadPhantom) -> None:
    # The same volume twice: nothing took up contrast agent.
    result = segment(head.pre, head.pre)
    assert result.report.objects == []
    assert any("Nothing was found" in warning for warning in result.report.warnings)


def test_seeds_for_vessels_need_a_volume_that_shows_them(head: HeadPhantom) -> None:
    with pytest.raises(InvalidInput) as caught:
        segment(head.post, head.pre, params=SegmentationParams(vessel_seeds=[[0, 0, 0]]))
    assert caught.value.code == "missing_input"
    assert caught.value.hint


def test_seeds_outside_the_volume_are_refused_with_its_range(head: HeadPhantom) -> None:
    for point in ([500.0, 0.0, 0.0], [0.0, float("inf"), 0.0]):
        with pytest.raises(InvalidInput) as caught:
            segment(head.post, head.pre, params=SegmentationParams.model_construct(seeds=[point]))
        assert caught.value.code == "invalid_params"
        assert "mm" in caught.value.message
        assert caught.value.hint


def test_a_surface_that_ends_smaller_than_its_seed_says_why() -> None:
    phantom = blob_phantom(np.random.default_rng(3), radius=14.0, snr=6.0)
    result = segment(phantom.volume, params=SegmentationParams(seeds=[list(phantom.center)], smoothing=0.6))
    for item in result.report.objects:
        assert item.volume_mm3 >= 0.99 * item.seed_volume_mm3 or any("of its seed" in note for note in item.notes)

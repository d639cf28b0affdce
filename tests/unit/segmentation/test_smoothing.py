"""Smoothing in single precision against SciPy's in double precision."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from shapery_segmentation.smoothing import gaussian


@pytest.mark.parametrize("sigma", [0.6, 2.0, (0.5, 1.0, 3.0)], ids=["narrow", "wide", "unlike"])
@pytest.mark.parametrize("shape", [(20, 17, 23), (3, 2, 1), (1, 9, 4)], ids=["usual", "flat", "one layer"])
def test_it_is_what_scipy_says(sigma: float | tuple[float, float, float], shape: tuple[int, int, int]) -> None:
    values = np.random.default_rng(3).normal(size=shape).astype(np.float32)
    expected = ndimage.gaussian_filter(values.astype(np.float64), sigma, truncate=3.0, mode="nearest")
    np.testing.assert_allclose(gaussian(values, sigma), expected, atol=2e-6)


def test_the_layout_of_the_input_does_not_matter() -> None:
    values = np.random.default_rng(4).normal(size=(9, 8, 7)).astype(np.float32)
    np.testing.assert_array_equal(gaussian(np.asfortranarray(values), 1.0), gaussian(values, 1.0))


def test_without_width_nothing_changes() -> None:
    values = np.random.default_rng(5).normal(size=(4, 5, 6)).astype(np.float32)
    np.testing.assert_array_equal(gaussian(values, 0.0), values)

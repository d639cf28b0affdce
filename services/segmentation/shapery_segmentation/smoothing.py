"""Gaussian smoothing in single precision: what `scipy.ndimage` does in double precision, several times faster."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.concurrent import in_slabs
from shapery_segmentation import _smoothing_kernels as kernels

FloatArray = NDArray[np.float32]


def gaussian(values: FloatArray, sigma: float | Sequence[float], *, truncate: float = 3.0) -> FloatArray:
    """Return `values` smoothed by a Gaussian; beyond the ends the last values hold.

    Parameters
    ----------
    values : (I, J, K) float32
        Finite.
    sigma
        Standard deviation in voxels, the same along all axes or one for each.
    truncate
        Standard deviations at which the kernel ends.

    Notes
    -----
    The kernel is that of `scipy.ndimage.gaussian_filter` with ``mode="nearest"``; the sums are rounded to single
    precision on the way, a few units in the seventh digit.
    """
    sigmas = (sigma,) * 3 if isinstance(sigma, int | float) else tuple(sigma)
    first, second, third = (_half_kernel(float(s), truncate) for s in sigmas)
    data = np.ascontiguousarray(values, dtype=np.float32)
    out, room = np.empty_like(data), np.empty_like(data)

    def across(begin: int, end: int) -> None:
        kernels.smooth_across(data, first, begin, end, room)

    def within(begin: int, end: int) -> None:
        line = np.empty(data.shape[2] + 2 * (len(third) - 1), dtype=np.float32)
        kernels.smooth_within(room, second, third, begin, end, line, out)

    in_slabs(across, data.shape)
    in_slabs(within, data.shape)
    return out


def _half_kernel(sigma: float, truncate: float) -> FloatArray:
    """Return the middle and the right half of a sampled Gaussian whose whole sums to 1."""
    radius = int(truncate * sigma + 0.5)
    half = np.exp(-0.5 * np.square(np.arange(radius + 1) / max(sigma, 1e-30)))
    return np.asarray(half / (half[0] + 2.0 * half[1:].sum()), dtype=np.float32)

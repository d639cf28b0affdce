"""Means over cubes of voxels, and back."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_segmentation import _block_kernels as kernels

FloatArray = NDArray[np.float32]


def block_mean(values: FloatArray, factor: int) -> FloatArray:
    """Return means over cubes of `factor` voxels; a rest at the far end is repeated to fill its cubes."""
    if factor == 1:
        return values
    return block_means(values, (factor, factor, factor))


def block_means(values: NDArray[Any], factors: tuple[int, int, int]) -> FloatArray:
    """Return means over blocks of so many voxels along each axis; a rest at the far end is repeated to fill them."""
    out = np.empty([-(-n // f) for n, f in zip(values.shape, factors, strict=True)], dtype=np.float32)
    kernels.block_means(np.ascontiguousarray(values, dtype=np.float32), *factors, out)
    return out


def spread(values: FloatArray, factor: int, shape: tuple[int, ...]) -> FloatArray:
    """Return `values` of cubes at each of their voxels, cut to `shape`."""
    for axis in range(3):
        values = np.repeat(values, factor, axis=axis)
    return np.ascontiguousarray(values[: shape[0], : shape[1], : shape[2]])

"""Means over cubes of voxels, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]


def block_mean(values: FloatArray, factor: int) -> FloatArray:
    """Return means over cubes of `factor` voxels; a rest at the far end is repeated to fill its cubes."""
    if factor == 1:
        return values
    pad = [(0, -n % factor) for n in values.shape]
    full = np.pad(values, pad, mode="edge")
    a, b, c = (n // factor for n in full.shape)
    mean = full.reshape(a, factor, b, factor, c, factor).mean(axis=(1, 3, 5), dtype=np.float32)
    return np.ascontiguousarray(mean, dtype=np.float32)


def spread(values: FloatArray, factor: int, shape: tuple[int, ...]) -> FloatArray:
    """Return `values` of cubes at each of their voxels, cut to `shape`."""
    for axis in range(3):
        values = np.repeat(values, factor, axis=axis)
    return np.ascontiguousarray(values[: shape[0], : shape[1], : shape[2]])

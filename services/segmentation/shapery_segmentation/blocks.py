"""Means over cubes of voxels, and back."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_geometry.volume import Volume
from shapery_segmentation import _block_kernels as kernels

FloatArray = NDArray[np.float32]

BLOCK = 4.0
"""mm: edge of the cubes that wide means are made of."""


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


def local_mean(values: FloatArray, weights: FloatArray, spacing: float, scale: float, least: float) -> FloatArray:
    """Return the weighted mean around each voxel, worked out on cubes of about 4 mm.

    Parameters
    ----------
    values : (I, J, K) float32
        Multiplied by their weights already.
    weights : (I, J, K) float32
    spacing
        Edge of a voxel in mm.
    scale
        Standard deviation in mm of the Gaussian that tells how near is near; several cubes wide.
    least
        Mean weight up to which the result fades to 0.

    Returns
    -------
    (I, J, K) float32, linear between the cubes, because steps would be edges.
    """
    factor = max(1, round(BLOCK / spacing))
    sigma = scale / (factor * spacing)
    total = ndimage.gaussian_filter(block_mean(values, factor), sigma)
    mean = total / np.maximum(ndimage.gaussian_filter(block_mean(weights, factor), sigma), np.float32(least))
    blocks = np.diag([factor, factor, factor, 1.0])
    blocks[:3, 3] = (factor - 1) / 2
    return np.asarray(Volume(mean, blocks).resampled_to(Volume(values, np.eye(4))).data)

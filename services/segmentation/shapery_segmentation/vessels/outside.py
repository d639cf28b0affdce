"""What of a volume was never measured: the skull was stripped, or the grid reaches beyond the scan.

There the file holds one value. Its border is sharper and longer than any vessel's, and its size hides the noise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_geometry.volume import Volume
from shapery_segmentation.blocks import block_mean
from shapery_segmentation.smoothing import gaussian

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float32]

LEAST_OUTSIDE = 0.05
"""Share of the volume below which voxels of one value say nothing."""

CUBE, LEAST_SOLID = 4, 0.3
"""Share of the inside that lies in cubes of so many voxels wholly within it. Where there is less, what is left is the
vessels themselves, and the one value is their background."""

SPREAD = 2.0
"""Voxels: deviation of the Gaussian that carries values of the inside outwards."""

LEAST_CARRIED = 1e-3
"""What must arrive of it; farther out stands the median of the inside."""


def measured(volume: Volume) -> tuple[FloatArray, BoolArray | None]:
    """Return the values of a volume, its outside made to look like what is near, and the outside if there is any.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` if no voxel is finite.
    """
    values = np.ascontiguousarray(volume.filled().data, dtype=np.float32)
    outside = find_outside(values, volume.finite())
    return values if outside is None else carried_out(values, outside), outside


def find_outside(values: FloatArray, known: BoolArray | None = None) -> BoolArray | None:
    """Return which voxels were never measured, or None where all were.

    Parameters
    ----------
    values : (I, J, K) float32
        Finite.
    known : (I, J, K) bool
        Which of them the file gave; all if it is not given.

    Notes
    -----
    Voxels with the most frequent value of the volume's border that hang together through faces and reach it, where they
    are at least `LEAST_OUTSIDE` of the volume and what is left is solid (`LEAST_SOLID`).
    """
    unknown = np.zeros(values.shape, dtype=np.bool_) if known is None else ~known
    faces = np.concatenate([np.take(values, end, axis=axis).ravel() for axis in range(3) for end in (0, -1)])
    found, counts = np.unique(faces, return_counts=True)
    same = values == found[np.argmax(counts)]
    if np.count_nonzero(same) < LEAST_OUTSIDE * values.size:
        return unknown if unknown.any() else None
    labels, count = ndimage.label(same)
    reaching = np.zeros(count + 1, dtype=np.bool_)
    for axis in range(3):
        for end in (0, -1):
            reaching[np.take(labels, end, axis=axis)] = True
    reaching[0] = False
    outside = np.asarray(reaching[labels])
    if np.count_nonzero(outside) < LEAST_OUTSIDE * values.size or not _solid(~outside):
        outside[:] = False
    outside |= unknown
    return outside if outside.any() and not outside.all() else None


def _solid(inside: BoolArray) -> bool:
    cubes = block_mean(inside.astype(np.float32), CUBE) >= 1.0
    return bool(np.count_nonzero(cubes) * CUBE**3 >= LEAST_SOLID * np.count_nonzero(inside))


def carried_out(values: FloatArray, outside: BoolArray) -> FloatArray:
    """Return the values with the outside made to look like what of the inside is near it, but without its detail."""
    inside = np.where(outside, np.float32(0.0), np.float32(1.0))
    weight = gaussian(inside, SPREAD)
    mean = gaussian(values * inside, SPREAD) / np.maximum(weight, np.float32(LEAST_CARRIED))
    usual = np.float32(np.median(values[~outside][::8]))
    return np.where(outside, np.where(weight > LEAST_CARRIED, mean, usual), values).astype(np.float32)

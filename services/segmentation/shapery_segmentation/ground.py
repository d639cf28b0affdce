"""The ground that an object lies in: what is around it, how far the object stands out, and how uneven that is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_segmentation.blocks import local_mean
from shapery_segmentation.neighborhoods import within_each

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

SURROUNDINGS = (2.0, 6.0)
"""mm from an object at which the shell around it begins, past the border's partial volume, and ends."""

UNEVENNESS_SCALE = 8.0
"""mm: standard deviation of the Gaussian that the ground is averaged with from place to place. Smaller ones follow
single gyri and vessels, larger ones miss that an object lies in edema on one side and at the cortex on the other;
between 6 and 12 little changes."""

LEAST_SHELL = 0.02
"""Share of the shell, by the weights of that Gaussian, below which the ground there is unknown and taken as usual."""


def shell(whole: BoolArray, brain: BoolArray, spacing: float) -> BoolArray:
    """Return the voxels of the brain around an object.

    Parameters
    ----------
    whole : (I, J, K) bool
        The object and what it encloses, which surrounds nothing.
    brain : (I, J, K) bool
    spacing
        Edge of a voxel in mm.
    """
    near, far = within_each(whole, [radius / spacing for radius in SURROUNDINGS])
    return np.asarray(far & ~near & brain)


def ground_of(around: FloatArray) -> tuple[float, float]:
    """Return median and robust deviation (1.4826 MAD) of the values in the shell around an object.

    0 and 0 where there are none.
    """
    if not len(around):
        return 0.0, 0.0
    middle = float(np.median(around))
    return middle, 1.4826 * float(np.median(np.abs(around - middle)))


def standing_out(values: FloatArray, ground: tuple[float, float]) -> float:
    """Return how far the median of an object's `values` lies above its ground (see `ground_of`), in deviations of that.

    Infinite where there is no shell, or no variation in it.
    """
    middle, deviation = ground
    return (float(np.median(values)) - middle) / deviation if deviation > 0 else float("inf")


def unevenness(field: FloatArray, around: BoolArray, spacing: float) -> FloatArray:
    """Return by how much the ground lies higher or lower from place to place than in the mean.

    Parameters
    ----------
    field : (I, J, K) float32
        Calibrated difference.
    around : (I, J, K) bool
        The shell around the object (see `shell`).
    spacing
        Edge of a voxel in mm.

    Returns
    -------
    (I, J, K) float32, in the field's units; 0 far from the shell and where there is none.
    """
    if not around.any():
        return np.zeros(field.shape, dtype=np.float32)
    apart = np.where(around, field - field[around].mean(dtype=np.float64), 0.0).astype(np.float32)
    return local_mean(apart, around.astype(np.float32), spacing, UNEVENNESS_SCALE, LEAST_SHELL)

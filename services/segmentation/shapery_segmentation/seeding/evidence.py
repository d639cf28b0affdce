"""What speaks for a tumor at each voxel, beside its being bright after contrast.

Vessels, dural sinuses and choroid plexus enhance as tumors do. They come in pairs or lie on the middle plane, hold
flowing blood or fluid (dark before contrast), are thin, or run along the brain's outer edge.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_segmentation.blocks import block_mean, spread
from shapery_segmentation.neighborhoods import depths
from shapery_segmentation.seeding import _symmetry_kernels as kernels
from shapery_segmentation.seeding.symmetry import SymmetryPlane
from shapery_segmentation.smoothing import gaussian

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

STEP = 2.0
"""mm: evidence is worked out on voxels of this size; it is smooth, and an eighth of the voxels cost an eighth."""

ASYMMETRY = (1.0, 0.4)
"""Centre and width of the step in asymmetry, in units of the calibrated difference: one deviation of normal brain."""

TISSUE = (-2.0, 0.4)
"""Likewise for the volume before contrast: two deviations below the brain's median begin fluid and flowing blood."""

DEPTH = (4.0, 1.0)
"""Likewise for the distance from the brain's edge in mm: dura, sinuses and cortical veins lie within 3 to 4 mm."""

TOLERANCE = 6.0
"""mm by which the two halves of a brain may differ: the mirror image counts with its largest value this near."""


def evidence(
    field: FloatArray, before: FloatArray, brain: BoolArray, plane: SymmetryPlane, spacing: float
) -> FloatArray:
    """Return the weight of evidence in [0, 1] of every voxel.

    Parameters
    ----------
    field : (I, J, K) float32
        Calibrated difference.
    before : (I, J, K) float32
        Volume before contrast, as `Calibration.before`.
    brain : (I, J, K) bool
    plane
        Between the halves of the brain.
    spacing
        Edge of a voxel in mm.

    Notes
    -----
    The product of three logistic steps: in the smoothed difference minus the largest value of its mirror image nearby;
    in the intensity before contrast; in the distance from the brain's edge.
    """
    factor = max(1, round(STEP / spacing))
    size = factor * spacing
    mean, dark = block_mean(field, factor), block_mean(before, factor)
    inside = block_mean(brain.astype(np.float32), factor) > 0.5

    smooth = gaussian(mean, 1.2 / size, truncate=4.0)
    matrix, offset = plane.reflection(spacing)
    # From full voxels to blocks, whose first lies (factor − 1) / 2 voxels in.
    shift = (matrix @ np.full(3, (factor - 1) / 2) + offset - (factor - 1) / 2) / factor
    mirror = np.empty_like(smooth)
    kernels.mirrored(smooth, np.ascontiguousarray(matrix), np.ascontiguousarray(shift), mirror)
    reach = max(1, round(TOLERANCE / 2 / size))
    asymmetry = smooth - ndimage.maximum_filter(mirror, size=2 * reach + 1, mode="nearest")

    # Outside the array begins what is not brain.
    depth = depths(inside) * size
    weight = _step(asymmetry, ASYMMETRY) * _step(dark, TISSUE) * _step(depth, DEPTH)
    weight[~inside] = 0.0
    return spread(weight.astype(np.float32), factor, field.shape)


def _step(values: NDArray[np.floating], step: tuple[float, float]) -> NDArray[np.floating]:
    centre, width = step
    return np.asarray(1.0 / (1.0 + np.exp(np.clip((centre - values) / width, -30.0, 30.0))))

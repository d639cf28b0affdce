"""What speaks for a tumor at each voxel, beside its being bright after contrast.

Vessels, dural sinuses and choroid plexus enhance as tumors do. They come in pairs or lie on the middle plane, hold
flowing blood or fluid (dark before contrast), are thin, or run along the brain's outer edge. A tumor across the middle
plane has a mirror image that is as bright, too: but that image is the tumor itself, and thicker than the veins there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_segmentation.blocks import block_mean, spread
from shapery_segmentation.gate import dense
from shapery_segmentation.labels import with_enclosed
from shapery_segmentation.neighborhoods import connected, depths, within
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

SEED_THRESHOLD = 2.0
"""Enhancement, in units of the calibrated difference, above which voxels make a seed. The surface's own threshold,
which may be lower, follows from the seed."""

THICKER = 7.0
"""mm: radius of the ball that fits into whatever lies across the middle plane and is no vein. Veins and sinuses there
are 3 to 8 mm across, but where the straight sinus begins, three of them and the tentorium meet: a ball of 6 mm fits."""

LEAST_RIM = 0.2
"""Share of enhancing voxels in what lies across the middle plane, with what it encloses: a rim of 3 mm around a core of
40 mm has 0.3, the meninges around a brain 0.1."""

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
    in the intensity before contrast; in the distance from the brain's edge. Where something thick lies across the
    middle plane, there is nothing to subtract.
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
    image = ndimage.maximum_filter(mirror, size=2 * reach + 1, mode="nearest")
    bright = dense((mean > SEED_THRESHOLD) & inside, size)
    own = _own_image(bright, plane, size, (factor - 1) / 2 * spacing)
    asymmetry = np.where(own, smooth, smooth - image)

    # Outside the array begins what is not brain; the step is over long before it is this deep.
    depth = depths(inside, round((DEPTH[0] + 20.0 * DEPTH[1]) / size)) * size
    weight = _step(asymmetry, ASYMMETRY) * _step(dark, TISSUE) * _step(depth, DEPTH)
    weight[~inside] = 0.0
    return spread(weight.astype(np.float32), factor, field.shape)


def _own_image(bright: BoolArray, plane: SymmetryPlane, size: float, first: float) -> BoolArray:
    """Return the bright blocks of what lies thick across the middle plane.

    Parameters
    ----------
    bright : (I, J, K) bool
    plane
        Between the halves of the brain.
    size, first
        Edge of a block, and place of the first one's centre along each axis, in mm.
    """
    across = [
        normal * (first + size * np.arange(n)).reshape([-1 if a == axis else 1 for a in range(3)])
        for axis, (normal, n) in enumerate(zip(plane.normal, bright.shape, strict=True))
    ]
    middle = np.abs(across[0] + across[1] + across[2] - plane.distance) <= size
    crossing, count = ndimage.label(connected(bright, bright & middle))
    own = np.zeros_like(bright)
    for number, box in enumerate(ndimage.find_objects(crossing, count), start=1):
        if min(side.stop - side.start for side in box) * size <= 2 * THICKER:
            continue
        part = crossing[box] == number
        whole = with_enclosed(part, size)
        thick = within(depths(whole) * size > THICKER, THICKER / size) & whole
        thick = connected(thick, thick & middle[box])
        if np.count_nonzero(part & thick) > LEAST_RIM * np.count_nonzero(thick):
            own[box] |= part & thick
    return own


def _step(values: NDArray[np.floating], step: tuple[float, float]) -> NDArray[np.floating]:
    centre, width = step
    return np.asarray(1.0 / (1.0 + np.exp(np.clip((centre - values) / width, -30.0, 30.0))))

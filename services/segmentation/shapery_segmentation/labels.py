"""From the recovered surface to labelled voxels: the seam of the surface closed, the enclosed core filled."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.concurrent import both
from shapery_segmentation import _label_kernels as kernels
from shapery_segmentation.neighborhoods import box_around, dilated, filled, within
from shapery_segmentation.smoothing import gaussian

BoolArray = NDArray[np.bool_]

OBJECT, ENCLOSED, VESSEL, MICROHEMORRHAGE = 1, 2, 3, 4
"""Values of ``labels.nii.gz``."""

DIRECTIONS = np.array([d for d in itertools.product((-1, 0, 1), repeat=3) if any(d)], dtype=np.int64)
"""(26, 3) from a voxel to its neighbours."""

ENCLOSED_FROM = 20
"""Directions of 26 in which an enclosed voxel meets the rim: a rim may be open on nearly a quarter of its sphere."""

SIGHT = 30.0
"""mm within which it must meet it; necroses are rarely wider than twice this."""

EVEN = 1.3
"""mm: standard deviation of the neighbourhood most of which is core where an indentation of the core is filled."""

SEAM = 2.0
"""mm: fronts of the surface stop at most about a millimetre and a half apart; what is left between them is closed."""


def close_seam(inside: BoolArray, enhancing: BoolArray, spacing: float) -> BoolArray:
    """Return `inside` with the seams closed at which the surface met itself.

    Parameters
    ----------
    inside : (I, J, K) bool
        Voxels inside the surface. The surface keeps its topology: around a necrosis its fronts meet and leave a gap.
    enhancing : (I, J, K) bool
        Voxels above the threshold in which the surface may lie; only these are added.
    spacing
        Edge of a voxel in mm.
    """
    radius = SEAM / spacing
    margin = int(radius) + 1
    wide = np.pad(inside, margin)
    closed = ~within(~within(wide, radius), radius)
    cut = (slice(margin, -margin),) * 3
    return np.asarray(inside | (closed[cut] & enhancing))


def fill_enclosed(rim: BoolArray, spacing: float) -> BoolArray:
    """Return the voxels that `rim` encloses, without the rim itself.

    Parameters
    ----------
    rim : (I, J, K) bool
        The enhancing part.
    spacing
        Edge of a voxel in mm.

    Notes
    -----
    A voxel is enclosed if at least 20 of the 26 directions to its neighbours meet the rim within 30 mm: unlike filling
    holes, this bears rims with gaps, which the annotators' cores run across. Holes proper are filled whatever their
    width.
    """
    out = np.zeros(rim.shape, dtype=np.bool_)
    if not rim.any():
        return out
    # From outside of the box around the rim at most 9 directions lead into it.
    box = box_around(rim, rim.shape, 0)
    part = np.ascontiguousarray(rim[box])
    lengths = np.linalg.norm(DIRECTIONS, axis=1) * spacing
    reaches = np.floor(np.minimum(SIGHT / lengths, max(part.shape))).astype(np.int64)
    wide = tuple(n + 2 for n in part.shape)
    slices = wide[0], wide[1] * wide[2]
    counts = np.zeros(slices, dtype=np.uint8)
    room = np.empty((3, *slices), dtype=np.int16)
    _, whole = both(lambda: kernels.count_rays(part, DIRECTIONS, reaches, room, counts), lambda: filled(part))
    met = counts.reshape(wide)[1:-1, 1:-1, 1:-1]
    out[box] = ((met >= ENCLOSED_FROM) | whole) & ~part
    return out


def with_enclosed(rim: BoolArray, spacing: float) -> BoolArray:
    """Return `rim` and the voxels that it encloses (see `fill_enclosed`)."""
    return fill_enclosed(rim, spacing) | rim


def fill_indentations(core: BoolArray, spacing: float) -> BoolArray:
    """Return the voxels outside of `core` most of whose surroundings are core, without the core itself.

    Parameters
    ----------
    core : (I, J, K) bool
        The rim and what it encloses.
    spacing
        Edge of a voxel in mm.

    Notes
    -----
    Voxel by voxel counts of directions leave the core ragged where the rim has gaps, and the surface leaves clefts a
    voxel or two wide; the experts' cores have neither. Most is more than half by the weights of a Gaussian of 1.3 mm,
    so what is convex stays as it is, and nothing is taken away.
    """
    out = np.zeros(core.shape, dtype=np.bool_)
    if not core.any():
        return out
    box = box_around(core, core.shape, 1)
    part = core[box]
    out[box] = (gaussian(part.astype(np.float32), EVEN / spacing) > 0.5) & ~part
    return out


def enhancing_part(rim: BoolArray, enclosed: BoolArray, enhancing: BoolArray) -> BoolArray:
    """Return the voxels of a core that enhance: the rim's outer layer, and inside it what exceeds the threshold.

    Parameters
    ----------
    rim, enclosed : (I, J, K) bool
        The voxels inside the surface, and those that they enclose.
    enhancing : (I, J, K) bool
        Voxels above the running threshold.

    Notes
    -----
    The surface tells where the object ends. Within, it cannot follow every fleck of necrosis and every septum across
    it, because its triangles and the distance that its fronts keep are of their size.
    """
    core = rim | enclosed
    return np.asarray((rim & dilated(~core)) | (core & enhancing))

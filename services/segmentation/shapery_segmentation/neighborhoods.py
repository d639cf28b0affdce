"""Sets of voxels: what lies within a distance, the box around them, what is connected."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapery_segmentation import _neighborhood_kernels as kernels

BoolArray = NDArray[np.bool_]


def within(mask: BoolArray, radius: float) -> BoolArray:
    """Return the voxels at most `radius` voxels from one of `mask`, itself included.

    Parameters
    ----------
    mask : (I, J, K) bool
    radius
        Below 100.
    """
    return within_each(mask, (radius,))[0]


def within_each(mask: BoolArray, radii: Sequence[float]) -> list[BoolArray]:
    """Return what `within` does for each of several radii."""
    reach = int(max(radii))
    if not 0 <= reach < 100:
        raise ValueError(f"radii must lie in [0, 100) voxels, not {max(radii)}")
    squared, room = np.empty(mask.shape, dtype=np.int16), np.empty(mask.shape, dtype=np.int16)
    lines = np.empty((2, *mask.shape[:2]), dtype=np.bool_)
    kernels.squared_distances(np.ascontiguousarray(mask), reach, lines, room, squared)
    return [squared <= np.int16(radius * radius) for radius in radii]


def eroded(mask: BoolArray) -> BoolArray:
    """Return the voxels of `mask` of which all six neighbours are in it, too; outside the grid nothing is."""
    out = np.zeros_like(mask)
    middle = out[1:-1, 1:-1, 1:-1]
    middle[...] = mask[1:-1, 1:-1, 1:-1]
    for axis in range(3):
        for side in (slice(None, -2), slice(2, None)):
            beside = [slice(1, -1)] * 3
            beside[axis] = side
            middle &= mask[tuple(beside)]
    return out


def connected(mask: BoolArray, start: BoolArray) -> BoolArray:
    """Return the parts of `mask`, connected through faces, that have a voxel in common with `start`."""
    first = np.flatnonzero(start & mask)
    queue = np.empty(mask.size, dtype=np.int64)
    queue[: len(first)] = first
    out = np.zeros(mask.shape, dtype=np.bool_)
    kernels.fill(np.ascontiguousarray(mask), queue, len(first), out)
    return out


def without_small(mask: BoolArray, least: float) -> BoolArray:
    """Return `mask` without its parts, connected through faces, edges or corners, of less than `least` voxels."""
    out = np.zeros(mask.shape, dtype=np.bool_)
    kernels.keep_large(np.flatnonzero(mask), np.array(mask), least, out)
    return out


def box_around(mask: BoolArray, shape: tuple[int, ...], margin: int) -> tuple[slice, slice, slice]:
    """Return the box around `mask` with `margin` voxels on all sides, cut to `shape`; all of it for an empty mask."""
    bounds = []
    for axis in range(3):
        line = np.flatnonzero(mask.any(axis=tuple(a for a in range(3) if a != axis)))
        bounds.append((int(line[0]), int(line[-1]) + 1) if len(line) else (0, shape[axis]))
    i, j, k = (slice(max(a - margin, 0), min(b + margin, n)) for (a, b), n in zip(bounds, shape, strict=True))
    return i, j, k

"""Sets of voxels: what lies within a distance, grown and shrunk, the box around them, what is connected."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.concurrent import in_slabs
from shapery_segmentation import _neighborhood_kernels as kernels

BoolArray = NDArray[np.bool_]

FARTHEST = 99
"""Voxels along an axis beyond which no distance is told."""


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
    squared = _squared_distances(mask, int(max(radii)))
    return [squared <= np.int16(radius * radius) for radius in radii]


def depths(mask: BoolArray, most: int = FARTHEST) -> NDArray[np.float32]:
    """Return the distance in voxels of each voxel of `mask` from the nearest that is outside; beyond the array all are.

    Exact up to `most` voxels along each axis; (I, J, K) float32, 0 outside.
    """
    wide = np.pad(mask, 1)
    squared = _squared_distances(~wide, min(most, (min(wide.shape) + 1) // 2))
    return np.sqrt(squared[1:-1, 1:-1, 1:-1], dtype=np.float32)


def _squared_distances(mask: BoolArray, reach: int) -> NDArray[np.int16]:
    """Return squared distances from `mask`, those farther than `reach` along an axis at least (`reach` + 1)²."""
    if not 0 <= reach <= FARTHEST:
        raise ValueError(f"distances must lie in [0, {FARTHEST + 1}) voxels, not {reach}")
    squared, room = np.empty(mask.shape, dtype=np.int16), np.empty(mask.shape, dtype=np.int16)
    lines = np.empty((2, *mask.shape[:2]), dtype=np.bool_)
    given = np.ascontiguousarray(mask)

    def within_slices(begin: int, end: int) -> None:
        kernels.squared_distances_within(given, reach, begin, end, lines, room, squared)

    def across_slices(begin: int, end: int) -> None:
        kernels.squared_distances_across(reach, begin, end, lines, room, squared)

    in_slabs(within_slices, mask.shape)
    in_slabs(across_slices, mask.shape)
    return squared


def dilated(mask: BoolArray, steps: int = 1) -> BoolArray:
    """Return `mask` grown by voxels: alternating face and edge neighbours, nearly a ball."""
    for step in range(steps):
        x, y, z = (_widened(mask, axis) for axis in range(3))
        if step % 2:
            x, y, z = _widened(x, 1), _widened(y, 2), _widened(z, 0)
        mask = x | y | z
    return mask


def eroded(mask: BoolArray, steps: int = 1) -> BoolArray:
    """Return `mask` shrunk likewise; what lies outside the array does not belong to it."""
    return ~dilated(np.pad(~mask, 1, constant_values=True), steps)[1:-1, 1:-1, 1:-1]


def _widened(mask: BoolArray, axis: int) -> BoolArray:
    """Return `mask` and both neighbours of its voxels along an axis."""
    out = mask.copy()
    ahead, behind = [slice(None)] * 3, [slice(None)] * 3
    ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
    out[tuple(ahead)] |= mask[tuple(behind)]
    out[tuple(behind)] |= mask[tuple(ahead)]
    return out


def filled(mask: BoolArray) -> BoolArray:
    """Return `mask` and its holes: what no way through faces leads to from outside the array without crossing it."""
    holes = np.pad(~mask, 1, constant_values=True)
    kernels.take_connected(holes, np.zeros(1, dtype=np.int64), np.empty(holes.size, dtype=np.int64))
    return np.asarray(mask | holes[1:-1, 1:-1, 1:-1])


def connected(mask: BoolArray, start: BoolArray) -> BoolArray:
    """Return the parts of `mask`, connected through faces, that have a voxel in common with `start`."""
    left = np.array(mask, order="C")
    kernels.take_connected(left, np.flatnonzero(start & mask), np.empty(mask.size, dtype=np.int64))
    return np.asarray(mask & ~left)


def parts(mask: BoolArray) -> list[NDArray[np.int64]]:
    """Return the flat indices of each part of `mask` that is connected through faces, edges or corners.

    The parts come in the order of their first voxels. The time is that of looking at the mask's voxels.
    """
    voxels, ends = _gathered(mask)
    return np.split(voxels, ends[:-1]) if len(ends) else []


def without_small(mask: BoolArray, least: float) -> BoolArray:
    """Return `mask` without its parts, connected through faces, edges or corners, of less than `least` voxels."""
    voxels, ends = _gathered(mask)
    sizes = np.diff(ends, prepend=0)
    out = np.zeros(mask.shape, dtype=np.bool_)
    out.ravel()[voxels[np.repeat(sizes >= least, sizes)]] = True
    return out


def _gathered(mask: BoolArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the flat indices of the voxels of `mask`, part by part, and where each part ends."""
    chosen = np.flatnonzero(mask)
    voxels, ends = np.empty_like(chosen), np.empty_like(chosen)
    count = kernels.gather_parts(chosen, np.array(mask), voxels, ends)
    return voxels, ends[:count]


def box_around(mask: BoolArray, shape: tuple[int, ...], margin: int) -> tuple[slice, slice, slice]:
    """Return the box around `mask` with `margin` voxels on all sides, cut to `shape`; all of it for an empty mask."""
    bounds = []
    for axis in range(3):
        line = np.flatnonzero(mask.any(axis=tuple(a for a in range(3) if a != axis)))
        bounds.append((int(line[0]), int(line[-1]) + 1) if len(line) else (0, shape[axis]))
    i, j, k = (slice(max(a - margin, 0), min(b + margin, n)) for (a, b), n in zip(bounds, shape, strict=True))
    return i, j, k

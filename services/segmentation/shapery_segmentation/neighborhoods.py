"""Sets of voxels: what lies within a distance, the box around them, what is connected."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_segmentation import _neighborhood_kernels as kernels

BoolArray = NDArray[np.bool_]


def within(mask: BoolArray, radius: float) -> BoolArray:
    """Return the voxels at most `radius` voxels from one of `mask`, itself included."""
    reach = int(radius)
    grid = np.stack(np.meshgrid(*(np.arange(-reach, reach + 1),) * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    offsets = grid[(grid**2).sum(axis=1) <= radius**2].astype(np.int64)
    out = np.zeros_like(mask)
    kernels.stamp(np.ascontiguousarray(mask), offsets, out)
    return out


def connected(mask: BoolArray, start: BoolArray) -> BoolArray:
    """Return the parts of `mask`, connected through faces, that have a voxel in common with `start`."""
    labels, count = ndimage.label(mask)
    hit = np.zeros(count + 1, dtype=np.bool_)
    hit[labels[start & mask]] = True
    hit[0] = False
    return np.asarray(hit[labels])


def box_around(mask: BoolArray, shape: tuple[int, ...], margin: int) -> tuple[slice, slice, slice]:
    """Return the box around `mask` with `margin` voxels on all sides, cut to `shape`; all of it for an empty mask."""
    bounds = []
    for axis in range(3):
        line = np.flatnonzero(mask.any(axis=tuple(a for a in range(3) if a != axis)))
        bounds.append((int(line[0]), int(line[-1]) + 1) if len(line) else (0, shape[axis]))
    i, j, k = (slice(max(a - margin, 0), min(b + margin, n)) for (a, b), n in zip(bounds, shape, strict=True))
    return i, j, k

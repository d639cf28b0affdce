"""Where vessels end: half-way between what is in them and what is around them, from place to place.

Bias fields, slow flow and changing tissue make one threshold wrong; the half-way value of a neighbourhood is right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_segmentation.vessels import _border_kernels as kernels
from shapery_segmentation.vessels.evidence import BLOCK, Evidence

FloatArray = NDArray[np.float32]
IntArray = NDArray[np.int32]

LEVEL = 0.5
"""Share of the way from the background to the vessel at which it ends."""

FOLLOW = 0.08
"""Share by which the running value of a vessel follows each new voxel: it forgets within a dozen."""

LEAST_NOISE, LEAST_CONTRAST = 4.0, 0.25
"""What a voxel must rise above the background in any case: in multiples of the scatter, and of typical contrast."""

CUBE = 3
"""Voxels along the edge of the cubes in which both sides are averaged."""

SPREAD = 1.5
"""Standard deviation in cubes over which these are averaged further."""

SHELL, MIXED = 5, 2
"""Layers around a vessel that are looked at, and how many of them next to it are mixed with it."""

ROUNDS = 2
"""Times that both sides, and from these the region, are worked out."""


@dataclass(frozen=True, eq=False)
class Border:
    """Values inside and outside of vessels, and the region that lies between.

    Parameters
    ----------
    inner, outer : (A, B, C) float32
        In cubes of `CUBE` voxels; only where `known`.
    known : (A, B, C) bool
        Near vessels.
    inside : (I, J, K) uint8
        1 for voxels above half-way, connected to a seed; 2 where nothing was to be looked for.
    voxels : (n, 3) int32
        The same as a list.
    """

    inner: FloatArray
    outer: FloatArray
    known: NDArray[np.bool_]
    inside: NDArray[np.uint8]
    voxels: IntArray


def within(mask: NDArray[np.bool_], spacing: tuple[float, float, float], reach: float) -> NDArray[np.bool_]:
    """Return the voxels within `reach` mm of those of a mask, themselves included; to a twelfth of the distance.

    Parameters
    ----------
    mask : (I, J, K) bool
    spacing
        mm.
    reach
        mm.
    """
    near = np.zeros(mask.shape, dtype=np.bool_)
    spans = [np.flatnonzero(mask.any(axis=tuple(a for a in range(3) if a != axis))) for axis in range(3)]
    if not len(spans[0]):
        return near
    pads = [int(reach / s) + 1 for s in spacing]
    box = tuple(slice(max(int(s[0]) - p, 0), int(s[-1]) + p + 1) for s, p in zip(spans, pads, strict=True))
    part = np.ascontiguousarray(mask[box])
    distance = np.empty(part.shape, dtype=np.float32)
    kernels.distances(part, np.array(spacing), 2.0 * reach + 1.0, distance)
    near[box] = distance <= reach
    return near


def find_border(
    evidence: Evidence, seeds: NDArray[np.int64], *, most: int, blocked: NDArray[np.bool_] | None = None
) -> Border:
    """Grow from seeds, then work out what is inside and outside, and from it the region anew.

    Parameters
    ----------
    evidence
    seeds : (n, 3) int64
    most
        Voxels at which growth stops.
    blocked : (I, J, K) bool
        What belongs to something else: neither inside nor outside.
    """
    shape = evidence.values.shape
    closed = np.zeros(shape, dtype=np.uint8) if blocked is None else np.where(blocked, np.uint8(2), np.uint8(0))
    inside = closed.copy()
    room = min(most, evidence.values.size)
    queue, core = np.empty((room, 3), dtype=np.int32), np.empty(room, dtype=np.float32)
    least = max(LEAST_NOISE * evidence.scatter, LEAST_CONTRAST * evidence.contrast)
    count = kernels.grow(
        evidence.smoothed, evidence.background, float(BLOCK), seeds, LEVEL, least, FOLLOW, room, inside, queue, core
    )
    voxels = queue[:count].copy()
    cubes = tuple(-(-n // CUBE) for n in shape)
    middle = np.full((1, 1, 1), np.inf, dtype=np.float32)
    start = seeds.astype(np.int32)
    for _ in range(ROUNDS):
        depth = np.zeros(shape, dtype=np.int8)
        around = np.empty((min(evidence.values.size, 40 * len(voxels) + 4096), 3), dtype=np.int32)
        inner_count, total = kernels.layers(inside, voxels, SHELL, depth, around)
        sums = np.zeros((4, *cubes), dtype=np.float32)
        kernels.gather_sides(
            evidence.values, evidence.smoothed, middle, float(CUBE), depth, around, inner_count, total, MIXED, sums
        )
        for part in sums:
            ndimage.gaussian_filter(part, SPREAD, output=part, mode="constant", truncate=4.0)
        known = (sums[1] > 1e-7) & (sums[3] > 1e-7)
        inner = np.where(known, sums[0] / np.maximum(sums[1], 1e-12), np.float32(0)).astype(np.float32)
        outer = np.where(known, sums[2] / np.maximum(sums[3], 1e-12), np.float32(0)).astype(np.float32)
        known &= inner > outer
        if not known.any():
            return Border(inner, outer, known, closed, np.zeros((0, 3), dtype=np.int32))
        nearest = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
        inner, outer = (np.ascontiguousarray(part[tuple(nearest)]) for part in (inner, outer))
        middle = 0.5 * (inner + outer)
        inside = closed.copy()
        queue = np.empty((room, 3), dtype=np.int32)
        count = kernels.grow_above(evidence.smoothed, middle, known, float(CUBE), start, inside, queue)
        voxels = queue[:count].copy()
    return Border(inner, outer, known, inside, voxels)

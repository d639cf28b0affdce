"""A closed surface of genus 0 from a region of any shape: the seed of the normal flow.

The flow keeps the topology of its seed, so a seed made of a whole region must be a topological ball even where the
region is a hollow rim with holes. It is grown from the region's deepest voxel without ever closing a loop or a cavity,
so it ends with seams one voxel wide where the region's topology differs; they lie where the region is thinnest.
"""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_segmentation.neighborhoods import box_around, depths
from shapery_segmentation.seeding import _ball_kernels as kernels

BoolArray = NDArray[np.bool_]

COARSE_TOLERANCE = 0.15
"""A ball on larger voxels is taken if its volume differs from the region's by less than this share."""

HALF_FULL = 4
"""Voxels of the eight in a larger one that must belong to the region so that it does."""


@cache
def _simple_table() -> BoolArray:
    table = np.zeros(1 << 14, dtype=np.bool_)
    kernels.simple_table(np.ascontiguousarray(kernels.ADJACENT), table)
    return table


def ball_inside(region: BoolArray, *, least_depth: float = 0.0) -> tuple[BoolArray, NDArray[np.int64]]:
    """Return a topological ball that fills `region` but for seams.

    Parameters
    ----------
    region : (I, J, K) bool
        At least one voxel; of several parts, the one with the deepest voxel is filled.
    least_depth
        Distance in voxels from the region's outside that voxels must exceed; the deepest is always in.

    Returns
    -------
    (I, J, K) bool, whose inside and outside are connected through 14 neighbours (see `_ball_kernels`), with neither
    handles nor cavities; and the voxel (3,) that it was grown from.

    References
    ----------
    G. Bertrand, "Simple points, topological numbers and geodesic neighborhoods in cubic grids", Pattern Recogn. Lett.
    15 (1994), doi:10.1016/0167-8655(94)90046-9.
    """
    if not region.any():
        raise ValueError("a region without voxels holds no ball")
    box = box_around(region, region.shape, 0)
    depth = np.pad(depths(region[box]), 1)
    start = np.array(np.unravel_index(int(depth.argmax()), depth.shape), dtype=np.int64)
    depth[depth <= least_depth] = 0.0
    ball = np.zeros(depth.shape, dtype=np.bool_)
    if depth[tuple(start)] > 0:
        kernels.grow(depth, start, kernels.OFFSETS, _simple_table(), ball)
    else:
        ball[tuple(start)] = True
    whole = np.zeros(region.shape, dtype=np.bool_)
    whole[box] = ball[1:-1, 1:-1, 1:-1]
    return whole, start - 1 + [side.start for side in box]


def seed_ball(
    region: BoolArray, affine: NDArray[np.float64]
) -> tuple[BoolArray, NDArray[np.float64], NDArray[np.int64]]:
    """Return a ball that fills `region`, on voxels twice as large where these can hold it.

    Parameters
    ----------
    region : (I, J, K) bool
        At least one voxel.
    affine : (4, 4) float64
        From voxel index to RAS mm.

    Returns
    -------
    The ball, its affine, and the voxel (3,) it was grown from. Larger voxels give a quarter of the triangles, which
    the flow would have to collapse one by one; thin regions need their own voxels.
    """
    even = np.pad(region, [(0, -n % 2) for n in region.shape]).view(np.uint8)
    eighths = [even[i::2, j::2, k::2] for i, j, k in itertools.product((0, 1), repeat=3)]
    half = np.asarray(sum(eighths[1:], eighths[0]) >= HALF_FULL)
    if half.any():
        ball, start = ball_inside(half)
        if abs(8.0 * np.count_nonzero(ball & half) / np.count_nonzero(region) - 1.0) < COARSE_TOLERANCE:
            coarse = affine.copy()
            coarse[:3, :3] *= 2.0
            coarse[:3, 3] += affine[:3, :3] @ np.full(3, 0.5)
            return ball, coarse, start
    ball, start = ball_inside(region)
    return ball, affine, start


@cache
def _pieces() -> tuple[NDArray[np.int8], NDArray[np.int8]]:
    pieces, counts = np.zeros((1 << 14, 14), dtype=np.int8), np.zeros(1 << 14, dtype=np.int8)
    kernels.piece_table(np.ascontiguousarray(kernels.ADJACENT), pieces, counts)
    return pieces, counts


def surface_of(
    inside: BoolArray,
    affine: NDArray[np.float64],
    *,
    even: bool = False,
    level: NDArray[np.float32] | None = None,
) -> TriangleMesh:
    """Return the surface between the voxels inside and outside, half-way between their centres.

    Parameters
    ----------
    inside : (I, J, K) bool
    affine : (4, 4) float64
        From voxel index to RAS mm.
    even
        Draw the vertices around each voxel of the inside together where the surface stays a manifold of the same
        topology: a third of the triangles, of about the voxels' size, and hardly any thin ones. Voxels without three
        neighbours inside keep all of theirs.
    level : (I, J, K) float32
        Where this is positive inside and negative outside, the surface lies where it vanishes, not half-way.

    Returns
    -------
    A closed, oriented manifold in RAS mm; without self-intersections unless it is `even`, where voxels that are next to
    noise can bring some about.

    References
    ----------
    G. M. Treece, R. W. Prager, A. H. Gee, "Regularised marching tetrahedra: improved iso-surface extraction", Computers
    & Graphics 23 (1999), doi:10.1016/S0097-8493(99)00076-X: the idea of drawing vertices together.
    """
    padded = np.pad(inside, 1)
    first, code = np.zeros(padded.shape, dtype=np.int32), np.zeros(padded.shape, dtype=np.int32)
    pieces, counts = _pieces()
    count = kernels.number_crossings(padded, kernels.OFFSETS, kernels.RINGS, pieces, counts, even, first, code)
    points = np.empty((count, 3))
    values = np.zeros((0, 0, 0), dtype=np.float32) if level is None else np.pad(level, 1)
    faces = kernels.march(
        padded, values, kernels.OFFSETS, kernels.TRIANGLES, kernels.SIZES, pieces, first, code, points
    )
    vertices = (points - 1.0) @ affine[:3, :3].T + affine[:3, 3]
    return TriangleMesh(vertices, faces if np.linalg.det(affine[:3, :3]) > 0 else faces[:, ::-1])

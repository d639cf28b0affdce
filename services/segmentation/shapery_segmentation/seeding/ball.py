"""A closed surface of genus 0 from a region of any shape: the seed of the normal flow.

The flow keeps the topology of its seed, so a seed made of a whole region must be a topological ball even where the
region is a hollow rim with holes. It is grown from the region's deepest voxel without ever closing a loop or a cavity,
so it ends with seams one voxel wide where the region's topology differs; they lie where the region is thinnest.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_geometry.mesh import TriangleMesh
from shapery_segmentation.seeding import _ball_kernels as kernels

BoolArray = NDArray[np.bool_]

COARSE_TOLERANCE = 0.15
"""A ball on larger voxels is taken if its volume differs from the region's by less than this share."""


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
    depth = ndimage.distance_transform_edt(np.pad(region, 1)).astype(np.float32)
    start = np.array(np.unravel_index(int(depth.argmax()), depth.shape), dtype=np.int64)
    depth[depth <= least_depth] = 0.0
    ball = np.zeros(depth.shape, dtype=np.bool_)
    if depth[tuple(start)] > 0:
        kernels.grow(depth, start, kernels.OFFSETS, _simple_table(), ball)
    else:
        ball[tuple(start)] = True
    return np.ascontiguousarray(ball[1:-1, 1:-1, 1:-1]), start - 1


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
    padded = np.pad(region, [(0, -n % 2) for n in region.shape])
    a, b, c = (n // 2 for n in padded.shape)
    half = padded.reshape(a, 2, b, 2, c, 2).mean(axis=(1, 3, 5)) >= 0.5
    if half.any():
        ball, start = ball_inside(half)
        if abs(8.0 * np.count_nonzero(ball & half) / np.count_nonzero(region) - 1.0) < COARSE_TOLERANCE:
            coarse = affine.copy()
            coarse[:3, :3] *= 2.0
            coarse[:3, 3] += affine[:3, :3] @ np.full(3, 0.5)
            return ball, coarse, start
    ball, start = ball_inside(region)
    return ball, affine, start


def surface_of(inside: BoolArray, affine: NDArray[np.float64]) -> TriangleMesh:
    """Return the surface between the voxels inside and outside, half-way between their centres.

    Parameters
    ----------
    inside : (I, J, K) bool
    affine : (4, 4) float64
        From voxel index to RAS mm.

    Returns
    -------
    A closed, oriented manifold without self-intersections, in RAS mm.
    """
    padded = np.pad(inside, 1)
    count = kernels.march(padded, kernels.TETRAHEDRA, np.zeros((0, 3, 2), dtype=np.int64))
    pairs = np.zeros((count, 3, 2), dtype=np.int64)
    kernels.march(padded, kernels.TETRAHEDRA, pairs)
    keys = (pairs[..., 0] * padded.size + pairs[..., 1]).ravel()
    unique, faces = np.unique(keys, return_inverse=True)
    ends = np.stack(np.unravel_index(np.stack(np.divmod(unique, padded.size)), padded.shape), axis=-1)
    points = ends.mean(axis=0) - 1.0
    vertices = points @ affine[:3, :3].T + affine[:3, 3]
    triangles = faces.reshape(-1, 3).astype(np.int32)
    if np.linalg.det(affine[:3, :3]) < 0:
        triangles = triangles[:, ::-1]
    return TriangleMesh(vertices, triangles)

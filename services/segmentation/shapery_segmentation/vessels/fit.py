"""From a surface that is right to a voxel to one that is right to a fraction of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh
from shapery_segmentation.vessels import _border_kernels as kernels
from shapery_segmentation.vessels.border import CUBE, Border
from shapery_segmentation.vessels.evidence import Evidence

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

ROUNDS = 5
"""Times that the surface is measured and moved."""

REACH, SAMPLES = 0.75, 4
"""Voxels before and behind the wall over which it is balanced, and points on each side. Partial volume and
interpolation blur a wall by half a voxel (their standard deviation); what lies further away only adds its noise."""

SPREADS = 9
"""Averages over neighbours that an offset goes through: what differs from vertex to vertex is noise."""

FAIRING, SLIDING = 0.7, 0.3
"""Share of the way to the neighbours' mean, along the normal less its own average over the neighbours, and across."""

BEND_SPREADS = 6
"""The same for the curvature."""

LARGEST_MOVE = 0.5
"""Voxels that a vertex moves at once at the most."""

LARGEST_SHIFT = 0.1
"""Voxels by which a surface is moved for the coverage of its voxels at the most."""


def fit_surface(
    mesh: DynamicMesh,
    evidence: Evidence,
    border: Border,
    grid: Volume,
    *,
    check_cancelled: Callable[[], None] | None = None,
) -> float:
    """Move a surface to the wall of vessels; return the mean of the last moves in mm.

    Parameters
    ----------
    mesh
        Closed, about a voxel from the wall at the most; it is changed. Moves that would make it touch itself are not
        made.
    evidence, border
        Of the volume on the grid `grid`.

    Notes
    -----
    Offsets from the wall (see `_border_kernels.wall_offsets`) are averaged over the surface before they are followed.
    Fairing moves a vertex along its normal towards the plane of its neighbours, less the average of that over the
    neighbours: a tube, on which all move alike, keeps its radius, and only roughness goes.
    """
    voxel = min(grid.spacing)
    inverse = np.ascontiguousarray(grid.inverse_affine[:3])
    surface, live = mesh.to_triangle_mesh(), mesh.live
    faces, count = surface.faces, len(surface.vertices)
    mean = _averaging(faces, count)
    offset = np.empty(count)
    last = 0.0
    # Only places change: the triangles stay what they are.
    for _ in range(ROUNDS):
        if check_cancelled is not None:
            check_cancelled()
        points = np.ascontiguousarray(mesh.arrays.points[live, :3])
        normals, way, along, bend = _bends(points, faces, mean)
        kernels.wall_offsets(
            points, normals, bend, evidence.values, border.inner, border.outer, float(CUBE), inverse,
            REACH * voxel, SAMPLES, offset,
        )  # fmt: skip
        np.clip(offset, -LARGEST_MOVE * voxel, LARGEST_MOVE * voxel, out=offset)
        smooth = offset
        for _ in range(SPREADS):
            smooth = 0.5 * (smooth + mean @ smooth)
        rough = along - mean @ (mean @ along)
        target = points + (smooth + FAIRING * rough)[:, None] * normals
        target += SLIDING * (way - along[:, None] * normals)
        mesh.move(live, target)
        last = float(np.abs(smooth).mean())
    return last


def half_covered(surface: TriangleMesh, grid: Volume) -> BoolArray:
    """Return the voxels of which at least half lies inside the smooth surface that a mesh stands for.

    Parameters
    ----------
    surface
        Closed, RAS mm; its vertices lie on the smooth surface.
    grid
        The volume on whose grid the mask is wanted.

    Notes
    -----
    Two things that are small elsewhere are a tenth of the voxels of a vessel of one voxel and a half in radius. Faces
    cut corners: each is cut into four, the new vertices on the curve between the old ones that their normals tell, and
    what is left of it, Σκ·e²/16 for edges e, is added. And a voxel of edge h with its centre on a convex surface has
    less than half of itself inside: to second order, half is there where the centre lies Σκ·h²/24 deeper.

    References
    ----------
    The curve is that of A. Vlachos et al., "Curved PN triangles", Symp. Interactive 3D Graphics 2001,
    doi:10.1145/364338.364387.
    """
    count = len(surface.vertices)
    points = np.ascontiguousarray(surface.vertices)
    normals, _, _, bend = _bends(points, surface.faces, _averaging(surface.faces, count))
    start, end = surface.faces.ravel(), np.roll(surface.faces, -1, axis=1).ravel()
    keys = np.minimum(start, end).astype(np.int64) * count + np.maximum(start, end)
    edges, number = np.unique(keys, return_inverse=True)
    a, b = np.divmod(edges, count)
    way = points[b] - points[a]
    rise = np.einsum("ij,ij->i", way, normals[a])[:, None] * normals[a]
    rise -= np.einsum("ij,ij->i", way, normals[b])[:, None] * normals[b]
    points = np.concatenate((points, 0.5 * (points[a] + points[b]) - rise / 8.0))
    bend = np.concatenate((bend, 0.5 * (bend[a] + bend[b])))
    # The new vertex on the edge that begins at each corner of a face.
    middle = (count + number.reshape(-1, 3)).astype(np.int32)
    corner = surface.faces
    faces = np.concatenate(
        [np.stack((corner[:, k], middle[:, k], middle[:, k - 1]), axis=1) for k in range(3)] + [middle]
    )
    normals, square = np.empty(points.shape), np.empty(len(points))
    kernels.surround(points, faces, normals, square)
    inwards = bend * (float(np.mean(np.square(grid.spacing))) / 24.0 - square / 16.0)
    most = LARGEST_SHIFT * min(grid.spacing)
    places = points - np.clip(inwards, -most, most)[:, None] * normals
    return rasterize(TriangleMesh(places, faces), grid, known_closed=True)


def _bends(
    points: FloatArray, faces: NDArray[np.int32], mean: sparse.csr_array
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return normals, ways to the neighbours' mean, their part along the normals, and sums of curvatures (1/mm)."""
    normals, square = np.empty(points.shape), np.empty(len(points))
    kernels.surround(points, faces, normals, square)
    way = mean @ points - points
    along = np.einsum("ij,ij->i", way, normals)
    # On a regular mesh the way to the neighbours' mean is −(κ₁ + κ₂)/4 times the mean squared edge.
    bend = -4.0 * along / np.maximum(square, 1e-12)
    for _ in range(BEND_SPREADS):
        bend = 0.5 * (bend + mean @ bend)
    return normals, way, along, bend


def _averaging(faces: NDArray[np.int32], count: int) -> sparse.csr_array:
    """Return the (n, n) matrix that takes values to the means over each vertex's neighbours."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    degree = np.bincount(start, minlength=count)
    return sparse.csr_array((1.0 / degree[start], (start, end)), shape=(count, count))

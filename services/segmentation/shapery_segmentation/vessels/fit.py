"""From a surface that is right to a voxel to one that is right to a fraction of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shapery_geometry.volume import Volume
from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh
from shapery_segmentation.vessels import _border_kernels as kernels
from shapery_segmentation.vessels.border import CUBE, Border
from shapery_segmentation.vessels.evidence import Evidence

FloatArray = NDArray[np.float64]

ROUNDS = 5
"""Times that the surface is measured and moved."""

REACH, SAMPLES = 1.0, 4
"""Voxels before and behind the wall over which it is balanced, and points on each side."""

SPREADS = 9
"""Averages over neighbours that an offset goes through: what differs from vertex to vertex is noise."""

FAIRING, SLIDING = 0.7, 0.3
"""Share of the way to the neighbours' mean, along the normal less its own average over the neighbours, and across."""

BEND_SPREADS = 6
"""The same for the curvature."""

LARGEST_MOVE = 0.5
"""Voxels that a vertex moves at once at the most."""


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
    normals, square = np.empty((count, 3)), np.empty(count)
    offset = np.empty(count)
    last = 0.0
    # Only places change: the triangles stay what they are.
    for _ in range(ROUNDS):
        if check_cancelled is not None:
            check_cancelled()
        points = np.ascontiguousarray(mesh.arrays.points[live, :3])
        kernels.surround(points, faces, normals, square)
        way = mean @ points - points
        along = np.einsum("ij,ij->i", way, normals)
        # On a regular mesh the way to the neighbours' mean is −(κ₁ + κ₂)/4 times the mean squared edge.
        bend = -4.0 * along / np.maximum(square, 1e-12)
        for _ in range(BEND_SPREADS):
            bend = 0.5 * (bend + mean @ bend)
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


def _averaging(faces: NDArray[np.int32], count: int) -> sparse.csr_array:
    """Return the (n, n) matrix that takes values to the means over each vertex's neighbours."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    degree = np.bincount(start, minlength=count)
    return sparse.csr_array((1.0 / degree[start], (start, end)), shape=(count, count))

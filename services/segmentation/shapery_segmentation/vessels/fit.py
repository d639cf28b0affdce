"""From a surface that is right to a voxel to one that is right to a fraction of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shapery_geometry.operators.curvature import mean_curvature
from shapery_geometry.volume import Volume
from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh
from shapery_segmentation.vessels import _border_kernels as kernels
from shapery_segmentation.vessels.border import CUBE, Border
from shapery_segmentation.vessels.evidence import Evidence

FloatArray = NDArray[np.float64]

ROUNDS = 8
"""Times that the surface is measured and moved."""

REACH, SAMPLES = 1.0, 4
"""Voxels before and behind the wall over which it is balanced, and points on each side."""

SPREADS = 6
"""Averages over neighbours that an offset goes through: what differs from vertex to vertex is noise."""

FAIRING, SLIDING = 0.3, 0.3
"""Share of the way to the neighbours' mean, along the normal less its own average over the neighbours, and across."""

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
    last = 0.0
    for _ in range(ROUNDS):
        if check_cancelled is not None:
            check_cancelled()
        surface, live = mesh.to_triangle_mesh(), mesh.live
        points, normals = surface.vertices, surface.vertex_normals
        mean = _averaging(surface.faces, len(points))
        bend = 2.0 * mean_curvature(surface)
        for _ in range(4):
            bend = mean @ bend
        offset = np.empty(len(points))
        kernels.wall_offsets(
            points, normals, bend, evidence.values, border.inner, border.outer, float(CUBE),
            np.ascontiguousarray(grid.inverse_affine[:3]), REACH * voxel, SAMPLES, offset,
        )  # fmt: skip
        np.clip(offset, -LARGEST_MOVE * voxel, LARGEST_MOVE * voxel, out=offset)
        for _ in range(SPREADS):
            offset = 0.5 * (offset + mean @ offset)
        way = mean @ points - points
        along = np.einsum("ij,ij->i", way, normals)
        rough = along - mean @ (mean @ along)
        target = points + (offset + FAIRING * rough)[:, None] * normals
        target += SLIDING * (way - along[:, None] * normals)
        mesh.move(live, target)
        last = float(np.abs(offset).mean())
    return last


def _averaging(faces: NDArray[np.int32], count: int) -> sparse.csr_array:
    """Return the (n, n) matrix that takes values to the means over each vertex's neighbours."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    degree = np.bincount(start, minlength=count)
    return sparse.csr_array((1.0 / degree[start], (start, end)), shape=(count, count))

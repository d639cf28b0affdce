"""The running threshold (3.4.1): what counts as inside follows from what is inside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume

ENOUGH = 50_000
"""Voxels in the box around a surface from which only one in eight is looked at."""


def median_inside(field: NDArray[np.float32], affine: NDArray[np.float64], surface: TriangleMesh) -> float | None:
    """Return the median of `field` over the voxels inside a surface; none where it holds no voxel's centre.

    Parameters
    ----------
    field : (I, J, K) float32
    affine : (4, 4) float64
        From index to RAS mm.
    surface
        Closed, RAS mm.

    Notes
    -----
    The dissertation takes the mean at the vertices that are inside; those lie at the border, where intensities are low
    and mixed. The median over the inside does not depend on how the surface has got to where it is.
    """
    index = Volume(field, affine).to_index(surface.vertices)
    low = np.maximum(np.floor(index.min(axis=0)), 0).astype(np.int64)
    high = np.minimum(np.ceil(index.max(axis=0)) + 1, field.shape).astype(np.int64)
    if (high <= low).any():
        return None
    # Every second voxel along each axis says the same where they are many.
    step = 2 if np.prod(high - low) > ENOUGH else 1
    i, j, k = (slice(a, b, step) for a, b in zip(low, high, strict=True))
    part = field[i, j, k]
    shifted = affine.copy()
    shifted[:3, 3] += affine[:3, :3] @ low
    shifted[:3, :3] *= step
    inside = rasterize(surface, Volume(part, shifted), known_closed=True)
    return float(np.median(part[inside])) if inside.any() else None

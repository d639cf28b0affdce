"""The running threshold (3.4.1): what counts as inside follows from what is inside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume


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
    i, j, k = (slice(a, b) for a, b in zip(low, high, strict=True))
    part = field[i, j, k]
    shifted = affine.copy()
    shifted[:3, 3] += affine[:3, :3] @ low
    inside = rasterize(surface, Volume(part, shifted), known_closed=True)
    return float(np.median(part[inside])) if inside.any() else None

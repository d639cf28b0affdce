"""From a closed surface to the voxels inside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry import _rasterize_kernels as kernels
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.volume import Volume

FRACTION_BITS = 16
"""Vertices are rounded to 2⁻¹⁶ of a voxel, so that every test of sides is exact in 64-bit integers."""

_RANGE_BITS = 30
"""Bits of a rounded coordinate: products of two differences stay below 2⁶³."""


def rasterize(mesh: TriangleMesh, grid: Volume, *, known_closed: bool = False) -> NDArray[np.bool_]:
    """Return the voxels of `grid` whose centres lie inside `mesh`.

    Parameters
    ----------
    mesh
        A closed surface in RAS mm. Several components, cavities (components that face inwards) and parts outside the
        grid are allowed, and so are self-intersections, where a voxel counts as inside if the surface winds around it
        a number of times other than zero.
    grid
        The volume on whose grid the mask is wanted; any affine, also oblique or sheared. Its values are not read.
    known_closed
        Spares the test for a border, which takes longer than all the rest, where the surface cannot have one.

    Returns
    -------
    (I, J, K) bool.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where the surface has a border.

    Notes
    -----
    A scanline per column of voxels along the last axis: every face that the column meets adds its sign to the voxels
    before the crossing, which sums to the winding number. Whether a column meets a face is decided in exact integer
    arithmetic, and columns that run through an edge or a vertex are shifted symbolically (by ε and ε² along the first
    two axes), so they meet exactly one of the faces around it. A voxel centre that lies on the surface itself belongs
    to the object where the surface faces the low end of the last axis.

    References
    ----------
    H. Edelsbrunner, E. P. Mücke, "Simulation of simplicity", ACM Trans. Graph. 9 (1990), doi:10.1145/77635.77639.
    """
    mask = np.zeros(grid.shape, dtype=np.bool_)
    if not len(mesh.faces):
        return mask
    if not known_closed and not mesh.closed:
        raise InvalidInput(
            "invalid_mesh",
            f"The surface has {len(mesh.boundary_edges)} boundary edges, so it has no inside.",
            "Close the surface first.",
        )
    index = grid.to_index(mesh.vertices)
    bits = FRACTION_BITS
    extent = float(np.abs(index[:, :2]).max())
    while bits > 0 and (extent + 1.0) * 2.0**bits >= 2.0**_RANGE_BITS:
        bits -= 1
    if (extent + 1.0) * 2.0**bits >= 2.0**_RANGE_BITS:
        raise InvalidInput("invalid_mesh", f"The surface lies up to {extent:.3g} voxels away from the volume.")
    fixed = np.ascontiguousarray(np.rint(index[:, :2] * 2.0**bits).astype(np.int64))
    height = np.ascontiguousarray(index[:, 2])

    # Only the box around the surface is touched.
    low = np.maximum(np.floor(index.min(axis=0)), 0).astype(np.int64)
    high = np.minimum(np.ceil(index.max(axis=0)) + 1, grid.shape).astype(np.int64)
    if (high <= low).any():
        return mask
    winding = np.zeros(tuple((high - low) + (0, 0, 1)), dtype=np.int32)
    kernels.add_crossings(fixed, height, mesh.faces, bits, low, winding)
    box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
    # Left-handed grids mirror the surface, which negates the winding number; "other than zero" does not mind.
    kernels.fill(winding, mask[box])
    return mask

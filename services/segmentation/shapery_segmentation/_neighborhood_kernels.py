"""Loops of `shapery_segmentation.neighborhoods`."""

from __future__ import annotations

from typing import Any

from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def stamp(mask: Array, offsets: Array, out: Array) -> None:
    """Set in `out` every voxel that lies at one of `offsets` (n, 3) from a voxel of `mask`.

    Only voxels with a face neighbour outside the mask are stamped: the others' balls lie within theirs or in the mask.
    """
    nx, ny, nz = mask.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if not mask[i, j, k]:
                    continue
                out[i, j, k] = True
                if (
                    0 < i < nx - 1
                    and 0 < j < ny - 1
                    and 0 < k < nz - 1
                    and mask[i - 1, j, k]
                    and mask[i + 1, j, k]
                    and mask[i, j - 1, k]
                    and mask[i, j + 1, k]
                    and mask[i, j, k - 1]
                    and mask[i, j, k + 1]
                ):
                    continue
                for n in range(offsets.shape[0]):
                    a, b, c = i + offsets[n, 0], j + offsets[n, 1], k + offsets[n, 2]
                    if 0 <= a < nx and 0 <= b < ny and 0 <= c < nz:
                        out[a, b, c] = True

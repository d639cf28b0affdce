"""Loops of `shapery_segmentation.labels`."""

from __future__ import annotations

from typing import Any

from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def count_rays(rim: Array, directions: Array, reaches: Array, steps: Array, counts: Array) -> None:
    """Add to `counts` the number of directions in which each voxel meets `rim` within reach.

    Parameters
    ----------
    rim : (I, J, K) bool
    directions : (n, 3) int64
        Steps from voxel to voxel, each component −1, 0 or 1.
    reaches : (n,) int64
        Largest number of steps along each direction.
    steps : (I, J, K) int16
        Scratch.
    counts : (I, J, K) uint8
        Zero at first.
    """
    nx, ny, nz = rim.shape
    for n in range(directions.shape[0]):
        dx, dy, dz = directions[n, 0], directions[n, 1], directions[n, 2]
        far = reaches[n]
        # Against the direction, so that what a voxel looks at was visited before it.
        for i0 in range(nx):
            i = nx - 1 - i0 if dx > 0 else i0
            for j0 in range(ny):
                j = ny - 1 - j0 if dy > 0 else j0
                for k0 in range(nz):
                    k = nz - 1 - k0 if dz > 0 else k0
                    if rim[i, j, k]:
                        steps[i, j, k] = 0
                        continue
                    a, b, c = i + dx, j + dy, k + dz
                    steps[i, j, k] = -1
                    if 0 <= a < nx and 0 <= b < ny and 0 <= c < nz:
                        seen = steps[a, b, c]
                        if 0 <= seen < far:
                            steps[i, j, k] = seen + 1
                            counts[i, j, k] += 1

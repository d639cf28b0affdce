"""Loops of `shapery_segmentation.labels`: whole rows at a time, which compile to vector instructions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]

_PLAIN = {"nogil": True, "_nrt": False}
"""Without counting references to rows, which would cost more than what is done with them."""


@njit(**_PLAIN)
def _look(rim: Array, ahead: Array, far: int, steps: Array, counts: Array) -> None:
    """Work out a row of `steps` from the row `ahead`."""
    most = np.int16(far + 1)
    for k in range(rim.shape[0]):
        step = min(np.int16(ahead[k] + 1), most)
        steps[k] = np.int16(0) if rim[k] else step
        counts[k] += np.uint8(step < most)


@njit(cache=True, **_PLAIN)
def count_rays(rim: Array, directions: Array, reaches: Array, steps: Array, counts: Array) -> None:
    """Add to `counts` the number of directions in which each voxel meets `rim` within reach.

    Parameters
    ----------
    rim : (I, J, K) bool
    directions : (n, 3) int64
        Of −1, 0 and 1.
    reaches : (n,) int64
        Steps within which the rim counts, by direction.
    steps : (I + 2, J + 2, K + 2) int16
        Room for the steps to the rim, with a border.
    counts : (I, J, K) uint8
        Zero at first. What is counted at voxels of the rim itself means nothing.
    """
    ni, nj, nk = rim.shape
    for n in range(directions.shape[0]):
        dx, dy, dz = directions[n, 0], directions[n, 1], directions[n, 2]
        far = reaches[n]
        # Beyond the border there is nothing to meet.
        steps[:] = far + 1
        # Against the direction, so that what a voxel looks at was visited before it.
        for i0 in range(ni):
            i = ni - 1 - i0 if dx > 0 else i0
            for j0 in range(nj):
                j = nj - 1 - j0 if dy > 0 else j0
                if dx != 0 or dy != 0:
                    ahead = steps[i + 1 + dx, j + 1 + dy, 1 + dz : 1 + dz + nk]
                    _look(rim[i, j], ahead, far, steps[i + 1, j + 1, 1 : 1 + nk], counts[i, j])
                    continue
                for k0 in range(nk):
                    k = nk - 1 - k0 if dz > 0 else k0
                    step = min(steps[i + 1, j + 1, k + 1 + dz] + 1, far + 1)
                    steps[i + 1, j + 1, k + 1] = 0 if rim[i, j, k] else step
                    counts[i, j, k] += step <= far

"""Loops of `shapery_segmentation.labels`: whole slices at a time, which compile to vector instructions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]

_PLAIN = {"nogil": True, "_nrt": False}
"""Without counting references to slices, which would cost more than what is done with them."""

FAR = 20_000
"""Steps to a rim that is not there; more than an array has along any axis can be added to it."""


@njit(**_PLAIN)
def _look(ahead: Array, least: Array, most: Array, far: int, steps: Array, counts: Array) -> None:
    """Work out a part of `steps` from the part `ahead` of it, as long as the two have no voxel in common."""
    reach = np.int16(far)
    for n in range(steps.shape[0]):
        step = min(max(np.int16(ahead[n] + 1), least[n]), most[n])
        steps[n] = step
        counts[n] += np.uint8(step <= reach)


@njit(cache=True, **_PLAIN)
def count_rays(rim: Array, directions: Array, reaches: Array, room: Array, counts: Array) -> None:
    """Add to `counts` the number of directions in which each voxel meets `rim` within reach.

    Parameters
    ----------
    rim : (I, J, K) bool
    directions : (n, 3) int64
        Of −1, 0 and 1.
    reaches : (n,) int64
        Steps within which the rim counts, by direction; below `FAR`.
    room : (3, I + 2, (J + 2)·(K + 2)) int16
        Room for the steps to the rim, and for their bounds: no more than 0 at the rim, no less than `FAR` at the
        border, beyond which there is nothing to meet.
    counts : (I + 2, (J + 2)·(K + 2)) uint8
        Zero at first; its border, and what is counted at voxels of the rim itself, mean nothing.
    """
    ni, nj, nk = rim.shape
    wide = nk + 2
    size = (nj + 2) * wide
    steps, least, most = room[0], room[1], room[2]
    for i in range(ni + 2):
        for n in range(size):
            steps[i, n] = least[i, n] = most[i, n] = FAR
    for i in range(ni):
        for j in range(nj):
            for k in range(nk):
                at = (j + 1) * wide + k + 1
                least[i + 1, at] = 0
                if rim[i, j, k]:
                    most[i + 1, at] = 0
    # Rows from the first voxel of a slice to its last, with the borders between them.
    low, high = wide + 1, size - wide - 1
    for d in range(directions.shape[0]):
        dx, dy, dz = directions[d, 0], directions[d, 1], directions[d, 2]
        far = reaches[d]
        shift = dy * wide + dz
        # Against the direction, so that what a voxel looks at was visited before it.
        for i0 in range(ni):
            i = ni - i0 if dx > 0 else i0 + 1
            if dx != 0:
                _look(
                    steps[i + dx, low + shift : high + shift], least[i, low:high], most[i, low:high], far,
                    steps[i, low:high], counts[i, low:high],
                )  # fmt: skip
            elif dy != 0:
                for j0 in range(nj):
                    a = (nj - j0 if dy > 0 else j0 + 1) * wide + 1
                    b = a + nk
                    _look(
                        steps[i, a + shift : b + shift], least[i, a:b], most[i, a:b], far,
                        steps[i, a:b], counts[i, a:b],
                    )  # fmt: skip
            else:
                for n0 in range(high - low):
                    n = high - 1 - n0 if dz > 0 else low + n0
                    step = min(max(np.int16(steps[i, n + dz] + 1), least[i, n]), most[i, n])
                    steps[i, n] = step
                    counts[i, n] += np.uint8(step <= far)

"""Loops of `shapery_segmentation.blocks`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def block_means(values: Array, f: int, g: int, h: int, out: Array) -> None:
    """Write the mean of each block of f × g × h voxels to `out`; blocks that run over the end have its last voxels.

    Parameters
    ----------
    values : (I, J, K) float32
    out : (a, b, c) float32
    """
    ni, nj, nk = values.shape
    row = np.zeros(out.shape[2])
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            row[:] = 0.0
            for p in range(i * f, (i + 1) * f):
                for q in range(j * g, (j + 1) * g):
                    line = values[min(p, ni - 1), min(q, nj - 1)]
                    for k in range(out.shape[2]):
                        for r in range(k * h, (k + 1) * h):
                            row[k] += line[min(r, nk - 1)]
            for k in range(out.shape[2]):
                out[i, j, k] = row[k] / (f * g * h)

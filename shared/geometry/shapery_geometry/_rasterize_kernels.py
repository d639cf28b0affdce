"""Loops of `shapery_geometry.rasterize`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def _side(ax: int, ay: int, bx: int, by: int, px: int, py: int) -> int:
    """Return on which side of the line from a to b the point p lies: 1 left, −1 right; never 0 for a ≠ b.

    Integers, exact. A point on the line is taken to be p + (ε, ε²): the determinant's derivatives decide.
    """
    det = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
    if det > 0:
        return 1
    if det < 0:
        return -1
    if by != ay:
        return -1 if by > ay else 1
    if bx != ax:
        return 1 if bx > ax else -1
    return 0


@njit(cache=True, nogil=True)
def add_crossings(fixed: Array, height: Array, faces: Array, bits: int, low: Array, winding: Array) -> None:
    """Add to `winding` (a, b, c + 1) the sign of every crossing of a face with a column, at the voxel behind it.

    Parameters
    ----------
    fixed : (n, 2) int64
        First two index coordinates of the vertices, times 2^bits.
    height : (n,) float64
        Third index coordinate.
    faces : (m, 3) int32
    bits : int
    low : (3,) int64
        Index of the voxel at ``winding[0, 0, 0]``.
    """
    na, nb, nc = winding.shape[0], winding.shape[1], winding.shape[2] - 1
    one = np.int64(1) << bits
    for f in range(faces.shape[0]):
        u, v, w = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, uy = fixed[u, 0], fixed[u, 1]
        vx, vy = fixed[v, 0], fixed[v, 1]
        wx, wy = fixed[w, 0], fixed[w, 1]
        # Columns are shifted by +ε only, so those from the floor of the least coordinate on can meet the face.
        i0 = max(min(ux, vx, wx) >> bits, low[0])
        i1 = min((max(ux, vx, wx) >> bits) + 1, low[0] + na)
        j0 = max(min(uy, vy, wy) >> bits, low[1])
        j1 = min((max(uy, vy, wy) >> bits) + 1, low[1] + nb)
        if i0 >= i1 or j0 >= j1:
            continue
        area = float((vx - ux) * (wy - uy) - (vy - uy) * (wx - ux))
        for i in range(i0, i1):
            px = i * one
            for j in range(j0, j1):
                py = j * one
                s = _side(ux, uy, vx, vy, px, py)
                if s == 0 or _side(vx, vy, wx, wy, px, py) != s or _side(wx, wy, ux, uy, px, py) != s:
                    continue
                if area == 0.0:
                    # Three points on a line contain no shifted column; kept as a guard against dividing by zero.
                    continue
                bv = float((px - ux) * (wy - uy) - (py - uy) * (wx - ux)) / area
                bw = float((vx - ux) * (py - uy) - (vy - uy) * (px - ux)) / area
                z = height[u] + bv * (height[v] - height[u]) + bw * (height[w] - height[u])
                # Voxels with index below z lie before the crossing.
                k = min(max(int(np.ceil(z)) - low[2], 0), nc)
                winding[i - low[0], j - low[1], k] += s


@njit(cache=True, nogil=True)
def fill(winding: Array, mask: Array) -> None:
    """Sum the crossings from the far end of each column and write where the sum is not zero."""
    na, nb, nc = mask.shape
    for i in range(na):
        for j in range(nb):
            total = winding[i, j, nc]
            for k in range(nc - 1, -1, -1):
                # A crossing stored at k lies behind the voxels up to k − 1.
                if total != 0:
                    mask[i, j, k] = True
                total += winding[i, j, k]

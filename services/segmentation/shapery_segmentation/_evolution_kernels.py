"""Loops of `shapery_segmentation.evolution`: vertices of one cell drawn together."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def surface_area(points: Array, faces: Array) -> float:
    """Return the area of a mesh, points (n, 3) float64 and faces (m, 3) int32."""
    total = 0.0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        total += np.sqrt(nx * nx + ny * ny + nz * nz)
    return 0.5 * total


@njit(cache=True, nogil=True)
def number_cells(points: Array, side: float, keys: Array, names: Array, number: Array, most: int) -> int:
    """Give numbers to the cells of a grid that hold points, in the order in which they are met.

    Parameters
    ----------
    points : (n, 3) float64
    side : float
        Edge of a cell.
    keys, names : (2^k,) int64
        Room for a table of more entries than `most`.
    number : (n,) int32
        Receives the number of each point's cell.
    most : int

    Returns
    -------
    int
        How many cells there are; if that is more than `most`, nothing else holds.
    """
    low = np.full(3, np.inf)
    high = np.full(3, -np.inf)
    for v in range(points.shape[0]):
        for axis in range(3):
            low[axis] = min(low[axis], points[v, axis])
            high[axis] = max(high[axis], points[v, axis])
    ny = np.int64((high[1] - low[1]) / side) + 1
    nz = np.int64((high[2] - low[2]) / side) + 1
    mask = keys.shape[0] - 1
    keys[:] = -1
    count = 0
    for v in range(points.shape[0]):
        i, j = np.int64((points[v, 0] - low[0]) / side), np.int64((points[v, 1] - low[1]) / side)
        key = (i * ny + j) * nz + np.int64((points[v, 2] - low[2]) / side)
        # Multiplied by the golden ratio, cells side by side are spread over the table.
        at = ((key * np.int64(0x9E3779B1)) >> 8) & mask
        while keys[at] != key and keys[at] >= 0:
            at = (at + 1) & mask
        if keys[at] < 0:
            if count == most:
                return most + 1
            keys[at] = key
            names[at] = count
            count += 1
        number[v] = names[at]
    return count


@njit(cache=True, nogil=True)
def draw_together(points: Array, faces: Array, number: Array, means: Array, kept: Array) -> int:
    """Write the mean of the points of each cell, and the faces that are left.

    Parameters
    ----------
    points : (n, 3) float64
    faces : (m, 3) int32
    number : (n,) int32
        The cell of each point.
    means : (c, 3) float64
        Receives the means.
    kept : (m, 3) int32
        Receives the faces whose corners lie in three cells.

    Returns
    -------
    int
        How many faces these are.
    """
    size = np.zeros(means.shape[0])
    means[:] = 0.0
    for v in range(points.shape[0]):
        c = number[v]
        size[c] += 1.0
        for axis in range(3):
            means[c, axis] += points[v, axis]
    for c in range(means.shape[0]):
        for axis in range(3):
            means[c, axis] /= size[c]
    count = 0
    for f in range(faces.shape[0]):
        a, b, c = number[faces[f, 0]], number[faces[f, 1]], number[faces[f, 2]]
        if a != b and b != c and c != a:
            kept[count, 0], kept[count, 1], kept[count, 2] = a, b, c
            count += 1
    return count

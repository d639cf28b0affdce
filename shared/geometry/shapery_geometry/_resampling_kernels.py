"""Loops of `shapery_geometry.resampling`. One pass over the target, no array of coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

Array = npt.NDArray[Any]
FloatArray = npt.NDArray[np.float64]


@njit(nogil=True)
def _known_part(data: Array, x: int, y: int, z: int, u: float, v: float, w: float, fill: float) -> float:
    """Return the trilinear value in a cell of which some corners may not be known or not be there."""
    total = 0.0
    weight = 0.0
    for a in range(min(2, data.shape[0])):
        part_u = u if a == 1 else 1.0 - u
        for b in range(min(2, data.shape[1])):
            part_v = v if b == 1 else 1.0 - v
            for c in range(min(2, data.shape[2])):
                share = part_u * part_v * (w if c == 1 else 1.0 - w)
                value = float(data[x + a, y + b, z + c])
                if share > 0.0 and np.isfinite(value):
                    total += share * value
                    weight += share
    return total / weight if weight >= 0.5 else fill


@njit(cache=True, nogil=True)
def linear(data: Array, matrix: FloatArray, offset: FloatArray, out: Array, fill: float, begin: int, end: int) -> None:
    """Write into `out` the trilinear value of `data` at ``matrix @ (i, j, k) + offset``, `fill` outside.

    Done for `i` from `begin` to before `end`. Non-finite corners carry no weight; where they would carry more than half
    of it, `fill` is written.
    """
    nx, ny, nz = data.shape
    for i in range(begin, end):
        for j in range(out.shape[1]):
            for k in range(out.shape[2]):
                x = matrix[0, 0] * i + matrix[0, 1] * j + matrix[0, 2] * k + offset[0]
                y = matrix[1, 0] * i + matrix[1, 1] * j + matrix[1, 2] * k + offset[1]
                z = matrix[2, 0] * i + matrix[2, 1] * j + matrix[2, 2] * k + offset[2]
                if not (-0.5 <= x <= nx - 0.5 and -0.5 <= y <= ny - 0.5 and -0.5 <= z <= nz - 0.5):
                    out[i, j, k] = fill
                    continue
                x = min(max(x, 0.0), nx - 1.0)
                y = min(max(y, 0.0), ny - 1.0)
                z = min(max(z, 0.0), nz - 1.0)
                x0 = min(int(x), max(nx - 2, 0))
                y0 = min(int(y), max(ny - 2, 0))
                z0 = min(int(z), max(nz - 2, 0))
                u, v, w = x - x0, y - y0, z - z0
                if nx > 1 and ny > 1 and nz > 1:
                    value = (1.0 - u) * (
                        (1.0 - v) * ((1.0 - w) * data[x0, y0, z0] + w * data[x0, y0, z0 + 1])
                        + v * ((1.0 - w) * data[x0, y0 + 1, z0] + w * data[x0, y0 + 1, z0 + 1])
                    ) + u * (
                        (1.0 - v) * ((1.0 - w) * data[x0 + 1, y0, z0] + w * data[x0 + 1, y0, z0 + 1])
                        + v * ((1.0 - w) * data[x0 + 1, y0 + 1, z0] + w * data[x0 + 1, y0 + 1, z0 + 1])
                    )
                    if np.isfinite(value):
                        out[i, j, k] = value
                        continue
                out[i, j, k] = _known_part(data, x0, y0, z0, u, v, w, fill)


@njit(nogil=True)
def _cell(place: float, count: int) -> tuple[int, float, bool]:
    """Return the first voxel of the cell around `place`, the share of the next along the axis, and if it is there."""
    inside = -0.5 <= place <= count - 0.5
    place = min(max(place, 0.0), count - 1.0)
    first = min(int(place), max(count - 2, 0))
    return first, place - first, inside


@njit(cache=True, nogil=True)
def linear_aligned(data: Array, scale: FloatArray, offset: FloatArray, out: Array, fill: float) -> None:
    """Do what `linear` does where the axes of both grids are parallel: at ``scale * (i, j, k) + offset``.

    Four rows of `data`, which has two voxels at least along each axis, are merged into one; that serves a whole row of
    `out`.
    """
    nx, ny, nz = data.shape
    row = np.empty(nz, dtype=np.float64)
    for i in range(out.shape[0]):
        x, u, there_x = _cell(scale[0] * i + offset[0], nx)
        for j in range(out.shape[1]):
            y, v, there_y = _cell(scale[1] * j + offset[1], ny)
            if not (there_x and there_y):
                out[i, j] = fill
                continue
            for z in range(nz):
                row[z] = (1.0 - u) * ((1.0 - v) * data[x, y, z] + v * data[x, y + 1, z]) + u * (
                    (1.0 - v) * data[x + 1, y, z] + v * data[x + 1, y + 1, z]
                )
            for k in range(out.shape[2]):
                z, w, there_z = _cell(scale[2] * k + offset[2], nz)
                value = (1.0 - w) * row[z] + w * row[z + 1]
                if not there_z:
                    out[i, j, k] = fill
                elif np.isfinite(value):
                    out[i, j, k] = value
                else:
                    out[i, j, k] = _known_part(data, x, y, z, u, v, w, fill)


@njit(cache=True, nogil=True)
def nearest(data: Array, matrix: FloatArray, offset: FloatArray, out: Array, fill: float) -> None:
    """Write into `out` the voxel of `data` nearest to ``matrix @ (i, j, k) + offset``, `fill` outside."""
    nx, ny, nz = data.shape
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            for k in range(out.shape[2]):
                x = matrix[0, 0] * i + matrix[0, 1] * j + matrix[0, 2] * k + offset[0]
                y = matrix[1, 0] * i + matrix[1, 1] * j + matrix[1, 2] * k + offset[1]
                z = matrix[2, 0] * i + matrix[2, 1] * j + matrix[2, 2] * k + offset[2]
                if not (-0.5 <= x <= nx - 0.5 and -0.5 <= y <= ny - 0.5 and -0.5 <= z <= nz - 0.5):
                    out[i, j, k] = fill
                    continue
                out[i, j, k] = data[
                    min(max(int(np.floor(x + 0.5)), 0), nx - 1),
                    min(max(int(np.floor(y + 0.5)), 0), ny - 1),
                    min(max(int(np.floor(z + 0.5)), 0), nz - 1),
                ]

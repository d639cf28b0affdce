"""Loops over the voxels that a surface crosses: the share of each that lies inside, and what it gains by a move."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def cover(points: Array, faces: Array, samples: int, low: Array, inside: Array) -> None:
    """Write the share of every voxel of a box that lies inside a closed surface.

    Parameters
    ----------
    points : (n, 3) float64
        Voxel indices of the whole volume.
    faces : (m, 3) int32
        Closed, looking outwards in these indices.
    samples : int
        Columns along the last axis in each voxel, along either other axis; along the columns nothing is sampled.
    low : (3,) int64
        The voxel at which the box begins.
    inside : (A, B, C) float32
        Zero; receives the shares.

    Notes
    -----
    Where a column enters the surface, everything above gains its share, where it leaves it loses that. A column that
    meets the edge between two faces meets one of them: the one of which it is the left or the upper edge.
    """
    na, nb, nc = inside.shape
    share = 1.0 / (samples * samples)
    for f in range(faces.shape[0]):
        a, b, c = faces[f]
        x0, y0, z0 = points[a, 0] - low[0], points[a, 1] - low[1], points[a, 2] - low[2]
        x1, y1, z1 = points[b, 0] - low[0], points[b, 1] - low[1], points[b, 2] - low[2]
        x2, y2, z2 = points[c, 0] - low[0], points[c, 1] - low[1], points[c, 2] - low[2]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0.0:
            continue
        # What looks up is where a column leaves.
        gain = -share if area > 0.0 else share
        first = max(int(np.ceil((min(x0, x1, x2) + 0.5) * samples - 0.5)), 0)
        last = min(int(np.floor((max(x0, x1, x2) + 0.5) * samples - 0.5)), na * samples - 1)
        left = max(int(np.ceil((min(y0, y1, y2) + 0.5) * samples - 0.5)), 0)
        right = min(int(np.floor((max(y0, y1, y2) + 0.5) * samples - 0.5)), nb * samples - 1)
        for s in range(first, last + 1):
            x = low[0] + (s + 0.5) / samples - 0.5
            for t in range(left, right + 1):
                y = low[1] + (t + 0.5) / samples - 0.5
                u = _beside(points, b, c, x, y, area > 0.0)
                v = _beside(points, c, a, x, y, area > 0.0)
                w = _beside(points, a, b, x, y, area > 0.0)
                if u < 0.0 or v < 0.0 or w < 0.0 or u + v + w <= 0.0:
                    continue
                z = (u * z0 + v * z1 + w * z2) / (u + v + w) + 0.5
                i, j = s // samples, t // samples
                if z <= 0.0:
                    inside[i, j, 0] += gain
                elif z < nc:
                    k = int(z)
                    inside[i, j, k] += gain * (1.0 - (z - k))
                    if k + 1 < nc:
                        inside[i, j, k + 1] += gain * (z - k)
    for i in range(na):
        for j in range(nb):
            for k in range(1, nc):
                inside[i, j, k] += inside[i, j, k - 1]


@njit(cache=True, nogil=True)
def blurred(shares: Array, places: Array, bells: Array, out: Array) -> None:
    """Write what blurred volumes show at some voxels.

    Parameters
    ----------
    shares : (A, B, C) float32
        The sharp volume; 0 beyond it.
    places : (n, 3) int64
        Voxels.
    bells : (s, 2 r + 1) float64
        Along one axis, the shares that the neighbours have in what a voxel shows, for each of s blurs.
    out : (n, s) float64
    """
    na, nb, nc = shares.shape
    reach = bells.shape[1] // 2
    for n in range(places.shape[0]):
        i0, j0, k0 = places[n]
        first, last = max(-reach, -k0), min(reach, nc - 1 - k0)
        for s in range(bells.shape[0]):
            bell = bells[s]
            total = 0.0
            for i in range(max(-reach, -i0), min(reach, na - 1 - i0) + 1):
                for j in range(max(-reach, -j0), min(reach, nb - 1 - j0) + 1):
                    part = bell[i + reach] * bell[j + reach]
                    if part < 1e-6:
                        continue
                    line = 0.0
                    for k in range(first, last + 1):
                        line += bell[k + reach] * shares[i0 + i, j0 + j, k0 + k]
                    total += part * line
            out[n, s] = total


@njit(cache=True, nogil=True)
def _beside(points: Array, a: int, b: int, x: float, y: float, upwards: bool) -> float:
    """Return twice the area of a triangle over the edge from `a` to `b`, positive within; −1 on an edge not its own.

    From either of its faces an edge is seen through the same numbers.
    """
    p, q = (a, b) if a < b else (b, a)
    turn = (points[q, 0] - points[p, 0]) * (y - points[p, 1]) - (points[q, 1] - points[p, 1]) * (x - points[p, 0])
    dx, dy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    if not upwards:
        dx, dy = -dx, -dy
    if turn == 0.0:
        return 0.0 if dy > 0.0 or (dy == 0.0 and dx < 0.0) else -1.0
    return float(turn if (a < b) == upwards else -turn)


@njit(cache=True, nogil=True)
def crossed(
    index: Array, points: Array, faces: Array, low: Array, shape: Array, voxel: Array, vertex: Array, area: Array
) -> int:
    """List the voxels that the faces of a surface lie in, with the area that each vertex moves there.

    Parameters
    ----------
    index, points : (n, 3) float64
        The same vertices as voxel indices and in RAS mm.
    faces : (m, 3) int32
    low, shape : (3,) int64
        The box of voxels whose flat indices are told; others are left out.
    voxel, vertex : (9 m,) int64
    area : (9 m,) float64
        Room for the list; areas in mm², three points of each face with a third of its area.

    Returns
    -------
    int
        Length of the list.
    """
    count = 0
    for f in range(faces.shape[0]):
        a, b, c = faces[f]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        third = np.sqrt(nx * nx + ny * ny + nz * nz) / 6.0
        for at in range(3):
            flat = 0
            within = True
            for axis in range(3):
                mean = (index[a, axis] + index[b, axis] + index[c, axis]) / 6.0
                place = int(np.floor(mean + 0.5 * index[faces[f, at], axis] + 0.5)) - low[axis]
                within = within and 0 <= place < shape[axis]
                flat = flat * shape[axis] + place
            if not within:
                continue
            for corner in range(3):
                voxel[count] = flat
                vertex[count] = faces[f, corner]
                area[count] = third * (2.0 / 3.0 if corner == at else 1.0 / 6.0)
                count += 1
    return count

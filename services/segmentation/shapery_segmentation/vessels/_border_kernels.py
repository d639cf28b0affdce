"""Loops that find the border of vessels: growth with a running threshold, what lies on both sides of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]

NEIGHBOURS = np.array(
    [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1) if (i, j, k) != (0, 0, 0)], dtype=np.int64
)


@njit(cache=True, nogil=True)
def sample_blocks(blocks: Array, size: float, i: int, j: int, k: int) -> float:
    """Return the trilinear interpolation of values at the centres of cubes of `size` voxels."""
    a, b, c = blocks.shape
    x = min(max((i + 0.5) / size - 0.5, 0.0), a - 1.0)
    y = min(max((j + 0.5) / size - 0.5, 0.0), b - 1.0)
    z = min(max((k + 0.5) / size - 0.5, 0.0), c - 1.0)
    p, q, r = int(x), int(y), int(z)
    p1, q1, r1 = min(p + 1, a - 1), min(q + 1, b - 1), min(r + 1, c - 1)
    u, v, w = x - p, y - q, z - r
    return float(
        (1 - u)
        * (
            (1 - v) * ((1 - w) * blocks[p, q, r] + w * blocks[p, q, r1])
            + v * ((1 - w) * blocks[p, q1, r] + w * blocks[p, q1, r1])
        )
        + u
        * (
            (1 - v) * ((1 - w) * blocks[p1, q, r] + w * blocks[p1, q, r1])
            + v * ((1 - w) * blocks[p1, q1, r] + w * blocks[p1, q1, r1])
        )
    )


@njit(cache=True, nogil=True)
def grow(
    values: Array, blocks: Array, size: float, seeds: Array, level: float, least: float, follow: float, most: int,
    inside: Array, queue: Array, core: Array,
) -> int:  # fmt: skip
    """Grow from seeds over voxels that exceed a threshold which follows what has been reached.

    Parameters
    ----------
    values : (I, J, K) float32
        Smoothed; vessels are bright.
    blocks : (A, B, C) float32
        The background at the centres of cubes.
    size : float
        Voxels along the edge of such a cube.
    seeds : (n, 3) int64
    level : float
        Share of the way from the background to the vessel's own value at which it ends.
    least : float
        What must be exceeded above the background in any case.
    follow : float
        Share by which the vessel's value follows that of a new voxel's surroundings.
    most : int
        Voxels at which to stop.
    inside : (I, J, K) uint8
        Receives 1; voxels that are not 0 are not entered.
    queue : (m, 3) int32
        Receives the voxels.
    core : (m,) float32
        Receives the running value of the vessel at each of them.

    Returns
    -------
    int
        Voxels reached.
    """
    ni, nj, nk = values.shape
    size_now = 0
    for n in range(seeds.shape[0]):
        i, j, k = seeds[n]
        if inside[i, j, k] == 0 and values[i, j, k] - sample_blocks(blocks, size, i, j, k) > least:
            inside[i, j, k] = 1
            core[size_now] = _peak(values, i, j, k)
            queue[size_now] = seeds[n]
            size_now += 1
    done = 0
    while done < size_now and size_now < most:
        own = core[done]
        i, j, k = queue[done]
        done += 1
        for n in range(26):
            a, b, c = i + NEIGHBOURS[n, 0], j + NEIGHBOURS[n, 1], k + NEIGHBOURS[n, 2]
            if a < 0 or b < 0 or c < 0 or a >= ni or b >= nj or c >= nk or inside[a, b, c] != 0:
                continue
            ground = sample_blocks(blocks, size, a, b, c)
            if values[a, b, c] - ground <= max(least, level * (own - ground)):
                continue
            if size_now == core.shape[0]:
                return size_now
            inside[a, b, c] = 1
            peak = _peak(values, a, b, c)
            core[size_now] = own + follow * (peak - own)
            queue[size_now, 0] = a
            queue[size_now, 1] = b
            queue[size_now, 2] = c
            size_now += 1
    return size_now


@njit(cache=True, nogil=True)
def _peak(values: Array, i: int, j: int, k: int) -> float:
    """Return the largest value within two voxels."""
    most = values[i, j, k]
    for a in range(max(i - 2, 0), min(i + 3, values.shape[0])):
        for b in range(max(j - 2, 0), min(j + 3, values.shape[1])):
            for c in range(max(k - 2, 0), min(k + 3, values.shape[2])):
                most = max(most, values[a, b, c])
    return float(most)


@njit(cache=True, nogil=True)
def layers(inside: Array, voxels: Array, reach: int, depth: Array, queue: Array) -> tuple[int, int]:
    """Write the number of each layer of a region: inwards from 1, outwards from −1, in steps through faces.

    Parameters
    ----------
    inside : (I, J, K) uint8
        1 inside, 0 outside, 2 in neither.
    voxels : (n, 3) int32
        Those where it is 1.
    reach : int
        Layers to number on the outside.
    depth : (I, J, K) int8
        Zero; receives the numbers. Inside they end at 100.
    queue : (m, 3) int32
        Receives the voxels numbered, inner ones first.

    Returns
    -------
    tuple
        How many voxels of `queue` lie inside, and how many there are.
    """
    ni, nj, nk = inside.shape
    size = 0
    for n in range(voxels.shape[0]):
        i, j, k = voxels[n]
        border = i == 0 or j == 0 or k == 0 or i == ni - 1 or j == nj - 1 or k == nk - 1
        if not border:
            for axis in range(3):
                for step in (-1, 1):
                    a, b, c = i + (axis == 0) * step, j + (axis == 1) * step, k + (axis == 2) * step
                    border = border or inside[a, b, c] != 1
        if border:
            depth[i, j, k] = 1
            queue[size] = voxels[n]
            size += 1
    rim = size
    done = 0
    while done < size:
        i, j, k = queue[done]
        done += 1
        for axis in range(3):
            for step in (-1, 1):
                a, b, c = i + (axis == 0) * step, j + (axis == 1) * step, k + (axis == 2) * step
                if a < 0 or b < 0 or c < 0 or a >= ni or b >= nj or c >= nk:
                    continue
                if inside[a, b, c] == 1 and depth[a, b, c] == 0:
                    depth[a, b, c] = min(depth[i, j, k] + 1, 100)
                    queue[size, 0], queue[size, 1], queue[size, 2] = a, b, c
                    size += 1
    inner = size
    # Outwards: the rim is looked at first, then what was added for it.
    done = 0
    while done < size:
        if done == rim:
            done = inner
            if done >= size:
                break
        i, j, k = queue[done]
        done += 1
        here = min(np.int64(depth[i, j, k]), np.int64(0))
        if here <= -reach:
            continue
        for axis in range(3):
            for step in (-1, 1):
                a, b, c = i + (axis == 0) * step, j + (axis == 1) * step, k + (axis == 2) * step
                if a < 0 or b < 0 or c < 0 or a >= ni or b >= nj or c >= nk:
                    continue
                if inside[a, b, c] == 0 and depth[a, b, c] == 0 and size < queue.shape[0]:
                    depth[a, b, c] = here - 1
                    queue[size, 0], queue[size, 1], queue[size, 2] = a, b, c
                    size += 1
    return inner, size


@njit(cache=True, nogil=True)
def gather_sides(
    values: Array, smoothed: Array, middle: Array, size: float, depth: Array, queue: Array, inner: int, count: int,
    skip: int, sums: Array,
) -> None:  # fmt: skip
    """Add up, in cubes, the values in the middle of vessels and those just outside of them.

    Parameters
    ----------
    values, smoothed : (I, J, K) float32
    middle : (A, B, C) float32
        Outer voxels above this are left out; a single cube that is infinite: none is.
    size : float
        Voxels along the edge of a cube of `middle` and of `sums`.
    depth, queue, inner, count
        What `layers` returned.
    skip : int
        Layers next to the border that are mixed.
    sums : (4, A, B, C) float32
        Receives sum and number inside, sum and number outside.
    """
    ni, nj, nk = values.shape
    for n in range(count):
        i, j, k = queue[n]
        d = depth[i, j, k]
        a, b, c = int(i / size), int(j / size), int(k / size)
        if n < inner:
            core = d > skip
            if not core:
                # The middle of what is too thin for that.
                core = True
                for m in range(26):
                    p, q, r = i + NEIGHBOURS[m, 0], j + NEIGHBOURS[m, 1], k + NEIGHBOURS[m, 2]
                    if 0 <= p < ni and 0 <= q < nj and 0 <= r < nk and depth[p, q, r] > d:
                        core = False
                        break
                if core and d == 1:
                    # One layer only: where the values peak.
                    core = smoothed[i, j, k] >= _peak_near(smoothed, depth, i, j, k)
            if core:
                sums[0, a, b, c] += values[i, j, k]
                sums[1, a, b, c] += 1.0
        elif d < -skip and (middle.size == 1 or smoothed[i, j, k] < sample_blocks(middle, size, i, j, k)):
            sums[2, a, b, c] += values[i, j, k]
            sums[3, a, b, c] += 1.0


@njit(cache=True, nogil=True)
def _peak_near(values: Array, depth: Array, i: int, j: int, k: int) -> float:
    most = values[i, j, k]
    for a in range(max(i - 1, 0), min(i + 2, values.shape[0])):
        for b in range(max(j - 1, 0), min(j + 2, values.shape[1])):
            for c in range(max(k - 1, 0), min(k + 2, values.shape[2])):
                if depth[a, b, c] > 0:
                    most = max(most, values[a, b, c])
    # Nearly the largest: the ridge of a thin vessel runs between voxels.
    return float(0.98 * most)


@njit(cache=True, nogil=True)
def grow_above(
    values: Array, middle: Array, known: Array, size: float, seeds: Array, inside: Array, queue: Array
) -> int:
    """Grow from seeds over voxels that exceed `middle`, where that is known; return how many they are.

    Parameters
    ----------
    values : (I, J, K) float32
    middle, known : (A, B, C) float32, bool
        In cubes of `size` voxels.
    seeds : (n, 3) int32
    inside : (I, J, K) uint8
        Receives 1; voxels that are not 0 are not entered.
    queue : (m, 3) int32
        Receives the voxels.
    """
    ni, nj, nk = values.shape
    count = 0
    for n in range(seeds.shape[0]):
        i, j, k = seeds[n]
        if inside[i, j, k] == 0 and values[i, j, k] > sample_blocks(middle, size, i, j, k) and count < queue.shape[0]:
            inside[i, j, k] = 1
            queue[count] = seeds[n]
            count += 1
    done = 0
    while done < count:
        i, j, k = queue[done]
        done += 1
        for n in range(26):
            a, b, c = i + NEIGHBOURS[n, 0], j + NEIGHBOURS[n, 1], k + NEIGHBOURS[n, 2]
            if a < 0 or b < 0 or c < 0 or a >= ni or b >= nj or c >= nk or inside[a, b, c] != 0:
                continue
            if not known[int(a / size), int(b / size), int(c / size)]:
                continue
            if values[a, b, c] > sample_blocks(middle, size, a, b, c) and count < queue.shape[0]:
                inside[a, b, c] = 1
                queue[count, 0], queue[count, 1], queue[count, 2] = a, b, c
                count += 1
    return count


@njit(cache=True, nogil=True)
def relative_values(
    values: Array, inside: Array, inner: Array, outer: Array, size: float, voxels: Array, relative: Array,
    contrast: Array,
) -> None:  # fmt: skip
    """Write where between outside (0) and inside (1) voxels lie, and how far apart these are.

    Parameters
    ----------
    values : (I, J, K) float32
    inside : (I, J, K) uint8
        2 where nothing is to be looked for.
    inner, outer : (A, B, C) float32
        In cubes of `size` voxels.
    voxels : (n, 3) int64
    relative, contrast : (n,) float64
        Contrast is 0 where nothing is known.
    """
    for n in range(voxels.shape[0]):
        i, j, k = voxels[n]
        ground = sample_blocks(outer, size, i, j, k)
        rise = sample_blocks(inner, size, i, j, k) - ground
        known = rise > 0.0 and inside[i, j, k] != 2
        contrast[n] = rise if known else 0.0
        relative[n] = (values[i, j, k] - ground) / rise if known else 0.0


@njit(cache=True, nogil=True)
def relative_field(
    smoothed: Array, inner: Array, outer: Array, size: float, voxels: Array, low: Array, field: Array
) -> None:
    """Write where between outside (−1) and inside (1) some voxels lie, smoothed, into a box that begins at `low`."""
    for n in range(voxels.shape[0]):
        i, j, k = voxels[n]
        high, ground = sample_blocks(inner, size, i, j, k), sample_blocks(outer, size, i, j, k)
        half = 0.5 * (high - ground)
        if half > 0.0:
            value = (smoothed[i, j, k] - 0.5 * (high + ground)) / half
            field[i - low[0], j - low[1], k - low[2]] = min(max(value, -1.0), 1.0)


@njit(cache=True, nogil=True)
def surround(points: Array, faces: Array, normals: Array, square: Array) -> None:
    """Write unit normals (n, 3), faces weighted by area, and the mean squared length of the edges (n,) at vertices."""
    count = np.zeros(points.shape[0])
    normals[:] = 0.0
    square[:] = 0.0
    for f in range(faces.shape[0]):
        a, b, c = faces[f]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        for v in (a, b, c):
            normals[v, 0] += nx
            normals[v, 1] += ny
            normals[v, 2] += nz
        # Each edge is met from both its faces, once at either end.
        square[a] += ux * ux + uy * uy + uz * uz
        square[c] += vx * vx + vy * vy + vz * vz
        square[b] += (ux - vx) ** 2 + (uy - vy) ** 2 + (uz - vz) ** 2
        count[a] += 1.0
        count[b] += 1.0
        count[c] += 1.0
    for v in range(points.shape[0]):
        size = np.sqrt(normals[v, 0] ** 2 + normals[v, 1] ** 2 + normals[v, 2] ** 2)
        if size > 0.0:
            for axis in range(3):
                normals[v, axis] /= size
        square[v] /= max(count[v], 1.0)


@njit(cache=True, nogil=True)
def distances(mask: Array, spacing: Array, most: float, distance: Array) -> None:
    """Write how far each voxel is from the voxels of a mask, in mm, in two sweeps over its 26 neighbours.

    Between the directions of neighbours it is too long by up to a twelfth. Beyond `most` it is `most`.
    """
    ni, nj, nk = mask.shape
    for i in range(ni):
        for j in range(nj):
            for k in range(nk):
                distance[i, j, k] = 0.0 if mask[i, j, k] else most
    length = np.empty(26)
    for n in range(26):
        length[n] = np.sqrt(
            (NEIGHBOURS[n, 0] * spacing[0]) ** 2
            + (NEIGHBOURS[n, 1] * spacing[1]) ** 2
            + (NEIGHBOURS[n, 2] * spacing[2]) ** 2
        )
    # The first 13 neighbours come before a voxel in memory, the others after it.
    for turn in range(2):
        for at in range(ni * nj * nk):
            here = at if turn == 0 else ni * nj * nk - 1 - at
            i, j, k = here // (nj * nk), here // nk % nj, here % nk
            least = distance[i, j, k]
            if least == 0.0:
                continue
            for n in range(13 * turn, 13 * turn + 13):
                a, b, c = i + NEIGHBOURS[n, 0], j + NEIGHBOURS[n, 1], k + NEIGHBOURS[n, 2]
                if 0 <= a < ni and 0 <= b < nj and 0 <= c < nk:
                    least = min(least, distance[a, b, c] + length[n])
            distance[i, j, k] = least

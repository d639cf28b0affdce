"""Loops of `shapery_segmentation.neighborhoods`, whole rows at a time where that compiles to vector instructions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


_PLAIN = {"nogil": True, "_nrt": False}
"""Without counting references to rows, which would cost more than what is done with them."""


@njit(**_PLAIN)
def _least(row: Array, more: int, out: Array) -> None:
    for k in range(out.shape[0]):
        value = np.int16(row[k] + more)
        out[k] = min(out[k], value)


@njit(cache=True, **_PLAIN)
def squared_distances_within(
    mask: Array, reach: int, begin: int, end: int, lines: Array, room: Array, out: Array
) -> None:
    """Write the squared distance in voxels of every voxel from `mask` in its slice, as far as it is at most `reach`.

    Parameters
    ----------
    mask : (I, J, K) bool
    reach : int
        At most 99.
    begin, end : int
        Slices that are worked out.
    lines : (2, I, J) bool
        Receives which rows hold a voxel of the mask, and which have one near in their slice.
    room, out : (I, J, K) int16
        What receives the distances, in rows that have something near, and room; what is farther along an axis gets
        (reach + 1)² or more.

    Notes
    -----
    Axis after axis (T. Saito and J. Toriwaki, Pattern Recogn. 27, 1994, doi:10.1016/0031-3203(94)90133-3). Rows without
    anything near are passed over.
    """
    _, nj, nk = mask.shape
    farthest = np.int16((reach + 1) ** 2)
    lines[:, begin:end] = False
    for i in range(begin, end):
        for j in range(nj):
            last = reach + 1
            for k in range(nk):
                if mask[i, j, k]:
                    last = 0
                    lines[0, i, j] = True
                elif last <= reach:
                    last += 1
                out[i, j, k] = last * last
            if not lines[0, i, j]:
                continue
            last = reach + 1
            for k in range(nk - 1, -1, -1):
                if mask[i, j, k]:
                    last = 0
                elif last <= reach:
                    last += 1
                out[i, j, k] = min(out[i, j, k], np.int16(last * last))
    for i in range(begin, end):
        for j in range(nj):
            for step in range(max(-reach, -j), min(reach, nj - 1 - j) + 1):
                if lines[0, i, j + step]:
                    if not lines[1, i, j]:
                        lines[1, i, j] = True
                        room[i, j, :] = farthest
                    _least(out[i, j + step], step * step, room[i, j])


@njit(cache=True, **_PLAIN)
def squared_distances_across(reach: int, begin: int, end: int, lines: Array, room: Array, out: Array) -> None:
    """Write the squared distance of every voxel from the mask whose distances within slices are known.

    Parameters
    ----------
    reach, begin, end, lines, room
        As `squared_distances_within` takes and leaves them.
    out : (I, J, K) int16
        Receives the distances.
    """
    ni, nj, _ = room.shape
    farthest = np.int16((reach + 1) ** 2)
    for i in range(begin, end):
        for j in range(nj):
            out[i, j, :] = farthest
            for step in range(max(-reach, -i), min(reach, ni - 1 - i) + 1):
                if lines[1, i + step, j]:
                    _least(room[i + step, j], step * step, out[i, j])


@njit(cache=True, nogil=True)
def fill(mask: Array, queue: Array, count: int, out: Array) -> None:
    """Set in `out` the voxels of `mask` that paths through faces lead to.

    Parameters
    ----------
    mask : (I, J, K) bool
    queue : (I·J·K,) int64
        Flat indices of the `count` voxels to start from, all in `mask`; then room.
    out : (I, J, K) bool
        False at first.
    """
    ni, nj, nk = mask.shape
    inside, reached = mask.ravel(), out.ravel()
    for n in range(count):
        reached[queue[n]] = True
    done = 0
    while done < count:
        at = queue[done]
        done += 1
        k = at % nk
        j = (at // nk) % nj
        i = at // (nj * nk)
        for side in range(6):
            if side == 0 and k > 0:
                beside = at - 1
            elif side == 1 and k < nk - 1:
                beside = at + 1
            elif side == 2 and j > 0:
                beside = at - nk
            elif side == 3 and j < nj - 1:
                beside = at + nk
            elif side == 4 and i > 0:
                beside = at - nj * nk
            elif side == 5 and i < ni - 1:
                beside = at + nj * nk
            else:
                continue
            if inside[beside] and not reached[beside]:
                reached[beside] = True
                queue[count] = beside
                count += 1


@njit(cache=True, nogil=True)
def keep_large(chosen: Array, left: Array, least: float, out: Array) -> None:
    """Write the parts of a mask, connected through 26 neighbours, of at least `least` voxels.

    Parameters
    ----------
    chosen : (n,) int64
        Flat indices of the mask's voxels. The time is that of looking at their neighbours.
    left : (I, J, K) bool
        The mask; emptied.
    least : float
    out : (I, J, K) bool
        Receives the parts.
    """
    nx, ny, nz = left.shape
    queue = np.empty(chosen.shape[0], np.int64)
    for n in range(chosen.shape[0]):
        i, j, k = chosen[n] // (ny * nz), (chosen[n] // nz) % ny, chosen[n] % nz
        if not left[i, j, k]:
            continue
        left[i, j, k] = False
        queue[0] = chosen[n]
        done, size = 0, 1
        while done < size:
            i, j, k = queue[done] // (ny * nz), (queue[done] // nz) % ny, queue[done] % nz
            done += 1
            for a in range(max(i - 1, 0), min(i + 2, nx)):
                for b in range(max(j - 1, 0), min(j + 2, ny)):
                    for c in range(max(k - 1, 0), min(k + 2, nz)):
                        if left[a, b, c]:
                            left[a, b, c] = False
                            queue[size] = (a * ny + b) * nz + c
                            size += 1
        if size >= least:
            for done in range(size):
                i, j, k = queue[done] // (ny * nz), (queue[done] // nz) % ny, queue[done] % nz
                out[i, j, k] = True

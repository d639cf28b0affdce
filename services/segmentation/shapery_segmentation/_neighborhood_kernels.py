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


@njit(inline="always")
def _visit(left: Array, begin: int, end: int, queue: Array, count: int) -> int:
    """Take the first voxel of each run that is left between two flat indices into the queue; return its new length."""
    waiting = False
    for n in range(begin, end):
        here = left[n]
        if here and not waiting:
            left[n] = False
            queue[count] = n
            count += 1
        waiting = here
    return count


@njit(cache=True, nogil=True)
def take_connected(left: Array, start: Array, queue: Array) -> None:
    """Take away the voxels of a mask that paths through faces lead to.

    Parameters
    ----------
    left : (I, J, K) bool
        The mask; what is reached becomes false.
    start : (n,) int64
        Flat indices of voxels from which paths begin.
    queue : (I·J·K,) int64
        Room.

    Notes
    -----
    Run by run: what is reached is followed along its row, and in the four rows beside that run one voxel of each run
    waits. A voxel waits once at the most, so there is room.
    """
    ni, nj, nk = left.shape
    flat = left.ravel()
    for first in start:
        if not flat[first]:
            continue
        flat[first] = False
        queue[0] = first
        count = 1
        while count > 0:
            count -= 1
            at = queue[count]
            row = at // nk
            begin, end = at, at + 1
            while begin > row * nk and flat[begin - 1]:
                begin -= 1
                flat[begin] = False
            while end < (row + 1) * nk and flat[end]:
                flat[end] = False
                end += 1
            j = row % nj
            if j > 0:
                count = _visit(flat, begin - nk, end - nk, queue, count)
            if j < nj - 1:
                count = _visit(flat, begin + nk, end + nk, queue, count)
            if row >= nj:
                count = _visit(flat, begin - nj * nk, end - nj * nk, queue, count)
            if row < (ni - 1) * nj:
                count = _visit(flat, begin + nj * nk, end + nj * nk, queue, count)


@njit(cache=True, nogil=True)
def gather_parts(chosen: Array, left: Array, voxels: Array, ends: Array) -> int:
    """Write the parts of a mask, connected through 26 neighbours, one after the other.

    Parameters
    ----------
    chosen : (n,) int64
        Flat indices of the mask's voxels. The time is that of looking at their neighbours.
    left : (I, J, K) bool
        The mask; emptied.
    voxels : (n,) int64
        Receives the flat indices, part by part; the parts in the order of their first voxel in `chosen`.
    ends : (n,) int64
        Receives where in `voxels` each part ends.

    Returns
    -------
    int
        How many parts there are.
    """
    nx, ny, nz = left.shape
    parts = done = size = 0
    for n in range(chosen.shape[0]):
        i, j, k = chosen[n] // (ny * nz), (chosen[n] // nz) % ny, chosen[n] % nz
        if not left[i, j, k]:
            continue
        left[i, j, k] = False
        voxels[size] = chosen[n]
        size += 1
        while done < size:
            i, j, k = voxels[done] // (ny * nz), (voxels[done] // nz) % ny, voxels[done] % nz
            done += 1
            for a in range(max(i - 1, 0), min(i + 2, nx)):
                for b in range(max(j - 1, 0), min(j + 2, ny)):
                    for c in range(max(k - 1, 0), min(k + 2, nz)):
                        if left[a, b, c]:
                            left[a, b, c] = False
                            voxels[size] = (a * ny + b) * nz + c
                            size += 1
        ends[parts] = size
        parts += 1
    return parts

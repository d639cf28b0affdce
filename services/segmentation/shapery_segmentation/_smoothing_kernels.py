"""Loops of `shapery_segmentation.smoothing`: whole rows at a time, which compile to vector instructions."""

from __future__ import annotations

from typing import Any

from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(nogil=True)
def _weigh(middle: Array, weight: float, out: Array) -> None:
    for k in range(out.shape[0]):
        out[k] = weight * middle[k]


@njit(nogil=True)
def _add_pair(left: Array, right: Array, weight: float, out: Array) -> None:
    for k in range(out.shape[0]):
        out[k] += weight * (left[k] + right[k])


@njit(cache=True, nogil=True)
def smooth(values: Array, first: Array, second: Array, third: Array, room: Array, line: Array, out: Array) -> None:
    """Convolve `values` along each axis with a symmetric kernel; beyond an end its last value holds.

    Parameters
    ----------
    values : (I, J, K) float32
    first, second, third : (r + 1,) float32
        The middle of each axis's kernel and what follows.
    room, out : (I, J, K) float32
        Room, and what receives the result.
    line : (K + 2r,) float32
        Room for one row along the last axis and what is beyond its ends.
    """
    ni, nj, nk = values.shape
    for i in range(ni):
        for j in range(nj):
            row = room[i, j]
            _weigh(values[i, j], first[0], row)
            for t in range(1, first.shape[0]):
                _add_pair(values[max(i - t, 0), j], values[min(i + t, ni - 1), j], first[t], row)
    radius = third.shape[0] - 1
    for i in range(ni):
        for j in range(nj):
            row = line[radius : radius + nk]
            _weigh(room[i, j], second[0], row)
            for t in range(1, second.shape[0]):
                _add_pair(room[i, max(j - t, 0)], room[i, min(j + t, nj - 1)], second[t], row)
            for t in range(radius):
                line[t] = row[0]
                line[radius + nk + t] = row[nk - 1]
            done = out[i, j]
            _weigh(row, third[0], done)
            for t in range(1, radius + 1):
                _add_pair(line[radius - t : radius - t + nk], line[radius + t : radius + t + nk], third[t], done)

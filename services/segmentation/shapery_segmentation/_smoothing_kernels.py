"""Loops of `shapery_segmentation.smoothing`: whole rows at a time, which compile to vector instructions."""

from __future__ import annotations

from typing import Any

from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]

_PLAIN = {"nogil": True, "_nrt": False}
"""Without counting references to rows, which would cost more than what is done with them."""


@njit(**_PLAIN)
def _weigh(middle: Array, weight: float, out: Array) -> None:
    for k in range(out.shape[0]):
        out[k] = weight * middle[k]


@njit(**_PLAIN)
def _add_pair(left: Array, right: Array, weight: float, out: Array) -> None:
    for k in range(out.shape[0]):
        out[k] += weight * (left[k] + right[k])


@njit(**_PLAIN)
def _add_pairs(left: Array, right: Array, weight: float, wide: Array, far: Array, less: float, out: Array) -> None:
    for k in range(out.shape[0]):
        out[k] = out[k] + weight * (left[k] + right[k]) + less * (wide[k] + far[k])


@njit(cache=True, **_PLAIN)
def smooth_across(values: Array, first: Array, begin: int, end: int, out: Array) -> None:
    """Convolve `values` along the first axis with a symmetric kernel; beyond an end the last value holds.

    Parameters
    ----------
    values : (I, J, K) float32
    first : (r + 1,) float32
        The middle of the kernel and what follows.
    begin, end : int
        Slices that are worked out.
    out : (I, J, K) float32
        Receives the result.
    """
    ni, nj, _ = values.shape
    for i in range(begin, end):
        for j in range(nj):
            row = out[i, j]
            _weigh(values[i, j], first[0], row)
            # Two pairs at once, which reads and writes the sum half as often.
            for t in range(1, first.shape[0] - 1, 2):
                _add_pairs(
                    values[max(i - t, 0), j], values[min(i + t, ni - 1), j], first[t],
                    values[max(i - t - 1, 0), j], values[min(i + t + 1, ni - 1), j], first[t + 1], row,
                )  # fmt: skip
            if first.shape[0] % 2 == 0:
                t = first.shape[0] - 1
                _add_pair(values[max(i - t, 0), j], values[min(i + t, ni - 1), j], first[t], row)


@njit(cache=True, **_PLAIN)
def smooth_within(room: Array, second: Array, third: Array, begin: int, end: int, line: Array, out: Array) -> None:
    """Do the same along the second and the third axis.

    Parameters
    ----------
    room : (I, J, K) float32
        What `smooth_across` wrote.
    second, third : (r + 1,) float32
    begin, end : int
        Slices that are worked out.
    line : (K + 2r,) float32
        Room for one row along the last axis and what is beyond its ends.
    out : (I, J, K) float32
        Receives the result.
    """
    _, nj, nk = room.shape
    radius = third.shape[0] - 1
    for i in range(begin, end):
        for j in range(nj):
            row = line[radius : radius + nk]
            _weigh(room[i, j], second[0], row)
            for t in range(1, second.shape[0] - 1, 2):
                _add_pairs(
                    room[i, max(j - t, 0)], room[i, min(j + t, nj - 1)], second[t],
                    room[i, max(j - t - 1, 0)], room[i, min(j + t + 1, nj - 1)], second[t + 1], row,
                )  # fmt: skip
            if second.shape[0] % 2 == 0:
                t = second.shape[0] - 1
                _add_pair(room[i, max(j - t, 0)], room[i, min(j + t, nj - 1)], second[t], row)
            for t in range(radius):
                line[t] = row[0]
                line[radius + nk + t] = row[nk - 1]
            done = out[i, j]
            _weigh(row, third[0], done)
            for t in range(1, radius, 2):
                _add_pairs(
                    line[radius - t : radius - t + nk], line[radius + t : radius + t + nk], third[t],
                    line[radius - t - 1 : radius - t - 1 + nk], line[radius + t + 1 : radius + t + 1 + nk],
                    third[t + 1], done,
                )  # fmt: skip
            if radius % 2 == 1:
                _add_pair(line[:nk], line[2 * radius : 2 * radius + nk], third[radius], done)

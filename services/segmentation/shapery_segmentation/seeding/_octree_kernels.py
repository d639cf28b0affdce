"""Loops of `shapery_segmentation.seeding.octree`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]

BINS = 96
"""Bins of a cell's histogram."""

ROUNDS = 40
"""Rounds of expectation and maximisation: the peaks then move by less than a bin."""


@njit(cache=True, nogil=True)
def histogram(field: Array, mask: Array, low: Array, high: Array, bottom: float, width: float, counts: Array) -> int:
    """Count the voxels of `mask` in the cell [low, high) into bins of `width` from `bottom`; return their number."""
    counts[:] = 0.0
    total = 0
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            for k in range(low[2], high[2]):
                if mask[i, j, k]:
                    b = int((field[i, j, k] - bottom) / width)
                    counts[min(max(b, 0), BINS - 1)] += 1.0
                    total += 1
    return total


@njit(cache=True, nogil=True)
def two_normals(counts: Array, bottom: float, width: float, start: float, result: Array) -> None:
    """Fit two normal distributions to a histogram by expectation and maximisation.

    Parameters
    ----------
    counts : (bins,) float64
    bottom, width : float
        Lower end of the first bin, and width of each.
    start : float
        Value that separates the two classes at first.
    result : (7,) float64
        Written: weight, mean and deviation of the lower and of the upper class, and how much the description of one
        voxel becomes shorter than with a single normal distribution, in nats.
    """
    n = counts.shape[0]
    total = counts.sum()
    result[:] = 0.0
    if total <= 0.0:
        return
    floor = (0.5 * width) ** 2
    mean = 0.0
    for b in range(n):
        mean += counts[b] * (bottom + (b + 0.5) * width)
    mean /= total
    variance = 0.0
    for b in range(n):
        variance += counts[b] * (bottom + (b + 0.5) * width - mean) ** 2
    variance = max(variance / total, floor)
    single = -0.5 * np.log(2.0 * np.pi * variance) - 0.5

    w, m, v = np.zeros(2), np.zeros(2), np.zeros(2)
    for b in range(n):
        x = bottom + (b + 0.5) * width
        c = 1 if x > start else 0
        w[c] += counts[b]
        m[c] += counts[b] * x
    if w[0] == 0.0 or w[1] == 0.0:
        result[0], result[1], result[2] = 1.0, mean, np.sqrt(variance)
        result[4], result[5] = mean, np.sqrt(variance)
        return
    m[0] /= w[0]
    m[1] /= w[1]
    for b in range(n):
        x = bottom + (b + 0.5) * width
        c = 1 if x > start else 0
        v[c] += counts[b] * (x - m[c]) ** 2
    for c in range(2):
        v[c] = max(v[c] / w[c], floor)
        w[c] /= total
    double = single
    for _ in range(ROUNDS):
        s0 = s1 = x0 = x1 = q0 = q1 = 0.0
        likelihood = 0.0
        a0 = w[0] / np.sqrt(2.0 * np.pi * v[0])
        a1 = w[1] / np.sqrt(2.0 * np.pi * v[1])
        for b in range(n):
            if counts[b] == 0.0:
                continue
            x = bottom + (b + 0.5) * width
            p0 = a0 * np.exp(-0.5 * (x - m[0]) ** 2 / v[0])
            p1 = a1 * np.exp(-0.5 * (x - m[1]) ** 2 / v[1])
            p = p0 + p1 + 1e-300
            likelihood += counts[b] * np.log(p)
            r = counts[b] * p1 / p
            s1 += r
            x1 += r * x
            q1 += r * x * x
            r = counts[b] * p0 / p
            s0 += r
            x0 += r * x
            q0 += r * x * x
        double = likelihood / total
        if s0 < 1.0 or s1 < 1.0:
            break
        w[0], w[1] = s0 / total, s1 / total
        m[0], m[1] = x0 / s0, x1 / s1
        v[0] = max(q0 / s0 - m[0] * m[0], floor)
        v[1] = max(q1 / s1 - m[1] * m[1], floor)
    lower, upper = (0, 1) if m[0] <= m[1] else (1, 0)
    result[0], result[1], result[2] = w[lower], m[lower], np.sqrt(v[lower])
    result[3], result[4], result[5] = w[upper], m[upper], np.sqrt(v[upper])
    result[6] = double - single


@njit(cache=True, nogil=True)
def scan(
    field: Array,
    mask: Array,
    edges: Array,
    bottom: float,
    width: float,
    start: float,
    begin: int,
    end: int,
    results: Array,
) -> None:
    """Fit two normal distributions to the cells of one level.

    Parameters
    ----------
    edges : (3, cells + 1) int64
        First voxel of each cell along each axis, and the end of the last.
    begin, end : int
        Slices of cells along the first axis.
    results : (cells, cells, cells, 8) float64
        Written: as `two_normals`, and the number of voxels.
    """
    cells = edges.shape[1] - 1
    counts = np.zeros(BINS)
    low, high = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for a in range(begin, end):
        for b in range(cells):
            for c in range(cells):
                low[0], low[1], low[2] = edges[0, a], edges[1, b], edges[2, c]
                high[0], high[1], high[2] = edges[0, a + 1], edges[1, b + 1], edges[2, c + 1]
                total = histogram(field, mask, low, high, bottom, width, counts)
                results[a, b, c, 7] = total
                if total > 0:
                    two_normals(counts, bottom, width, start, results[a, b, c, :7])

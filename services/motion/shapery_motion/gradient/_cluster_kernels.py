"""Compiled loops of `shapery_motion.gradient.clustering`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def assign(points, centres, labels, distances):
    """Give every point (m, d) the label of its nearest centre, and its squared distance; `centres` is (d, k).

    The first of equally near centres counts.
    """
    dimensions, k = centres.shape
    buffer = np.empty(k)
    for i in range(len(points)):
        for c in range(k):
            d = points[i, 0] - centres[0, c]
            buffer[c] = d * d
        for axis in range(1, dimensions):
            x = points[i, axis]
            for c in range(k):
                d = x - centres[axis, c]
                buffer[c] += d * d
        best = 0
        for c in range(1, k):
            if buffer[c] < buffer[best]:
                best = c
        labels[i] = best
        distances[i] = buffer[best]


@njit(cache=True, nogil=True)
def draw_centres(points, first, draws, chosen):
    """Draw centres in proportion to the squared distance from those before (k-means++); return how many were found.

    `draws` are uniform in [0, 1), one for each centre after the first; `chosen` receives the points' numbers.
    """
    n, dimensions = points.shape
    nearest = np.full(n, np.inf)
    chosen[0] = first
    last = first
    for k in range(len(draws)):
        total = 0.0
        for i in range(n):
            there = 0.0
            for axis in range(dimensions):
                d = points[i, axis] - points[last, axis]
                there += d * d
            nearest[i] = min(nearest[i], there)
            total += nearest[i]
        if not total > 0.0:
            return k + 1
        goal, passed = draws[k] * total, 0.0
        last = -1
        for i in range(n):
            passed += nearest[i]
            if nearest[i] > 0.0:
                last = i
            if passed > goal:
                break
        chosen[k + 1] = last
    return len(draws) + 1


@njit(cache=True, nogil=True)
def means(points, labels, centres, counts):
    """Put the mean of each label's points into `centres` (k, d) and their number into `counts`."""
    centres[:] = 0.0
    counts[:] = 0
    for i in range(len(points)):
        label = labels[i]
        counts[label] += 1
        for axis in range(points.shape[1]):
            centres[label, axis] += points[i, axis]
    for c in range(len(centres)):
        if counts[c]:
            for axis in range(points.shape[1]):
                centres[c, axis] /= counts[c]


@njit(cache=True, nogil=True)
def moments(labels, source, target, solid, cross, square):
    """Sum Ṽ Vᵀ into `cross` (k, 3, 3) and V Vᵀ into `square` (k, 3, 3) over the solid faces of each cluster."""
    cross[:] = 0.0
    square[:] = 0.0
    for f in range(len(labels)):
        if not solid[f]:
            continue
        c = labels[f]
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    cross[c, i, j] += target[f, i, k] * source[f, j, k]
                    square[c, i, j] += source[f, i, k] * source[f, j, k]


@njit(cache=True, nogil=True)
def nearest_members(points, labels, centres, solid, members):
    """For each cluster the solid face whose transformation lies nearest to the centre; −1 where it has none."""
    members[:] = -1
    best = np.full(len(members), np.inf)
    for f in range(len(labels)):
        if not solid[f]:
            continue
        c = labels[f]
        distance = 0.0
        for axis in range(points.shape[1]):
            d = points[f, axis] - centres[c, axis]
            distance += d * d
        if distance < best[c]:
            best[c] = distance
            members[c] = f

"""Compiled loops of `shapery_motion.baselines.affine`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def assign(source, target, transforms, labels, errors):
    """Give each vertex the transform (k, 3, 4) that brings it nearest to its target, and the squared distance left.

    The first of equally good ones counts.
    """
    for v in range(len(source)):
        x, y, z = source[v, 0], source[v, 1], source[v, 2]
        best = 0
        least = np.inf
        for k in range(len(transforms)):
            t = transforms[k]
            squared = 0.0
            for axis in range(3):
                d = t[axis, 0] * x + t[axis, 1] * y + t[axis, 2] * z + t[axis, 3] - target[v, axis]
                squared += d * d
            if squared < least:
                least = squared
                best = k
        labels[v] = best
        errors[v] = least


@njit(cache=True, nogil=True)
def moments(source, target, labels, square, cross):
    """Sum x xᵀ (k, 4, 4) and x̃ xᵀ (k, 3, 4) with x = (source, 1) and x̃ the target over each cluster's vertices."""
    square[:] = 0.0
    cross[:] = 0.0
    row = np.empty(4)
    row[3] = 1.0
    for v in range(len(source)):
        k = labels[v]
        row[:3] = source[v]
        for i in range(4):
            for j in range(4):
                square[k, i, j] += row[i] * row[j]
        for i in range(3):
            for j in range(4):
                cross[k, i, j] += target[v, i] * row[j]

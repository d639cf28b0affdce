"""Compiled loops of `shapery_motion.gradient.traversal`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def walk(faces, across, vertex_count):
    """Visit the faces breadth first; see `shapery_motion.gradient.traversal.Traversal` for what is returned."""
    m = len(faces)
    face_order = np.empty(m, dtype=np.int32)
    parents = np.full(m, -1, dtype=np.int32)
    vertex_order = np.empty(vertex_count, dtype=np.int32)
    predictors = np.full((vertex_count, 3), -1, dtype=np.int32)
    seen_face = np.zeros(m, dtype=np.bool_)
    seen_vertex = np.zeros(vertex_count, dtype=np.bool_)
    filled = 0
    placed = 0
    head = 0
    for seed in range(m):
        if seen_face[seed]:
            continue
        seen_face[seed] = True
        face_order[filled] = seed
        filled += 1
        while head < filled:
            f = face_order[head]
            head += 1
            for corner in range(3):
                v = faces[f, corner]
                if not seen_vertex[v]:
                    # only a seed has new vertices here: those of others were placed when they were found
                    seen_vertex[v] = True
                    if placed > 0:
                        predictors[v, 0] = vertex_order[placed - 1]
                    vertex_order[placed] = v
                    placed += 1
            for side in range(3):
                g = across[f, side]
                if g < 0 or seen_face[g]:
                    continue
                seen_face[g] = True
                parents[g] = f
                face_order[filled] = g
                filled += 1
                a = faces[f, side]
                b = faces[f, (side + 1) % 3]
                opposite = faces[f, (side + 2) % 3]
                for corner in range(3):
                    v = faces[g, corner]
                    if not seen_vertex[v]:
                        seen_vertex[v] = True
                        predictors[v, 0] = a
                        predictors[v, 1] = b
                        predictors[v, 2] = opposite
                        vertex_order[placed] = v
                        placed += 1
    for v in range(vertex_count):
        if not seen_vertex[v]:
            if placed > 0:
                predictors[v, 0] = vertex_order[placed - 1]
            vertex_order[placed] = v
            placed += 1
    return face_order, parents, vertex_order, predictors


@njit(cache=True, nogil=True)
def to_residuals(values, order, predictors, result):
    """Replace values (n, 3) by their differences from the prediction, in coding order."""
    for k in range(len(order)):
        v = order[k]
        a, b, c = predictors[v]
        for axis in range(3):
            predicted = 0
            if b >= 0:
                predicted = values[a, axis] + values[b, axis] - values[c, axis]
            elif a >= 0:
                predicted = values[a, axis]
            result[k, axis] = values[v, axis] - predicted


@njit(cache=True, nogil=True)
def from_residuals(residuals, order, predictors, result):
    """Undo `to_residuals`."""
    for k in range(len(order)):
        v = order[k]
        a, b, c = predictors[v]
        for axis in range(3):
            predicted = 0
            if b >= 0:
                predicted = result[a, axis] + result[b, axis] - result[c, axis]
            elif a >= 0:
                predicted = result[a, axis]
            result[v, axis] = residuals[k, axis] + predicted

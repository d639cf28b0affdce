"""Moving many vertices at once, with a check of every face that moved and rollback where it would touch another."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit

from shapery_segmentation.mesh._contact_kernels import dot, inner
from shapery_segmentation.mesh._grid_kernels import face_contact, link_face, measure_face, normal
from shapery_segmentation.mesh._operation_kernels import compactness, origin, preceding, twin
from shapery_segmentation.mesh.arrays import AREA, FORMER, NORMAL, OUT, STAMP

LEAST_TURN = 0.2
"""Least product of the normals of a face before and after one move."""

LEAST_SHAPE = 0.02
"""Least compactness that a move may give to a face, unless it had less before."""

MOVED = 1
RETURNED = 2


@inner
def _put_back(m, f, state, old, queue, size):
    """Return the moved vertices of face `f` to where they were, and append them to `queue`; return its new length."""
    for k in range(3):
        v = origin(m, 3 * f + k)
        if state[v] == MOVED:
            state[v] = RETURNED
            for axis in range(3):
                m.points[v, axis] = old[v, axis]
            start = m.vertices[v, OUT]
            h = start
            while True:
                measure_face(m, h // 3)
                link_face(m, h // 3)
                h = twin(m, preceding(h))
                if h == start:
                    break
            queue[size] = v
            size += 1
    return size


@inner
def _spoiled(m, f):
    """Return whether face `f` turned or thinned too much since it was last at rest."""
    g = m.facets
    area = g[f, FORMER + 3]
    turn = dot((g[f, FORMER], g[f, FORMER + 1], g[f, FORMER + 2]), normal(m, f))
    return (area > 0.0 and turn < LEAST_TURN) or (g[f, AREA] < area and compactness(m, f) < LEAST_SHAPE)


@njit(cache=True, nogil=True)
def move_vertices(m, movers, target, old, state, batch):
    """Move vertices to their targets, except where a face would turn over, degenerate or touch another.

    Parameters
    ----------
    m : MeshArrays
    movers : (n,) int32
        The vertices to move, each once.
    target : (V, 3) float64
        Where to; rounded to float32 values.
    old : (V, 3) float64
        Receives the positions before, for the movers.
    state : (V,) int8
        Is `MOVED` or `RETURNED` for the movers afterwards.
    batch : int
        A positive stamp that no face carries yet.

    Returns
    -------
    int
        Movers that were put back.

    Notes
    -----
    All vertices move first. Then every face of a mover is tested against the faces around it; where two touch, the
    movers of both go back, and the faces around these are tested again, until nothing touches. Vertices only ever go
    back, so this ends, in the worst case in the state before the call, which was free of contacts.
    """
    n = movers.shape[0]
    for i in range(n):
        v = movers[i]
        state[v] = MOVED
        for axis in range(3):
            old[v, axis] = m.points[v, axis]
            m.points[v, axis] = np.float64(np.float32(target[v, axis]))
    faces = np.empty(m.links.shape[0], dtype=np.int32)
    count = 0
    for i in range(n):
        start = m.vertices[movers[i], OUT]
        h = start
        while True:
            f = h // 3
            if m.links[f, STAMP] != batch:
                m.links[f, STAMP] = batch
                faces[count] = f
                count += 1
            h = twin(m, preceding(h))
            if h == start:
                break
    for i in range(count):
        f = faces[i]
        for axis in range(4):
            m.facets[f, FORMER + axis] = m.facets[f, NORMAL + axis]
        measure_face(m, f)
        link_face(m, f)

    queue = np.empty(n, dtype=np.int32)
    size = 0
    for i in range(count):
        f = faces[i]
        if _spoiled(m, f):
            size = _put_back(m, f, state, old, queue, size)
        else:
            g = face_contact(m, f, batch)
            if g >= 0:
                size = _put_back(m, f, state, old, queue, size)
                size = _put_back(m, g, state, old, queue, size)
    done = 0
    while done < size:
        start = m.vertices[queue[done], OUT]
        h = start
        while True:
            f = h // 3
            if _spoiled(m, f):
                size = _put_back(m, f, state, old, queue, size)
            else:
                g = face_contact(m, f, 0)
                if g >= 0:
                    size = _put_back(m, f, state, old, queue, size)
                    size = _put_back(m, g, state, old, queue, size)
            h = twin(m, preceding(h))
            if h == start:
                break
        done += 1
    return size

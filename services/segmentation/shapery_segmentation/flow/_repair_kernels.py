"""Help for vertices that do not come to rest: finer triangles, collapse, smoothing."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.flow._state_kernels import AWAKE, COLLAPSE, FROZEN, MODE, NONE, REFINE, WISH, wake
from shapery_segmentation.flow._step_kernels import surround
from shapery_segmentation.mesh._operation_kernels import compactness, following, origin, preceding, twin
from shapery_segmentation.mesh.arrays import OUT, SCALE, VERTEX_TOP
from shapery_segmentation.mesh.compiled import kernel


@kernel
def answer_wishes(m, state, counter, dials, may_refine, may_collapse, collapse):
    """Give finer triangles to frozen vertices that guard a small feature, and name those that should collapse.

    Parameters
    ----------
    m, state, counter, dials
        As in `propose`.
    may_refine, may_collapse : bool
        Which wishes to answer; the others are forgotten.
    collapse : (V,) int8
        Receives 1 for vertices to collapse.

    Returns
    -------
    refined, collapsing, pinched : int
        Wishes that are answered of either kind, and those for a change of topology, which is not made here: fronts that
        meet inside the object, and thin pieces that are not object.
    """
    refined = 0
    collapsing = 0
    pinched = 0
    for v in range(m.layout[VERTEX_TOP]):
        collapse[v] = 0
        if m.vertices[v, OUT] < 0 or counter[v, WISH] == NONE:
            continue
        wish = counter[v, WISH]
        counter[v, WISH] = NONE
        pinched += wish != REFINE
        if wish == COLLAPSE:
            if may_collapse:
                collapse[v] = 1
                collapsing += 1
        elif wish == REFINE and may_refine and m.points[v, SCALE] > dials.least_scale:
            scale = max(dials.least_scale, 0.7 * m.points[v, SCALE])
            m.points[v, SCALE] = scale
            wake(state, counter, v)
            first = np.int64(m.vertices[v, OUT])
            h = first
            while True:
                w = origin(m, following(h))
                # Edge lengths grow by a third from one vertex to the next.
                m.points[w, SCALE] = min(m.points[w, SCALE], 1.35 * scale)
                wake(state, counter, w)
                h = twin(m, preceding(h))
                if h == first:
                    break
            refined += 1
    return refined, collapsing, pinched


@kernel
def irregular_vertices(m, counter, least, target, movers):
    """Find vertices on the move with a face thinner than `least`, and where smoothing would put them.

    Returns
    -------
    int
        How many; written to `movers`, and where they go to `target`.
    """
    count = 0
    for v in range(m.layout[VERTEX_TOP]):
        if m.vertices[v, OUT] < 0 or (counter[v, MODE] != AWAKE and counter[v, MODE] != FROZEN):
            continue
        first = np.int64(m.vertices[v, OUT])
        h = first
        thin = False
        while True:
            thin = thin or compactness(m, h // 3) < least
            h = twin(m, preceding(h))
            if h == first:
                break
        if thin:
            _, u, _ = surround(m, v)
            for axis in range(3):
                target[v, axis] = m.points[v, axis] + 0.5 * u[axis]
            movers[count] = v
            count += 1
    return count

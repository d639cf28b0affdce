"""Moving many vertices, with a check of everything that moved and rollback where something would touch.

Two faces that share a vertex are checked through the star of that vertex, all others pair by pair.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.mesh._cells_kernels import ANY, gather, note_face, sort_faces
from shapery_segmentation.mesh._contact_kernels import cross, dot, subtract, touching
from shapery_segmentation.mesh._grid_kernels import corners, measure_face, normal, point
from shapery_segmentation.mesh._operation_kernels import compactness, following, origin, preceding, twin
from shapery_segmentation.mesh.arrays import (
    AREA,
    CLEARANCE,
    FACE_TOP,
    LARGEST_RADIUS,
    NORMAL,
    ORIGIN,
    OUT,
    RADIUS,
    STAMP,
)
from shapery_segmentation.mesh.compiled import inlined, inner, kernel

LEAST_TURN = 0.2
"""Least product of the normals of a face before and after one move."""

LEAST_SHAPE = 0.02
"""Least compactness that a move may give to a face, unless it had less before."""

OPPOSED = 0.55
"""Product of the normals of two faces below which they may belong to fronts that meet."""

SORTED = 0.1
"""Radii of the largest face that faces may be from where they were sorted, or the search for contacts is wide."""

LEAST_TILT = 0.25
"""A star whose faces all have at least this product with the mean of their normals is a graph over their plane."""


@inner
def is_graph(m, v):
    """Return whether the star of `v` certainly projects one to one onto the plane across its mean normal.

    Then no two of its faces have more in common than they share. Every face must look the way of the mean, so that the
    projected star turns around `v` in one sense; and it must turn once: on the way around from the first neighbour
    nothing comes back to that neighbour's left side after it has been on its right.
    """
    nx = ny = nz = 0.0
    start = np.int64(m.vertices[v, OUT])
    h = start
    while True:
        f = h // 3
        w = np.float64(m.facets[f, AREA])
        n = normal(m, f)
        nx += w * n[0]
        ny += w * n[1]
        nz += w * n[2]
        h = twin(m, preceding(h))
        if h == start:
            break
    mean = (nx, ny, nz)
    least = LEAST_TILT * np.sqrt(dot(mean, mean))
    if least == 0.0:
        return False
    o = point(m, v)
    across = cross(mean, subtract(point(m, origin(m, following(start))), o))
    right = False
    while True:
        if dot(normal(m, h // 3), mean) < least:
            return False
        h = twin(m, preceding(h))
        if h == start:
            return True
        side = dot(across, subtract(point(m, origin(m, following(h))), o))
        if right and side >= 0.0:
            return False
        right = side < 0.0


@inner
def triangle(m, f):
    """Return the corners of face `f`."""
    a, b, c = corners(m, f)
    return point(m, a), point(m, b), point(m, c)


@inner
def faces_touch(m, f, g):
    """Return whether two faces of the mesh have more in common than they share."""
    return touching(
        corners(m, f), triangle(m, f), normal(m, f), corners(m, g), triangle(m, g), normal(m, g), m.bound[CLEARANCE]
    )


@inlined
def _beyond_plane(points, n, o, a, b, c, gap):
    """Return whether vertices a, b and c lie on one side of the plane with normal `n` through vertex `o`."""
    level = n[0] * points[o, 0] + n[1] * points[o, 1] + n[2] * points[o, 2]
    s = n[0] * points[a, 0] + n[1] * points[a, 1] + n[2] * points[a, 2] - level
    t = n[0] * points[b, 0] + n[1] * points[b, 1] + n[2] * points[b, 2] - level
    u = n[0] * points[c, 0] + n[1] * points[c, 1] + n[2] * points[c, 2] - level
    return (s > gap and t > gap and u > gap) or (s < -gap and t < -gap and u < -gap)


@inlined
def touch_apart(m, f, g, own, gap):
    """Return whether two faces that share no vertex touch; false where they share one. `own` is the normal of `f`."""
    i0, i1, i2 = corners(m, f)
    j0, j1, j2 = corners(m, g)
    if i0 in (j0, j1, j2) or i1 in (j0, j1, j2) or i2 in (j0, j1, j2):
        return False
    if _beyond_plane(m.points, own, i0, j0, j1, j2, gap):
        return False
    return not _beyond_plane(m.points, normal(m, g), j0, i0, i1, i2, gap) and faces_touch(m, f, g)


@inner
def contact(m, cells, f, slack, batch, limit, found):
    """Return a face that touches face `f` and shares no vertex with it, or −1.

    Only those are tested the product of whose normals is below `limit`. Faces below `f` with the stamp `batch`, if that
    is positive, are left out: they are tested against `f`.
    """
    c = (np.float64(m.facets[f, 0]), np.float64(m.facets[f, 1]), np.float64(m.facets[f, 2]))
    own = normal(m, f)
    gap = m.bound[CLEARANCE]
    n = gather(m.layout, m.bound, cells, c, m.facets[f, RADIUS] + slack + gap, 1.0, own, limit, found)
    for i in range(n):
        g = np.int64(found[i])
        if g == f or (batch > 0 and g < f and m.links[g, STAMP] == batch):
            continue
        if touch_apart(m, f, g, own, gap):
            return g
    return np.int64(-1)


@inner
def _put_back(m, cells, f, batch, state, old, queue, size):
    """Return the moved vertices of face `f` to where they were, and append them to `queue`; return its new length."""
    for k in range(3):
        v = origin(m, 3 * f + k)
        if state[v] == batch:
            state[v] = -batch
            for axis in range(3):
                m.points[v, axis] = old[v, axis]
            start = m.vertices[v, OUT]
            h = start
            while True:
                measure_face(m, h // 3)
                note_face(m, cells, h // 3)
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
    area = m.former[f, 3]
    turn = dot((m.former[f, 0], m.former[f, 1], m.former[f, 2]), normal(m, f))
    return (area > 0.0 and turn < LEAST_TURN) or (g[f, AREA] < area and compactness(m, f) < LEAST_SHAPE)


@inner
def _mend_star(m, cells, v, batch, state, old, queue, size):
    """Put back the movers of faces around `v` that touch each other; return the new length of the queue."""
    if is_graph(m, v):
        return size
    start = np.int64(m.vertices[v, OUT])
    h = start
    while True:
        k = twin(m, preceding(h))
        while k != start:
            if faces_touch(m, h // 3, k // 3):
                size = _put_back(m, cells, h // 3, batch, state, old, queue, size)
                size = _put_back(m, cells, k // 3, batch, state, old, queue, size)
            k = twin(m, preceding(k))
        h = twin(m, preceding(h))
        if h == start:
            return size


@inner
def displace(m, moves, v, target, batch):
    """Move vertex `v` to row `v` of `target`, rounded to float32 values, and note where it was when `batch` began."""
    if moves.state[v] != batch:
        moves.state[v] = batch
        for axis in range(3):
            moves.old[v, axis] = m.points[v, axis]
        moves.movers[moves.counts[0]] = v
        moves.counts[0] += 1
    for axis in range(3):
        m.points[v, axis] = np.float64(np.float32(target[v, axis]))


@inner
def _measure(m, cells, moves, batch, sorted_in, first, end):
    """Do what `measure_moved` says."""
    largest = 0.0
    for f in range(first, end):
        if m.half_edges[3 * f, ORIGIN] < 0:
            continue
        i, j, k = corners(m, f)
        if moves.state[i] != batch and moves.state[j] != batch and moves.state[k] != batch:
            continue
        if m.links[f, STAMP] != batch:
            m.links[f, STAMP] = batch
            for axis in range(4):
                m.former[f, axis] = m.facets[f, NORMAL + axis]
        measure_face(m, f)
        largest = max(largest, np.float64(m.facets[f, RADIUS]))
        if sorted_in:
            note_face(m, cells, f)
    return largest


@inner
def _slack(m, moves):
    """Return how far in mm the vertex has moved that moved farthest since the batch began."""
    slack = 0.0
    for i in range(moves.counts[0]):
        v = moves.movers[i]
        way = 0.0
        for axis in range(3):
            way += (m.points[v, axis] - moves.old[v, axis]) ** 2
        slack = max(slack, way)
    return np.sqrt(slack)


@inner
def _ready(m, cells, moves, drift):
    """Do what `make_ready` says."""
    if drift > SORTED * np.float64(m.bound[LARGEST_RADIUS]):
        sort_faces(m, cells)
        drift = 0.0
    return drift, _slack(m, moves) + drift


@inner
def _suspect(m, cells, moves, batch, clear, drift, first, end, found):
    """Do what `find_suspects` says."""
    limit = OPPOSED if clear.shape[0] > 0 else ANY
    wrong = first
    stars = 3 * first
    for f in range(first, end):
        if m.links[f, STAMP] != batch:
            continue
        g = np.int64(f)
        if not _spoiled(m, f):
            g = np.int64(-1) if _is_clear(m, f, clear) else contact(m, cells, f, drift, batch, limit, found)
        if g >= 0:
            moves.wrong[wrong, 0] = f
            moves.wrong[wrong, 1] = g
            wrong += 1
        for k in range(3):
            # Each changed star is met from the half-edges that leave its centre; one of them is the one noted for it.
            h = 3 * f + k
            v = origin(m, h)
            if clear.shape[0] > 0 and clear[v] == 1:
                continue
            start = np.int64(m.vertices[v, OUT])
            if h != start and (m.links[start // 3, STAMP] == batch or _first_stamped(m, start, batch) != h):
                continue
            if not is_graph(m, v):
                moves.stars[stars] = v
                stars += 1
    return wrong, stars


@inner
def _put_suspects_back(m, cells, moves, batch, first, end, size):
    """Put back the movers of the pairs of faces from `first` to `end`; return the new length of the queue."""
    for i in range(first, end):
        for k in range(2):
            f = np.int64(moves.wrong[i, k])
            size = _put_back(m, cells, f, batch, moves.state, moves.old, moves.queue, size)
    return size


@inner
def _mend_suspects(m, cells, moves, batch, first, end, size):
    """Mend the stars from `first` to `end`; return the new length of the queue."""
    for i in range(first, end):
        v = np.int64(moves.stars[i])
        size = _mend_star(m, cells, v, batch, moves.state, moves.old, moves.queue, size)
    return size


@inner
def _settle(m, cells, moves, batch, limit, slack, middle, wrong, stars):
    """Do what `put_back` says."""
    state, old, queue, found = moves.state, moves.old, moves.queue, moves.found[0]
    # Nothing was put back before: those faces would be far from where they were sorted, and searches wide.
    size = _put_suspects_back(m, cells, moves, batch, 0, wrong[0], 0)
    size = _put_suspects_back(m, cells, moves, batch, middle, wrong[1], size)
    size = _mend_suspects(m, cells, moves, batch, 0, stars[0], size)
    size = _mend_suspects(m, cells, moves, batch, 3 * middle, stars[1], size)
    done = 0
    while done < size:
        v = np.int64(queue[done])
        done += 1
        first = np.int64(m.vertices[v, OUT])
        h = first
        while True:
            f = h // 3
            if _spoiled(m, f):
                size = _put_back(m, cells, f, batch, state, old, queue, size)
            else:
                g = contact(m, cells, f, slack, 0, limit, found)
                if g >= 0:
                    size = _put_back(m, cells, f, batch, state, old, queue, size)
                    size = _put_back(m, cells, g, batch, state, old, queue, size)
            size = _mend_star(m, cells, origin(m, following(h)), batch, state, old, queue, size)
            h = twin(m, preceding(h))
            if h == first:
                break
        size = _mend_star(m, cells, v, batch, state, old, queue, size)
    return size


@kernel
def measure_moved(m, cells, moves, batch, first, end):
    """Measure the faces whose vertices have moved since `batch` began, and note how they looked before that.

    What is noted of them in `cells` is brought up to date. Parts can be done at once.

    Parameters
    ----------
    m, cells, moves, batch
        See `shapery_segmentation.mesh.contacts.measure`.
    first, end : int
        Slots of faces that are looked at.

    Returns
    -------
    float
        The largest radius among them. ``m.bound`` may not have it yet where parts are done at once.
    """
    return _measure(m, cells, moves, batch, True, first, end)


@kernel
def make_ready(m, cells, moves, drift):
    """Sort the faces anew if they are far from where they were sorted.

    Parameters
    ----------
    m : MeshArrays
    cells : Cells
        The faces, brought up to date with every move.
    moves : Moves
    drift : float
        How far in mm faces may be from where they were sorted.

    Returns
    -------
    drift, slack : float
        The same now, and how far they may be from there once moves were put back.
    """
    return _ready(m, cells, moves, drift)


@kernel
def find_suspects(m, cells, moves, batch, clear, drift, first, end, found):
    """Find what touches of the faces that changed, and the stars that may be folded, without changing anything.

    Parameters
    ----------
    m, cells, moves, batch, clear, drift
        See `shapery_segmentation.mesh.contacts.verify`.
    first, end : int
        Slots of faces that are looked at.
    found : (F,) int32
        Room.

    Returns
    -------
    wrong, stars : int
        Ends of what was found in ``moves.wrong`` and ``moves.stars``, from `first` and 3·`first` on.
    """
    return _suspect(m, cells, moves, batch, clear, drift, first, end, found)


@kernel
def put_back(m, cells, moves, batch, clear, slack, middle, wrong, stars):
    """Put back what `find_suspects` found, and what then touches, until nothing does.

    Parameters
    ----------
    m, cells, moves, batch, clear
        See `shapery_segmentation.mesh.contacts.verify`.
    slack : float
        From `make_ready`.
    middle : int
        Where the second part began.
    wrong, stars : (int, int)
        What `find_suspects` returned for both parts.

    Returns
    -------
    int
        How many vertices were put back; ``moves.queue`` names them.
    """
    limit = OPPOSED if clear.shape[0] > 0 else ANY
    return _settle(m, cells, moves, batch, limit, slack, middle, wrong, stars)


@kernel
def move_vertices(m, cells, movers, target, moves, batch):
    """Move vertices to their targets, except where a face would turn over, degenerate or touch another.

    Parameters
    ----------
    m : MeshArrays
    cells : Cells
        Room for the faces, which are sorted anew; those that are put back stay in the cells that they had come to.
    movers : (n,) int32
        The vertices to move, each once.
    target : (V, 3) float64
        Where to; rounded to float32 values.
    moves : Moves
        Of which nothing is left to be verified.
    batch : int
        A positive stamp that no face and no vertex carries yet.

    Returns
    -------
    int
        Movers that were put back; ``moves.state`` is `batch` for those that moved.
    """
    moves.counts[:] = 0
    for i in range(movers.shape[0]):
        displace(m, moves, movers[i], target, batch)
    top = m.layout[FACE_TOP]
    _measure(m, cells, moves, batch, False, 0, top)
    drift, slack = _ready(m, cells, moves, np.inf)
    wrong, stars = _suspect(m, cells, moves, batch, moves.none, drift, 0, top, moves.found[0])
    return _settle(m, cells, moves, batch, ANY, slack, top, (wrong, top), (stars, 3 * top))


@inner
def _is_clear(m, f, clear):
    """Return whether all vertices of face `f` are clear."""
    if clear.shape[0] == 0:
        return False
    i, j, k = corners(m, f)
    return clear[i] == 1 and clear[j] == 1 and clear[k] == 1


@inner
def _first_stamped(m, first, batch):
    """Return the first half-edge, around the vertex at which `first` starts, of a face with the stamp."""
    h = first
    while m.links[h // 3, STAMP] != batch:
        h = twin(m, preceding(h))
        if h == first:
            break
    return h

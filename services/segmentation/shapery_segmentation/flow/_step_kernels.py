"""One step of the normal flow: speeds at the vertices, obstacles ahead, oscillation and aging, sleep."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.flow._speed_kernels import GRADIENT, THRESHOLD, sample, slope_at, speed_at
from shapery_segmentation.flow._state_kernels import (
    AGE,
    AGED,
    ASLEEP,
    AWAKE,
    BLOCKED,
    COLLAPSE,
    FLIPS,
    FREE,
    FROZEN,
    GAIN,
    LAST,
    MEET,
    MODE,
    NET,
    OSCILLATING,
    REFINE,
    RETURNS,
    SEEN,
    SIGN,
    STEP,
    WISH,
    wake,
)
from shapery_segmentation.mesh._cells_kernels import gather
from shapery_segmentation.mesh._contact_kernels import dot, subtract
from shapery_segmentation.mesh._grid_kernels import corners, normal, point
from shapery_segmentation.mesh._motion_kernels import displace
from shapery_segmentation.mesh._operation_kernels import following, origin, preceding, twin
from shapery_segmentation.mesh.arrays import AREA, OUT, SCALE, VERTEX_TOP
from shapery_segmentation.mesh.compiled import inner, kernel

# Sides of an obstacle.
NOWHERE = 0
AHEAD = 1
BEHIND = 2

STEADY = 4
"""Steps without a change of direction after which the changes before no longer count as consecutive."""

LARGEST_STEP = 0.5
"""Edge lengths that a vertex moves along its normal at the most."""

LEAST_FALL = 0.3
"""Least share of a move that is taken to be gone once it is made: near the border the step is Newton's, but not more
than the inverse of this times the plain one."""

FARTHER = 0.6
"""Edge lengths beyond the gap that fronts keep in which obstacles are looked for: where there are none, none is looked
for until the vertex has moved half of that, and whoever comes from beyond looks for itself."""

WARY = 0.15
"""What a product of normals may change until then."""

SAMPLES = 4
"""Points at which the speed is looked at on the way back to the previous position, when a vertex is stopped."""


@inner
def surround(m, v):
    """Return the unit normal at `v` (its faces weighted by area), the way to the mean of its neighbours, and 1 or 0."""
    nx = ny = nz = 0.0
    ux = uy = uz = 0.0
    degree = 0
    first = np.int64(m.vertices[v, OUT])
    h = first
    while True:
        f = h // 3
        w = np.float64(m.facets[f, AREA])
        a = normal(m, f)
        nx += w * a[0]
        ny += w * a[1]
        nz += w * a[2]
        q = point(m, origin(m, following(h)))
        ux += q[0]
        uy += q[1]
        uz += q[2]
        degree += 1
        h = twin(m, preceding(h))
        if h == first:
            break
    size = np.sqrt(nx * nx + ny * ny + nz * nz)
    inverse = 1.0 / size if size > 0.0 else 0.0
    here = point(m, v)
    mean = (ux / degree, uy / degree, uz / degree)
    return (nx * inverse, ny * inverse, nz * inverse), subtract(mean, here), size > 0.0


@inner
def _obstacle(m, cells, v, p, n, here, front, rear, farther, opposed, rear_opposed, found):
    """Return where another part of the surface is near the point `p` to which `v` would move, and its face.

    The third that is returned tells whether the faces around `v` can touch nothing soon; the fourth how far away the
    nearest centroid of a face is that could be an obstacle, `farther` beyond the wider of the gaps at the most.

    A face counts if it is no face of `v`, the way brings `v` nearer to its centroid, and that lies ahead of `p` within
    `front`, the product of the normals below `opposed`, or behind it within `rear`, the product below `rear_opposed`.
    Nothing can be touched soon where within the wider of the gaps and a third of `farther` beyond that nothing is
    turned nearly as much.
    """
    limit = max(opposed, rear_opposed)
    reach = max(front, rear) + farther
    count = gather(m.layout, m.bound, cells, p, reach, 0.0, n, limit + WARY, found)
    clear = True
    nearest = reach * reach
    for i in range(count):
        g = np.int64(found[i])
        turn = dot(n, normal(m, g))
        own = v in corners(m, g)
        c = (np.float64(m.facets[g, 0]), np.float64(m.facets[g, 1]), np.float64(m.facets[g, 2]))
        d, e = subtract(c, p), subtract(c, here)
        if not own:
            nearest = min(nearest, dot(d, d))
        if turn >= limit:
            continue
        clear = clear and not own
        ahead = dot(d, n) >= 0.0
        if turn >= (opposed if ahead else rear_opposed):
            continue
        gap = front if ahead else rear
        if dot(d, d) < gap * gap and dot(d, d) < dot(e, e) and not own:
            return (AHEAD if ahead else BEHIND), g, False, 0.0
    nearest = np.sqrt(nearest)
    return NOWHERE, np.int64(-1), clear and nearest >= reach - 0.67 * farther, nearest


@inner
def _wish(field, inverse, allowed, inverse_allowed, dials, side, here, c, n):
    """Return what would help a vertex at `here` that a face around `c` blocks.

    What matters is what lies half-way. Ahead it is a gap: if nothing of the object is there, it is a small feature that
    finer triangles can follow; else two fronts meet inside the object, and rest, or merge
    where that is allowed. Behind it is a part of the surface's inside: if that is object, it is thin and wants finer
    triangles; else it should go, and does by collapsing.
    """
    middle = (0.5 * (here[0] + c[0]), 0.5 * (here[1] + c[1]), 0.5 * (here[2] + c[2]))
    there = speed_at(field, inverse, allowed, inverse_allowed, dials, middle, n)
    if side == AHEAD:
        return REFINE if there < 0.0 else MEET
    return REFINE if there > 0.0 else COLLAPSE


@inner
def _place_of_rest(state, v, here, speed, field, inverse, allowed, inverse_allowed, dials, n):
    """Return where between the previous position of `v` and this one the speed is least (Fig. 3.5)."""
    best = abs(speed)
    place = here
    for k in range(1, SAMPLES + 1):
        t = k / SAMPLES
        q = (
            here[0] + t * (state[v, LAST] - here[0]),
            here[1] + t * (state[v, LAST + 1] - here[1]),
            here[2] + t * (state[v, LAST + 2] - here[2]),
        )
        there = abs(speed_at(field, inverse, allowed, inverse_allowed, dials, q, n))
        if there < best:
            best = there
            place = q
    return place


@kernel
def propose(m, cells, state, counter, clear, field, inverse, allowed, inverse_allowed, dials, first, end, found,
            target, movers):  # fmt: skip
    """Compute where the awake vertices would go, and freeze those that something has been in the way of for long.

    Nothing of the mesh changes, and of the other arrays only the rows of these vertices: parts can be done at once.

    Parameters
    ----------
    m, cells
        Mesh and its faces sorted by cell.
    state, counter : (V, 10) float64, (V, 7) int32
    clear : (V,) int8
        1 for vertices that nothing can be in the way of soon.
    field, allowed : (I, J, K) float32, uint8
        `allowed` may be empty: everything is.
    inverse, inverse_allowed : (3, 4) float64
        From RAS mm to index.
    dials : Dials
    first, end : int
        Slots of vertices that are looked at.
    found : (F,) int32
        Room.
    target : (V, 3) float64
        Receives where they would go.
    movers : (V,) int32
        Receives which would go, from `first` on.

    Returns
    -------
    int
        How many would go.
    """
    count = 0
    for v in range(first, end):
        if m.vertices[v, OUT] < 0 or counter[v, MODE] != AWAKE:
            continue
        n, u, known = surround(m, v)
        if not known:
            continue
        here = point(m, v)
        local = dials.length * m.points[v, SCALE]
        speed = speed_at(field, inverse, allowed, inverse_allowed, dials, here, n)

        sign = 1 if speed > 0.0 else -1
        if counter[v, SIGN] != 0 and sign * counter[v, SIGN] < 0:
            counter[v, FLIPS] += 1
            counter[v, SIGN] = sign
            state[v, GAIN] *= dials.damping
            if counter[v, FLIPS] >= dials.aging:
                counter[v, MODE] = AGED
                p = _place_of_rest(state, v, here, speed, field, inverse, allowed, inverse_allowed, dials, n)
                state[v, STEP] = 0.0
                for axis in range(3):
                    target[v, axis] = p[axis]
                movers[first + count] = v
                count += 1
                continue
        else:
            # The magnitude counts steps in one direction.
            counter[v, SIGN] += sign
            state[v, GAIN] = min(1.0, 1.1 * state[v, GAIN])
            if abs(counter[v, SIGN]) > STEADY:
                counter[v, FLIPS] = 0

        along = dot(u, n)
        forward = dials.step * local * state[v, GAIN] * speed
        bend = dials.bend
        if dials.model == GRADIENT:
            # In Eq. 3.1 the curvature is multiplied by g.
            value, _ = sample(field, inverse, here)
            bend *= value
        forward += bend * along
        if dials.model == THRESHOLD:
            # Near the border the way to it is known: what is left of the move, over how fast it falls on the way.
            near = 1.0 - speed * speed
            falls = bend - dials.step * local * near * slope_at(field, inverse, here, n)
            forward *= 1.0 + near * (1.0 / max(falls, LEAST_FALL) - 1.0)
        forward = max(-LARGEST_STEP * local, min(LARGEST_STEP * local, forward))
        p = (
            here[0] + forward * n[0] + dials.slide * (u[0] - along * n[0]),
            here[1] + forward * n[1] + dials.slide * (u[1] - along * n[1]),
            here[2] + forward * n[2] + dials.slide * (u[2] - along * n[2]),
        )
        counter[v, AGE] += 1
        farther = FARTHER * local
        side, g = NOWHERE, np.int64(-1)
        seen = subtract(here, (state[v, SEEN], state[v, SEEN + 1], state[v, SEEN + 2]))
        if dot(seen, seen) >= state[v, FREE] * state[v, FREE]:
            side, g, free, nearest = _obstacle(
                m, cells, v, p, n, here, dials.front * local, dials.rear * local, farther,
                dials.opposed, dials.rear_opposed, found,
            )  # fmt: skip
            clear[v] = free
            # Half the way is left to whoever comes from there.
            state[v, FREE] = 0.5 * max(nearest - max(dials.front, dials.rear) * local, 0.0)
            for axis in range(3):
                state[v, SEEN + axis] = here[axis]
        if side != NOWHERE:
            counter[v, BLOCKED] += 1
            if counter[v, BLOCKED] >= dials.patience:
                c = (np.float64(m.facets[g, 0]), np.float64(m.facets[g, 1]), np.float64(m.facets[g, 2]))
                counter[v, MODE] = FROZEN
                counter[v, WISH] = _wish(field, inverse, allowed, inverse_allowed, dials, side, here, c, n)
            continue
        state[v, STEP] = forward
        for axis in range(3):
            state[v, LAST + axis] = here[axis]
            target[v, axis] = p[axis]
        movers[first + count] = v
        count += 1
    return count


@kernel
def advance(m, moves, batch, state, counter, target, movers, middle, counts):
    """Move every vertex that `propose` says, without a test of what moved (see `shapery_segmentation.mesh.contacts`).

    Parameters
    ----------
    m : MeshArrays
        Its faces have to be measured then.
    moves, batch
        As `_motion_kernels.displace` takes them.
    state, counter, target, movers
        As `propose` takes and leaves them.
    middle : int
        Where the second part of `movers` begins.
    counts : (int, int)
        How many vertices `propose` named in both parts.

    Returns
    -------
    float
        How far in mm the vertex that moved farthest has moved.
    """
    farthest = 0.0
    for part in range(2):
        first = 0 if part == 0 else middle
        for i in range(first, first + counts[part]):
            v = movers[i]
            here = point(m, v)
            displace(m, moves, v, target, batch)
            way = subtract(point(m, v), here)
            farthest = max(farthest, dot(way, way))
            state[v, NET] += state[v, STEP]
            counter[v, BLOCKED] = 0
    return np.sqrt(farthest)


@kernel
def settle(m, state, counter, dials):
    """Let vertices sleep that got nowhere in a window of steps, and wake the neighbours of those that did.

    Parameters
    ----------
    m, state, counter, dials
        As `propose` takes and leaves them.

    Returns
    -------
    awake, oscillating : int
        Vertices awake now, and those among them that change their direction again and again.
    """
    awake = 0
    oscillating = 0
    for v in range(m.layout[VERTEX_TOP]):
        if m.vertices[v, OUT] < 0 or counter[v, MODE] != AWAKE:
            continue
        if counter[v, AGE] >= dials.window:
            net = abs(state[v, NET])
            local = dials.length * m.points[v, SCALE]
            if net > dials.stir * local:
                first = np.int64(m.vertices[v, OUT])
                h = first
                while True:
                    wake(state, counter, origin(m, following(h)))
                    h = twin(m, preceding(h))
                    if h == first:
                        break
            counter[v, AGE] = 0
            state[v, NET] = 0.0
            # One that is kept from moving is not at rest: it will be frozen, and its wish heard.
            if net < dials.rest * local and counter[v, BLOCKED] == 0 and counter[v, RETURNS] == 0:
                counter[v, MODE] = ASLEEP
                continue
        awake += 1
        oscillating += counter[v, FLIPS] >= OSCILLATING
    return awake, oscillating


@kernel
def take_back(moves, batch, size, state, counter, clear, dials):
    """Note what a verification told: vertices that were put back try half the way next time, and freeze in the end.

    Parameters
    ----------
    size : int
        How many were put back.
    """
    for i in range(moves.counts[0]):
        v = moves.movers[i]
        if moves.state[v] == batch:
            counter[v, RETURNS] = 0
    for i in range(size):
        v = moves.queue[i]
        clear[v] = 0
        state[v, FREE] = 0.0
        counter[v, RETURNS] += 1
        counter[v, AGE] = 0
        state[v, GAIN] *= 0.5
        state[v, NET] = 0.0
        if counter[v, MODE] == ASLEEP:
            counter[v, MODE] = AWAKE
        if counter[v, MODE] == AWAKE and counter[v, RETURNS] >= dials.patience:
            counter[v, MODE] = FROZEN

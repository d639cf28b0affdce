"""One step of the normal flow: speeds at the vertices, obstacles ahead, oscillation and aging, sleep."""

# mypy: allow-untyped-defs, allow-untyped-calls

from typing import NamedTuple

import numpy as np

from shapery_segmentation.mesh._cells_kernels import gather
from shapery_segmentation.mesh._contact_kernels import dot, subtract
from shapery_segmentation.mesh._grid_kernels import corners, normal, point
from shapery_segmentation.mesh._operation_kernels import compactness, following, origin, preceding, twin
from shapery_segmentation.mesh.arrays import AREA, CREATED, OUT, RELINKED, SCALE, TOUCHED, UNTOUCHED, VERTEX_TOP
from shapery_segmentation.mesh.compiled import inner, kernel

# Columns of the vertices' state (float64).
NET = 0  # way along the normal since the window began, mm
GAIN = 1  # share of the full step; falls with every change of direction
STEP = 2  # way along the normal of the last step, mm
LAST = 3  # previous position (3)
STATE_COLUMNS = 6

# Columns of the vertices' counters (int32).
MODE = 0
FLIPS = 1  # changes of direction in a row
SIGN = 2  # direction of the last step
AGE = 3  # steps since the window began
BLOCKED = 4  # steps in a row that an obstacle forbade
WISH = 5  # what would help a blocked vertex
TRIES = 6  # geometric interpolations that have not brought it to rest
COUNTER_COLUMNS = 7

# Values of MODE.
AWAKE = 0
ASLEEP = 1
AGED = 2
FROZEN = 3

# Values of WISH.
NONE = 0
REFINE = 1
COLLAPSE = 2
MEET = 3

# Speed models.
THRESHOLD = 0
GRADIENT = 1

# Sides of an obstacle.
NOWHERE = 0
AHEAD = 1
BEHIND = 2

STEADY = 4
"""Steps without a change of direction after which the changes before no longer count as consecutive."""

OSCILLATING = 2
"""Changes of direction in a row from which a vertex counts as oscillating."""

LARGEST_STEP = 0.5
"""Edge lengths that a vertex moves along its normal at the most."""

SAMPLES = 4
"""Points at which the speed is looked at on the way back to the previous position, when a vertex is stopped."""


class Dials(NamedTuple):
    """Numbers that a step depends on; see `shapery_segmentation.flow.params` for what they mean."""

    model: int
    threshold: float
    balloon: float
    length: float
    step: float
    bend: float
    slide: float
    front: float
    rear: float
    opposed: float
    rear_opposed: float
    damping: float
    aging: int
    patience: int
    window: int
    rest: float
    stir: float
    least_scale: float


@inner
def sample(field, inverse, p):
    """Return the trilinear interpolation of `field` at the point `p` (RAS mm), and whether `p` lies in the grid."""
    x = inverse[0, 0] * p[0] + inverse[0, 1] * p[1] + inverse[0, 2] * p[2] + inverse[0, 3]
    y = inverse[1, 0] * p[0] + inverse[1, 1] * p[1] + inverse[1, 2] * p[2] + inverse[1, 3]
    z = inverse[2, 0] * p[0] + inverse[2, 1] * p[1] + inverse[2, 2] * p[2] + inverse[2, 3]
    ni, nj, nk = field.shape
    if not (0.0 <= x <= ni - 1 and 0.0 <= y <= nj - 1 and 0.0 <= z <= nk - 1):
        return 0.0, False
    # The last voxel is the far end of the last cell; along an axis of one voxel both ends are the same.
    i, j, k = min(np.int64(x), max(ni - 2, 0)), min(np.int64(y), max(nj - 2, 0)), min(np.int64(z), max(nk - 2, 0))
    i1, j1, k1 = min(i + 1, ni - 1), min(j + 1, nj - 1), min(k + 1, nk - 1)
    u, v, w = x - i, y - j, z - k
    a = (field[i, j, k] * (1.0 - w) + field[i, j, k1] * w) * (1.0 - v)
    a += (field[i, j1, k] * (1.0 - w) + field[i, j1, k1] * w) * v
    b = (field[i1, j, k] * (1.0 - w) + field[i1, j, k1] * w) * (1.0 - v)
    b += (field[i1, j1, k] * (1.0 - w) + field[i1, j1, k1] * w) * v
    return a * (1.0 - u) + b * u, True


@inner
def speed_at(field, inverse, allowed, inverse_allowed, dials, p, n):
    """Return the speed along the normal `n` at the point `p`, in [−1, 1], without the curvature.

    Outside the grid, and where nothing is allowed, it is −1; across the border of what is allowed it falls linearly.
    """
    value, inside = sample(field, inverse, p)
    if not inside:
        return -1.0
    gate = 1.0
    if allowed.shape[0] > 0:
        gate, inside = sample(allowed, inverse_allowed, p)
    if dials.model == THRESHOLD:
        drive = np.tanh(value - dials.threshold)
    else:
        # g·v − ∇g·n, the derivative taken over one edge length, in which the step is measured, too.
        half = 0.5 * dials.length
        ahead, known_ahead = sample(field, inverse, (p[0] + half * n[0], p[1] + half * n[1], p[2] + half * n[2]))
        back, known_back = sample(field, inverse, (p[0] - half * n[0], p[1] - half * n[1], p[2] - half * n[2]))
        drive = dials.balloon * value
        if known_ahead and known_back:
            drive -= ahead - back
        drive = max(-1.0, min(1.0, drive))
    return gate * drive - (1.0 - gate)


@inner
def _obstacle(m, start, spheres, names, v, p, n, here, front, rear, opposed, rear_opposed, found):
    """Return whether another part of the surface is near the point `p` to which `v` would move, and which face.

    A face counts if it is no face of `v`, the way brings `v` nearer to its centroid, and that lies ahead of `p` within
    `front`, the product of the normals below `opposed`, or behind it within `rear`, the product below `rear_opposed`.
    """
    count = gather(m.layout, m.bound, start, spheres, names, p, max(front, rear), 0.0, found)
    for i in range(count):
        g = np.int64(found[i])
        turn = dot(n, normal(m, g))
        if turn >= max(opposed, rear_opposed):
            continue
        c = (np.float64(m.facets[g, 0]), np.float64(m.facets[g, 1]), np.float64(m.facets[g, 2]))
        d, e = subtract(c, p), subtract(c, here)
        ahead = dot(d, n) >= 0.0
        if turn >= (opposed if ahead else rear_opposed):
            continue
        limit = front if ahead else rear
        if dot(d, d) < limit * limit and dot(d, d) < dot(e, e) and v not in corners(m, g):
            return (AHEAD if ahead else BEHIND), g
    return NOWHERE, np.int64(-1)


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
def _wake(state, counter, v):
    """Set a vertex at rest going again, unless it was stopped for its age."""
    if counter[v, MODE] == ASLEEP or counter[v, MODE] == FROZEN:
        counter[v, MODE] = AWAKE
        counter[v, AGE] = 0
        counter[v, BLOCKED] = 0
        state[v, NET] = 0.0


@kernel
def wake_all(m, state, counter):
    """Wake every vertex, those stopped for their age too: what they rested on has changed."""
    for v in range(m.layout[VERTEX_TOP]):
        if m.vertices[v, OUT] >= 0:
            _wake(state, counter, v)
            counter[v, MODE] = AWAKE
            counter[v, FLIPS] = 0
            counter[v, SIGN] = 0
            state[v, GAIN] = 1.0


@kernel
def adopt_touched(m, state, counter):
    """Begin anew at vertices that an operation created, wake those whose neighbours it changed; forget its marks."""
    for v in range(m.layout[VERTEX_TOP]):
        mark = m.vertices[v, TOUCHED]
        if mark == UNTOUCHED:
            continue
        m.vertices[v, TOUCHED] = UNTOUCHED
        if m.vertices[v, OUT] < 0:
            continue
        if mark == CREATED:
            for column in range(STATE_COLUMNS):
                state[v, column] = 0.0
            for column in range(COUNTER_COLUMNS):
                counter[v, column] = 0
            state[v, GAIN] = 1.0
        elif mark == RELINKED:
            _wake(state, counter, v)


@inner
def _surround(m, v):
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
def propose(
    m, start, spheres, names, state, counter, field, inverse, allowed, inverse_allowed, dials, target, movers
):  # fmt: skip
    """Compute where the awake vertices would go, and freeze those that something has been in the way of for long.

    Parameters
    ----------
    m, start, spheres, names
        Mesh and its faces sorted by cell.
    state, counter : (V, 6) float64, (V, 7) int32
    field, allowed : (I, J, K) float32, uint8
        `allowed` may be empty: everything is.
    inverse, inverse_allowed : (3, 4) float64
        From RAS mm to index.
    dials : Dials
    target : (V, 3) float64
        Receives where movers go.
    movers : (V,) int32
        Receives who they are.

    Returns
    -------
    int
        How many there are.
    """
    count = 0
    found = np.empty(m.links.shape[0], dtype=np.int32)
    for v in range(m.layout[VERTEX_TOP]):
        if m.vertices[v, OUT] < 0 or counter[v, MODE] != AWAKE:
            continue
        n, u, known = _surround(m, v)
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
                movers[count] = v
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
        forward = max(-LARGEST_STEP * local, min(LARGEST_STEP * local, forward + bend * along))
        p = (
            here[0] + forward * n[0] + dials.slide * (u[0] - along * n[0]),
            here[1] + forward * n[1] + dials.slide * (u[1] - along * n[1]),
            here[2] + forward * n[2] + dials.slide * (u[2] - along * n[2]),
        )
        counter[v, AGE] += 1
        side, g = _obstacle(
            m,
            start,
            spheres,
            names,
            v,
            p,
            n,
            here,
            dials.front * local,
            dials.rear * local,
            dials.opposed,
            dials.rear_opposed,
            found,
        )
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
        movers[count] = v
        count += 1
    return count


@kernel
def settle(m, state, counter, moved, batch, movers, dials):
    """Let vertices sleep that got nowhere in a window of steps, and wake the neighbours of those that did.

    Returns
    -------
    awake, oscillating : int
        Vertices awake now, and those among them that change their direction again and again.
    """
    for i in range(movers.shape[0]):
        v = movers[i]
        if moved[v] == batch:
            state[v, NET] += state[v, STEP]
            counter[v, BLOCKED] = 0
        else:
            # Put back because something would have touched: half the way next time.
            state[v, GAIN] *= 0.5
            counter[v, BLOCKED] += 1
            if counter[v, BLOCKED] >= dials.patience and counter[v, MODE] == AWAKE:
                counter[v, MODE] = FROZEN
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
                    _wake(state, counter, origin(m, following(h)))
                    h = twin(m, preceding(h))
                    if h == first:
                        break
            counter[v, AGE] = 0
            state[v, NET] = 0.0
            # One that is kept from moving is not at rest: it will be frozen, and its wish heard.
            if net < dials.rest * local and counter[v, BLOCKED] == 0:
                counter[v, MODE] = ASLEEP
                continue
        awake += 1
        oscillating += counter[v, FLIPS] >= OSCILLATING
    return awake, oscillating


@kernel
def steepest_points(m, field, inverse, names, half, reach, target, strength):
    """Find where along the normals of vertices the field changes most.

    Parameters
    ----------
    m : MeshArrays
    field, inverse
        As in `propose`.
    names : (n,) int32
        The vertices.
    half : float
        Half the way in mm over which the change is taken.
    reach : float
        How far in mm to look to either side; 0: at the vertex itself only.
    target : (V, 3) float64
        Receives the places.
    strength : (n,) float64
        Receives the changes there; 0 where the field is not known.
    """
    steps = SAMPLES if reach > 0.0 else 0
    for i in range(names.shape[0]):
        v = np.int64(names[i])
        n, _, _ = _surround(m, v)
        here = point(m, v)
        strength[i] = 0.0
        for axis in range(3):
            target[v, axis] = here[axis]
        # From the vertex outwards to both sides, so that of equal ones the nearest is taken.
        for step in range(2 * steps + 1):
            t = reach * ((step + 1) // 2) / max(steps, 1) * (1.0 if step % 2 else -1.0)
            a, known_a = sample(
                field,
                inverse,
                (here[0] + (t + half) * n[0], here[1] + (t + half) * n[1], here[2] + (t + half) * n[2]),
            )
            b, known_b = sample(
                field,
                inverse,
                (here[0] + (t - half) * n[0], here[1] + (t - half) * n[1], here[2] + (t - half) * n[2]),
            )
            if known_a and known_b and abs(a - b) > strength[i]:
                strength[i] = abs(a - b)
                for axis in range(3):
                    target[v, axis] = here[axis] + t * n[axis]


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
            _wake(state, counter, v)
            first = np.int64(m.vertices[v, OUT])
            h = first
            while True:
                w = origin(m, following(h))
                # Edge lengths grow by a third from one vertex to the next.
                m.points[w, SCALE] = min(m.points[w, SCALE], 1.35 * scale)
                _wake(state, counter, w)
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
            _, u, _ = _surround(m, v)
            for axis in range(3):
                target[v, axis] = m.points[v, axis] + 0.5 * u[axis]
            movers[count] = v
            count += 1
    return count

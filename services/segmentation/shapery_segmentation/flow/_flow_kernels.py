"""One step of the normal flow: speeds at the vertices, collisions ahead, sleep, oscillation and aging."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit

from shapery_segmentation.mesh._cells_kernels import gather
from shapery_segmentation.mesh._contact_kernels import dot, inner, subtract
from shapery_segmentation.mesh._grid_kernels import corners, normal, point
from shapery_segmentation.mesh._motion_kernels import MOVED
from shapery_segmentation.mesh._operation_kernels import following, origin, preceding, twin
from shapery_segmentation.mesh.arrays import (
    AREA,
    CREATED,
    OUT,
    RELINKED,
    SCALE,
    TOUCHED,
    UNTOUCHED,
    VERTEX_TOP,
)

# Columns of the vertex state (float64).
NET = 0  # normal way since the window began, mm
GAIN = 1  # share of the full step; falls with every change of direction
LAST_SPEED = 2  # speed at the previous position
LAST_X = 3  # previous position (3)
STEP = 6  # way along the normal of the last step, mm
STATE_COLUMNS = 7

# Columns of the vertex counters (int32).
MODE = 0
FLIPS = 1  # changes of direction so far
SIGN = 2  # direction of the last step
AGE = 3  # steps since the window began
BLOCKED = 4  # consecutive steps that a collision forbade
COUNTER_COLUMNS = 5

# Values of MODE.
AWAKE = 0
ASLEEP = 1
AGED = 2
FROZEN = 3

# Speed models.
THRESHOLD = 0
GRADIENT = 1

# Results of `_obstacle`.
NOTHING = 0
AHEAD = 1
BEHIND = 2


@inner
def sample(field, inverse, p, outside):
    """Return the trilinear interpolation of `field` at the point `p` (RAS mm), and whether it lies in the grid.

    Beyond the outermost voxel centres the value is `outside`.
    """
    x = inverse[0, 0] * p[0] + inverse[0, 1] * p[1] + inverse[0, 2] * p[2] + inverse[0, 3]
    y = inverse[1, 0] * p[0] + inverse[1, 1] * p[1] + inverse[1, 2] * p[2] + inverse[1, 3]
    z = inverse[2, 0] * p[0] + inverse[2, 1] * p[1] + inverse[2, 2] * p[2] + inverse[2, 3]
    ni, nj, nk = field.shape
    if not (0.0 <= x <= ni - 1 and 0.0 <= y <= nj - 1 and 0.0 <= z <= nk - 1):
        return outside, False
    i, j, k = min(np.int64(x), max(ni - 2, 0)), min(np.int64(y), max(nj - 2, 0)), min(np.int64(z), max(nk - 2, 0))
    i1, j1, k1 = min(i + 1, ni - 1), min(j + 1, nj - 1), min(k + 1, nk - 1)
    u, v, w = x - i, y - j, z - k
    a = (field[i, j, k] * (1.0 - w) + field[i, j, k1] * w) * (1.0 - v) + (
        field[i, j1, k] * (1.0 - w) + field[i, j1, k1] * w
    ) * v
    b = (field[i1, j, k] * (1.0 - w) + field[i1, j, k1] * w) * (1.0 - v) + (
        field[i1, j1, k] * (1.0 - w) + field[i1, j1, k1] * w
    ) * v
    return a * (1.0 - u) + b * u, True


@inner
def _speed(field, allowed, inverse, model, threshold, balloon, p, n, length):
    """Return the speed along the normal `n` at the point `p`, in [−1, 1] for the threshold model.

    See `shapery_segmentation.flow.normal` for the two models; curvature is added elsewhere.
    """
    value, inside = sample(field, inverse, p, 0.0)
    if not inside or np.isnan(value):
        return -1.0
    gate = 1.0
    if allowed.shape[0] > 0:
        gate, _ = sample(allowed, inverse, p, 0.0)
    if model == THRESHOLD:
        drive = np.tanh(value - threshold)
    else:
        # v·g − ∇g·n, the derivative taken over one edge length, in which the step is measured, too.
        half = 0.5 * length
        ahead, _ = sample(field, inverse, (p[0] + half * n[0], p[1] + half * n[1], p[2] + half * n[2]), value)
        back, _ = sample(field, inverse, (p[0] - half * n[0], p[1] - half * n[1], p[2] - half * n[2]), value)
        drive = max(-1.0, min(1.0, balloon * value - (ahead - back)))
    return gate * drive - (1.0 - gate)


@inner
def _obstacle(m, start, spheres, names, v, p, n, here, front, rear, opposed, found):
    """Return whether another part of the surface is near the point `p` to which `v` would move, and which face.

    A face counts if its normal has a product below `opposed` with `n`, it is no face of `v`, the way brings `v` nearer
    to its centroid, and that lies within `front` ahead of `p` or within `rear` behind it.
    """
    count = gather(m.layout, m.bound, start, spheres, names, p, max(front, rear), 0.0, found)
    for i in range(count):
        g = np.int64(found[i])
        if dot(n, normal(m, g)) >= opposed:
            continue
        c = (np.float64(m.facets[g, 0]), np.float64(m.facets[g, 1]), np.float64(m.facets[g, 2]))
        d, e = subtract(c, p), subtract(c, here)
        along = dot(d, n)
        limit = front if along >= 0.0 else rear
        if dot(d, d) < limit * limit and dot(d, d) < dot(e, e):
            a, b, c2 = corners(m, g)
            if v not in (a, b, c2):
                return (AHEAD if along >= 0.0 else BEHIND), g
    return NOTHING, np.int64(-1)


@inner
def _wake(state, counter, v):
    """Set a vertex at rest going again, unless it has been stopped for its age."""
    if counter[v, MODE] == ASLEEP or counter[v, MODE] == FROZEN:
        counter[v, MODE] = AWAKE
        counter[v, AGE] = 0
        counter[v, BLOCKED] = 0
        state[v, NET] = 0.0


@njit(cache=True, nogil=True)
def wake_all(m, state, counter, aged):
    """Wake every vertex; those stopped for their age too if `aged` is set."""
    for v in range(m.layout[VERTEX_TOP]):
        if m.vertices[v, OUT] >= 0:
            _wake(state, counter, v)
            if aged and counter[v, MODE] == AGED:
                counter[v, MODE] = AWAKE
                counter[v, FLIPS] = 0
                state[v, GAIN] = 1.0


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def propose(
    m, start, spheres, names, state, counter, field, allowed, inverse, model, threshold, balloon, length, step, bend,
    slide, aging, front, rear, opposed, patience, target, movers,
):  # fmt: skip
    """Compute where the awake vertices would go.

    Returns
    -------
    int
        Number of movers written to `movers`, their targets to `target`.
    """
    count = 0
    found = np.empty(m.links.shape[0], dtype=np.int32)
    for v in range(m.layout[VERTEX_TOP]):
        first = np.int64(m.vertices[v, OUT])
        if first < 0 or counter[v, MODE] != AWAKE:
            continue
        here = point(m, v)
        nx = ny = nz = 0.0
        ux = uy = uz = 0.0
        degree = 0
        h = first
        while True:
            f = h // 3
            w = m.facets[f, AREA]
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
        if size == 0.0:
            continue
        n = (nx / size, ny / size, nz / size)
        ux, uy, uz = ux / degree - here[0], uy / degree - here[1], uz / degree - here[2]
        local = length * m.points[v, SCALE]
        speed = _speed(field, allowed, inverse, model, threshold, balloon, here, n, local)

        sign = 1 if speed > 0.0 else -1
        if counter[v, SIGN] != 0 and sign != counter[v, SIGN]:
            counter[v, FLIPS] += 1
            state[v, GAIN] *= 0.5
            if counter[v, FLIPS] >= aging:
                # Stop where the speed is least on the way from the previous position to this one (Fig. 3.5).
                best = abs(speed)
                at = 0.0
                for k in range(1, 5):
                    t = 0.25 * k
                    q = (
                        here[0] + t * (state[v, LAST_X] - here[0]),
                        here[1] + t * (state[v, LAST_X + 1] - here[1]),
                        here[2] + t * (state[v, LAST_X + 2] - here[2]),
                    )
                    there = abs(_speed(field, allowed, inverse, model, threshold, balloon, q, n, local))
                    if there < best:
                        best = there
                        at = t
                counter[v, MODE] = AGED
                if at > 0.0:
                    for axis in range(3):
                        target[v, axis] = here[axis] + at * (state[v, LAST_X + axis] - here[axis])
                    movers[count] = v
                    count += 1
                continue
        else:
            state[v, GAIN] = min(1.0, 1.1 * state[v, GAIN])
        counter[v, SIGN] = sign

        along = ux * n[0] + uy * n[1] + uz * n[2]
        forward = step * local * state[v, GAIN] * speed + bend * along
        forward = max(-0.5 * local, min(0.5 * local, forward))
        dx = forward * n[0] + slide * (ux - along * n[0])
        dy = forward * n[1] + slide * (uy - along * n[1])
        dz = forward * n[2] + slide * (uz - along * n[2])
        p = (here[0] + dx, here[1] + dy, here[2] + dz)
        side, _ = _obstacle(m, start, spheres, names, v, p, n, here, front * local, rear * local, opposed, found)
        if side != NOTHING:
            counter[v, BLOCKED] += 1
            counter[v, AGE] += 1
            if counter[v, BLOCKED] >= patience:
                counter[v, MODE] = FROZEN
            continue
        counter[v, BLOCKED] = 0
        state[v, LAST_SPEED] = speed
        for axis in range(3):
            state[v, LAST_X + axis] = here[axis]
            target[v, axis] = p[axis]
        state[v, STEP] = forward
        counter[v, AGE] += 1
        movers[count] = v
        count += 1
    return count


@njit(cache=True, nogil=True)
def settle(m, state, counter, moved, movers, count, length, window, rest, stir):
    """Let vertices sleep that got nowhere in a window of steps, and wake the neighbours of those that did.

    Returns
    -------
    awake : int
        Vertices awake now.
    """
    for i in range(count):
        v = movers[i]
        if moved[v] == MOVED:
            state[v, NET] += state[v, STEP]
        else:
            # Put back: try half the way next time.
            state[v, GAIN] *= 0.5
            counter[v, BLOCKED] += 1
    awake = 0
    for v in range(m.layout[VERTEX_TOP]):
        if m.vertices[v, OUT] < 0 or counter[v, MODE] != AWAKE:
            continue
        if counter[v, AGE] >= window:
            net = abs(state[v, NET])
            local = length * m.points[v, SCALE]
            if net > stir * local:
                start = np.int64(m.vertices[v, OUT])
                h = start
                while True:
                    _wake(state, counter, origin(m, following(h)))
                    h = twin(m, preceding(h))
                    if h == start:
                        break
            counter[v, AGE] = 0
            state[v, NET] = 0.0
            if net < rest * local:
                counter[v, MODE] = ASLEEP
                continue
        awake += 1
    return awake

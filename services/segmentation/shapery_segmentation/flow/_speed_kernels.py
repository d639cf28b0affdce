"""The speed of the normal flow at a point: the field interpolated, the two models, the gate."""

# mypy: allow-untyped-defs, allow-untyped-calls

from typing import NamedTuple

import numpy as np

from shapery_segmentation.mesh.compiled import inner

# Speed models.
THRESHOLD = 0
GRADIENT = 1


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
def sample_both(field, gate, inverse, p):
    """Return what `sample` does of two arrays on one grid: both values, and whether `p` lies in the grid."""
    x = inverse[0, 0] * p[0] + inverse[0, 1] * p[1] + inverse[0, 2] * p[2] + inverse[0, 3]
    y = inverse[1, 0] * p[0] + inverse[1, 1] * p[1] + inverse[1, 2] * p[2] + inverse[1, 3]
    z = inverse[2, 0] * p[0] + inverse[2, 1] * p[1] + inverse[2, 2] * p[2] + inverse[2, 3]
    ni, nj, nk = field.shape
    if not (0.0 <= x <= ni - 1 and 0.0 <= y <= nj - 1 and 0.0 <= z <= nk - 1):
        return 0.0, 0.0, False
    i, j, k = min(np.int64(x), max(ni - 2, 0)), min(np.int64(y), max(nj - 2, 0)), min(np.int64(z), max(nk - 2, 0))
    i1, j1, k1 = min(i + 1, ni - 1), min(j + 1, nj - 1), min(k + 1, nk - 1)
    u, v, w = x - i, y - j, z - k
    a = (field[i, j, k] * (1.0 - w) + field[i, j, k1] * w) * (1.0 - v)
    a += (field[i, j1, k] * (1.0 - w) + field[i, j1, k1] * w) * v
    b = (field[i1, j, k] * (1.0 - w) + field[i1, j, k1] * w) * (1.0 - v)
    b += (field[i1, j1, k] * (1.0 - w) + field[i1, j1, k1] * w) * v
    near, far = np.int64(gate[i, j, k]), np.int64(gate[i, j, k1])
    near_up, far_up = np.int64(gate[i, j1, k]), np.int64(gate[i, j1, k1])
    behind, far_behind = np.int64(gate[i1, j, k]), np.int64(gate[i1, j, k1])
    behind_up, far_behind_up = np.int64(gate[i1, j1, k]), np.int64(gate[i1, j1, k1])
    open_ = 1.0
    # Hardly anywhere does the border of what is allowed pass.
    if near + far + near_up + far_up + behind + far_behind + behind_up + far_behind_up < 8:
        c = (near * (1.0 - w) + far * w) * (1.0 - v) + (near_up * (1.0 - w) + far_up * w) * v
        d = (behind * (1.0 - w) + far_behind * w) * (1.0 - v) + (behind_up * (1.0 - w) + far_behind_up * w) * v
        open_ = c * (1.0 - u) + d * u
    return a * (1.0 - u) + b * u, open_, True


@inner
def slope_at(field, inverse, p, n):
    """Return how the interpolated `field` changes along `n` at the point `p`, per mm; 0 outside the grid."""
    x = inverse[0, 0] * p[0] + inverse[0, 1] * p[1] + inverse[0, 2] * p[2] + inverse[0, 3]
    y = inverse[1, 0] * p[0] + inverse[1, 1] * p[1] + inverse[1, 2] * p[2] + inverse[1, 3]
    z = inverse[2, 0] * p[0] + inverse[2, 1] * p[1] + inverse[2, 2] * p[2] + inverse[2, 3]
    ni, nj, nk = field.shape
    if not (0.0 <= x <= ni - 1 and 0.0 <= y <= nj - 1 and 0.0 <= z <= nk - 1):
        return 0.0
    i, j, k = min(np.int64(x), max(ni - 2, 0)), min(np.int64(y), max(nj - 2, 0)), min(np.int64(z), max(nk - 2, 0))
    i1, j1, k1 = min(i + 1, ni - 1), min(j + 1, nj - 1), min(k + 1, nk - 1)
    u, v, w = x - i, y - j, z - k
    a, b, c, d = field[i, j, k], field[i, j, k1], field[i, j1, k], field[i, j1, k1]
    e, f, g, h = field[i1, j, k], field[i1, j, k1], field[i1, j1, k], field[i1, j1, k1]
    dx = ((e - a) * (1.0 - w) + (f - b) * w) * (1.0 - v) + ((g - c) * (1.0 - w) + (h - d) * w) * v
    dy = ((c - a) * (1.0 - w) + (d - b) * w) * (1.0 - u) + ((g - e) * (1.0 - w) + (h - f) * w) * u
    dz = ((b - a) * (1.0 - v) + (d - c) * v) * (1.0 - u) + ((f - e) * (1.0 - v) + (h - g) * v) * u
    return (
        dx * (inverse[0, 0] * n[0] + inverse[0, 1] * n[1] + inverse[0, 2] * n[2])
        + dy * (inverse[1, 0] * n[0] + inverse[1, 1] * n[1] + inverse[1, 2] * n[2])
        + dz * (inverse[2, 0] * n[0] + inverse[2, 1] * n[1] + inverse[2, 2] * n[2])
    )


@inner
def speed_at(field, inverse, allowed, inverse_allowed, dials, p, n):
    """Return the speed along the normal `n` at the point `p`, in [−1, 1], without the curvature.

    Outside the grid, and where nothing is allowed, it is −1; across the border of what is allowed it falls linearly.
    """
    gate = 1.0
    if dials.model == THRESHOLD and allowed.shape[0] > 0:
        value, gate, inside = sample_both(field, allowed, inverse, p)
    else:
        value, inside = sample(field, inverse, p)
        if inside and allowed.shape[0] > 0:
            gate, _ = sample(allowed, inverse_allowed, p)
    if not inside:
        return -1.0
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

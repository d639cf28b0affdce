"""The level of a field that an open surface grows on: its gradient, the way to it, and the first triangle there."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.flow._front_kernels import Dials, unit
from shapery_segmentation.flow._speed_kernels import sample
from shapery_segmentation.mesh._contact_kernels import cross, dot
from shapery_segmentation.mesh.compiled import inner, kernel


@inner
def gradient(field, inverse, p, half):
    """Return the gradient of `field` (per mm) at `p` by central differences over `half` mm, and whether it is known."""
    x1, a = sample(field, inverse, (p[0] + half, p[1], p[2]))
    x0, b = sample(field, inverse, (p[0] - half, p[1], p[2]))
    y1, c = sample(field, inverse, (p[0], p[1] + half, p[2]))
    y0, d = sample(field, inverse, (p[0], p[1] - half, p[2]))
    z1, e = sample(field, inverse, (p[0], p[1], p[2] + half))
    z0, f = sample(field, inverse, (p[0], p[1], p[2] - half))
    scale = 0.5 / half
    return ((x1 - x0) * scale, (y1 - y0) * scale, (z1 - z0) * scale), a and b and c and d and e and f


@inner
def pull(field, inverse, dials, p):
    """Return the point of the border nearest to `p`, its outward normal, and whether there is one with a gradient.

    Newton steps along the gradient, each of at most half a voxel.
    """
    q = p
    n = (0.0, 0.0, 0.0)
    for _ in range(6):
        g, known = gradient(field, inverse, q, 0.35 * dials.voxel)
        value, inside = sample(field, inverse, q)
        size = np.sqrt(dot(g, g))
        if not (known and inside) or size * dials.voxel < dials.prominence:
            return q, n, False
        n = (-g[0] / size, -g[1] / size, -g[2] / size)
        step = (value - dials.threshold) / size
        limit = 0.5 * dials.voxel
        step = max(-limit, min(limit, step))
        q = (q[0] + step * n[0], q[1] + step * n[1], q[2] + step * n[2])
        if abs(step) < 0.02 * dials.voxel:
            return q, n, True
    value, inside = sample(field, inverse, q)
    return q, n, inside and abs(value - dials.threshold) < 0.15


@kernel
def first_triangle(field, inverse, point, threshold, edge, voxel, corners):
    """Write three points of the border, counter-clockwise seen from outside; return whether there are any.

    From `point` (3,) one goes straight on, in each of 26 directions in turn, to where the field falls below the
    threshold; around the nearest such place the triangle is laid, and pulled to the border.
    """
    dials = Dials(threshold, edge, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, voxel)
    best = 1e30
    p = (0.0, 0.0, 0.0)
    for a in range(-1, 2):
        for b in range(-1, 2):
            for c in range(-1, 2):
                size = np.sqrt(np.float64(a * a + b * b + c * c))
                if size == 0.0:
                    continue
                t = 0.0
                while t < min(best, 500.0 * voxel):
                    t += 0.5 * voxel
                    q = (point[0] + t * a / size, point[1] + t * b / size, point[2] + t * c / size)
                    value, inside = sample(field, inverse, q)
                    if not inside:
                        break
                    if value < threshold:
                        if t < best:
                            best = t
                            p = q
                        break
    if best >= 1e30:
        return False
    p, n, found = pull(field, inverse, dials, p)
    if not found:
        return False
    axis = (1.0, 0.0, 0.0) if abs(n[0]) < 0.6 else (0.0, 1.0, 0.0)
    e1 = unit(cross(n, axis))
    e2 = cross(n, e1)
    for k in range(3):
        turn = 2.0 * np.pi * k / 3.0
        x, y = edge / np.sqrt(3.0) * np.cos(turn), edge / np.sqrt(3.0) * np.sin(turn)
        q = (p[0] + x * e1[0] + y * e2[0], p[1] + x * e1[1] + y * e2[1], p[2] + x * e1[2] + y * e2[2])
        q, _, found = pull(field, inverse, dials, q)
        if not found:
            return False
        for axis_number in range(3):
            corners[k, axis_number] = q[axis_number]
    return True

"""Compiled loops of `shapery_geometry.operators.surface_distance`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def closest_on_triangle(a, b, c, p):
    """Barycentric weights of the point of the triangle abc nearest to p, and the squared distance.

    The nearest point is the foot of p on the plane if that lies inside, else the nearest one on a side. Both are tried
    as they are, without regions, so that needles and triangles without area need no care.
    """
    best = np.inf
    w0, w1, w2 = 1.0, 0.0, 0.0
    for k in range(3):
        q = a if k == 0 else (b if k == 1 else c)
        r = b if k == 0 else (c if k == 1 else a)
        length = 0.0
        along = 0.0
        for axis in range(3):
            d = r[axis] - q[axis]
            length += d * d
            along += d * (p[axis] - q[axis])
        t = min(max(along / length, 0.0), 1.0) if length > 0 else 0.0
        square = 0.0
        for axis in range(3):
            d = p[axis] - (q[axis] + t * (r[axis] - q[axis]))
            square += d * d
        if square < best:
            best = square
            if k == 0:
                w0, w1, w2 = 1 - t, t, 0.0
            elif k == 1:
                w0, w1, w2 = 0.0, 1 - t, t
            else:
                w0, w1, w2 = t, 0.0, 1 - t
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    px, py, pz = p[0] - a[0], p[1] - a[1], p[2] - a[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    square = nx * nx + ny * ny + nz * nz
    if square > 0:
        s = ((py * vz - pz * vy) * nx + (pz * vx - px * vz) * ny + (px * vy - py * vx) * nz) / square
        t = ((uy * pz - uz * py) * nx + (uz * px - ux * pz) * ny + (ux * py - uy * px) * nz) / square
        if s >= 0 and t >= 0 and s + t <= 1:
            height = px * nx + py * ny + pz * nz
            height = height * height / square
            if height < best:
                return 1 - s - t, s, t, height
    return w0, w1, w2, best


@njit(cache=True, nogil=True)
def box_distance(nodes, node, p):
    """Squared distance of p from a node's box; infinite for an empty box."""
    square = 0.0
    for axis in range(3):
        low = nodes[node, axis] - p[axis]
        high = p[axis] - nodes[node, axis + 3]
        d = max(low, high, 0.0)
        square += d * d
    return square


@njit(cache=True, nogil=True)
def closest_faces(points, vertices, faces, order, nodes, first_leaf, leaf_size):
    """For each point the nearest face, the barycentric weights of its nearest point, and the squared distance."""
    chosen = np.empty(len(points), dtype=np.int32)
    weights = np.empty((len(points), 3))
    squares = np.empty(len(points))
    stack = np.empty(128, dtype=np.int64)
    bounds = np.empty(128)
    for i in range(len(points)):
        p = points[i]
        best = np.inf
        stack[0] = 0
        bounds[0] = 0.0
        top = 1
        while top > 0:
            top -= 1
            if bounds[top] >= best:
                continue
            node = stack[top]
            if node < first_leaf:
                near, far = 2 * node + 1, 2 * node + 2
                near_bound, far_bound = box_distance(nodes, near, p), box_distance(nodes, far, p)
                if far_bound < near_bound:
                    near, far = far, near
                    near_bound, far_bound = far_bound, near_bound
                # the nearer child is looked at first
                if far_bound < best:
                    stack[top] = far
                    bounds[top] = far_bound
                    top += 1
                if near_bound < best:
                    stack[top] = near
                    bounds[top] = near_bound
                    top += 1
                continue
            start = (node - first_leaf) * leaf_size
            for place in range(start, min(start + leaf_size, len(order))):
                f = order[place]
                w0, w1, w2, square = closest_on_triangle(
                    vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]], p
                )
                if square < best:
                    best = square
                    chosen[i] = f
                    weights[i, 0] = w0
                    weights[i, 1] = w1
                    weights[i, 2] = w2
        squares[i] = best
    return chosen, weights, squares

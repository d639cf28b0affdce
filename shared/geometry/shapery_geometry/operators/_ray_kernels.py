"""Compiled loops of `shapery_geometry.operators.rays`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"nnan", "nsz", "contract"})
def _enter(nodes, node, ox, oy, oz, ix, iy, iz, best):
    """Where a ray enters a node's box, or infinity where it misses it or enters behind `best`."""
    low = 0.0
    high = best
    a, b = (nodes[node, 0] - ox) * ix, (nodes[node, 3] - ox) * ix
    low, high = max(low, min(a, b)), min(high, max(a, b))
    a, b = (nodes[node, 1] - oy) * iy, (nodes[node, 4] - oy) * iy
    low, high = max(low, min(a, b)), min(high, max(a, b))
    a, b = (nodes[node, 2] - oz) * iz, (nodes[node, 5] - oz) * iz
    low, high = max(low, min(a, b)), min(high, max(a, b))
    return low if low <= high else np.inf


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"nnan", "nsz", "contract"})
def first_hits(origins, directions, starts, vertices, faces, order, nodes, first_leaf, leaf_size):
    """(k,) parameter at which each ray first meets a face beyond `starts`, or infinity, and the (k,) face or −1.

    Faces whose normal is seen from either side count.
    """
    result = np.full(len(origins), np.inf)
    which = np.full(len(origins), -1, dtype=np.int32)
    stack = np.empty(128, dtype=np.int64)
    for r in range(len(origins)):
        ox, oy, oz = origins[r, 0], origins[r, 1], origins[r, 2]
        dx, dy, dz = directions[r, 0], directions[r, 1], directions[r, 2]
        # a tiny number in place of zero keeps 0 · ∞ out of the tests with boxes
        ix = 1.0 / (dx if abs(dx) > 1e-30 else 1e-30)
        iy = 1.0 / (dy if abs(dy) > 1e-30 else 1e-30)
        iz = 1.0 / (dz if abs(dz) > 1e-30 else 1e-30)
        best = np.inf
        stack[0] = 0
        top = 1
        while top > 0:
            top -= 1
            node = stack[top]
            if _enter(nodes, node, ox, oy, oz, ix, iy, iz, best) == np.inf:
                continue
            if node < first_leaf:
                near, far = 2 * node + 1, 2 * node + 2
                at_near = _enter(nodes, near, ox, oy, oz, ix, iy, iz, best)
                at_far = _enter(nodes, far, ox, oy, oz, ix, iy, iz, best)
                if at_far < at_near:
                    near, far = far, near
                    at_near, at_far = at_far, at_near
                if at_far < np.inf:
                    stack[top] = far
                    top += 1
                if at_near < np.inf:
                    stack[top] = near
                    top += 1
                continue
            leaf = (node - first_leaf) * leaf_size
            for place in range(leaf, min(leaf + leaf_size, len(order))):
                f = order[place]
                a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
                ax, ay, az = vertices[a, 0], vertices[a, 1], vertices[a, 2]
                ux, uy, uz = vertices[b, 0] - ax, vertices[b, 1] - ay, vertices[b, 2] - az
                vx, vy, vz = vertices[c, 0] - ax, vertices[c, 1] - ay, vertices[c, 2] - az
                # Möller–Trumbore
                px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
                det = ux * px + uy * py + uz * pz
                if det == 0.0:
                    continue
                tx, ty, tz = ox - ax, oy - ay, oz - az
                s = (tx * px + ty * py + tz * pz) / det
                if s < -1e-9 or s > 1 + 1e-9:
                    continue
                qx, qy, qz = ty * uz - tz * uy, tz * ux - tx * uz, tx * uy - ty * ux
                t = (dx * qx + dy * qy + dz * qz) / det
                if t < -1e-9 or s + t > 1 + 1e-9:
                    continue
                at = (vx * qx + vy * qy + vz * qz) / det
                if starts[r] < at < best:
                    best = at
                    which[r] = f
        result[r] = best
    return result, which

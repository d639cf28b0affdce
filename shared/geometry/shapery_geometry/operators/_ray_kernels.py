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
def in_leaf_order(vertices, faces, order):
    """(m, 9) a corner and the two edges from it of each face, in the order of the leaves: a leaf is one read."""
    result = np.empty((len(order), 9))
    for place in range(len(order)):
        f = order[place]
        for k in range(3):
            a = vertices[faces[f, 0], k]
            result[place, k] = a
            result[place, 3 + k] = vertices[faces[f, 1], k] - a
            result[place, 6 + k] = vertices[faces[f, 2], k] - a
    return result


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"nnan", "nsz", "contract"})
def first_hits(origins, directions, starts, triangles, order, nodes, first_leaf, leaf_size):
    """(k,) parameter at which each ray first meets a face beyond `starts`, or infinity, and the (k,) face or −1.

    Faces whose normal is seen from either side count. ``triangles`` are those of `in_leaf_order`.
    """
    result = np.full(len(origins), np.inf)
    which = np.full(len(origins), -1, dtype=np.int32)
    stack = np.empty(128, dtype=np.int64)
    entries = np.empty(128)
    for r in range(len(origins)):
        ox, oy, oz = origins[r, 0], origins[r, 1], origins[r, 2]
        dx, dy, dz = directions[r, 0], directions[r, 1], directions[r, 2]
        # a tiny number in place of zero keeps 0 · ∞ out of the tests with boxes
        ix = 1.0 / (dx if abs(dx) > 1e-30 else 1e-30)
        iy = 1.0 / (dy if abs(dy) > 1e-30 else 1e-30)
        iz = 1.0 / (dz if abs(dz) > 1e-30 else 1e-30)
        best = np.inf
        stack[0] = 0
        entries[0] = _enter(nodes, 0, ox, oy, oz, ix, iy, iz, best)
        top = 1
        while top > 0:
            top -= 1
            if entries[top] >= best:
                continue
            node = stack[top]
            while node < first_leaf:
                near, far = 2 * node + 1, 2 * node + 2
                at_near = _enter(nodes, near, ox, oy, oz, ix, iy, iz, best)
                at_far = _enter(nodes, far, ox, oy, oz, ix, iy, iz, best)
                if at_far < at_near:
                    near, far = far, near
                    at_near, at_far = at_far, at_near
                if at_near == np.inf:
                    node = -1
                    break
                if at_far < np.inf:
                    stack[top] = far
                    entries[top] = at_far
                    top += 1
                node = near
            if node < 0:
                continue
            leaf = (node - first_leaf) * leaf_size
            for place in range(leaf, min(leaf + leaf_size, len(order))):
                ux, uy, uz = triangles[place, 3], triangles[place, 4], triangles[place, 5]
                vx, vy, vz = triangles[place, 6], triangles[place, 7], triangles[place, 8]
                # Möller–Trumbore
                px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
                det = ux * px + uy * py + uz * pz
                if det == 0.0:
                    continue
                inverse = 1.0 / det
                tx, ty, tz = ox - triangles[place, 0], oy - triangles[place, 1], oz - triangles[place, 2]
                s = (tx * px + ty * py + tz * pz) * inverse
                if s < -1e-9 or s > 1 + 1e-9:
                    continue
                qx, qy, qz = ty * uz - tz * uy, tz * ux - tx * uz, tx * uy - ty * ux
                t = (dx * qx + dy * qy + dz * qz) * inverse
                if t < -1e-9 or s + t > 1 + 1e-9:
                    continue
                at = (vx * qx + vy * qy + vz * qz) * inverse
                if starts[r] < at < best:
                    best = at
                    which[r] = order[place]
        result[r] = best
    return result, which

"""Compiled loops of `shapery_motion.errors`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def position_sums(original, decoded):
    """Squared errors summed, the largest of them, and the squared distances of `original` from its centroid summed."""
    n = len(original)
    total = 0.0
    largest = 0.0
    for i in range(n):
        squared = 0.0
        for axis in range(3):
            d = np.float64(original[i, axis]) - np.float64(decoded[i, axis])
            squared += d * d
        total += squared
        # an error that is not a number is never lost
        if squared > largest or np.isnan(squared):
            largest = squared
    spread = 0.0
    for axis in range(3):
        mean = 0.0
        for i in range(n):
            mean += np.float64(original[i, axis])
        mean /= max(n, 1)
        for i in range(n):
            d = np.float64(original[i, axis]) - mean
            spread += d * d
    return total, largest, spread


@njit(cache=True, nogil=True)
def edge_length_sum(vertices, edges):
    """Sum of the lengths of `edges`."""
    total = 0.0
    for i in range(len(edges)):
        squared = 0.0
        for axis in range(3):
            d = np.float64(vertices[edges[i, 0], axis]) - np.float64(vertices[edges[i, 1], axis])
            squared += d * d
        total += np.sqrt(squared)
    return total


@njit(cache=True, nogil=True)
def unit_normals(vertices, faces):
    """(m, 3) unit normals; zero where a face has no area."""
    result = np.zeros((len(faces), 3))
    for f in range(len(faces)):
        a = faces[f, 0]
        b = faces[f, 1]
        c = faces[f, 2]
        ux = np.float64(vertices[b, 0]) - np.float64(vertices[a, 0])
        uy = np.float64(vertices[b, 1]) - np.float64(vertices[a, 1])
        uz = np.float64(vertices[b, 2]) - np.float64(vertices[a, 2])
        vx = np.float64(vertices[c, 0]) - np.float64(vertices[a, 0])
        vy = np.float64(vertices[c, 1]) - np.float64(vertices[a, 1])
        vz = np.float64(vertices[c, 2]) - np.float64(vertices[a, 2])
        x = uy * vz - uz * vy
        y = uz * vx - ux * vz
        z = ux * vy - uy * vx
        length = np.sqrt(x * x + y * y + z * z)
        # below this the direction is rounding, not shape
        if length > 1e-12 * (ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz):
            result[f, 0] = x / length
            result[f, 1] = y / length
            result[f, 2] = z / length
    return result


@njit(cache=True, nogil=True)
def _angle(ax, ay, az, bx, by, bz):
    """Angle between two vectors, precise near 0 and π, where the arccosine is not."""
    x = ay * bz - az * by
    y = az * bx - ax * bz
    z = ax * by - ay * bx
    return np.arctan2(np.sqrt(x * x + y * y + z * z), ax * bx + ay * by + az * bz)


@njit(cache=True, nogil=True)
def normal_angle_sum(original, decoded):
    """Sum of the angles between normals and their count, over faces with an area in `original`.

    A face that lost its area has no normal to compare, and counts as a right angle.
    """
    total = 0.0
    count = 0
    for f in range(len(original)):
        a = original[f]
        b = decoded[f]
        if a[0] == 0.0 and a[1] == 0.0 and a[2] == 0.0:
            continue
        count += 1
        if b[0] == 0.0 and b[1] == 0.0 and b[2] == 0.0:
            total += 0.5 * np.pi
        else:
            total += _angle(a[0], a[1], a[2], b[0], b[1], b[2])
    return total, count


@njit(cache=True, nogil=True)
def _fold(vertices, a, b, first, second):
    """Signed angle between the normals of two faces about the edge from `a` to `b`."""
    ex = np.float64(vertices[b, 0]) - np.float64(vertices[a, 0])
    ey = np.float64(vertices[b, 1]) - np.float64(vertices[a, 1])
    ez = np.float64(vertices[b, 2]) - np.float64(vertices[a, 2])
    x = first[1] * second[2] - first[2] * second[1]
    y = first[2] * second[0] - first[0] * second[2]
    z = first[0] * second[1] - first[1] * second[0]
    sine = np.sqrt(x * x + y * y + z * z)
    if x * ex + y * ey + z * ez < 0.0:
        sine = -sine
    return np.arctan2(sine, first[0] * second[0] + first[1] * second[1] + first[2] * second[2])


@njit(cache=True, nogil=True)
def dihedral_difference_sum(original, decoded, original_normals, decoded_normals, edges, pairs):
    """Sum of the changes of the dihedral angle and their count, over edges whose two faces have areas in both."""
    total = 0.0
    count = 0
    for e in range(len(edges)):
        f = pairs[e, 0]
        g = pairs[e, 1]
        solid = True
        for k in (f, g):
            for normals in (original_normals, decoded_normals):
                n = normals[k]
                if n[0] == 0.0 and n[1] == 0.0 and n[2] == 0.0:
                    solid = False
        if not solid:
            continue
        a = edges[e, 0]
        b = edges[e, 1]
        before = _fold(original, a, b, original_normals[f], original_normals[g])
        after = _fold(decoded, a, b, decoded_normals[f], decoded_normals[g])
        change = abs(before - after)
        total += min(change, 2.0 * np.pi - change)
        count += 1
    return total, count

"""Compiled loops of `shapery_motion.gradient.deformation` and `.gluing`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def edge_frames(vertices, faces):
    """(m, 3, 3) matrices V of Eq. 5.3, whose columns are two sides of the face and the fourth vertex's offset."""
    result = np.empty((len(faces), 3, 3))
    for f in range(len(faces)):
        for axis in range(3):
            origin = np.float64(vertices[faces[f, 0], axis])
            result[f, axis, 0] = np.float64(vertices[faces[f, 1], axis]) - origin
            result[f, axis, 1] = np.float64(vertices[faces[f, 2], axis]) - origin
        v = result[f]
        x = v[1, 0] * v[2, 1] - v[2, 0] * v[1, 1]
        y = v[2, 0] * v[0, 1] - v[0, 0] * v[2, 1]
        z = v[0, 0] * v[1, 1] - v[1, 0] * v[0, 1]
        length = np.sqrt(x * x + y * y + z * z)
        scale = 1.0 / np.sqrt(length) if length > 0.0 else 0.0
        v[0, 2] = x * scale
        v[1, 2] = y * scale
        v[2, 2] = z * scale
    return result


@njit(cache=True, nogil=True)
def inverses(frames, threshold, result, solid):
    """Invert the matrices V; where a face is degenerate its inverse is zero and `solid` false.

    With c the cross product of the sides a and b, the rows are b × c / |c|², c × a / |c|² and c / |c|^1.5.
    """
    for f in range(len(frames)):
        v = frames[f]
        ax, ay, az = v[0, 0], v[1, 0], v[2, 0]
        bx, by, bz = v[0, 1], v[1, 1], v[2, 1]
        cx = ay * bz - az * by
        cy = az * bx - ax * bz
        cz = ax * by - ay * bx
        squared = cx * cx + cy * cy + cz * cz
        dx, dy, dz = bx - ax, by - ay, bz - az
        longest = max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, dx * dx + dy * dy + dz * dz)
        solid[f] = np.sqrt(squared) > threshold * longest
        if not solid[f]:
            result[f] = 0.0
            continue
        result[f, 0, 0] = (by * cz - bz * cy) / squared
        result[f, 0, 1] = (bz * cx - bx * cz) / squared
        result[f, 0, 2] = (bx * cy - by * cx) / squared
        result[f, 1, 0] = (cy * az - cz * ay) / squared
        result[f, 1, 1] = (cz * ax - cx * az) / squared
        result[f, 1, 2] = (cx * ay - cy * ax) / squared
        scale = squared**-0.75
        result[f, 2, 0] = cx * scale
        result[f, 2, 1] = cy * scale
        result[f, 2, 2] = cz * scale


@njit(cache=True, nogil=True)
def products(frames, inverse, solid, result):
    """Q = Ṽ V⁻¹ of Eq. 5.4 for every face; the identity where the face is degenerate."""
    for f in range(len(frames)):
        if not solid[f]:
            result[f] = 0.0
            result[f, 0, 0] = 1.0
            result[f, 1, 1] = 1.0
            result[f, 2, 2] = 1.0
            continue
        for i in range(3):
            for j in range(3):
                result[f, i, j] = (
                    frames[f, i, 0] * inverse[f, 0, j]
                    + frames[f, i, 1] * inverse[f, 1, j]
                    + frames[f, i, 2] * inverse[f, 2, j]
                )


@njit(cache=True, nogil=True)
def divergence(faces, hats, labels, matrices, result):
    """Add up the right-hand side of Eq. 5.9: for each corner of each face, its matrix times the corner's gradient.

    `hats` (m, 3, 3) holds for each face the weighted gradients of the hat functions of its corners.
    """
    result[:] = 0.0
    for f in range(len(faces)):
        q = matrices[labels[f]]
        for corner in range(3):
            vertex = faces[f, corner]
            gx = hats[f, corner, 0]
            gy = hats[f, corner, 1]
            gz = hats[f, corner, 2]
            for axis in range(3):
                result[vertex, axis] += q[axis, 0] * gx + q[axis, 1] * gy + q[axis, 2] * gz

"""Compiled loops of `shapery_geometry.operators.intrinsic`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def find_twins(faces):
    """(3m,) the one half-edge that runs the other way along the same edge, or −1 where there is none or several."""
    m = len(faces)
    n = 0
    for f in range(m):
        for k in range(3):
            n = max(n, faces[f, k] + 1)
    keys = np.empty(3 * m, dtype=np.int64)
    for f in range(m):
        for k in range(3):
            a, b = faces[f, k], faces[f, (k + 1) % 3]
            keys[3 * f + k] = np.int64(min(a, b)) * n + max(a, b)
    order = np.argsort(keys, kind="mergesort")
    twins = np.full(3 * m, -1, dtype=np.int64)
    start = 0
    while start < len(order):
        end = start + 1
        while end < len(order) and keys[order[end]] == keys[order[start]]:
            end += 1
        if end - start == 2:
            g, h = order[start], order[start + 1]
            if g // 3 != h // 3 and faces[g // 3, g % 3] != faces[h // 3, h % 3]:
                twins[g] = h
                twins[h] = g
        start = end
    return twins


@njit(cache=True, nogil=True)
def triangle_area(a, b, c):
    """Area from three side lengths; zero where they form no triangle."""
    s = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return 0.25 * np.sqrt(s) if s > 0 else 0.0


@njit(cache=True, nogil=True)
def _cotangent(a, b, opposite):
    """Cotangent of the angle between sides a and b."""
    area = triangle_area(a, b, opposite)
    return (a * a + b * b - opposite * opposite) / (4 * area) if area > 0 else 0.0


@njit(cache=True, nogil=True)
def flip_to_delaunay(faces, lengths, twins, limit):
    """Flip edges in place until both angles opposite each edge sum to at most π; return the number of flips.

    ``lengths[f, k]`` belongs to the side from corner k to corner k + 1.
    """
    m = len(faces)
    queue = np.empty(3 * m, dtype=np.int64)
    queued = np.zeros(3 * m, dtype=np.bool_)
    head, waiting = 0, 0
    for h in range(3 * m):
        if twins[h] > h:
            queue[waiting] = h
            queued[h] = True
            waiting += 1
    flips = 0
    while waiting > 0 and flips < limit:
        h = queue[head]
        head = (head + 1) % (3 * m)
        waiting -= 1
        queued[h] = False
        g = twins[h]
        if g < 0:
            continue
        f, s = h // 3, h % 3
        e, t = g // 3, g % 3
        ij = lengths[f, s]
        jk, ki = lengths[f, (s + 1) % 3], lengths[f, (s + 2) % 3]
        il, lj = lengths[e, (t + 1) % 3], lengths[e, (t + 2) % 3]
        if _cotangent(jk, ki, ij) + _cotangent(il, lj, ij) >= -1e-9:
            continue
        # both triangles laid out in the plane, with the edge on the x axis
        kx = (ij * ij + ki * ki - jk * jk) / (2 * ij)
        ky = np.sqrt(max(ki * ki - kx * kx, 0.0))
        lx = (ij * ij + il * il - lj * lj) / (2 * ij)
        ly = -np.sqrt(max(il * il - lx * lx, 0.0))
        kl = np.hypot(kx - lx, ky - ly)
        if triangle_area(kl, lj, jk) <= 0 or triangle_area(kl, ki, il) <= 0:
            continue
        i, j = faces[f, s], faces[f, (s + 1) % 3]
        k, l = faces[f, (s + 2) % 3], faces[e, (t + 2) % 3]  # noqa: E741
        jk_twin, ki_twin = twins[3 * f + (s + 1) % 3], twins[3 * f + (s + 2) % 3]
        il_twin, lj_twin = twins[3 * e + (t + 1) % 3], twins[3 * e + (t + 2) % 3]
        faces[f, 0], faces[f, 1], faces[f, 2] = k, l, j
        lengths[f, 0], lengths[f, 1], lengths[f, 2] = kl, lj, jk
        faces[e, 0], faces[e, 1], faces[e, 2] = l, k, i
        lengths[e, 0], lengths[e, 1], lengths[e, 2] = kl, ki, il
        twins[3 * f] = 3 * e
        twins[3 * e] = 3 * f
        # an outer side may have been glued to another of the four: then its twin has moved, too
        old = (3 * f + (s + 1) % 3, 3 * f + (s + 2) % 3, 3 * e + (t + 1) % 3, 3 * e + (t + 2) % 3)
        new = (3 * f + 2, 3 * e + 1, 3 * e + 2, 3 * f + 1)
        outer = (jk_twin, ki_twin, il_twin, lj_twin)
        for a in range(4):
            to = outer[a]
            for b in range(4):
                if to == old[b]:
                    to = new[b]
                    break
            twins[new[a]] = to
            if to >= 0:
                twins[to] = new[a]
        for a in range(4):
            side = new[a] if twins[new[a]] < 0 or new[a] < twins[new[a]] else twins[new[a]]
            if twins[side] >= 0 and not queued[side] and waiting < 3 * m:
                queue[(head + waiting) % (3 * m)] = side
                queued[side] = True
                waiting += 1
        flips += 1
    return flips


@njit(cache=True, nogil=True)
def half_cotangents(lengths):
    """(m, 3) half the cotangent of the angle opposite each side."""
    result = np.empty_like(lengths)
    for f in range(len(lengths)):
        for k in range(3):
            a, b = lengths[f, (k + 1) % 3], lengths[f, (k + 2) % 3]
            result[f, k] = 0.5 * _cotangent(a, b, lengths[f, k])
    return result


@njit(cache=True, nogil=True)
def areas(lengths):
    """(m,) area of each face."""
    result = np.empty(len(lengths))
    for f in range(len(lengths)):
        result[f] = triangle_area(lengths[f, 0], lengths[f, 1], lengths[f, 2])
    return result

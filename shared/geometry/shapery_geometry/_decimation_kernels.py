"""Loops of `shapery_geometry.decimation`: quadrics, a heap of edges, and the collapse of one edge after another."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from pathlib import Path

import numpy as np

from shapery_geometry.compilation import KernelFamily, inlined, inner

kernel = KernelFamily([Path(__file__)]).kernel

TURN = 0.2
"""A collapse is not made where it would turn a face further than to this cosine."""
NEEDLE = 1e-3
"""Nor where it makes a face whose area is below this share of the square of its longest side."""


@inlined
def _add_plane(q, nx, ny, nz, px, py, pz, weight):
    """Add to a quadric the squared distance from the plane with a unit normal through a point."""
    d = nx * px + ny * py + nz * pz
    q[0] += weight * nx * nx
    q[1] += weight * nx * ny
    q[2] += weight * nx * nz
    q[3] += weight * ny * ny
    q[4] += weight * ny * nz
    q[5] += weight * nz * nz
    q[6] += weight * d * nx
    q[7] += weight * d * ny
    q[8] += weight * d * nz
    q[9] += weight * d * d


@inlined
def _add_point(q, px, py, pz, weight):
    """Add to a quadric the squared distance from a point."""
    q[0] += weight
    q[3] += weight
    q[5] += weight
    q[6] += weight * px
    q[7] += weight * py
    q[8] += weight * pz
    q[9] += weight * (px * px + py * py + pz * pz)


@kernel
def vertex_quadrics(points, faces, edges, edge_faces, evenness, rim_weight, quadrics):
    """Add up the quadrics of all vertices.

    Parameters
    ----------
    points : (n, 3) float64
    faces : (m, 3) int32
    edges : (b, 2) int32
        Those on a rim, and
    edge_faces : (b,) int32
        a face of each.
    evenness
        Weight of the distance from the middles of faces, beside that from their planes.
    rim_weight
        Weight of the planes that stand on faces along the rim, per squared length.
    quadrics : (n, 10) float64
        0 throughout.
    """
    third = 1.0 / 3.0
    for f in range(len(faces)):
        a, b, c = faces[f]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        if not length > 0.0:
            continue
        nx, ny, nz = nx / length, ny / length, nz / length
        share = length * third / 2
        px = (points[a, 0] + points[b, 0] + points[c, 0]) * third
        py = (points[a, 1] + points[b, 1] + points[c, 1]) * third
        pz = (points[a, 2] + points[b, 2] + points[c, 2]) * third
        for k in range(3):
            q = quadrics[faces[f, k]]
            _add_plane(q, nx, ny, nz, points[a, 0], points[a, 1], points[a, 2], share)
            _add_point(q, px, py, pz, share * evenness)
    for e in range(len(edges)):
        a, b = edges[e]
        f = faces[edge_faces[e]]
        o, u, v = points[f[0]], points[f[1]], points[f[2]]
        ux, uy, uz = u[0] - o[0], u[1] - o[1], u[2] - o[2]
        vx, vy, vz = v[0] - o[0], v[1] - o[1], v[2] - o[2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        ex, ey, ez = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        sx, sy, sz = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
        length = np.sqrt(sx * sx + sy * sy + sz * sz)
        if not length > 0.0:
            continue
        weight = rim_weight * (ex * ex + ey * ey + ez * ez)
        for k in range(2):
            _add_plane(
                quadrics[edges[e, k]], sx / length, sy / length, sz / length,
                points[a, 0], points[a, 1], points[a, 2], weight,
            )  # fmt: skip


@inlined
def _best_place(p, q):
    """Return the point where the sum of two quadrics is least, and how much it is there.

    The matrices have full rank wherever there is any area, since distances from points are part of them.
    """
    a, b, c = p[0] + q[0], p[1] + q[1], p[2] + q[2]
    d, e, f = p[3] + q[3], p[4] + q[4], p[5] + q[5]
    r, s, t = p[6] + q[6], p[7] + q[7], p[8] + q[8]
    # LDLᵀ
    if not a > 0.0:
        return 0.0, 0.0, 0.0, -1.0
    l1, l2 = b / a, c / a
    d2 = d - l1 * b
    if not d2 > 0.0:
        return 0.0, 0.0, 0.0, -1.0
    l3 = (e - l1 * c) / d2
    d3 = f - l2 * c - l3 * (e - l1 * c)
    if not d3 > 0.0:
        return 0.0, 0.0, 0.0, -1.0
    y2 = s - l1 * r
    z = (t - l2 * r - l3 * y2) / d3
    y = y2 / d2 - l3 * z
    x = r / a - l1 * y - l2 * z
    return x, y, z, max(p[9] + q[9] - (r * x + s * y + t * z), 0.0)


@inlined
def _merged(points, quadrics, a, b):
    """Return where two vertices would meet, and what it costs."""
    x, y, z, cost = _best_place(quadrics[a], quadrics[b])
    if cost < 0.0:
        # nothing around has an area
        x = (points[a, 0] + points[b, 0]) / 2
        y = (points[a, 1] + points[b, 1]) / 2
        z = (points[a, 2] + points[b, 2]) / 2
        cost = 0.0
    return x, y, z, cost


@inner
def _sink(keys, entries, size, place):
    """Move an entry of the heap down to where it belongs."""
    key = keys[place]
    a, b, stamp = entries[place, 0], entries[place, 1], entries[place, 2]
    while True:
        child = 2 * place + 1
        if child >= size:
            break
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if not keys[child] < key:
            break
        keys[place] = keys[child]
        for k in range(3):
            entries[place, k] = entries[child, k]
        place = child
    keys[place] = key
    entries[place, 0], entries[place, 1], entries[place, 2] = a, b, stamp


@inner
def _push(keys, entries, size, key, a, b, stamp):
    """Put an entry into the heap, which has room for it."""
    place = size
    while place > 0:
        parent = (place - 1) // 2
        if not key < keys[parent]:
            break
        keys[place] = keys[parent]
        for k in range(3):
            entries[place, k] = entries[parent, k]
        place = parent
    keys[place] = key
    entries[place, 0], entries[place, 1], entries[place, 2] = a, b, stamp


@inner
def _heap_of(keys, entries, size, stamps):
    """Leave out what is stale and order the rest; returns how many entries there are."""
    kept = 0
    for i in range(size):
        if stamps[entries[i, 0]] + stamps[entries[i, 1]] == entries[i, 2]:
            keys[kept] = keys[i]
            for k in range(3):
                entries[kept, k] = entries[i, k]
            kept += 1
    for place in range(kept // 2 - 1, -1, -1):
        _sink(keys, entries, kept, place)
    return kept


@inner
def _prune(head, following, alive, v):
    """Leave out of the list of a vertex the corners of faces that are gone."""
    before, corner = -1, head[v]
    while corner >= 0:
        after = following[corner]
        if alive[corner // 3]:
            before = corner
        elif before < 0:
            head[v] = after
        else:
            following[before] = after
        corner = after


@inner
def _forget(faces, head, following, marks, v, first, second):
    """Set the marks of all corners around a vertex to 0; return whether one of its faces has both others as corners."""
    both, corner = False, head[v]
    while corner >= 0:
        f = corner // 3
        found = 0
        for k in range(3):
            w = faces[f, k]
            marks[w] = 0
            if w in (first, second):
                found += 1
        both = both or found == 2
        corner = following[corner]
    return both


@inner
def _allowed(faces, head, following, rim, seen, count, a, b):
    """Whether the surface stays what it is, topologically, if an edge is collapsed.

    The link condition: what both ends touch is the edge's faces alone, where a rim touches all that lies beyond.
    Writes to `seen` and `count`, which are 0 before and after.
    """
    shared, first, second = 0, -1, -1
    corner = head[a]
    while corner >= 0:
        f = corner // 3
        for k in range(3):
            w = faces[f, k]
            if w == b:
                shared += 1
            elif w != a:
                count[w] += 1
        corner = following[corner]
    common, fine, both_rims = 0, True, False
    corner = head[b]
    while corner >= 0:
        f = corner // 3
        has_a = faces[f, 0] == a or faces[f, 1] == a or faces[f, 2] == a
        for k in range(3):
            w = faces[f, k]
            if w in (a, b):
                continue
            if seen[w] == 0 and count[w] > 0:
                common += 1
            seen[w] += 1
            if has_a:
                if first < 0:
                    first = w
                elif second < 0:
                    second = w
        corner = following[corner]
    if first >= 0 and count[first] != 2 and seen[first] != 2:
        both_rims = True
    if second >= 0 and count[second] != 2 and seen[second] != 2:
        both_rims = True
    if common != shared or both_rims or (rim[a] and rim[b] and shared == 2):
        fine = False
    # two faces over the same edge on the far sides would come to lie on each other
    here = _forget(faces, head, following, count, a, first, second)
    there = _forget(faces, head, following, seen, b, first, second)
    return fine and not (here and there)


@inner
def _shared(faces, head, following, a, b):
    """Return how many faces an edge has."""
    result, corner = 0, head[a]
    while corner >= 0:
        f = corner // 3
        if b in (faces[f, 0], faces[f, 1], faces[f, 2]):
            result += 1
        corner = following[corner]
    return result


@inner
def _turns_over(points, faces, head, following, a, b, x, y, z):
    """Whether a face of `a` that `b` is no corner of turns too far or becomes a needle when `a` moves to a place."""
    corner = head[a]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        c, d = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
        corner = following[corner]
        if c == b or d == b:
            continue
        cx, cy, cz = points[c, 0], points[c, 1], points[c, 2]
        ex, ey, ez = points[d, 0] - cx, points[d, 1] - cy, points[d, 2] - cz
        ux, uy, uz = points[a, 0] - cx, points[a, 1] - cy, points[a, 2] - cz
        vx, vy, vz = x - cx, y - cy, z - cz
        ox, oy, oz = ey * uz - ez * uy, ez * ux - ex * uz, ex * uy - ey * ux
        nx, ny, nz = ey * vz - ez * vy, ez * vx - ex * vz, ex * vy - ey * vx
        old, new = np.sqrt(ox * ox + oy * oy + oz * oz), np.sqrt(nx * nx + ny * ny + nz * nz)
        if ox * nx + oy * ny + oz * nz < TURN * old * new:
            return True
        edge = ex * ex + ey * ey + ez * ez
        longest = max(edge, vx * vx + vy * vy + vz * vz, (vx - ex) ** 2 + (vy - ey) ** 2 + (vz - ez) ** 2)
        if new < 2 * NEEDLE * longest:
            before = max(edge, ux * ux + uy * uy + uz * uz, (ux - ex) ** 2 + (uy - ey) ** 2 + (uz - ez) ** 2)
            if new * before <= old * longest:
                return True
    return False


@kernel
def collapse(points, faces, quadrics, rim, edges, target, keep_topology, alive):
    """Collapse edges, the cheapest first, until `target` faces are left or no edge may be collapsed.

    Parameters
    ----------
    points : (n, 3) float64, faces : (m, 3) int32, quadrics : (n, 10) float64, rim : (n,) bool
        Written to. No face names a vertex twice.
    edges : (e, 2) int32
        All of them, each once.
    target
        Number of faces.
    keep_topology
        Whether only what changes no topology is collapsed.
    alive : (m,) bool
        All true; afterwards which faces are left.
    """
    n, m = len(points), len(faces)
    head = np.full(n, -1, np.int32)
    following = np.empty(3 * m, np.int32)
    for corner in range(3 * m - 1, -1, -1):
        v = faces[corner // 3, corner % 3]
        following[corner] = head[v]
        head[v] = corner
    stamps = np.zeros(n, np.int32)
    seen, count = np.zeros(n, np.int32), np.zeros(n, np.int32)
    room = 2 * len(edges) + 64
    keys, entries = np.empty(room, np.float32), np.empty((room, 3), np.int32)
    size = len(edges)
    for e in range(size):
        keys[e] = _merged(points, quadrics, edges[e, 0], edges[e, 1])[3]
        entries[e, 0], entries[e, 1], entries[e, 2] = edges[e, 0], edges[e, 1], 0
    size = _heap_of(keys, entries, size, stamps)
    left, progress = m, 0
    while left > target:
        if size == 0:
            if progress == 0:
                break
            # what was not allowed may be by now
            progress = 0
            for f in range(m):
                if alive[f]:
                    for k in range(3):
                        a, b = faces[f, k], faces[f, (k + 1) % 3]
                        # an edge of two faces is met twice, in both directions where they agree
                        if size < room and (a < b or (rim[a] and rim[b])):
                            keys[size] = _merged(points, quadrics, a, b)[3]
                            entries[size, 0], entries[size, 1], entries[size, 2] = a, b, stamps[a] + stamps[b]
                            size += 1
            size = _heap_of(keys, entries, size, stamps)
            continue
        a, b, stamp = entries[0, 0], entries[0, 1], entries[0, 2]
        size -= 1
        if size > 0:
            keys[0] = keys[size]
            for k in range(3):
                entries[0, k] = entries[size, k]
            _sink(keys, entries, size, 0)
        if stamps[a] + stamps[b] != stamp:
            continue
        _prune(head, following, alive, a)
        _prune(head, following, alive, b)
        if keep_topology:
            if not _allowed(faces, head, following, rim, seen, count, a, b):
                continue
        elif _shared(faces, head, following, a, b) == left:
            # something stays
            continue
        x, y, z, _ = _merged(points, quadrics, a, b)
        if _turns_over(points, faces, head, following, a, b, x, y, z) or _turns_over(
            points, faces, head, following, b, a, x, y, z
        ):
            continue
        progress += 1
        points[a, 0], points[a, 1], points[a, 2] = x, y, z
        for k in range(10):
            quadrics[a, k] += quadrics[b, k]
        rim[a] = rim[a] or rim[b]
        stamps[a] += 1
        stamps[b] = -(1 << 30)
        # the faces of both that are left become one list
        chain, corner = -1, head[b]
        while corner >= 0:
            after, f = following[corner], corner // 3
            if faces[f, 0] == a or faces[f, 1] == a or faces[f, 2] == a:
                alive[f] = False
                left -= 1
            else:
                faces[f, corner % 3] = a
                following[corner] = chain
                chain = corner
            corner = after
        corner = head[a]
        while corner >= 0:
            after = following[corner]
            if alive[corner // 3]:
                following[corner] = chain
                chain = corner
            corner = after
        head[a] = chain
        corner = chain
        while corner >= 0:
            for k in range(1, 3):
                w = faces[corner // 3, (corner % 3 + k) % 3]
                if seen[w] == 0:
                    seen[w] = 1
                    if size == room:
                        size = _heap_of(keys, entries, size, stamps)
                    if size == room:
                        more_keys, more_entries = np.empty(2 * room, np.float32), np.empty((2 * room, 3), np.int32)
                        more_keys[:room] = keys
                        more_entries[:room] = entries
                        keys, entries, room = more_keys, more_entries, 2 * room
                    cost = _merged(points, quadrics, a, w)[3]
                    _push(keys, entries, size, np.float32(cost), a, w, stamps[a] + stamps[w])
                    size += 1
            corner = following[corner]
        corner = chain
        while corner >= 0:
            for k in range(3):
                seen[faces[corner // 3, k]] = 0
            corner = following[corner]
    return left

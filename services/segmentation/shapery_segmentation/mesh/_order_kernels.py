"""Slots of a mesh: in the order of space, moved to others, and those of a mesh whose faces are cut into four."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.mesh._grid_kernels import measure_face
from shapery_segmentation.mesh._operation_kernels import following, origin, twin
from shapery_segmentation.mesh.arrays import AREA, FACE_TOP, NORMAL, ORIGIN, OUT, SCALE, TWIN, VERTEX_TOP
from shapery_segmentation.mesh.compiled import inner, kernel

DIGIT = 11
"""Bits that one pass of the radix sort looks at."""


@kernel
def space_order(points, cell, order):
    """Write an order of points in which neighbours in space are neighbours in memory (Z-order of cells).

    Parameters
    ----------
    points : (n, 3 or more) float64
    cell : float
        Edge of the cells.
    order : (n,) int64
        Receives it; points of one cell keep theirs.
    """
    n = points.shape[0]
    low = np.full(3, np.inf)
    for v in range(n):
        for axis in range(3):
            low[axis] = min(low[axis], points[v, axis])
    code = np.zeros(n, dtype=np.int64)
    largest = np.int64(0)
    for v in range(n):
        for axis in range(3):
            index = np.int64(np.floor((points[v, axis] - low[axis]) / cell))
            bit = 2 - axis
            while index > 0:
                code[v] |= (index & 1) << bit
                index >>= 1
                bit += 3
        largest = max(largest, code[v])
    other = np.empty(n, dtype=np.int64)
    for v in range(n):
        order[v] = v
    start = np.empty((1 << DIGIT) + 1, dtype=np.int64)
    shift = 0
    while largest >> shift > 0:
        start[:] = 0
        for v in range(n):
            start[((code[v] >> shift) & ((1 << DIGIT) - 1)) + 1] += 1
        for d in range(1 << DIGIT):
            start[d + 1] += start[d]
        for i in range(n):
            d = (code[order[i]] >> shift) & ((1 << DIGIT) - 1)
            other[start[d]] = order[i]
            start[d] += 1
        order[:] = other
        shift += DIGIT


@kernel
def transfer(m, new, vertices, faces):
    """Copy a mesh into empty arrays, slot by slot.

    Parameters
    ----------
    m, new : MeshArrays
        The layout of `new` says already how many vertices and faces it has.
    vertices, faces : (n,), (f,) int64
        The slots in `m`, all of them in use, of what becomes the first, second, … of `new`.
    """
    number = np.empty(m.vertices.shape[0], dtype=np.int64)
    place = np.empty(m.links.shape[0], dtype=np.int64)
    for v in range(vertices.shape[0]):
        number[vertices[v]] = v
        for column in range(4):
            new.points[v, column] = m.points[vertices[v], column]
    for f in range(faces.shape[0]):
        place[faces[f]] = f
    # From the back, so that each vertex is left with the first half-edge that starts at it.
    for f in range(faces.shape[0] - 1, -1, -1):
        for k in range(2, -1, -1):
            h = 3 * faces[f] + k
            t = twin(m, h)
            v = number[origin(m, h)]
            new.half_edges[3 * f + k, ORIGIN] = v
            new.half_edges[3 * f + k, TWIN] = 3 * place[t // 3] + t % 3
            new.vertices[v, OUT] = 3 * f + k
        measure_face(new, f)


@kernel
def cut_into_four(m, new, parents):
    """Write a mesh without free slots, every face of it cut into four, into empty arrays.

    The new vertices come after the old ones, in the order of the lesser half-edge of their edge; of F faces those at
    the first, second and third corner come first, F of each, then those in the middle.

    Parameters
    ----------
    m, new : MeshArrays
        As in `transfer`.
    parents : (n, 2) int32
        Receives for every vertex of `new` the ends of its edge in `m`, or twice the vertex itself.
    """
    count, faces = m.layout[VERTEX_TOP], m.layout[FACE_TOP]
    for v in range(count):
        parents[v, 0] = parents[v, 1] = v
        for column in range(4):
            new.points[v, column] = m.points[v, column]
    middle = np.empty(3 * faces, dtype=np.int64)
    for h in range(3 * faces):
        t = twin(m, h)
        if t < h:
            middle[h] = middle[t]
            continue
        u, v = origin(m, h), origin(m, following(h))
        for axis in range(3):
            new.points[count, axis] = np.float64(np.float32(0.5 * (m.points[u, axis] + m.points[v, axis])))
        new.points[count, SCALE] = min(m.points[u, SCALE], m.points[v, SCALE])
        parents[count, 0], parents[count, 1] = u, v
        middle[h] = count
        count += 1
    for f in range(faces):
        for k in range(3):
            after, before = (k + 1) % 3, (k + 2) % 3
            # The quarter at corner k: its own corner at place k, the middles of the sides that meet there beside it.
            own, inside = 3 * (k * faces + f), 3 * (3 * faces + f)
            new.half_edges[own + k, ORIGIN] = origin(m, 3 * f + k)
            new.half_edges[own + after, ORIGIN] = middle[3 * f + k]
            new.half_edges[own + before, ORIGIN] = middle[3 * f + before]
            # Its side across runs from the middle of side k to that of the side before, in the inner quarter back.
            new.half_edges[inside + k, ORIGIN] = middle[3 * f + k]
            new.half_edges[own + after, TWIN] = inside + before
            new.half_edges[inside + before, TWIN] = own + after
            # Side k has its first half here, and its second in the quarter at the next corner.
            t = twin(m, 3 * f + k)
            g, j = t // 3, t % 3
            far = (j + 1) % 3
            new.half_edges[own + k, TWIN] = 3 * (far * faces + g) + j
            new.half_edges[3 * (after * faces + f) + k, TWIN] = 3 * (j * faces + g) + j
    for h in range(12 * faces):
        new.vertices[origin(new, h), OUT] = h


@inner
def _first_of(link, v):
    """Return the vertex that stands for the part of `v`, and bring what lies on the way nearer to it."""
    while link[v] != v:
        link[v] = link[link[v]]
        v = np.int64(link[v])
    return v


@kernel
def part_volumes(m):
    """Return the volume that each part of the surface encloses that hangs together."""
    top = m.layout[VERTEX_TOP]
    # Face by face, which lie in memory as they do in space, vertices are led to the first of their part.
    link = np.arange(top).astype(np.int32)
    for f in range(m.layout[FACE_TOP]):
        if origin(m, 3 * f) < 0:
            continue
        first = _first_of(link, origin(m, 3 * f))
        for k in range(1, 3):
            other = _first_of(link, origin(m, 3 * f + k))
            link[max(first, other)] = min(first, other)
            first = min(first, other)
    part = np.empty(top, dtype=np.int32)
    parts = 0
    for v in range(top):
        if m.vertices[v, OUT] < 0:
            continue
        if link[v] == v:
            part[v] = parts
            parts += 1
        else:
            part[v] = part[_first_of(link, v)]
    volumes = np.zeros(parts)
    about = np.zeros((parts, 3))
    begun = np.zeros(parts, dtype=np.bool_)
    for f in range(m.layout[FACE_TOP]):
        v = origin(m, 3 * f)
        if v < 0:
            continue
        p = part[v]
        if not begun[p]:
            begun[p] = True
            for axis in range(3):
                about[p, axis] = m.points[v, axis]
        height = 0.0
        for axis in range(3):
            height += (m.facets[f, axis] - about[p, axis]) * m.facets[f, NORMAL + axis]
        volumes[p] += m.facets[f, AREA] * height / 3.0
    return volumes

"""Compiled loops of `shapery_geometry.bvh`."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def face_boxes(vertices, faces):
    """(m, 6) least and largest coordinates of each face."""
    boxes = np.empty((len(faces), 6))
    for i in range(len(faces)):
        for axis in range(3):
            a = vertices[faces[i, 0], axis]
            b = vertices[faces[i, 1], axis]
            c = vertices[faces[i, 2], axis]
            boxes[i, axis] = min(a, b, c)
            boxes[i, axis + 3] = max(a, b, c)
    return boxes


@njit(cache=True, nogil=True)
def _spread(x):
    """Put two zero bits between the lower 21 bits of `x`."""
    x = x & np.uint64(0x1FFFFF)
    x = (x | (x << np.uint64(32))) & np.uint64(0x1F00000000FFFF)
    x = (x | (x << np.uint64(16))) & np.uint64(0x1F0000FF0000FF)
    x = (x | (x << np.uint64(8))) & np.uint64(0x100F00F00F00F00F)
    x = (x | (x << np.uint64(4))) & np.uint64(0x10C30C30C30C30C3)
    return (x | (x << np.uint64(2))) & np.uint64(0x1249249249249249)


@njit(cache=True, nogil=True)
def morton_codes(boxes):
    """(m,) position of each box's centre on a space-filling curve of 2²¹ cells a side."""
    codes = np.empty(len(boxes), dtype=np.uint64)
    low = np.full(3, np.inf)
    high = np.full(3, -np.inf)
    for i in range(len(boxes)):
        for axis in range(3):
            centre = 0.5 * boxes[i, axis] + 0.5 * boxes[i, axis + 3]
            low[axis] = min(low[axis], centre)
            high[axis] = max(high[axis], centre)
    extent = max(high[0] - low[0], high[1] - low[1], high[2] - low[2])
    scale = 2097151.0 / extent if extent > 0 else 0.0
    for i in range(len(boxes)):
        code = np.uint64(0)
        for axis in range(3):
            centre = 0.5 * boxes[i, axis] + 0.5 * boxes[i, axis + 3]
            cell = min(max((centre - low[axis]) * scale, 0.0), 2097151.0)
            code |= _spread(np.uint64(cell)) << np.uint64(axis)
        codes[i] = code
    return codes


@njit(cache=True, nogil=True)
def split_order(boxes, leaf_size):
    """(m,) boxes in the order of a tree that is split across its longest side at every node.

    The left side of each node is full, as `node_boxes` wants it.
    """
    m = len(boxes)
    order = np.arange(m)
    centres = boxes[:, :3] + boxes[:, 3:]
    keys = np.empty(m)
    width = 1
    while width * leaf_size < m:
        width *= 2
    starts, ends, widths = np.empty(64, np.int64), np.empty(64, np.int64), np.empty(64, np.int64)
    starts[0], ends[0], widths[0] = 0, m, width
    top = 1
    while top > 0:
        top -= 1
        a, b, leaves = starts[top], ends[top], widths[top]
        if b - a <= leaf_size:
            continue
        half = leaves // 2 * leaf_size
        if b - a <= half:
            starts[top], ends[top], widths[top] = a, b, leaves // 2
            top += 1
            continue
        axis, longest = 0, -1.0
        for k in range(3):
            low, high = np.inf, -np.inf
            for i in range(a, b):
                value = centres[order[i], k]
                low, high = min(low, value), max(high, value)
            if high - low > longest:
                axis, longest = k, high - low
        for i in range(a, b):
            keys[i] = centres[order[i], axis]
        order[a:b] = order[a:b][np.argsort(keys[a:b], kind="mergesort")]
        for begin, end in ((a + half, b), (a, a + half)):
            starts[top], ends[top], widths[top] = begin, end, leaves // 2
            top += 1
    return order


@njit(cache=True, nogil=True)
def node_boxes(boxes, order, leaf_size, first_leaf):
    """(2 · first_leaf + 1, 6) boxes of a complete binary tree whose leaves hold the ordered boxes."""
    nodes = np.empty((2 * first_leaf + 1, 6))
    for node in range(len(nodes)):
        for axis in range(3):
            nodes[node, axis] = np.inf
            nodes[node, axis + 3] = -np.inf
    for i in range(len(order)):
        node = first_leaf + i // leaf_size
        for axis in range(3):
            nodes[node, axis] = min(nodes[node, axis], boxes[order[i], axis])
            nodes[node, axis + 3] = max(nodes[node, axis + 3], boxes[order[i], axis + 3])
    for node in range(first_leaf - 1, -1, -1):
        for axis in range(3):
            nodes[node, axis] = min(nodes[2 * node + 1, axis], nodes[2 * node + 2, axis])
            nodes[node, axis + 3] = max(nodes[2 * node + 1, axis + 3], nodes[2 * node + 2, axis + 3])
    return nodes

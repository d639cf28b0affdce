"""Compiled loop of `shapery_geometry.mesh_io.ply`: where each list of a binary file begins."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def list_positions(data, start, rows, item_bytes, count_bytes, wanted, big_endian):
    """Walk the rows of an element whose lists have differing lengths.

    Property p is a scalar of ``item_bytes[p]`` where ``count_bytes[p]`` is 0, else a list of such items after a count.
    Return for each row position and length of the list `wanted`, and the position after the last row: −1 where the
    data end before, −2 for a length with the highest bit set, which no sane file has.
    """
    positions = np.empty(rows, dtype=np.int64)
    counts = np.empty(rows, dtype=np.int64)
    at = start
    for row in range(rows):
        for p in range(len(item_bytes)):
            width = count_bytes[p]
            if width == 0:
                at += item_bytes[p]
                continue
            if at + width > len(data):
                return positions, counts, -1
            count = np.int64(0)
            for k in range(width):
                byte = np.int64(data[at + k])
                if big_endian:
                    count = (count << 8) | byte
                else:
                    count |= byte << (8 * k)
            if width == 4 and count >= 1 << 31:
                return positions, counts, -2
            at += width
            if p == wanted:
                positions[row] = at
                counts[row] = count
            at += count * item_bytes[p]
        if at > len(data):
            return positions, counts, -1
    return positions, counts, at

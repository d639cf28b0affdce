"""Which faces are near a point: what a search reads of each, sorted by the cell of a grid that their centroids lie in.

Built anew for every few steps of a flow, because a query reads what it compares in a few runs of memory. The grid
repeats itself in space: a cell's coordinates are taken modulo powers of two, so it needs no bounds, and what is far
away in the same cell costs a comparison and nothing else. Its size follows the region that the mesh fills.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.mesh.arrays import (
    COPIED,
    FACE_TOP,
    INVERSE_CELL,
    LARGEST_RADIUS,
    MASK,
    NORMAL,
    ORIGIN,
    RADIUS,
    SHIFT,
)
from shapery_segmentation.mesh.compiled import inlined, inner, kernel

ANY = 2.0
"""More than any product of two unit normals."""


@inner
def _cell(layout, inverse, x, y, z):
    """Return the number of the cell that holds a point."""
    i = np.int64(np.floor(x * inverse)) & layout[MASK]
    j = np.int64(np.floor(y * inverse)) & layout[MASK + 1]
    k = np.int64(np.floor(z * inverse)) & layout[MASK + 2]
    return (i << layout[SHIFT]) | (j << layout[SHIFT + 1]) | k


@inner
def sort_faces(m, cells):
    """Do what `sort_into_cells` says."""
    inverse = m.bound[INVERSE_CELL]
    facets = m.facets
    start = cells.start
    start[:] = 0
    largest = 0.0
    # Until it is sorted, a face's place holds its cell.
    for f in range(m.layout[FACE_TOP]):
        if m.half_edges[3 * f, ORIGIN] >= 0:
            c = _cell(m.layout, inverse, facets[f, 0], facets[f, 1], facets[f, 2])
            cells.place[f] = c
            start[c] += 1
            largest = max(largest, facets[f, RADIUS])
    m.bound[LARGEST_RADIUS] = largest
    total = 0
    for c in range(start.shape[0]):
        total += start[c]
        start[c] = total
    # From the back, so that every cell's counter ends at its beginning and faces keep their order.
    for f in range(m.layout[FACE_TOP] - 1, -1, -1):
        if m.half_edges[3 * f, ORIGIN] >= 0:
            c = cells.place[f]
            at = start[c] - 1
            start[c] = at
            cells.names[at] = f
            cells.place[f] = at
            for k in range(COPIED):
                cells.records[at, k] = facets[f, k]


@inlined
def note_face(m, cells, f):
    """Bring the record of face `f`, which is sorted, up to date."""
    at = cells.place[f]
    for k in range(COPIED):
        cells.records[at, k] = m.facets[f, k]


@kernel
def sort_into_cells(m, cells):
    """Sort the faces in use by cell (a counting sort).

    Parameters
    ----------
    m : MeshArrays
        Its ``layout`` and ``bound`` hold the size of the grid; the largest radius is brought up to date.
    cells : Cells
        Receives them.
    """
    sort_faces(m, cells)


@inner
def gather(layout, bound, cells, p, radius, whole, n, limit, found):
    """Collect the faces near a point that are turned away from a direction.

    Parameters
    ----------
    layout, bound
        Of the mesh.
    cells : Cells
        From `sort_into_cells`.
    p : (float, float, float)
    radius : float
        Distance from `p` within which a face counts.
    whole : float
        1: its bounding sphere, 0: its centre has to be that near.
    n : (float, float, float)
        Unit vector.
    limit : float
        Only faces count whose normal's product with `n` is less; `ANY`: all.
    found : (n,) int32
        Receives their numbers; must be as long as there are faces.

    Returns
    -------
    int
        How many there are.
    """
    start, records, names = cells.start, cells.records, cells.names
    inverse = bound[INVERSE_CELL]
    reach = radius + whole * bound[LARGEST_RADIUS]
    mx, my, mz = layout[MASK], layout[MASK + 1], layout[MASK + 2]
    sx, sy = layout[SHIFT], layout[SHIFT + 1]
    x0, x1 = np.int64(np.floor((p[0] - reach) * inverse)), np.int64(np.floor((p[0] + reach) * inverse))
    y0, y1 = np.int64(np.floor((p[1] - reach) * inverse)), np.int64(np.floor((p[1] + reach) * inverse))
    z0, z1 = np.int64(np.floor((p[2] - reach) * inverse)), np.int64(np.floor((p[2] + reach) * inverse))
    # Where the reach exceeds the period, every cell is visited once.
    x1, y1, z1 = min(x1, x0 + mx), min(y1, y0 + my), min(z1, z0 + mz)
    px, py, pz = np.float32(p[0]), np.float32(p[1]), np.float32(p[2])
    nx, ny, nz = np.float32(n[0]), np.float32(n[1]), np.float32(n[2])
    # Rounding to float32 must not lose a face.
    radius32 = np.float32(radius + 1e-6 * (abs(p[0]) + abs(p[1]) + abs(p[2])))
    whole32, limit32 = np.float32(whole), np.float32(limit)
    first = z0 & mz
    last = first + (z1 - z0)
    count = 0
    cell = 1.0 / inverse
    for x in range(x0, x1 + 1):
        # How far the row of cells is away; where the reach exceeds the period, it is somewhere else, too.
        wide = max(x * cell - p[0], p[0] - (x + 1) * cell, 0.0) if x1 - x0 < mx else 0.0
        for y in range(y0, y1 + 1):
            high = max(y * cell - p[1], p[1] - (y + 1) * cell, 0.0) if y1 - y0 < my else 0.0
            if wide * wide + high * high > reach * reach:
                continue
            row = ((x & mx) << sx) | ((y & my) << sy)
            # The cells of a row are neighbours in memory, except where it runs over the end of the period.
            for part in range(2):
                if part == 0:
                    a, b = start[row + first], start[row + min(last, mz) + 1]
                elif last > mz:
                    a, b = start[row], start[row + (last & mz) + 1]
                else:
                    break
                for i in range(a, b):
                    dx, dy, dz = records[i, 0] - px, records[i, 1] - py, records[i, 2] - pz
                    near = radius32 + whole32 * records[i, RADIUS]
                    turn = nx * records[i, NORMAL] + ny * records[i, NORMAL + 1] + nz * records[i, NORMAL + 2]
                    # Without branches, which could not be foreseen.
                    found[count] = names[i]
                    count += (dx * dx + dy * dy + dz * dz <= near * near) & (turn < limit32)
    return count

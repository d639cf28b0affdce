"""Which faces are near a point: their bounding spheres, sorted by the cell of a grid that their centres lie in.

Built anew for every step of a flow, because a query reads what it compares in a few runs of memory. The grid repeats
itself in space: a cell's coordinates are taken modulo powers of two, so it needs no bounds, and what is far away in the
same cell costs a comparison and nothing else. Its size follows the region that the mesh fills.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from shapery_segmentation.mesh.arrays import FACE_TOP, INVERSE_CELL, LARGEST_RADIUS, MASK, ORIGIN, RADIUS, SHIFT
from shapery_segmentation.mesh.compiled import inner, kernel


@inner
def _cell(layout, inverse, x, y, z):
    """Return the number of the cell that holds a point."""
    i = np.int64(np.floor(x * inverse)) & layout[MASK]
    j = np.int64(np.floor(y * inverse)) & layout[MASK + 1]
    k = np.int64(np.floor(z * inverse)) & layout[MASK + 2]
    return (i << layout[SHIFT]) | (j << layout[SHIFT + 1]) | k


@inner
def sort_faces(m, start, spheres, names):
    """Do what `sort_into_cells` says."""
    inverse = m.bound[INVERSE_CELL]
    facets = m.facets
    start[:] = 0
    largest = 0.0
    for f in range(m.layout[FACE_TOP]):
        if m.half_edges[3 * f, ORIGIN] >= 0:
            start[_cell(m.layout, inverse, facets[f, 0], facets[f, 1], facets[f, 2])] += 1
            largest = max(largest, facets[f, RADIUS])
    m.bound[LARGEST_RADIUS] = largest
    total = 0
    for c in range(start.shape[0]):
        total += start[c]
        start[c] = total
    # From the back, so that every cell's counter ends at its beginning and faces keep their order.
    for f in range(m.layout[FACE_TOP] - 1, -1, -1):
        if m.half_edges[3 * f, ORIGIN] >= 0:
            c = _cell(m.layout, inverse, facets[f, 0], facets[f, 1], facets[f, 2])
            at = start[c] - 1
            start[c] = at
            names[at] = f
            for k in range(4):
                spheres[at, k] = facets[f, k]


@kernel
def sort_into_cells(m, start, spheres, names):
    """Sort the faces in use by cell (a counting sort).

    Parameters
    ----------
    m : MeshArrays
        Its ``layout`` and ``bound`` hold the size of the grid; the largest radius is brought up to date.
    start : (C + 1,) int32
        Receives where the faces of each cell begin in the next two.
    spheres : (F, 4) float32
        Receives centre and radius.
    names : (F,) int32
        Receives the faces' numbers.
    """
    sort_faces(m, start, spheres, names)


@inner
def gather(layout, bound, start, spheres, names, p, radius, whole, found):
    """Collect the faces near a point.

    Parameters
    ----------
    layout, bound
        Of the mesh.
    start, spheres, names
        From `sort_into_cells`.
    p : (float, float, float)
    radius : float
        Distance from `p` within which a face counts.
    whole : float
        1: its bounding sphere, 0: its centre has to be that near.
    found : (n,) int32
        Receives their numbers; must be as long as there are faces.

    Returns
    -------
    int
        How many there are.
    """
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
    # Rounding to float32 must not lose a face.
    radius32 = np.float32(radius + 1e-6 * (abs(p[0]) + abs(p[1]) + abs(p[2])))
    whole32 = np.float32(whole)
    first = z0 & mz
    last = first + (z1 - z0)
    n = 0
    for x in range(x0, x1 + 1):
        for y in range(y0, y1 + 1):
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
                    dx, dy, dz = spheres[i, 0] - px, spheres[i, 1] - py, spheres[i, 2] - pz
                    near = radius32 + whole32 * spheres[i, 3]
                    if dx * dx + dy * dy + dz * dz <= near * near:
                        found[n] = names[i]
                        n += 1
    return n

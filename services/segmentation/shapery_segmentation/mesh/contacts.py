"""Whether faces touch others than they should: those that moved, or all of a surface, in two halves at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.concurrent import in_halves
from shapery_segmentation.mesh import _motion_kernels as motion
from shapery_segmentation.mesh import _whole_kernels as whole
from shapery_segmentation.mesh.arrays import FACE_COUNT, FACE_TOP, LARGEST_RADIUS, VERTEX_TOP, Cells, MeshArrays, Moves

MANY = 4000
"""Faces from which on a second thread saves more than it costs."""


def measure(arrays: MeshArrays, cells: Cells, moves: Moves, batch: int) -> None:
    """Measure the faces whose vertices have moved since `batch` began.

    Parameters
    ----------
    arrays
    cells
        The faces, sorted; what is noted of them is brought up to date.
    moves
    batch
        The stamp of the vertices that moved. The faces get it, too.
    """
    before = float(arrays.bound[LARGEST_RADIUS])

    def measured(first: int, end: int) -> float:
        return float(motion.measure_moved(arrays, cells, moves, batch, first, end))

    largest = in_halves(measured, int(arrays.layout[FACE_TOP]), MANY)
    # Each half may have written over what the other did.
    arrays.bound[LARGEST_RADIUS] = max(before, *largest)


def verify(arrays: MeshArrays, cells: Cells, moves: Moves, batch: int, clear: NDArray[np.int8], drift: float) -> int:
    """Test all that moved since `batch` began; put back what turned over, degenerated or touches another face.

    Parameters
    ----------
    arrays
    cells
        The faces, brought up to date with every move.
    moves
    batch
        The stamp of what moved. Afterwards ``moves.state`` of the vertices that were put back is −`batch`.
    clear : (V,) int8
        Where this is given, not everything is tested: of faces that share no vertex, those whose vertices all have 1
        here are left out, and pairs whose normals look the same way (`_motion_kernels.OPPOSED`); of stars, those around
        a 1. Whoever gives it has to ask `find_contacts` in the end.
    drift
        How far in mm faces may be from where they were sorted. If that is far, they are sorted anew.

    Returns
    -------
    How many were put back; ``moves.queue`` names them.

    Notes
    -----
    Every star and every face that changed is tested; where two faces touch, the movers of both go back to where they
    were when `batch` began, and what is around these is tested again, until nothing touches. Vertices only ever go
    back, so this ends, in the worst case in the state at the beginning, which was free of contacts. What lies between
    does not matter: any number of moves can be verified at once.
    """
    drift, slack = motion.make_ready(arrays, cells, moves, drift)

    def suspects(first: int, end: int) -> tuple[int, int]:
        room = moves.found[min(first, 1)]
        wrong, stars = motion.find_suspects(arrays, cells, moves, batch, clear, drift, first, end, room)
        return int(wrong), int(stars)

    top = int(arrays.layout[FACE_TOP])
    parts = in_halves(suspects, top, MANY)
    middle = top // 2
    if len(parts) == 1:
        parts.append((top, 3 * top))
        middle = top
    (wrong, stars), (more_wrong, more_stars) = parts
    back = motion.put_back(arrays, cells, moves, batch, clear, slack, middle, (wrong, more_wrong), (stars, more_stars))
    return int(back)


def find_contacts(arrays: MeshArrays, cells: Cells, concerned: NDArray[np.bool_]) -> int:
    """Return how many pairs of faces have more in common than they share.

    Parameters
    ----------
    arrays, cells
        Mesh and its faces sorted by cell.
    concerned : (V,) bool
        Receives true for the vertices of faces that touch others. If it is empty, the first that does ends the search,
        and what is returned only tells whether there is one.
    """

    def among_faces(first: int, end: int) -> int:
        return int(whole.find_contacts(arrays, cells, first, end, concerned))

    def in_stars(first: int, end: int) -> int:
        return int(whole.find_star_contacts(arrays, first, end, concerned))

    faces, vertices = int(arrays.layout[FACE_COUNT]), int(arrays.layout[VERTEX_TOP])
    return sum(in_halves(among_faces, faces, MANY)) + sum(in_halves(in_stars, vertices, MANY))

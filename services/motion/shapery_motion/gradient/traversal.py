"""The order in which faces and vertices are coded, and what predicts each of them; from the connectivity alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import IntArray
from shapery_motion.gradient import _traversal_kernels as kernels

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Traversal:
    """A walk over the faces, breadth first across their sides, from the face of least number of each part on.

    Each face is followed by those across its sides, in the order of the sides. Where more than two faces share an edge
    they follow each other in a ring, by number. Vertices are placed when the walk first finds them; those without a
    face come last, by number.
    """

    across: IntArray
    """(m, 3) the face across each side, from corner k to corner k + 1; −1 at a boundary."""
    face_order: IntArray
    """(m,) the faces as they are visited."""
    parents: IntArray
    """(m,) the face from which each was found; −1 for the first of a part."""
    ranks: IntArray
    """(m,) when each face is visited."""
    vertex_order: IntArray
    """(n,) the vertices as they are placed."""
    predictors: IntArray
    """(n, 3) for each vertex those a, b, c that predict it as a + b − c (the parallelogram across the side that led
    here), or a alone, where b and c are −1; all are −1 for the very first."""

    def residuals(self, values: NDArray[Any]) -> Integers:
        """Return the differences (n, 3) of whole numbers from their predictions, in coding order."""
        result = np.empty((len(self.vertex_order), 3), dtype=np.int64)
        kernels.to_residuals(values, self.vertex_order, self.predictors, result)
        return result

    def values(self, residuals: Integers) -> Integers:
        """Return the whole numbers (n, 3) whose differences in coding order are given."""
        result = np.empty((len(self.vertex_order), 3), dtype=np.int64)
        kernels.from_residuals(residuals, self.vertex_order, self.predictors, result)
        return result


def traverse(faces: IntArray, vertex_count: int) -> Traversal:
    """Walk over a mesh of n vertices and the faces (m, 3)."""
    across = _across(faces)
    face_order, parents, vertex_order, predictors = kernels.walk(faces, across, vertex_count)
    ranks = np.empty(len(faces), dtype=np.int32)
    ranks[face_order] = np.arange(len(faces), dtype=np.int32)
    return Traversal(across, face_order, parents, ranks, vertex_order, predictors)


def _across(faces: IntArray) -> IntArray:
    if not len(faces):
        return np.zeros((0, 3), dtype=np.int32)
    sides = np.sort(np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2).astype(np.int64), axis=1)
    keys = sides[:, 0] << 32 | sides[:, 1]
    order = np.argsort(keys, kind="stable")
    starts = np.flatnonzero(np.diff(keys[order], prepend=-1))
    following = np.roll(order, -1)
    # the last of each ring is followed by its first
    following[np.append(starts[1:], len(order)) - 1] = order[starts]
    result = np.full(len(order), -1, dtype=np.int64)
    result[order] = following
    alone = result == np.arange(len(order))
    return np.asarray(np.where(alone, -1, result // 3).reshape(-1, 3), dtype=np.int32)

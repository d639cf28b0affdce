"""A tree of boxes around the faces of a mesh, for questions of the kind "which faces are near this?"."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_geometry import _bvh_kernels
from shapery_geometry.mesh import TriangleMesh

LEAF_SIZE = 4
"""Faces in a leaf; with fewer the tree grows, with more each leaf tests more faces in vain."""
SPLIT_FACES = 50_000
"""So many faces are sorted by splitting nodes across their longest side; more of them along a space-filling curve."""


@dataclass(frozen=True, eq=False)
class FaceTree:
    """A complete binary tree of axis-aligned boxes over faces.

    Node k has the children 2k + 1 and 2k + 2; leaf number l is node ``first_leaf + l`` and holds the faces
    ``order[l * LEAF_SIZE : (l + 1) * LEAF_SIZE]``. Leaves behind the last face have empty boxes (low +inf, high −inf).
    """

    order: NDArray[np.int64]
    """(m,) faces as they lie in the leaves."""
    boxes: NDArray[np.float64]
    """(m, 6) least and largest coordinates of each face, in the order of the mesh."""
    nodes: NDArray[np.float64]
    """(2 · first_leaf + 1, 6) boxes of the nodes."""
    first_leaf: int


def build_face_tree(mesh: TriangleMesh) -> FaceTree:
    """Build the tree of a mesh in O(m log m), or O(m log² m) where that is little and makes questions cheaper."""
    boxes = _bvh_kernels.face_boxes(mesh.vertices, mesh.faces)
    if len(boxes) <= SPLIT_FACES:
        order = _bvh_kernels.split_order(boxes, LEAF_SIZE)
    else:
        order = np.argsort(_bvh_kernels.morton_codes(boxes), kind="stable")
    leaves = max(1, -(-len(order) // LEAF_SIZE))
    first_leaf = (1 << (leaves - 1).bit_length()) - 1
    nodes = _bvh_kernels.node_boxes(boxes, order, LEAF_SIZE, first_leaf)
    return FaceTree(order, boxes, nodes, first_leaf)

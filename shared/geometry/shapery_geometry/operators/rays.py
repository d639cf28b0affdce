"""Where rays meet a surface.

References
----------
T. Möller, B. Trumbore, Fast, minimum storage ray/triangle intersection, Journal of Graphics Tools 2(1), 1997,
doi:10.1080/10867651.1997.10487468.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapery_geometry.bvh import LEAF_SIZE, FaceTree, build_face_tree
from shapery_geometry.mesh import TriangleMesh, checked_vertices
from shapery_geometry.operators import _ray_kernels as kernels


def first_hits(
    mesh: TriangleMesh,
    origins: ArrayLike,
    directions: ArrayLike,
    *,
    beyond: float = 0.0,
    tree: FaceTree | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return how far each ray runs until it meets the mesh, from either side of a face.

    Parameters
    ----------
    mesh
        Any mesh.
    origins, directions : (k, 3) float64
        In the frame of the mesh. Distances are in lengths of the directions, which are usually unit vectors.
    beyond
        Hits at most this far from the origin do not count: for rays that start on the surface.
    tree
        From `shapery_geometry.bvh.build_face_tree`, for several calls with one mesh.

    Returns
    -------
    distances : (k,) float64
        Infinite where nothing is met.
    faces : (k,) int32
        The face that is met, or −1.
    """
    start, along = checked_vertices(origins), checked_vertices(directions)
    if start.shape != along.shape:
        raise ValueError(f"{len(start)} origins do not fit {len(along)} directions")
    if not len(mesh.faces):
        return np.full(len(start), np.inf), np.full(len(start), -1, dtype=np.int32)
    tree = build_face_tree(mesh) if tree is None else tree
    distances, faces = kernels.first_hits(
        start, along, np.full(len(start), beyond), kernels.in_leaf_order(mesh.vertices, mesh.faces, tree.order),
        tree.order, tree.nodes, tree.first_leaf, LEAF_SIZE,
    )  # fmt: skip
    return np.asarray(distances), np.asarray(faces)

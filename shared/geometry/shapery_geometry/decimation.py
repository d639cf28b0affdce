"""Fewer faces for the same shape, by quadric edge collapse.

Beside the distance from the planes of the faces that a vertex stands for, its quadric holds a little of the distance
from their middles. So it has one minimum even where the surface is flat, and there the vertices spread evenly, as in
a clustering of the surface; where it bends, the planes decide.

References
----------
M. Garland, P. S. Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997,
doi:10.1145/258734.258849.
P. Trettner, L. Kobbelt, Fast and robust QEF minimization using probabilistic quadrics, Computer Graphics Forum 39(2),
2020, doi:10.1111/cgf.13933.
T. K. Dey, H. Edelsbrunner, S. Guha, D. V. Nekhayev, Topology preserving edge contraction, Publications de l'Institut
Mathématique 66, 1999.
"""

from __future__ import annotations

import numpy as np

from shapery_geometry import _decimation_kernels as kernels
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.repair import drop_degenerate_faces

EVENNESS = 3e-4
"""Weight of the squared distance from the middles of faces, beside 1 for that from their planes."""
RIM = 1.0
"""Weight of the planes that hold a rim in place: for each edge its squared length, beside the area of faces."""


def decimate(mesh: TriangleMesh, faces: int, *, keep_topology: bool = True) -> TriangleMesh:
    """Return the mesh with about `faces` faces.

    Parameters
    ----------
    mesh
        Best welded and oriented.
    faces
        How many to keep at most. A mesh that has no more is returned as it is. The work may stop earlier: where
        topology is kept, or where every face that is left would turn over.
    keep_topology
        Whether handles, components and holes are kept. Otherwise they are for as long as there is something else to
        collapse.

    Returns
    -------
    The vertices that are left, in their order.

    Raises
    ------
    ValueError
        For fewer than four faces.
    """
    if faces < 4:
        raise ValueError(f"a closed surface has 4 faces at least, not {faces}")
    if len(mesh.faces) <= faces:
        return mesh
    reduced = _collapsed(mesh, faces, keep_topology=True)
    if len(reduced.faces) > faces and not keep_topology:
        reduced = _collapsed(reduced, faces, keep_topology=False)
    return reduced


def _collapsed(mesh: TriangleMesh, faces: int, *, keep_topology: bool) -> TriangleMesh:
    mesh = drop_degenerate_faces(mesh).mesh
    topology, left = mesh.topology, np.array(mesh.faces)
    centre, scale = mesh.vertices.mean(axis=0), max(mesh.diagonal, 1e-300)
    points = (mesh.vertices - centre) / scale
    # a rim is where an edge has not two faces
    on_rim = np.flatnonzero(topology.edge_face_counts != 2)
    one_face = np.empty(len(topology.edges), dtype=np.int32)
    one_face[topology.face_edges] = np.arange(len(left), dtype=np.int32)[:, None]
    rim = np.zeros(len(points), dtype=bool)
    rim[topology.edges[on_rim]] = True
    quadrics = np.zeros((len(points), 10))
    kernels.vertex_quadrics(points, left, topology.edges[on_rim], one_face[on_rim], EVENNESS, RIM, quadrics)
    alive = np.ones(len(left), dtype=bool)
    kernels.collapse(points, left, quadrics, rim, topology.edges, faces, keep_topology, alive)
    left = left[alive]
    used = np.zeros(len(points), dtype=bool)
    used[left] = True
    places = np.cumsum(used) - 1
    return TriangleMesh(points[used] * scale + centre, places[left])

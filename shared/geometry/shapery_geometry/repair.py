"""What is wrong with a mesh, told; and repairs that say what they did.

No step moves a vertex, closes a hole or guesses a surface. Each does the one thing that its name says and returns, with
the mesh, how many elements it touched and where vertices and faces have gone.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from shapery_contracts.errors import InvalidInput
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import TriangleMesh


@dataclass(frozen=True, slots=True)
class MeshReport:
    """The state of a mesh; all numbers but the first two and the last are counts of faults."""

    vertices: int
    faces: int
    duplicate_vertices: int
    """Vertices at exactly the same place as an earlier one."""
    unreferenced_vertices: int
    """Vertices that no face uses."""
    degenerate_faces: int
    """Faces that name a vertex twice."""
    flat_faces: int
    """Other faces without area, to rounding: their height is below 10⁻¹² of their longest side."""
    duplicate_faces: int
    """Faces with the same three vertices as an earlier one, in any order."""
    boundary_edges: int
    boundary_loops: int
    nonmanifold_edges: int
    nonmanifold_vertices: int
    self_intersections: int | None
    """Pairs of faces that intersect; None where it was not asked for."""
    components: int
    closed: bool
    manifold: bool
    oriented: bool
    euler_characteristic: int
    genus: int | None
    """Handles; None where the mesh is not manifold or not oriented."""

    @property
    def sound(self) -> bool:
        """Whether the mesh is closed, manifold and oriented, every face has an area and every vertex a face."""
        faults = self.unreferenced_vertices + self.degenerate_faces + self.flat_faces + self.duplicate_faces
        return self.closed and self.manifold and self.oriented and not faults and not self.self_intersections

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain values, for JSON."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Repair:
    """A mesh after a step, or several, and what was done.

    Attributes
    ----------
    mesh
        The result; the very same object where nothing had to be done.
    changes
        For each step that was taken its name and how many elements it touched, in their order.
    vertex_map : (n,) int32
        Where each vertex of the given mesh has gone; −1 where it was left out.
    face_source : (m,) int32
        From which face of the given mesh each face of the result comes.
    """

    mesh: TriangleMesh
    changes: tuple[tuple[str, int], ...]
    vertex_map: NDArray[np.int32]
    face_source: NDArray[np.int32]

    @property
    def changed(self) -> int:
        """How many elements were touched in all."""
        return sum(count for _, count in self.changes)

    def then(self, other: Repair) -> Repair:
        """Return both as one; `other` was done on this result."""
        moved = np.full(len(self.vertex_map), -1, dtype=np.int32)
        kept = self.vertex_map >= 0
        moved[kept] = other.vertex_map[self.vertex_map[kept]]
        return Repair(other.mesh, self.changes + other.changes, moved, self.face_source[other.face_source])


def mesh_report(mesh: TriangleMesh, *, intersections: bool = False) -> MeshReport:
    """Examine a mesh.

    Parameters
    ----------
    mesh
        Any mesh.
    intersections
        Also count self-intersections, which takes the longest.
    """
    topology = mesh.topology
    return MeshReport(
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
        duplicate_vertices=len(mesh.vertices) - len(np.unique(_places(mesh))),
        unreferenced_vertices=int((~topology.referenced).sum()),
        degenerate_faces=len(topology.degenerate_faces),
        flat_faces=int(_flat(mesh).sum()),
        duplicate_faces=int(_duplicate(mesh).sum()),
        boundary_edges=len(topology.boundary_edges),
        boundary_loops=len(topology.boundary_loops),
        nonmanifold_edges=len(topology.nonmanifold_edges),
        nonmanifold_vertices=len(topology.nonmanifold_vertices),
        self_intersections=len(self_intersections(mesh)) if intersections else None,
        components=topology.component_count,
        closed=topology.closed,
        manifold=topology.manifold,
        oriented=topology.oriented,
        euler_characteristic=topology.euler_characteristic,
        genus=mesh.genus if topology.manifold and topology.oriented else None,
    )


def repair(mesh: TriangleMesh, *, tolerance: float = 0.0, outward: bool = True) -> Repair:
    """Weld, drop degenerate and duplicate faces and unreferenced vertices, and orient, in this order.

    Parameters
    ----------
    mesh
        Any mesh.
    tolerance
        See `weld`.
    outward
        See `orient`.
    """
    done = weld(mesh, tolerance)
    for step in (drop_degenerate_faces, drop_duplicate_faces, drop_unreferenced_vertices):
        done = done.then(step(done.mesh))
    return done.then(orient(done.mesh, outward=outward))


def weld(mesh: TriangleMesh, tolerance: float = 0.0) -> Repair:
    """Make one vertex of those at one place.

    Parameters
    ----------
    mesh
        Any mesh.
    tolerance
        Vertices are joined that lie at most this far apart, in the unit of the mesh, directly or over others; 0 joins
        those at exactly the same place. The first of them keeps its place.

    Notes
    -----
    The change counts the vertices that were joined to another. Faces keep their number; some may become degenerate.
    """
    if not tolerance >= 0:
        raise ValueError(f"the tolerance must not be negative, but is {tolerance}")
    n = len(mesh.vertices)
    if tolerance == 0 or n == 0:
        labels = np.unique(_places(mesh), return_inverse=True)[1].reshape(-1).astype(np.int64)
    else:
        pairs = cKDTree(mesh.vertices).query_pairs(tolerance, output_type="ndarray")
        links = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
        labels = connected_components(links.tocsr(), directed=False)[1].astype(np.int64)
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    keep = np.zeros(n, dtype=bool)
    keep[first] = True
    places = np.cumsum(keep) - 1
    vertex_map = places[first[inverse.reshape(-1)]].astype(np.int32)
    merged = n - int(keep.sum())
    result = TriangleMesh(mesh.vertices[keep], vertex_map[mesh.faces]) if merged else mesh
    return Repair(result, (("weld", merged),), vertex_map, np.arange(len(mesh.faces), dtype=np.int32))


def drop_degenerate_faces(mesh: TriangleMesh, *, flat: bool = False) -> Repair:
    """Leave out the faces that name a vertex twice.

    Parameters
    ----------
    mesh
        Any mesh.
    flat
        Also leave out faces of three vertices on one line. This opens the surface where its neighbours do not touch.
    """
    bad = np.zeros(len(mesh.faces), dtype=bool)
    bad[mesh.topology.degenerate_faces] = True
    return _without_faces(mesh, bad | _flat(mesh) if flat else bad, "drop_degenerate_faces")


def drop_duplicate_faces(mesh: TriangleMesh) -> Repair:
    """Leave out each face whose three vertices an earlier face has, whichever way it is turned."""
    return _without_faces(mesh, _duplicate(mesh), "drop_duplicate_faces")


def drop_unreferenced_vertices(mesh: TriangleMesh) -> Repair:
    """Leave out the vertices that no face uses; the others keep their order."""
    used = mesh.topology.referenced
    vertex_map = np.where(used, np.cumsum(used) - 1, -1).astype(np.int32)
    count = int((~used).sum())
    result = TriangleMesh(mesh.vertices[used], vertex_map[mesh.faces]) if count else mesh
    source = np.arange(len(mesh.faces), dtype=np.int32)
    return Repair(result, (("drop_unreferenced_vertices", count),), vertex_map, source)


def orient(mesh: TriangleMesh, *, outward: bool = True) -> Repair:
    """Turn faces over so that neighbours agree.

    Faces are neighbours across edges of exactly two faces. In each set of neighbours the smaller part is turned. A set
    with one side only (a Möbius strip) is left as it is.

    Parameters
    ----------
    mesh
        Any mesh.
    outward
        Also turn every closed set of neighbours to positive volume, so that faces look outwards; a cavity inside a body
        is turned too. Without it, sets that agree already are left as they are.
    """
    m = len(mesh.faces)
    nothing = Repair(
        mesh, (("orient", 0),), np.arange(len(mesh.vertices), dtype=np.int32), np.arange(m, dtype=np.int32)
    )
    if m == 0:
        return nothing
    from shapery_geometry import _topology_kernels as kernels

    first, second, agree = _neighbours(mesh)
    # Each face is there twice, as it is (f) and turned over (m + f); what fits together is linked. A set of faces that
    # can be oriented falls into two halves, each an orientation; one that cannot hangs together as a whole.
    other = np.where(agree, second, second + m)
    mirror = np.where(agree, second + m, second)
    rows, columns = np.concatenate((first, first + m)), np.concatenate((other, mirror))
    labels = np.arange(2 * m, dtype=np.int32)
    kernels.join_pairs(rows.astype(np.int32), columns.astype(np.int32), labels)
    as_is, turned = labels[:m], labels[m:]
    # the first face of a patch names it, and is as it is in the half that is looked at first
    patch, one_sided = np.minimum(as_is, turned), as_is == turned
    flip = (turned < as_is) & ~one_sided
    sizes, flips = np.bincount(patch), np.bincount(patch, weights=flip)
    flip ^= (2 * flips > sizes)[patch] & ~one_sided
    if outward:
        open_patches = np.zeros(len(sizes), dtype=bool)
        lonely = (mesh.topology.edge_face_counts != 2)[mesh.topology.face_edges].any(axis=1)
        open_patches[patch[lonely | one_sided]] = True
        points = mesh.corners - mesh.vertices.mean(axis=0)
        volumes = np.einsum("ij,ij->i", points[:, 0], np.cross(points[:, 1], points[:, 2]))
        inside_out = np.bincount(patch, weights=np.where(flip, -volumes, volumes)) < 0
        flip ^= (inside_out & ~open_patches)[patch]
    count = int(flip.sum())
    if not count:
        return nothing
    faces = np.where(flip[:, None], mesh.faces[:, ::-1], mesh.faces)
    return Repair(TriangleMesh(mesh.vertices, faces), (("orient", count),), nothing.vertex_map, nothing.face_source)


def submesh(mesh: TriangleMesh, faces: NDArray[np.bool_] | NDArray[np.integer]) -> Repair:
    """Return the mesh of some faces alone, in the order of the mesh, with the vertices that they use.

    Parameters
    ----------
    mesh
        Any mesh.
    faces : (m,) bool or (k,) int
        The faces to keep.
    """
    keep = np.zeros(len(mesh.faces), dtype=bool)
    try:
        keep[faces] = True
    except IndexError:
        raise InvalidInput("invalid_mesh", f"A chosen face does not exist; the mesh has {len(mesh.faces)}.") from None
    chosen = _without_faces(mesh, ~keep, "submesh")
    return chosen.then(drop_unreferenced_vertices(chosen.mesh))


def _neighbours(mesh: TriangleMesh) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """Faces on both sides of each edge that has exactly two, and whether they agree on what is outside."""
    topology = mesh.topology
    sides = topology.face_edges.reshape(-1)
    # of the two sides on an edge the last one that is written stays, and each side finds either itself or the other
    last = np.empty(len(topology.edges), dtype=np.int64)
    last[sides] = np.arange(len(sides))
    here = np.flatnonzero((topology.edge_face_counts == 2)[sides])
    there = last[sides[here]]
    here, there = here[here != there], there[here != there]
    first, second = here // 3, there // 3
    starts = mesh.faces.reshape(-1)
    agree = starts[here] != starts[there]
    apart = first != second
    return first[apart], second[apart], agree[apart]


def _without_faces(mesh: TriangleMesh, bad: NDArray[np.bool_], name: str) -> Repair:
    count = int(bad.sum())
    result = TriangleMesh(mesh.vertices, mesh.faces[~bad]) if count else mesh
    identity = np.arange(len(mesh.vertices), dtype=np.int32)
    return Repair(result, ((name, count),), identity, np.flatnonzero(~bad).astype(np.int32))


def _places(mesh: TriangleMesh) -> NDArray[np.void]:
    """Bytes that are the same where vertices lie at the same place."""
    # adding zero makes -0.0 and 0.0 the same
    return np.ascontiguousarray(mesh.vertices + 0.0).view(np.dtype((np.void, 24))).reshape(-1)


def _flat(mesh: TriangleMesh) -> NDArray[np.bool_]:
    """(m,) whether a face that names three vertices has no area, to rounding."""
    p = mesh.corners
    longest = np.max(
        [np.einsum("ij,ij->i", d, d) for d in (p[:, 1] - p[:, 0], p[:, 2] - p[:, 1], p[:, 0] - p[:, 2])], 0
    )
    flat = 2 * mesh.face_areas <= 1e-12 * longest
    flat[mesh.topology.degenerate_faces] = False
    return np.asarray(flat)


def _duplicate(mesh: TriangleMesh) -> NDArray[np.bool_]:
    """(m,) whether an earlier face has the same vertices."""
    rows = np.sort(mesh.faces, axis=1).astype(np.int64)
    n = max(len(mesh.vertices), 1)
    if n < 1 << 21:
        _, first = np.unique((rows[:, 0] * n + rows[:, 1]) * n + rows[:, 2], return_index=True)
    else:
        _, first = np.unique(rows, axis=0, return_index=True)
    result = np.ones(len(rows), dtype=bool)
    result[first] = False
    return result

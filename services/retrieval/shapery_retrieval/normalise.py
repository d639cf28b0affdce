"""From any mesh to one that can be analysed, and what was done to it.

The uploaded mesh itself is never changed: the analysis works on a copy that is welded, free of degenerate and duplicate
faces, oriented, bounded in size, evenly sampled, of unit area around the origin, and whose components are joined by
short links. What cannot be analysed is refused with a sentence.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import cKDTree

from shapery_contracts.errors import InvalidInput
from shapery_geometry.decimation import decimate
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.geodesics import NO_LINKS, Links
from shapery_geometry.repair import Repair, drop_degenerate_faces, drop_unreferenced_vertices, repair, submesh

WELD = 1e-6
"""Vertices nearer than this share of the diagonal are one."""
MAX_FACES = 5000
"""More faces are reduced to so many, for the analysis alone."""
TOLERATED_FACES = 6000
"""Meshes up to this size are analysed as they are."""
CLUSTERED_FACES = 400_000
"""Beyond so many faces, which are collapsed in about two seconds, vertices are first gathered in cells of a grid."""
MIN_VERTICES = 1000
"""Coarser meshes are split until they have so many vertices."""
SPECK = 1e-4
"""Components below this share of the area are left out."""
MAX_COMPONENTS = 128
"""Of more components the largest are kept."""
LINKS_PER_GAP = 6
"""How many vertices of two neighbouring components are joined."""


@dataclass(frozen=True, eq=False)
class NormalisedMesh:
    """A mesh as it is analysed.

    Attributes
    ----------
    mesh
        Of unit area, its centroid at the origin.
    links
        Paths that join the components.
    changes
        Each step that touched something, and how many elements.
    components
        Connected parts after welding, before specks were left out.
    centre, scale
        The analysed points are ``(points − centre) · scale``.
    """

    mesh: TriangleMesh
    links: Links
    changes: tuple[tuple[str, int], ...]
    components: int
    centre: NDArray[np.float64]
    scale: float


def normalise(mesh: TriangleMesh) -> NormalisedMesh:
    """Make a mesh ready for the analysis.

    The result does not depend on the order of the vertices and faces.

    Raises
    ------
    InvalidInput
        ``empty_content`` for a mesh without faces, ``invalid_mesh`` for one without a surface worth the name.
    """
    clean = cleaned(mesh)
    changes = [change for change in clean.changes if change[1]]
    surface = _in_order(clean.mesh)
    components = surface.component_count
    surface = _without_specks(surface, changes)
    surface = _reduced(surface, changes)
    before = len(surface.vertices)
    surface = _split(surface)
    if len(surface.vertices) > before:
        changes.append(("split_edges", len(surface.vertices) - before))
    scale, centre = 1 / float(np.sqrt(surface.area)), surface.centroid
    surface = surface.with_vertices((surface.vertices - centre) * scale)
    links = component_links(surface)
    if len(links.lengths):
        changes.append(("link_components", surface.component_count))
    return NormalisedMesh(surface, links, tuple(changes), components, centre, scale)


def cleaned(mesh: TriangleMesh) -> Repair:
    """Weld and repair a mesh, or refuse it.

    Raises
    ------
    InvalidInput
        See `normalise`.
    """
    if not len(mesh.faces):
        raise InvalidInput("empty_content", "The mesh has no faces.", "Give a surface, not a cloud of points.")
    done = repair(mesh, tolerance=WELD * mesh.diagonal)
    done = done.then(drop_degenerate_faces(done.mesh, flat=False))
    surface = done.mesh
    if not len(surface.faces):
        raise InvalidInput("invalid_mesh", "No face of the mesh has three different corners.", "Check the export.")
    if not surface.area > 1e-7 * surface.diagonal**2:
        raise InvalidInput(
            "invalid_mesh",
            f"The mesh has next to no area: {surface.area:.3g} with a diagonal of {surface.diagonal:.3g}.",
            "Remove stray vertices and needles.",
        )
    return done


def _in_order(mesh: TriangleMesh) -> TriangleMesh:
    """Return the mesh with vertices sorted by place, and faces from their smallest vertex on and sorted."""
    order = np.lexsort(mesh.vertices.T[::-1])
    rank = np.empty(len(order), dtype=np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    faces = rank[mesh.faces]
    turn = (np.argmin(faces, axis=1)[:, None] + np.arange(3)) % 3
    faces = np.take_along_axis(faces, turn, axis=1)
    # by the first two corners in one number, then by the third
    first = faces[:, 0].astype(np.int64) * len(order) + faces[:, 1]
    return TriangleMesh(mesh.vertices[order], faces[np.lexsort((faces[:, 2], first))])


def _without_specks(mesh: TriangleMesh, changes: list[tuple[str, int]]) -> TriangleMesh:
    count = mesh.component_count
    if count == 1:
        return mesh
    label = mesh.topology.face_components
    areas = np.bincount(label, weights=mesh.face_areas, minlength=count)
    keep = areas > SPECK * mesh.area
    keep[np.argsort(-areas, kind="stable")[MAX_COMPONENTS:]] = False
    if keep.all():
        return mesh
    if not keep.any():
        keep[int(np.argmax(areas))] = True
    changes.append(("leave_out_specks", int((~keep).sum())))
    return submesh(mesh, keep[label]).mesh


def _reduced(mesh: TriangleMesh, changes: list[tuple[str, int]]) -> TriangleMesh:
    if len(mesh.faces) <= TOLERATED_FACES:
        return mesh
    given, surface = len(mesh.faces), mesh
    if given > CLUSTERED_FACES:
        surface = _clustered(surface)
    reduced = decimate(surface, MAX_FACES)
    if len(reduced.faces) > 2 * MAX_FACES:
        # topology holds it up: what is not manifold, or very many handles and components
        reduced = decimate(reduced, MAX_FACES, keep_topology=False)
    if len(reduced.faces) > 2 * MAX_FACES:
        reduced = _clustered(reduced, 24)
    surface = repair(reduced).mesh
    if not surface.area > 0.25 * mesh.area:
        raise InvalidInput(
            "invalid_mesh", f"The mesh of {given} faces falls apart when it is reduced.", "Give a connected surface."
        )
    changes.append(("reduce_faces", given - len(surface.faces)))
    return _in_order(surface)


def _clustered(mesh: TriangleMesh, cells: int = 320) -> TriangleMesh:
    """Join the vertices in each cell of a grid, `cells` along the longest side, at their mean."""
    low, high = mesh.bounding_box
    size = float((high - low).max()) / cells
    index = np.floor((mesh.vertices - low) / size).astype(np.int64)
    key = (index[:, 0] * (cells + 1) + index[:, 1]) * (cells + 1) + index[:, 2]
    _, inverse, counts = np.unique(key, return_inverse=True, return_counts=True)
    inverse = inverse.reshape(-1)
    sums = [np.bincount(inverse, weights=mesh.vertices[:, axis]) for axis in range(3)]
    return repair(TriangleMesh(np.stack(sums, axis=1) / counts[:, None], inverse[mesh.faces])).mesh


def _split(mesh: TriangleMesh) -> TriangleMesh:
    """Halve long edges until there are `MIN_VERTICES`, and those far longer than the rest; all that share one do."""
    surface = mesh
    for _ in range(24):
        n = len(surface.vertices)
        even = np.sqrt(surface.area / max(n, MIN_VERTICES))
        long = surface.edge_lengths > (2.0 if n < MIN_VERTICES else 5.0) * even
        if not long.any():
            if n >= MIN_VERTICES:
                break
            long = surface.edge_lengths > np.quantile(surface.edge_lengths, 0.5)
            if not long.any():
                long[:] = True
        if n > 4 * MIN_VERTICES:
            break
        surface = _halved(surface, long)
    return surface


def _halved(mesh: TriangleMesh, marked: NDArray[np.bool_]) -> TriangleMesh:
    """Split every marked edge in its middle, and each face by how many of its sides are marked."""
    middle = np.full(len(marked), -1, dtype=np.int64)
    middle[marked] = len(mesh.vertices) + np.arange(int(marked.sum()))
    points = np.concatenate((mesh.vertices, mesh.vertices[mesh.edges[marked]].mean(axis=1)))
    sides = middle[mesh.topology.face_edges]
    count = (sides >= 0).sum(axis=1)
    # faces are turned so that one marked side comes first, and of two unmarked ones the last
    first = np.where(count == 2, (np.argmin(sides >= 0, axis=1) + 1) % 3, np.argmax(sides >= 0, axis=1))
    turn = (first[:, None] + np.arange(3)) % 3
    (a, b, c), (ab, bc, ca) = (
        np.take_along_axis(values, turn, axis=1).T for values in (mesh.faces.astype(np.int64), sides)
    )
    one, two, three = (count == k for k in (1, 2, 3))
    pieces = [
        np.stack((a, b, c), 1)[count == 0],
        np.stack((a, ab, c), 1)[one], np.stack((ab, b, c), 1)[one],
        np.stack((ab, b, bc), 1)[two], np.stack((a, ab, bc), 1)[two], np.stack((a, bc, c), 1)[two],
        np.stack((a, ab, ca), 1)[three], np.stack((b, bc, ab), 1)[three],
        np.stack((c, ca, bc), 1)[three], np.stack((ab, bc, ca), 1)[three],
    ]  # fmt: skip
    return TriangleMesh(points, np.concatenate(pieces))


def component_links(mesh: TriangleMesh) -> Links:
    """Join the components of a mesh along a shortest tree, each gap by its few nearest pairs of vertices."""
    count = mesh.component_count
    if count == 1:
        return NO_LINKS
    labels = mesh.topology.vertex_components
    members = [np.flatnonzero(labels == c) for c in range(count)]
    trees = [cKDTree(mesh.vertices[m]) for m in members]
    gaps = np.zeros((count, count))
    for a in range(count):
        for b in range(a + 1, count):
            small, large = (a, b) if len(members[a]) <= len(members[b]) else (b, a)
            # touching components still need an edge in the tree
            gaps[a, b] = np.min(trees[large].query(mesh.vertices[members[small]])[0]) + 1e-12
    tree = coo_array(minimum_spanning_tree(gaps))
    ends, lengths = [], []
    for a, b in zip(tree.coords[0].tolist(), tree.coords[1].tolist(), strict=True):
        small, large = (a, b) if len(members[a]) <= len(members[b]) else (b, a)
        distance, partner = trees[large].query(mesh.vertices[members[small]])
        nearest = np.argsort(distance, kind="stable")[:LINKS_PER_GAP]
        ends.append(np.stack((members[small][nearest], members[large][np.asarray(partner)[nearest]]), axis=1))
        lengths.append(np.asarray(distance)[nearest])
    return Links(np.concatenate(ends), np.concatenate(lengths))


def web_mesh(mesh: TriangleMesh, faces: int = 20_000) -> TriangleMesh:
    """Return the repaired mesh for viewers, in its own frame and unit, reduced where it is large.

    Faces larger than those that are analysed are split, since each vertex has one part: a table's top, which a file
    makes of a few faces, has a border where its parts meet.
    """
    surface = drop_unreferenced_vertices(cleaned(mesh).mesh).mesh
    if len(surface.faces) > CLUSTERED_FACES:
        surface = _clustered(surface)
    if len(surface.faces) > faces:
        surface = repair(decimate(surface, faces, keep_topology=False)).mesh
    longest = 2 * np.sqrt(surface.area / MIN_VERTICES)
    while len(surface.faces) < 2 * faces and (long := surface.edge_lengths > longest).any():
        surface = _halved(surface, long)
    return surface

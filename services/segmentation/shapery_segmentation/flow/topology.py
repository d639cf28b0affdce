"""Changes of topology (S4, ``topology="adaptive"``): parts that meet inside the object merge, necks outside it split.

Every operation on the triangles keeps the topology, so a change is made by laying the surface into a grid, deciding
there what is inside, and taking the border of that as the new surface. It is closed, oriented, manifold and free of
self-intersections whatever the voxels (see `shapery_segmentation.seeding.ball`), and within a quarter of an edge
length of the old one, from where the flow takes it back to the object.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.neighborhoods import within, without_small
from shapery_segmentation.seeding.ball import surface_of

BoolArray = NDArray[np.bool_]

CELL = 1.0
"""Edge of the grid's cells in edge lengths at the most: finer ones give many more triangles than are wanted."""

MERGED_GAP = 1.5
"""Half the width, in edge lengths, of the gaps that are closed where object lies in them."""

SPLIT_NECK = 0.7
"""Half the width, in edge lengths, of the necks that are cut where no object lies in them."""

PINHOLE = 6
"""Voxels that a hole through something thin must have to be one; fewer are filled."""

LEAST_CHANGE = 1.0
"""Cubes of the edge length that are closed or cut in one place, at least: fronts keep a gap of an edge length. Creases
whose sides have met count as well, though closing them changes no topology."""


def reconnected(
    surface: TriangleMesh,
    object_on: Callable[[Volume], NDArray[Any]],
    edge_length: float,
    *,
    cell: float | None = None,
) -> TriangleMesh | None:
    """Return a surface that is joined where it meets itself inside the object, and cut where it is thin outside of it.

    Parameters
    ----------
    surface
        Closed, RAS mm, without self-intersections.
    object_on
        Tells which voxels of a grid are object: those where what it returns is positive. Between these and where it is
        negative, the new surface lies where it vanishes.
    edge_length
        In mm.
    cell
        Edge of the grid's cells in mm, by default the edge length; edges of the new surface are about as long.

    Returns
    -------
    The new surface; none where nothing of any size would change.

    References
    ----------
    T. McInerney, D. Terzopoulos, "Topology adaptive deformable surfaces for medical image volume segmentation", IEEE
    Trans. Med. Imaging 18 (1999), doi:10.1109/42.811261.
    """
    cell = CELL * edge_length if cell is None else min(cell, CELL * edge_length)
    unit = edge_length / cell
    gap, neck = max(1.0, MERGED_GAP * unit), max(1.0, SPLIT_NECK * unit)
    margin = int(np.ceil(gap)) + 2
    low, high = surface.bounding_box
    shape = np.ceil((high - low) / cell).astype(int) + 2 * margin
    affine = np.diag([cell, cell, cell, 1.0])
    affine[:3, 3] = low - (margin - 0.5) * cell
    grid = Volume(np.broadcast_to(np.zeros((), np.uint8), tuple(shape)), affine)

    inside = rasterize(surface, grid)
    level = np.asarray(object_on(grid), dtype=np.float32)
    is_object = level > 0
    joined = inside | (~within(~within(inside, gap), gap) & is_object)
    thick = within(~within(~joined, neck), neck)
    solid = joined & (thick | is_object)
    holes = ~within(~within(solid, 1.0), 1.0) & ~solid
    solid |= holes & ~without_small(holes, PINHOLE)
    if not solid.any():
        return None
    least = LEAST_CHANGE * unit**3
    new = surface_of(solid, affine, even=True, level=level)
    # Necks that are thinner than the grid's cells are cut by laying the surface into it. If the topology stays, and
    # nothing was joined, only corners were cut.
    more = _euler(new) - _euler(surface)
    joins = without_small(solid & ~inside, least).any()
    changes = more > 0 or joins or (more < 0 and without_small(inside & ~solid, least).any())
    return new if changes else None


def _euler(surface: TriangleMesh) -> int:
    """Return the Euler characteristic of a closed surface that uses all of its vertices."""
    return len(surface.vertices) - len(surface.faces) // 2


def without_remains(mesh: TriangleMesh, least: float) -> TriangleMesh:
    """Return the surface without the parts that enclose less than `least` mm³; as it is if there are none."""
    if mesh.component_count < 2:
        return mesh
    label = mesh.topology.face_components
    corners = mesh.corners - mesh.vertices[0]
    parts = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    volumes = np.abs(np.bincount(label, weights=parts))
    if volumes.min() >= least:
        return mesh
    kept = mesh.faces[volumes[label] >= least]
    used = np.unique(kept)
    number = np.zeros(len(mesh.vertices), dtype=np.int32)
    number[used] = np.arange(len(used), dtype=np.int32)
    return TriangleMesh(mesh.vertices[used], number[kept])

"""From the region of a vessel to its surface: both flows by model selection, then the fit to the wall."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.flow.selection import SelectionParams, selected_flow
from shapery_segmentation.flow.tangential import TangentialFlowParams, seed_triangle, tangential_flow
from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh
from shapery_segmentation.seeding.ball import surface_of
from shapery_segmentation.vessels import _border_kernels as kernels
from shapery_segmentation.vessels.border import CUBE, SHELL, Border
from shapery_segmentation.vessels.evidence import Evidence
from shapery_segmentation.vessels.fit import fit_surface

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

EDGE, EDGE_OF_RADIUS = 0.8, 0.35
"""Length of the surface's edges: in voxels at the least, and of a small radius of the tree where that is longer. A
vessel of 1.5 voxels radius still has twelve corners around it."""

LARGEST_SURFACE = 400_000
"""Vertices at about which edges get longer instead."""

SEED_RADIUS = 1.0
"""Radius of the ball that the normal flow starts from, in voxels."""

LEAST_AGREEMENT = 0.7
"""Intersection over union with the region that a surface which grew must have, or part of the vessel is missing."""


@dataclass(frozen=True, eq=False)
class RelativeField:
    """The volume around vessels, from −1 outside to 1 inside, in a box.

    Parameters
    ----------
    values : (A, B, C) float32
        −1 where nothing is known.
    affine : (4, 4) float64
        From an index of `values` to RAS mm.
    low : (3,) int64
        The voxel of the whole volume at index 0.
    depth : (A, B, C) int8
        Number of the layer inside, from 1 at the border.
    """

    values: NDArray[np.float32]
    affine: FloatArray
    low: NDArray[np.int64]
    depth: NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class Tracked:
    """A surface and how it was made.

    Parameters
    ----------
    surface
        Closed, manifold, oriented, without self-intersections, RAS mm.
    model
        ``tangential`` or ``normal``: the flow that the model selection ended with; ``rebuilt``: neither gave a sound
        surface of the whole region, so it was made of the region's voxels.
    iterations, rounds
        Of the normal flow and of the tangential flow.
    """

    surface: TriangleMesh
    model: Literal["tangential", "normal", "rebuilt"]
    iterations: int
    rounds: int


def relative_box(evidence: Evidence, border: Border, grid: Volume) -> RelativeField:
    """Return the relative field around the region that was found, with two voxels of outside around it.

    Time and memory beyond the box itself grow with the region's surface.
    """
    depth = np.zeros(grid.shape, dtype=np.int8)
    around = np.empty((min(evidence.values.size, 40 * len(border.voxels) + 4096), 3), dtype=np.int32)
    _, total = kernels.layers(border.inside, border.voxels, SHELL, depth, around)
    around = around[:total]
    low = around.min(axis=0).astype(np.int64) - 2
    high = around.max(axis=0) + 3
    values = np.full(high - low, -1.0, dtype=np.float32)
    kernels.relative_field(evidence.smoothed, border.inner, border.outer, float(CUBE), around, low, values)
    affine = grid.affine.copy()
    affine[:3, 3] += affine[:3, :3] @ low
    box = np.zeros(values.shape, dtype=np.int8)
    inside = border.voxels
    box[tuple((inside - low).T)] = depth[tuple(inside.T)]
    return RelativeField(values, affine, low, box)


def edge_length(grid: Volume, radius: float, area: float) -> float:
    """Return the edge length in mm for a tree with a small radius of `radius` mm and about `area` mm² of wall."""
    voxel = grid.voxel_volume ** (1 / 3)
    edge = max(EDGE * max(min(grid.spacing), 0.75 * voxel), EDGE_OF_RADIUS * radius)
    return float(edge * max(1.0, np.sqrt(area / (0.87 * edge * edge) / LARGEST_SURFACE)))


def track_tree(
    voxels: NDArray[np.int64],
    field: RelativeField,
    edge: float,
    evidence: Evidence,
    border: Border,
    grid: Volume,
    *,
    check_cancelled: Callable[[], None],
) -> Tracked:
    """Return the surface of one connected region.

    Parameters
    ----------
    voxels : (n, 3) int64
        The region's, in the whole volume.
    field
    edge
        mm.
    evidence, border, grid
        Of the whole volume.
    check_cancelled

    Notes
    -----
    A small ball in the vessel's middle flows along its normals until the model selection opens it; the tangential flow
    tracks the rest. The guarantee does not rest on the flows: what they give is checked by the exact test, compared
    with the region, and where it is not sound replaced by the border of the region's voxels, which is sound by
    construction. Then every move of the fit is tested as it is made, and the result by the exact test once more.
    """
    part = np.zeros(field.values.shape, dtype=np.bool_)
    part[tuple((voxels - field.low).T)] = True
    box_grid = Volume(field.values, field.affine)
    mesh: DynamicMesh | None = None
    iterations = rounds = 0
    model: Literal["tangential", "normal", "rebuilt"] = "rebuilt"
    for found, name, done, turns in _grown(part, field, edge, check_cancelled):
        iterations, rounds = iterations + done, rounds + turns
        mesh = _sound(found, part, box_grid, edge)
        if mesh is not None:
            model = name
            break
    if mesh is None:
        mesh = DynamicMesh(surface_of(part, field.affine), edge)
        model = "rebuilt"
    check_cancelled()
    mesh.remesh(rounds=8)
    fit_surface(mesh, evidence, border, grid, check_cancelled=check_cancelled)
    surface = mesh.to_triangle_mesh()
    crossing = len(self_intersections(surface))
    if crossing:
        raise RuntimeError(f"{crossing} pairs of faces of a vessel's surface intersect")
    return Tracked(surface, model, iterations, rounds)


def seed_voxel(part: BoolArray, depth: NDArray[np.int8]) -> NDArray[np.int64]:
    """Return a voxel (3,) in the middle of the vessel where it is neither thin nor thickest.

    A normal flow that starts in the thickest part, say an aneurysm, takes long to fill it.
    """
    index = np.argwhere(part)
    own = depth[tuple(index.T)]
    wide = np.flatnonzero(own >= min(2, int(own.max())))
    order = wide[np.argsort(own[wide], kind="stable")]
    level = own[order[(9 * len(order)) // 10]]
    candidates = np.flatnonzero(own == level)
    return np.asarray(index[candidates[len(candidates) // 2]], dtype=np.int64)


def _grown(
    part: BoolArray, field: RelativeField, edge: float, check: Callable[[], None]
) -> Iterator[tuple[TriangleMesh, Literal["tangential", "normal"], int, int]]:
    """Yield surfaces that grew, the flow that made them, and its iterations and rounds.

    The first is what the model selection gives; the others grow tangentially from a triangle on the wall.
    """
    start = seed_voxel(part, field.depth)
    center = field.affine[:3, :3] @ start + field.affine[:3, 3]
    radius = SEED_RADIUS * float(np.linalg.norm(field.affine[:3, :3], axis=0).min())
    chosen = selected_flow(
        field.values,
        field.affine,
        icosphere(center, radius, 2),
        SelectionParams(edge_length=edge),
        check_cancelled=check,
    )
    if not chosen.vanished:
        turns = chosen.tangential.rounds if chosen.tangential is not None else 0
        yield chosen.mesh, chosen.model, chosen.iterations, turns
    triangle = seed_triangle(field.values, field.affine, center, edge_length=edge)
    if triangle is None:
        return
    params = TangentialFlowParams(edge_length=edge)
    grown = tangential_flow(field.values, field.affine, triangle, params, check_cancelled=check)
    yield grown.mesh, "tangential", 0, grown.rounds
    # Between voxels a region may be parted where its voxels meet at a corner: the larger piece is then elsewhere.
    if not grown.mesh.closed:
        return
    rest, count = ndimage.label(part & ~rasterize(grown.mesh, Volume(field.values, field.affine)))
    if count:
        rest = rest == 1 + np.argmax(np.bincount(rest.ravel())[1:])
        start = seed_voxel(rest, field.depth)
        center = field.affine[:3, :3] @ start + field.affine[:3, 3]
        triangle = seed_triangle(field.values, field.affine, center, edge_length=edge)
        if triangle is not None:
            grown = tangential_flow(field.values, field.affine, triangle, params, check_cancelled=check)
            yield grown.mesh, "tangential", 0, grown.rounds


def _sound(found: TriangleMesh, part: BoolArray, grid: Volume, edge: float) -> DynamicMesh | None:
    """Return the surface as a dynamic mesh if it is closed, sound, and holds the region."""
    if not (len(found.faces) and found.closed and found.manifold and found.oriented and found.volume > 0):
        return None
    inside = rasterize(found, grid)
    both = np.count_nonzero(inside & part)
    if both < LEAST_AGREEMENT * np.count_nonzero(inside | part):
        return None
    try:
        return DynamicMesh(found, edge)
    except InvalidInput:
        # Faces touch: the flow's clearance is smaller than the mesh's where edges are long.
        return None

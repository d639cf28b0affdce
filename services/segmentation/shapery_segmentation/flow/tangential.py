"""The tangential surface flow (3.4.2, 3.4.3): an open surface grows from its boundary along the border of an object.

The equation
------------
The boundary C of the surface moves in the surface's tangent plane (Eq. 3.4–3.9)::

    ΔC = α·k·n,   n = (n_l + n_r)/|n_l + n_r|,   k = 4·area(V_l, V, V_r) / (|VV_l|·|V_lV_r|·|V_rV|)

with n_l and n_r across the boundary's edges on both sides of a vertex V, and k the curvature of the circle through V
and its neighbours V_l and V_r. At each vertex that may still grow new vertices are put in at that distance, pulled to
the border of the object, and joined to V and its neighbours by new faces. Unlike the normal flow nothing has to travel:
a surface of n vertices costs n steps, whatever the length of the vessel.

What differs from the text
--------------------------
- The distance α·k is kept within bounds that follow the edge length: a straight boundary has no curvature and would
  stand still.
- One new vertex on the bisector, with two faces, is right where the open angle at V is about 120°. In general the angle
  is filled with the nearest number of equilateral triangles: none is put in below 90°, where V_l and V_r are joined
  (the on-site stitch), one on the bisector up to 150°, and so on, as in Hartmann's marching.
- A new vertex is pulled not to the nearest voxel with a prominent gradient, but along the gradient to where the field
  crosses the threshold, to a hundredth of a voxel; a place without a prominent gradient is given up, as in the text.

Topology
--------
A new vertex near another part of the boundary is replaced by its vertex there, which joins fronts that meet: behind a
fork, around a tube. Every new face is tested against all near faces before it counts (`shapery_segmentation.mesh`'s
test, with a clearance), and no directed edge is used twice, so the surface is oriented, manifold along its edges, and
free of self-intersections at any time. What the flow leaves open is stitched afterwards, over three adjacent vertices
of the boundary at a time; where that does not work, faces around the hole are taken out and it is grown over once
more.

References
----------
Sections 3.4.2 and 3.4.3 of the dissertation, Eq. 3.4–3.9, Figs 3.6–3.10. E. Hartmann, "A marching method for the
triangulation of surfaces", The Visual Computer 14 (1998), doi:10.1007/s003710050126.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.volume import check_affine
from shapery_segmentation.flow import _front_kernels as fronts
from shapery_segmentation.flow import _growth_kernels, _level_kernels, _stitch_kernels

FloatArray = NDArray[np.float64]

ROOM = 4096
"""Vertices that there is room for at first."""

MENDINGS = 4
"""Times that the faces around a hole are taken out and the flow goes on."""

STITCH_AGREEMENT = (0.1, -0.2, -1.0)
"""Products of a face's normal with those of its vertices that stitching asks for, one after the other."""

PART = 0.25
"""Share of the way to the middle of its own neighbours that each copy of a split vertex moves."""

SEED_EDGES = 0.9
"""Edge of the first triangle in edge lengths."""


@dataclass(frozen=True, slots=True)
class TangentialFlowParams:
    """How the boundary grows.

    Parameters
    ----------
    edge_length
        mm; none: 0.8 of the shortest voxel edge.
    rate
        α of Eq. 3.6 in mm: a boundary with that radius of curvature grows by one edge length.
    least_step, largest_step
        Bounds of a step, in edge lengths.
    snap
        Edge lengths within which a new vertex is replaced by one that is there.
    prominence
        Gradient that the border must have, in units of the field per voxel.
    agreement
        Product of the normals above which two parts belong to one side of the surface.
    max_vertices
        Where to stop (3.4.3); the boundary then stays open.
    """

    edge_length: float | None = None
    rate: float = 1.0
    least_step: float = 0.85
    largest_step: float = 1.1
    snap: float = 0.7
    prominence: float = 0.1
    agreement: float = 0.2
    max_vertices: int = 2_000_000

    def __post_init__(self) -> None:
        if self.edge_length is not None and not (np.isfinite(self.edge_length) and self.edge_length > 0):
            raise ValueError(f"edge_length must be positive, not {self.edge_length}")
        if not 0 < self.least_step <= self.largest_step <= 2:
            raise ValueError(f"steps must rise within (0, 2], not {self.least_step} and {self.largest_step}")
        for name, low, high in (("snap", 0.0, 1.0), ("prominence", 0.0, 1e9), ("agreement", -1.0, 1.0)):
            if not low <= getattr(self, name) <= high:
                raise ValueError(f"{name} must lie in [{low:g}, {high:g}], not {getattr(self, name)}")
        if self.max_vertices < 4:
            raise ValueError(f"max_vertices must be at least 4, not {self.max_vertices}")


@dataclass(frozen=True, slots=True)
class TangentialFlowResult:
    """The surface that grew.

    Parameters
    ----------
    mesh
        Oriented, without self-intersections, RAS mm, with float32 values as coordinates. Closed, unless `holes` says
        otherwise.
    holes
        Edges of the boundary that is left: none for a closed surface.
    rounds
        Times that the whole boundary was gone through.
    grown, stitched, refused
        Vertices put in; faces put in over vertices that were there; corners that were given up at first.
    limited
        Whether `max_vertices` ended it.
    """

    mesh: TriangleMesh
    holes: int
    rounds: int
    grown: int
    stitched: int
    refused: int
    limited: bool


def tangential_flow(
    field: NDArray[np.float32],
    affine: ArrayLike,
    seed: TriangleMesh,
    params: TangentialFlowParams | None = None,
    *,
    threshold: float = 0.0,
    check_cancelled: Callable[[], None] | None = None,
) -> TangentialFlowResult:
    """Let an open surface grow along the border of an object until it has none.

    Parameters
    ----------
    field : (I, J, K) float32
        Above `threshold` inside the object; finite.
    affine : (4, 4) float64
        From voxel index to RAS mm; any spacing, oblique, sheared or mirrored.
    seed
        An open, oriented surface near the border, with faces that look outwards; `seed_triangle` makes one.
    params
    threshold
        Value of the field at the border.
    check_cancelled
        Called now and then; what it raises ends the flow and passes through.

    Returns
    -------
    TangentialFlowResult

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where the seed is empty or not manifold and oriented, ``invalid_volume`` for an affine that
        spans no space.

    Notes
    -----
    The same input gives the same bytes. Time and memory grow with the surface.
    """
    p = params if params is not None else TangentialFlowParams()
    matrix = check_affine(affine)
    values = np.ascontiguousarray(field, dtype=np.float32)
    if values.ndim != 3 or min(values.shape) < 2:
        raise InvalidInput("invalid_volume", f"A field of shape {values.shape} has no border to follow.")
    voxel = float(np.linalg.norm(matrix[:3, :3], axis=0).min())
    length = p.edge_length if p.edge_length is not None else 0.8 * voxel
    inverse = np.ascontiguousarray(np.linalg.inv(matrix)[:3])
    dials = fronts.Dials(
        threshold=float(threshold),
        length=float(length),
        rate=float(p.rate),
        least_step=float(p.least_step),
        largest_step=float(p.largest_step),
        snap=float(p.snap),
        prominence=float(p.prominence),
        agreement=float(p.agreement),
        gap=1e-3 * float(length),
        voxel=voxel,
    )
    if not len(seed.faces):
        raise InvalidInput("invalid_mesh", "The seed of the tangential flow has no faces.")
    vertices, faces = seed.vertices, seed.faces
    normals = seed.vertex_normals
    state = np.zeros(2, dtype=np.int64)
    grown = stitched = refused = 0
    limited = False
    for attempt in range(MENDINGS + 1):
        front = _front(vertices, normals, faces, length)
        outcome = fronts.NO_ROOM
        while outcome == fronts.NO_ROOM:
            queue = np.empty(3 * len(front.corners), dtype=np.int32)
            if check_cancelled is not None:
                check_cancelled()
            outcome = _growth_kernels.grow(front, values, inverse, dials, p.max_vertices, queue, state)
            if outcome == fronts.NO_ROOM:
                front = _larger(front, length)
        limited = outcome == fronts.LIMIT
        for least in STITCH_AGREEMENT:
            if limited:
                break
            while (
                _stitch_kernels.stitch(front, dials, least, np.empty(3 * len(front.corners), dtype=np.int32))
                != fronts.DONE
            ):
                front = _larger(front, length)
        grown += int(front.layout[fronts.GROWN])
        stitched += int(front.layout[fronts.STITCHED])
        refused += int(front.layout[fronts.REFUSED])
        top, count = int(front.layout[fronts.VERTICES]), int(front.layout[fronts.FACES])
        vertices, normals, faces = front.points[:top], front.normals[:top], front.corners[:count]
        holes = int(np.count_nonzero(front.twin[: 3 * count] < 0))
        if limited or not holes or attempt == MENDINGS:
            break
        # Around a hole that can't be stitched something is in the way: it goes, and what grows there anew may fit.
        bad = np.zeros(top, dtype=np.bool_)
        open_edges = np.flatnonzero(front.twin[: 3 * count] < 0)
        bad[faces[open_edges // 3, open_edges % 3]] = True
        for _ in range(attempt):
            bad[faces[bad[faces].any(axis=1)]] = True
        kept = ~bad[faces].any(axis=1)
        if not kept.any():
            break
        vertices, normals, faces = _used(vertices, normals, faces[kept])
    vertices, normals, faces = _used(vertices, normals, faces)
    vertices, faces = _parted(vertices, faces)
    return TangentialFlowResult(TriangleMesh(vertices, faces), holes, int(state[0]), grown, stitched, refused, limited)


def seed_triangle(
    field: NDArray[np.float32], affine: ArrayLike, point: ArrayLike, *, edge_length: float, threshold: float = 0.0
) -> TriangleMesh | None:
    """Return a triangle on the border of the object that holds a point, to let the tangential flow start from.

    Parameters
    ----------
    field, affine, threshold
        See `tangential_flow`.
    point : (3,)
        RAS mm, inside the object.
    edge_length
        mm.

    Returns
    -------
    TriangleMesh or None
        None where no border is met in any of 26 directions.
    """
    matrix = check_affine(affine)
    values = np.ascontiguousarray(field, dtype=np.float32)
    inverse = np.ascontiguousarray(np.linalg.inv(matrix)[:3])
    voxel = float(np.linalg.norm(matrix[:3, :3], axis=0).min())
    corners = np.zeros((3, 3))
    found = _level_kernels.first_triangle(
        values, inverse, np.asarray(point, dtype=np.float64), float(threshold), SEED_EDGES * edge_length, voxel, corners
    )
    return TriangleMesh(corners, [[0, 1, 2]]) if found else None


def _front(vertices: FloatArray, normals: FloatArray, faces: NDArray[np.int32], length: float) -> fronts.Front:
    """Return the arrays of a surface to start from."""
    room = 2 * max(ROOM, len(vertices))
    front = _empty(room)
    front.points[: len(vertices)] = vertices.astype(np.float32)
    front.normals[: len(normals)] = normals
    front.corners[: len(faces)] = faces
    front.layout[fronts.VERTICES], front.layout[fronts.FACES] = len(vertices), len(faces)
    if not fronts.begin(front, length):
        raise InvalidInput("invalid_mesh", "The seed of the tangential flow is not manifold and oriented.")
    return front


def _empty(room: int) -> fronts.Front:
    faces = 2 * room + 2 * fronts.MARGIN
    table = 1 << int(np.ceil(np.log2(6 * faces)))
    return fronts.Front(
        points=np.zeros((room, 3)),
        normals=np.zeros((room, 3)),
        mode=np.full(room, fronts.ACTIVE, dtype=np.int8),
        free=np.zeros(room, dtype=np.int32),
        corners=np.zeros((faces, 3), dtype=np.int32),
        planes=np.zeros((faces, 3)),
        twin=np.full(3 * faces, -1, dtype=np.int32),
        keys=np.zeros(table, dtype=np.int64),
        values=np.zeros(table, dtype=np.int32),
        head=np.full(fronts.CELLS**3, -1, dtype=np.int32),
        after=np.full(faces, -1, dtype=np.int32),
        layout=np.zeros(fronts.LAYOUT, dtype=np.int64),
    )


def _larger(front: fronts.Front, length: float) -> fronts.Front:
    """Return larger arrays with the same surface."""
    larger = _empty(2 * len(front.points))
    top, count = int(front.layout[fronts.VERTICES]), int(front.layout[fronts.FACES])
    larger.points[:top], larger.normals[:top] = front.points[:top], front.normals[:top]
    larger.mode[:top] = front.mode[:top]
    larger.corners[:count] = front.corners[:count]
    larger.layout[:] = front.layout
    fronts.begin(larger, length)
    return larger


def _parted(vertices: FloatArray, faces: NDArray[np.int32]) -> tuple[FloatArray, NDArray[np.int32]]:
    """Return the surface with every vertex split at which several fans of faces meet, the copies drawn apart."""
    pinched = TriangleMesh(vertices, faces).topology.nonmanifold_vertices
    if not len(pinched):
        return vertices, faces
    points, faces = list(vertices), faces.copy()
    for v in pinched.tolist():
        waiting = set(np.flatnonzero((faces == v).any(axis=1)).tolist())
        first = True
        while waiting:
            fan = [waiting.pop()]
            rim = set(faces[fan[0]].tolist()) - {v}
            while beside := [f for f in waiting if rim.intersection(faces[f].tolist())]:
                waiting.difference_update(beside)
                fan += beside
                rim.update(faces[beside].ravel().tolist())
                rim.discard(v)
            place = vertices[v] + PART * (np.mean([points[u] for u in rim], axis=0) - vertices[v])
            if first:
                points[v] = place
            else:
                faces[fan] = np.where(faces[fan] == v, len(points), faces[fan])
                points.append(place)
            first = False
    return np.array(points).astype(np.float32).astype(np.float64), faces


def _used(
    vertices: FloatArray, normals: FloatArray, faces: NDArray[np.int32]
) -> tuple[FloatArray, FloatArray, NDArray[np.int32]]:
    """Return the same without vertices that no face has."""
    used = np.unique(faces)
    number = np.zeros(len(vertices), dtype=np.int32)
    number[used] = np.arange(len(used), dtype=np.int32)
    return vertices[used], normals[used], number[faces]

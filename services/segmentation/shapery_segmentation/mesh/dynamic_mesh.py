"""A closed surface that changes its triangles while it moves, and never touches itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_segmentation.mesh import _grid_kernels as grid
from shapery_segmentation.mesh import _motion_kernels as motion
from shapery_segmentation.mesh import _remesh_kernels as passes
from shapery_segmentation.mesh.arrays import (
    CLEARANCE,
    FACE_COUNT,
    FACE_TOP,
    INVERSE_CELL,
    MASK,
    ORIGIN,
    OUT,
    SHIFT,
    TOUCHED,
    TWIN,
    UNTOUCHED,
    VERTEX_COUNT,
    VERTEX_TOP,
    MeshArrays,
    allocate,
    grown,
)

SPLIT_RATIO = 1.4
"""An edge longer than this multiple of its target is split; its halves then stay above `COLLAPSE_RATIO`."""

COLLAPSE_RATIO = 0.6
"""An edge shorter than this multiple of its target is collapsed."""

LONGEST_RATIO = 1.35
"""A collapse makes no edge longer than this, or the next pass would split it again."""

CLEARANCE_SHARE = 1e-4
"""Distance that faces without a common vertex keep, as a share of the edge length; and at least
`LEAST_CLEARANCE`."""

LEAST_CLEARANCE = 1e-6
"""In mm."""

CELL_RATIO = 0.8
"""Size of the grid's cells in edge lengths."""

LARGEST_GRID_BITS = 20
"""Cells of the grid at the most, as a power of two; a larger region repeats (see `_grid_kernels`)."""

LARGEST_PASSES = 24
"""Rounds of splitting at the most when a mesh is brought to a much shorter edge length."""


@dataclass(slots=True)
class RemeshCount:
    """What one remeshing did."""

    splits: int = 0
    collapses: int = 0
    flips: int = 0


class DynamicMesh:
    """A closed, oriented manifold in RAS mm whose edges split, flip and collapse while its vertices move.

    Every operation keeps it closed, manifold, oriented, of the same genus, and free of self-contacts; one that cannot
    is not done.

    Parameters
    ----------
    surface
        A closed, manifold, consistently oriented mesh without self-intersections. Several components are allowed.
        Positions are rounded to float32 values.
    edge_length
        Target edge length in mm.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where the surface is not as demanded.
    """

    def __init__(self, surface: TriangleMesh, edge_length: float) -> None:
        if not (np.isfinite(edge_length) and edge_length > 0):
            raise ValueError(f"the edge length must be positive, not {edge_length}")
        _check_surface(surface)
        used, inverse = np.unique(surface.faces, return_inverse=True)
        faces = inverse.reshape(-1, 3).astype(np.int32)
        n, m = len(used), len(faces)
        arrays = allocate(2 * n + 256, 2 * m + 512)
        arrays.points[:n, :3] = surface.vertices[used].astype(np.float32)
        arrays.half_edges[: 3 * m, ORIGIN] = faces.ravel()
        arrays.half_edges[: 3 * m, TWIN] = _twins(faces)
        arrays.vertices[faces.ravel()[::-1], OUT] = np.arange(3 * m, dtype=np.int32)[::-1]
        arrays.layout[[VERTEX_TOP, VERTEX_COUNT]] = n
        arrays.layout[[FACE_TOP, FACE_COUNT]] = m
        arrays.bound[CLEARANCE] = max(CLEARANCE_SHARE * edge_length, LEAST_CLEARANCE)
        self.arrays: MeshArrays = arrays
        self.edge_length = float(edge_length)
        self._batch = 0
        self.rebuild_grid()
        touching = self.contacts()
        if touching:
            raise InvalidInput(
                "invalid_mesh",
                f"{touching} of the {m} faces of the surface to start from touch others that are not their neighbours.",
                "Start from a surface without self-intersections.",
            )

    @property
    def vertex_count(self) -> int:
        """Vertices in use."""
        return int(self.arrays.layout[VERTEX_COUNT])

    @property
    def face_count(self) -> int:
        """Faces in use."""
        return int(self.arrays.layout[FACE_COUNT])

    @property
    def volume(self) -> float:
        """Enclosed volume in mm³; negative where the faces look inwards."""
        return float(passes.signed_volume(self.arrays))

    @property
    def live(self) -> NDArray[np.int32]:
        """(n,) slots of the vertices in use, in rising order."""
        return np.flatnonzero(self.arrays.vertices[: self.arrays.layout[VERTEX_TOP], OUT] >= 0).astype(np.int32)

    @property
    def vertex_slots(self) -> int:
        """Length of arrays that hold something per vertex."""
        return len(self.arrays.vertices)

    def to_triangle_mesh(self) -> TriangleMesh:
        """Return the present surface, its vertices in the order of their slots."""
        live = self.live
        number = np.full(self.vertex_slots, -1, dtype=np.int32)
        number[live] = np.arange(len(live), dtype=np.int32)
        corners = self.arrays.half_edges[: 3 * self.arrays.layout[FACE_TOP], ORIGIN].reshape(-1, 3)
        return TriangleMesh(self.arrays.points[live, :3], number[corners[corners[:, 0] >= 0]])

    def contacts(self) -> int:
        """Return the number of faces that touch others than their neighbours: 0, or something here is broken."""
        return int(grid.count_contacts(self.arrays, self.next_batch()))

    def rebuild_grid(self) -> None:
        """Size the grid for the region that the surface fills now, and put all faces in."""
        arrays = self.arrays
        points = arrays.points[self.live, :3]
        extent = points.max(axis=0) - points.min(axis=0)
        # Far more cells than faces would only be emptied again and again.
        _, mean, _ = passes.edge_statistics(arrays)
        cell = CELL_RATIO * max(self.edge_length, 0.5 * float(mean))
        bits = np.ceil(np.log2(np.maximum(extent / cell + 2.0, 2.0))).astype(np.int64)
        while bits.sum() > LARGEST_GRID_BITS:
            bits[np.argmax(bits)] -= 1
        arrays.bound[INVERSE_CELL] = 1.0 / cell
        arrays.layout[MASK : MASK + 3] = (1 << bits) - 1
        arrays.layout[SHIFT] = bits[1] + bits[2]
        arrays.layout[SHIFT + 1] = bits[2]
        size = 1 << int(bits.sum())
        head = arrays.head if len(arrays.head) == size else np.empty(size, dtype=np.int32)
        head.fill(-1)
        self.arrays = arrays._replace(head=head)
        grid.build_grid(self.arrays)

    def remesh(self, active: NDArray[np.int8] | None = None, *, rounds: int = 1) -> RemeshCount:
        """Split long edges, collapse short ones and flip those that triangles squeeze.

        Parameters
        ----------
        active : (vertex_slots,) int8
            Edges are looked at where this is set at an end; everywhere if it is not given.
        rounds
            How often to do so; ends early where nothing changes any more.

        Returns
        -------
        RemeshCount
            What was done. ``arrays.touched`` names the vertices concerned until `clear_touched` is called.
        """
        total = RemeshCount()
        for _ in range(rounds):
            chosen = np.ones(self.vertex_slots, dtype=np.int8) if active is None else active
            done = RemeshCount(
                splits=self._split(chosen),
                collapses=int(
                    passes.collapse_pass(
                        self.arrays, self.edge_length, COLLAPSE_RATIO, LONGEST_RATIO, self._fitting(chosen)
                    )
                ),
                flips=int(passes.flip_pass(self.arrays, self._fitting(chosen))),
            )
            total.splits += done.splits
            total.collapses += done.collapses
            total.flips += done.flips
            if not (done.splits or done.collapses or done.flips):
                break
            # Longest faces got shorter and all may lie elsewhere now.
            self.rebuild_grid()
        return total

    def move(self, movers: NDArray[np.int32], target: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Move vertices; those whose faces would touch others, turn over or degenerate stay where they are.

        Parameters
        ----------
        movers : (n,) int32
            Slots, each once.
        target : (n, 3) float64
            Where to, RAS mm.

        Returns
        -------
        (n,) bool
            Which of them moved.
        """
        places = np.zeros((self.vertex_slots, 3))
        places[movers] = target
        state = np.zeros(self.vertex_slots, dtype=np.int8)
        motion.move_vertices(
            self.arrays, np.asarray(movers, dtype=np.int32), places, np.empty_like(places), state, self.next_batch()
        )
        return np.asarray(state[movers] == motion.MOVED)

    def next_batch(self) -> int:
        """Return a stamp that no face carries."""
        self._batch += 1
        return self._batch

    def clear_touched(self) -> None:
        """Forget which vertices operations touched."""
        self.arrays.vertices[:, TOUCHED] = UNTOUCHED

    def _split(self, active: NDArray[np.int8]) -> int:
        done, at = 0, 0
        while True:
            more, at = passes.split_pass(self.arrays, at, self.edge_length, SPLIT_RATIO, self._fitting(active))
            done += int(more)
            if at < 0:
                return done
            self.arrays = grown(self.arrays, 2 * self.vertex_slots, 2 * len(self.arrays.links))

    def _fitting(self, active: NDArray[np.int8]) -> NDArray[np.int8]:
        """Return `active` as long as the vertex arrays are now; new vertices are found by what touched them."""
        if len(active) >= self.vertex_slots:
            return active
        longer = np.zeros(self.vertex_slots, dtype=np.int8)
        longer[: len(active)] = active
        return longer


def _check_surface(surface: TriangleMesh) -> None:
    """Raise ``invalid_mesh`` unless the surface is a closed, oriented manifold."""
    if len(surface.faces) < 4:
        raise InvalidInput("invalid_mesh", f"A closed surface has at least 4 faces, this one has {len(surface.faces)}.")
    if not surface.closed:
        raise InvalidInput(
            "invalid_mesh",
            f"The surface to start from has {len(surface.boundary_edges)} boundary edges.",
            "Close it first.",
        )
    if not (surface.manifold and surface.oriented):
        what = "manifold" if not surface.manifold else "oriented consistently"
        raise InvalidInput("invalid_mesh", f"The surface to start from is not {what}.", "Repair it first.")


def _twins(faces: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return for each half-edge of a closed oriented mesh the one that runs the other way."""
    start = faces.ravel().astype(np.int64)
    end = np.roll(faces, -1, axis=1).ravel().astype(np.int64)
    n = int(start.max()) + 1
    forward = np.argsort(start * n + end, kind="stable")
    backward = np.argsort(end * n + start, kind="stable")
    twin = np.empty(len(start), dtype=np.int32)
    twin[forward] = backward
    return twin

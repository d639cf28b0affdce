"""A closed surface that changes its triangles while it moves, and never touches itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_segmentation.mesh import _cells_kernels as cells
from shapery_segmentation.mesh import _grid_kernels as grid
from shapery_segmentation.mesh import _motion_kernels as motion
from shapery_segmentation.mesh import _order_kernels as orders
from shapery_segmentation.mesh import _remesh_kernels as passes
from shapery_segmentation.mesh import _whole_kernels as whole
from shapery_segmentation.mesh.arrays import (
    CARELESS,
    CLEARANCE,
    FACE_COUNT,
    FACE_TOP,
    INVERSE_CELL,
    MASK,
    ORIGIN,
    OUT,
    SHIFT,
    TOUCHED,
    UNTOUCHED,
    VERTEX_COUNT,
    VERTEX_TOP,
    Cells,
    MeshArrays,
    Moves,
    allocate,
    grown,
    room_for_cells,
    room_for_moves,
)
from shapery_segmentation.mesh.contacts import find_contacts

SPLIT_RATIO = 1.5
"""An edge longer than this multiple of its target is split; its halves then stay above `COLLAPSE_RATIO`."""

COLLAPSE_RATIO = 0.6
"""An edge shorter than this multiple of its target is collapsed."""

DELAUNAY_SLACK = 0.05
"""How much an edge must fail the Delaunay condition to be flipped: no endless flipping of four points on a circle."""

ALL = 1 << 62
"""More half-edges than there can be."""

COARSENING = 1.7
"""A mesh that is much too fine gets coarser by at most about this factor in one round: evenly, and the grid follows."""

SETTLED = 1e-3
"""Operations per face in one round of remeshing at which no other round is worth it."""

LONGEST_RATIO = 1.35
"""A collapse makes no edge longer than this, or the next pass would split it again."""

CLEARANCE_SHARE = 1e-4
"""Distance that faces without a common vertex keep, as a share of the edge length; and at least
`LEAST_CLEARANCE`."""

LEAST_CLEARANCE = 1e-6
"""In mm."""

MENDINGS = 4
"""Rounds in which faces that touch are drawn apart."""

CELL_RATIO = 1.2
"""Size of the grid's cells in mean edge lengths."""

CELLS_PER_FACE = 8
"""Cells of the grid per face at the most; a larger region repeats (see `_grid_kernels`). More would be slower: they
leave the cache."""

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
    test
        Whether to refuse self-intersections at once; otherwise `retriangulate` refuses those that it comes upon.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where the surface is not as demanded.
    """

    def __init__(self, surface: TriangleMesh, edge_length: float, *, test: bool = True) -> None:
        if not (np.isfinite(edge_length) and edge_length > 0):
            raise ValueError(f"the edge length must be positive, not {edge_length}")
        if len(surface.faces) < 4:
            raise InvalidInput(
                "invalid_mesh", f"A closed surface has at least 4 faces, this one has {len(surface.faces)}."
            )
        self.edge_length = float(edge_length)
        self.mean_edge = self.edge_length
        self.cells = room_for_cells(0, 0)
        self.moves = room_for_moves(0, 0)
        self._batch = 0
        used = np.flatnonzero(np.bincount(surface.faces.ravel(), minlength=len(surface.vertices)))
        number = np.zeros(len(surface.vertices), dtype=np.int32)
        number[used] = np.arange(len(used), dtype=np.int32)
        points = np.ones((len(used), 4))
        points[:, :3] = surface.vertices[used].astype(np.float32)
        self._take(points, number[surface.faces])
        self.arrays.bound[CLEARANCE] = max(CLEARANCE_SHARE * edge_length, LEAST_CLEARANCE)
        if test:
            self._refuse_contacts()

    def _refuse_contacts(self) -> None:
        """Refuse the surface to start from where it touches itself."""
        if self.touches_itself():
            raise InvalidInput(
                "invalid_mesh",
                f"{self.contacts()} of the {self.face_count} faces of the surface to start from touch others.",
                "Start from a surface without self-intersections.",
            )

    def _take(self, points: NDArray[np.float64], faces: NDArray[np.int32]) -> None:
        """Put vertices (n, 4) and faces into arrays of their own, without holes, in the order of space."""
        order = _in_space_order(points, self.edge_length)
        number = np.empty(len(points), dtype=np.int32)
        number[order] = np.arange(len(points), dtype=np.int32)
        points, faces = points[order], number[faces]
        faces = faces[_in_space_order(points[faces[:, 0]], self.edge_length)]
        n, m = len(points), len(faces)
        arrays = _with_room(n, m)
        arrays.points[:n] = points
        arrays.half_edges[: 3 * m, ORIGIN] = faces.ravel()
        wrong = int(passes.link_twins(arrays, n, m))
        if wrong > 0:
            raise InvalidInput(
                "invalid_mesh",
                f"The surface to start from has {wrong} half-edges that do not meet exactly one other half-edge.",
                "Give a closed, manifold and consistently oriented surface.",
            )
        if wrong < 0:
            raise InvalidInput(
                "invalid_mesh",
                f"The surface to start from has {-wrong} vertices in which it touches itself.",
                "Give a manifold surface.",
            )
        self.arrays: MeshArrays = arrays
        grid.measure_all(arrays)
        self.size_grid()

    def compact(self) -> None:
        """Move vertices and faces to new slots, without holes and so that neighbours in space are neighbours in memory.

        Everything that the slots of vertices are known by becomes meaningless.
        """
        self._sort_in_space(self.arrays)

    def _sort_in_space(self, source: MeshArrays) -> NDArray[np.int64]:
        """Take over a mesh without holes, in the order of space; return the slots that its vertices had."""
        live, used = _slots(source)
        vertices = live[_in_space_order(source.points[live], self.edge_length)]
        first = source.half_edges[3 * used, ORIGIN]
        faces = used[_in_space_order(source.points[first], self.edge_length)]
        self.arrays = _with_room(len(vertices), len(faces))
        self.arrays.bound[CLEARANCE] = source.bound[CLEARANCE]
        orders.transfer(source, self.arrays, vertices, faces)
        self.size_grid()
        return vertices

    def subdivide(self, *, test: bool = True) -> NDArray[np.int32] | None:
        """Cut every face into four at the middles of its edges, which halves the edges and leaves the surface as it is.

        Parameters
        ----------
        test
            Whether to make sure that rounding brings no faces too near to each other.

        Returns
        -------
        (n, 2) int32
            For every vertex, the slots that the ends of its edge had, or twice that which it had itself; None where
            that test fails, and nothing was done.
        """
        before = self.arrays
        live, used = _slots(before)
        dense = _with_room(len(live), len(used))
        dense.bound[CLEARANCE] = before.bound[CLEARANCE]
        orders.transfer(before, dense, live, used)
        n = len(live) + 3 * len(used) // 2
        finer = _with_room(n, 4 * len(used))
        finer.bound[CLEARANCE] = before.bound[CLEARANCE]
        parents = np.empty((n, 2), dtype=np.int32)
        orders.cut_into_four(dense, finer, parents)
        order = self._sort_in_space(finer)
        if test and self.touches_itself():
            self.arrays = before
            self.size_grid()
            return None
        return live[parents[order]].astype(np.int32)

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
    def part_volumes(self) -> NDArray[np.float64]:
        """(n,) mm³ that each part encloses that hangs together; negative where it is a cavity."""
        return np.asarray(orders.part_volumes(self.arrays))

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
        live, faces = self.live_faces()
        return TriangleMesh(self.arrays.points[live, :3], faces)

    def live_faces(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return the slots of the vertices in use, and the faces in terms of their rank among these."""
        live = self.live
        number = np.full(self.vertex_slots, -1, dtype=np.int32)
        number[live] = np.arange(len(live), dtype=np.int32)
        corners = self.arrays.half_edges[: 3 * self.arrays.layout[FACE_TOP], ORIGIN].reshape(-1, 3)
        return live, number[corners[corners[:, 0] >= 0]]

    def touches_itself(self) -> bool:
        """Return whether any faces touch others than their neighbours, or neighbours more than they should."""
        self.sort_cells()
        return bool(find_contacts(self.arrays, self.cells, np.zeros(0, dtype=np.bool_)))

    def contacts(self) -> int:
        """Return the number of faces that touch others with a higher number, by the plain test of every near pair."""
        self.sort_cells()
        return int(whole.count_contacts(self.arrays, self.cells))

    def mend(self, rounds: int = MENDINGS) -> bool:
        """Draw the vertices of faces that touch others to the means of their neighbours, until nothing touches.

        Returns
        -------
        Whether so many rounds were enough.
        """
        self.sort_cells()
        concerned = np.zeros(self.vertex_slots, dtype=np.bool_)
        touching = find_contacts(self.arrays, self.cells, concerned)
        for _ in range(rounds):
            if not touching:
                break
            chosen = np.flatnonzero(concerned)
            whole.draw_together(self.arrays, chosen)
            self.sort_cells()
            concerned[:] = False
            touching = whole.find_contacts_around(
                self.arrays, self.cells, chosen, concerned, self.room_for_moves().found[0]
            )
        return not touching

    def size_grid(self) -> None:
        """Choose the size of the grid's cells, and their number by the region that the surface fills now."""
        arrays = self.arrays
        extent = np.empty(3)
        area = grid.measure_extent(arrays, extent)
        # The side of an equilateral triangle of the mean area.
        self.mean_edge = float(np.sqrt(4.0 / np.sqrt(3.0) * area))
        cell = CELL_RATIO * self.mean_edge
        bits = np.ceil(np.log2(np.maximum(extent / cell + 2.0, 2.0))).astype(np.int64)
        while 1 << int(bits.sum()) > CELLS_PER_FACE * self.face_count + 1024:
            bits[np.argmax(bits)] -= 1
        arrays.bound[INVERSE_CELL] = 1.0 / cell
        arrays.layout[MASK : MASK + 3] = (1 << bits) - 1
        arrays.layout[SHIFT] = bits[1] + bits[2]
        arrays.layout[SHIFT + 1] = bits[2]
        size = 1 << int(bits.sum())
        if len(arrays.head) != size:
            self.arrays = arrays._replace(head=np.full(size, -1, dtype=np.int32))

    def sort_cells(self) -> None:
        """Bring `cells` up to date, in which kernels look for what is near."""
        cells.sort_into_cells(self.arrays, self.room_for_cells())

    def room_for_cells(self) -> Cells:
        """Return `cells`, made anew if the grid or the arrays have changed their size."""
        size, faces = len(self.arrays.head), len(self.arrays.links)
        if len(self.cells.start) != size + 1 or len(self.cells.names) != faces:
            self.cells = room_for_cells(size, faces)
        return self.cells

    def remesh(
        self,
        active: NDArray[np.int8] | None = None,
        *,
        unwanted: NDArray[np.int8] | None = None,
        rounds: int = 1,
        careless: bool = False,
    ) -> RemeshCount:
        """Split long edges, collapse short ones and flip those that triangles squeeze.

        Parameters
        ----------
        active : (vertex_slots,) int8
            Edges are looked at where this is set at an end; everywhere if it is not given.
        unwanted : (vertex_slots,) int8
            1 for vertices that are to collapse into a neighbour, if that keeps the surface what it is.
        rounds
            How often to do so; ends early where hardly anything changes any more.
        careless
            Operations are not tested against the faces around them. A contact is rare, and to look for it at every
            operation costs more than all the rest: the caller asks `touches_itself` in the end.

        Returns
        -------
        RemeshCount
            What was done. ``arrays.touched`` names the vertices concerned until `clear_touched` is called.
        """
        total = RemeshCount()
        for _ in range(rounds):
            chosen = np.ones(self.vertex_slots, dtype=np.int8) if active is None else active
            self.size_grid()
            self.arrays.layout[CARELESS] = careless
            if not careless:
                self.arrays.head.fill(-1)
                grid.build_grid(self.arrays)
            done = RemeshCount(
                splits=self._split(chosen),
                collapses=self._collapse(chosen, unwanted),
                flips=int(passes.flip_pass(self.arrays, 0, ALL, DELAUNAY_SLACK, self._fitting(chosen))),
            )
            total.splits += done.splits
            total.collapses += done.collapses
            total.flips += done.flips
            if done.splits + done.collapses + done.flips <= SETTLED * self.face_count:
                break
        self.arrays.layout[CARELESS] = 0
        return total

    def retriangulate(self, rounds: int, *, given: bool = True, test: bool = True) -> None:
        """Bring all edges near their target, and compact the arrays.

        Without care first; only where that ends in a contact everything is done again with it. Slots become
        meaningless.

        Parameters
        ----------
        rounds
            Of remeshing, at the most.
        given
            Whether the surface comes from a caller, who is told where it touched itself before, unless `mend` can help.
        test
            Whether to look for contacts; without that the caller asks for `mend` in the end.

        Raises
        ------
        InvalidInput
            ``invalid_mesh`` where a given surface touched itself before.
        """
        live, faces = self.live_faces() if test else (np.zeros(0, np.int32), np.zeros((0, 3), np.int32))
        points, clearance = self.arrays.points[live], self.arrays.bound[CLEARANCE]
        self.remesh(rounds=rounds, careless=True)
        if test and self.touches_itself():
            self._take(points, faces)
            self.arrays.bound[CLEARANCE] = clearance
            if not self.mend() and given:
                self._refuse_contacts()
            self.remesh(rounds=rounds)
        self.compact()

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
        movers = np.asarray(movers, dtype=np.int32)
        batch = self.next_batch()
        motion.move_vertices(self.arrays, self.room_for_cells(), movers, places, self.room_for_moves(), batch)
        return np.asarray(self.moves.state[movers] == batch)

    def room_for_moves(self) -> Moves:
        """Return `moves`, made anew if the arrays have changed their size."""
        if len(self.moves.state) != self.vertex_slots or len(self.moves.wrong) != len(self.arrays.links):
            self.moves = room_for_moves(self.vertex_slots, len(self.arrays.links))
        return self.moves

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
            more, at = passes.split_pass(self.arrays, at, ALL, self.edge_length, SPLIT_RATIO, self._fitting(active))
            done += int(more)
            if at < 0:
                return done
            self.arrays = grown(self.arrays, 2 * self.vertex_slots, 2 * len(self.arrays.links))

    def _collapse(self, active: NDArray[np.int8], unwanted: NDArray[np.int8] | None) -> int:
        named = np.zeros(0, dtype=np.int8) if unwanted is None else unwanted.copy()
        length = min(self.edge_length, COARSENING * self.mean_edge)
        return int(
            passes.collapse_pass(
                self.arrays,
                0,
                ALL,
                length,
                COLLAPSE_RATIO,
                LONGEST_RATIO,
                self._fitting(active),
                self._fitting(named),
            )
        )

    def _fitting(self, active: NDArray[np.int8]) -> NDArray[np.int8]:
        """Return `active` as long as the vertex arrays are now; new vertices are found by what touched them."""
        if len(active) >= self.vertex_slots:
            return active
        longer = np.zeros(self.vertex_slots, dtype=np.int8)
        longer[: len(active)] = active
        return longer


def _with_room(vertices: int, faces: int) -> MeshArrays:
    """Return empty arrays for so many vertices and faces in use, and half as many more."""
    arrays = allocate(vertices + vertices // 2 + 256, faces + faces // 2 + 512)
    arrays.layout[[VERTEX_TOP, VERTEX_COUNT]] = vertices
    arrays.layout[[FACE_TOP, FACE_COUNT]] = faces
    return arrays


def _slots(arrays: MeshArrays) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the slots of vertices and faces in use, in rising order."""
    vertices = np.flatnonzero(arrays.vertices[: arrays.layout[VERTEX_TOP], OUT] >= 0)
    return vertices, np.flatnonzero(arrays.half_edges[: 3 * arrays.layout[FACE_TOP] : 3, ORIGIN] >= 0)


def _in_space_order(points: NDArray[np.float64], cell: float) -> NDArray[np.int64]:
    """Return an order of points in which neighbours in space are neighbours in memory."""
    order = np.empty(len(points), dtype=np.int64)
    orders.space_order(points, cell, order)
    return order

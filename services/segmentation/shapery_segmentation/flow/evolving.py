"""A surface on its way through the normal flow: what is done in which order, stage by stage (3.4.1)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.concurrent import both
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.volume import Volume
from shapery_segmentation.flow import _repair_kernels as repair
from shapery_segmentation.flow import _speed_kernels as speed
from shapery_segmentation.flow import _state_kernels as states
from shapery_segmentation.flow import _step_kernels as steps
from shapery_segmentation.flow.edges import EdgeIndicator
from shapery_segmentation.flow.interpolation import LEAST_TRUSTED, TRUSTED, contrasts, interpolated
from shapery_segmentation.flow.params import FlowResult, FlowState, NormalFlowParams, StageRecord
from shapery_segmentation.flow.threshold import median_inside
from shapery_segmentation.flow.topology import reconnected, without_remains
from shapery_segmentation.mesh import _motion_kernels as motion
from shapery_segmentation.mesh.arrays import LARGEST_RADIUS, SCALE, VERTEX_TOP
from shapery_segmentation.mesh.contacts import MANY, measure, verify
from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh

SEED_ROUNDS = 12
"""Rounds of remeshing at the most that bring a seed to the first edge length."""

EVEN = 0.8, 1.25
"""Mean edge over the edge length asked for between which a new surface need not be remeshed at first."""

STAGE_ROUNDS = 4
"""The same from one stage to the next."""

SUBDIVIDED = 1.7
"""Ratio of the edge lengths of two stages from which every face is cut into four, instead of edge by edge."""

STEADY_SHARE = 0.1
"""Moves per vertex since the threshold was last worked out, below which it is still the same."""

STILL = 0.05
"""Change of the threshold, in units of the field, that leaves vertices asleep."""

NOTHING_LEFT = 2.0
"""Cubes of the edge length that a surface must enclose to count as being there; a ball of this volume has a radius of
0.8 edge lengths."""

LARGEST_REFINEMENTS, LARGEST_RETREATS = 8, 50
"""Rounds per stage in which frozen vertices get finer triangles, and in which they collapse: the triangles that one
makes the other may take away, for ever. A retreat takes about half an edge length off a thin piece."""

LARGEST_FRUITLESS = 4
"""Retreats in a row that take no vertex away, after which they do not keep the surface from resting."""

RECONNECT_INTERVAL = 48
"""Iterations between two changes of topology where the surface does not come to rest."""

LARGEST_RECONNECTIONS = 4
"""How many changes of topology one stage may see."""

CLEARLY_FLAT = 0.5
"""Edge indicator above which no edge parts two fronts; the gradient model has no other notion of what is object."""

INTERPOLATIONS, PULLS = 4, 8
"""Rounds of interpolation at the end, and moves of half an edge length in each: where much was wrong, faces crowd, and
the mesh is mended in between."""

HASTE = 5.0
"""Multiple of `NormalFlowParams.awake_share` at which a stage is over that is not the last: the next one goes on."""

NO_AGING = 1 << 30
"""Changes of direction that no vertex makes."""

VERIFY_INTERVAL = 2
"""Iterations whose moves are tested together. With more, fronts that meet run into each other, are put back far, and
leave wide seams."""

LARGEST_DRIFT = 0.3
"""Edge lengths that faces may be from where they were sorted when obstacles are looked for."""

THIN = 0.3
"""Compactness (1 for an equilateral triangle) below which a face makes its vertices irregular."""


class Evolution:
    """A surface on its way, with what each vertex remembers."""

    def __init__(
        self,
        field: NDArray[np.float32],
        allowed: NDArray[np.bool_] | None,
        affine: NDArray[np.float64],
        seed: TriangleMesh,
        params: NormalFlowParams,
        threshold: float,
        thorough: bool,
    ) -> None:
        self.params = params
        self.thorough = thorough
        self.affine = np.array(affine)
        self.inverse = np.linalg.inv(self.affine)[:3]
        self.field, self.allowed = _finite(field, allowed)
        self.threshold = float(threshold)
        self.edges: EdgeIndicator | None = None
        if params.model == "gradient":
            self.edges = EdgeIndicator(self.field, self.affine, params.gradient_sigma, params.gradient_percentile)
        self.mesh = DynamicMesh(seed, params.edge_lengths[0], test=thorough)
        if self.mesh.volume <= 0:
            raise InvalidInput(
                "invalid_mesh",
                f"The seed encloses {self.mesh.volume:.3g} mm³: its faces look inwards.",
                "Turn its faces over.",
            )
        self.parts = len(self.mesh.part_volumes)
        self._moves = 0
        self.iteration = 0
        self.reconnections = self.interpolations = 0
        self.oscillating = self._most_oscillating = self._oscillations = 0
        self.vanished = False
        self.stages: list[StageRecord] = []
        self._settled_threshold = self.threshold
        self._batch = 0
        """Stamp of the moves that are not verified yet; 0 if there are none."""
        self._drift = 0.0
        """How far in mm faces may be from where they were sorted."""

    def run_stage(self, stage: int, on_iteration: Callable[[FlowState], None] | None) -> None:
        """Flow with one edge length until the surface rests."""
        p = self.params
        length = p.edge_lengths[stage]
        self._begin(stage)
        first = self.iteration
        awake = self.mesh.vertex_count
        few = p.awake_share * (1.0 if stage == len(p.edge_lengths) - 1 else HASTE)
        while self.iteration - first < p.max_iterations and not self.vanished:
            awake = self._step(length)
            self.iteration += 1
            done = self.iteration - first
            if done % VERIFY_INTERVAL == 0:
                self._verify()
            if done % p.release_interval == 0:
                self._release()
            if done % p.remesh_interval == 0:
                self._remesh(length)
            self._moves += awake
            rests = awake <= few * self.mesh.vertex_count and done % p.remesh_interval == 0 and not self._stirred
            due = rests or done % p.threshold_interval == 0
            if due and self._moves > STEADY_SHARE * self.mesh.vertex_count:
                rests = not self._update_threshold() and rests
                self._moves = 0
            if on_iteration is not None:
                state = self.mesh.vertex_count, awake, self.oscillating, self.threshold
                on_iteration(FlowState(stage, self.iteration, *state, self.mesh.to_triangle_mesh))
            if self._pinched and ((rests and len(p.edge_lengths) == 1) or done % RECONNECT_INTERVAL == 0):
                rests = not self._reconnect(length) and rests
            if rests:
                break
        if stage == len(p.edge_lengths) - 1 and p.interpolation_share is not None and not self.vanished:
            self._interpolate(p.interpolation_share, length)
        self._remesh(length)
        self.stages.append(
            StageRecord(
                edge_length=length,
                iterations=self.iteration - first,
                converged=awake <= few * self.mesh.vertex_count,
                vertices=self.mesh.vertex_count,
                threshold=self.threshold,
            )
        )

    def result(self, untouched: bool) -> FlowResult:
        """Return where the surface is, and what a test of all faces said in the end."""
        modes = self._counter[self.mesh.live, states.MODE]
        mesh = self.mesh.to_triangle_mesh()
        return FlowResult(
            mesh=mesh,
            threshold=self.threshold,
            iterations=self.iteration,
            converged=self.stages[-1].converged and not self.vanished,
            vanished=self.vanished,
            asleep=int(np.count_nonzero(modes == states.ASLEEP)),
            frozen=int(np.count_nonzero(modes == states.FROZEN)),
            aged=int(np.count_nonzero(modes == states.AGED)),
            awake=int(np.count_nonzero(modes == states.AWAKE)),
            oscillating=self._most_oscillating,
            oscillations=self._oscillations,
            interpolations=self.interpolations,
            reconnections=self.reconnections,
            untouched=untouched,
            stages=tuple(self.stages),
        )

    def _begin(self, stage: int) -> None:
        """Bring the mesh to the stage's edge length."""
        lengths = self.params.edge_lengths
        if stage and self._pinched and self._reconnect(lengths[stage - 1], lengths[stage]):
            self._refinements = self._retreats = self._fruitless = self._changes = 0
            return
        mesh = self.mesh
        if stage:
            # What was refined keeps its length in mm where that is the finer one.
            scale = mesh.arrays.points[:, SCALE]
            np.minimum(scale * (lengths[stage - 1] / lengths[stage]), 1.0, out=scale)
        mesh.edge_length = lengths[stage]
        halved = None
        if stage and lengths[stage - 1] >= SUBDIVIDED * lengths[stage]:
            halved = mesh.subdivide(test=self.thorough)
        if halved is None:
            self._take_up(STAGE_ROUNDS if stage else SEED_ROUNDS)
        else:
            # What nothing is in the way of at the longer edges has nothing in its way at the shorter ones.
            clear = self._clear[halved].min(axis=1)
            self._take_up(0)
            self._clear[: len(clear)] = clear
            self._state[:, states.SEEN : states.SEEN + 3] = mesh.arrays.points[:, :3]
            free = 0.5 * steps.FARTHER * mesh.edge_length * mesh.arrays.points[:, SCALE]
            self._state[:, states.FREE] = np.where(self._clear, free, 0.0)
        self._refinements = self._retreats = self._fruitless = self._changes = 0

    def _take_up(self, rounds: int) -> None:
        """Bring the mesh, which is new or has a new edge length, to that length; every vertex begins anew."""
        mesh = self.mesh
        if rounds:
            given = self.iteration == 0
            # Triangles of the right size get their shape while the surface moves.
            even = EVEN[0] < mesh.mean_edge / mesh.edge_length < EVEN[1]
            mesh.retriangulate(0 if even else rounds, given=given, test=given or self.thorough)
        n = mesh.vertex_slots
        self._state = np.zeros((n, states.STATE_COLUMNS))
        self._state[:, states.GAIN] = 1.0
        self._counter = np.zeros((n, states.COUNTER_COLUMNS), dtype=np.int32)
        self._clear = np.zeros(n, dtype=np.int8)
        self._target = np.zeros((0, 3))
        self._make_room()
        self._stale = self._fresh = True
        self._stirred = self._pinched = False

    def _step(self, length: float) -> int:
        """Move all vertices once; return how many are awake then."""
        mesh, dials = self.mesh, self._dials(length)
        if self._stale or self._drift > LARGEST_DRIFT * length:
            mesh.sort_cells()
            self._stale = False
            self._drift = 0.0
        if not self._batch:
            self._batch = mesh.next_batch()
            mesh.room_for_moves().counts[:] = 0
        field, inverse = self.field, self.inverse
        if self.edges is not None:
            self.edges.follow(mesh.arrays.points[mesh.live, :3])
            field, inverse = self.edges.values, self.edges.inverse

        def proposed(first: int, end: int) -> int:
            count = steps.propose(
                mesh.arrays, mesh.cells, self._state, self._counter, self._clear, field, inverse, self.allowed,
                self.inverse, dials, first, end, mesh.moves.found[min(first, 1)], self._target, self._movers,
            )  # fmt: skip
            return int(count)

        top = int(mesh.arrays.layout[VERTEX_TOP])
        moving = np.flatnonzero(self._counter[:top, states.MODE] == states.AWAKE)
        if len(moving) < MANY:
            middle, counts = top, (proposed(0, top), 0)
        else:
            middle = int(moving[len(moving) // 2])
            counts = both(lambda: proposed(0, middle), lambda: proposed(middle, top))
        self._drift += steps.advance(
            mesh.arrays, mesh.moves, self._batch, self._state, self._counter, self._target, self._movers, middle, counts
        )
        measure(mesh.arrays, mesh.cells, mesh.moves, self._batch)
        awake, self.oscillating = steps.settle(mesh.arrays, self._state, self._counter, dials)
        self._most_oscillating = max(self._most_oscillating, self.oscillating)
        self._oscillations += self.oscillating
        return int(awake)

    def _verify(self) -> None:
        """Test what moved since the last time, and put back what must not count."""
        if not self._batch:
            return
        mesh, batch = self.mesh, self._batch
        self._batch = 0
        clear = mesh.moves.none if self.thorough else self._clear
        back = verify(mesh.arrays, mesh.cells, mesh.moves, batch, clear, self._drift)
        if self._drift > motion.SORTED * mesh.arrays.bound[LARGEST_RADIUS]:
            self._drift = 0.0
        dials = self._dials(mesh.edge_length)
        steps.take_back(mesh.moves, batch, back, self._state, self._counter, self._clear, dials)
        self._stale = self._stale or back > 0

    def _remesh(self, length: float) -> None:
        """Answer what blocked vertices wish for, mend the triangles around what moves, and see what is left."""
        self._verify()
        mesh = self.mesh
        # The first time everywhere: what is at rest already has the triangles that it was given.
        fresh, self._fresh = self._fresh, False
        active = ((self._counter[:, states.MODE] == states.AWAKE) | fresh).astype(np.int8)
        refined, collapsing, pinched = repair.answer_wishes(
            mesh.arrays,
            self._state,
            self._counter,
            self._dials(length),
            self._refinements < LARGEST_REFINEMENTS,
            self._retreats < LARGEST_RETREATS,
            self._collapse,
        )
        self._refinements += refined > 0
        self._retreats += collapsing > 0
        before = mesh.vertex_count
        adaptive = self.params.topology == "adaptive" and self._changes < LARGEST_RECONNECTIONS
        self._pinched = adaptive and (self._pinched or pinched > 0)
        if refined:
            np.maximum(active, self._counter[:, states.MODE] == states.AWAKE, out=active)
        mesh.remesh(active, unwanted=self._collapse if collapsing else None, careless=not self.thorough)
        # What gets finer triangles is awake, and counted; what retreats may not be.
        self._fruitless = 0 if mesh.vertex_count < before else self._fruitless + (collapsing > 0)
        self._stirred = fresh or (collapsing > 0 and self._fruitless < LARGEST_FRUITLESS)
        self._make_room()
        states.adopt_touched(mesh.arrays, self._state, self._counter, self._clear)
        self._stale = True
        self.vanished = mesh.volume < NOTHING_LEFT * length**3
        if not self.vanished:
            self._drop_remains(NOTHING_LEFT * length**3)

    def _drop_remains(self, least: float) -> None:
        """Leave out the parts that have shrunk to nothing; a few faces more, and one could turn inside out."""
        if self.parts < 2 or np.abs(self.mesh.part_volumes).min() >= least:
            return
        before = self.mesh.to_triangle_mesh()
        after = without_remains(before, least)
        if after is not before:
            self.mesh = DynamicMesh(after, self.mesh.edge_length, test=False)
            self.parts = len(self.mesh.part_volumes)
            self._take_up(1)

    def _reconnect(self, length: float, following: float | None = None) -> bool:
        """Change the topology where the surface meets itself; return whether there was something to change.

        It costs as much as several dozen iterations, so it is done between two stages, where the mesh changes anyway:
        the new surface has the edge length of the one that is `following`. A flow of one stage does it where it comes
        to rest.
        """
        self._verify()
        self._pinched = False
        surface = reconnected(self.mesh.to_triangle_mesh(), self._object_on, length, cell=following)
        if surface is None:
            return False
        self._changes += 1
        self.reconnections += 1
        self.mesh = DynamicMesh(surface, length if following is None else following, test=False)
        self.parts = len(self.mesh.part_volumes)
        self._take_up(STAGE_ROUNDS)
        self._drop_remains(NOTHING_LEFT * self.mesh.edge_length**3)
        return True

    def _object_on(self, grid: Volume) -> NDArray[np.float32]:
        """Return what is positive on the voxels of a grid that are object: what the surface would grow into."""
        if self.edges is None:
            level = Volume(self.field, self.affine).resampled_to(grid).data - np.float32(self.threshold)
        else:
            # Between two fronts that no edge parts.
            affine = np.linalg.inv(np.vstack((self.edges.inverse, (0.0, 0.0, 0.0, 1.0))))
            flat = Volume(self.edges.values, affine).resampled_to(grid).data > CLEARLY_FLAT
            level = np.where(flat, np.float32(1.0), np.float32(-1.0))
        if self.allowed.size:
            gate = Volume(self.allowed.astype(np.float32), self.affine).resampled_to(grid).data
            level = np.where(gate >= 0.5, level, np.minimum(level, 2.0 * gate - 1.0))
        return np.asarray(level, dtype=np.float32)

    def _release(self) -> None:
        """Smooth the vertices of thin triangles, which would keep the flow from converging."""
        self._verify()
        count = repair.irregular_vertices(self.mesh.arrays, self._counter, THIN, self._target, self._movers)
        if count:
            self._move(self._movers[:count])

    def _move(self, movers: NDArray[np.int32]) -> None:
        """Move vertices to their targets, where that is possible."""
        mesh = self.mesh
        motion.move_vertices(
            mesh.arrays, mesh.room_for_cells(), movers, self._target, mesh.room_for_moves(), mesh.next_batch()
        )
        self._stale = True

    def _interpolate(self, share: float, length: float) -> None:
        """Put the vertices that the data do not hold between those that they do, if too many are such (S8)."""
        mesh = self.mesh
        for _ in range(INTERPOLATIONS):
            self._verify()
            live, faces = mesh.live_faces()
            points = mesh.arrays.points[live, :3]
            weight = contrasts(points, faces, self.field, self.inverse, length)
            trusted = weight >= TRUSTED
            if not LEAST_TRUSTED <= trusted.mean() < 1.0 - share:
                break
            self.interpolations += 1
            places, others = interpolated(points, faces, trusted, np.clip(weight, 0.0, 1.0))[~trusted], live[~trusted]
            for _ in range(PULLS):
                way = places - mesh.arrays.points[others, :3]
                far = np.linalg.norm(way, axis=1, keepdims=True)
                way *= np.minimum(1.0, 0.5 * length / np.maximum(far, 1e-30))
                self._target[others] = mesh.arrays.points[others, :3] + way
                self._move(others)
            mesh.remesh(rounds=STAGE_ROUNDS)
            self._make_room()
            states.adopt_touched(mesh.arrays, self._state, self._counter, self._clear)

    def _update_threshold(self) -> bool:
        """Let the threshold follow what is inside; where it changed by more than a little, wake all, and tell so."""
        p = self.params
        if p.threshold_share is None or p.model != "threshold":
            return False
        inside = median_inside(self.field, self.affine, self.mesh.to_triangle_mesh())
        if inside is None:
            return False
        ground = p.threshold_ground
        self.threshold = float(np.clip(ground + p.threshold_share * (inside - ground), *p.threshold_range))
        if abs(self.threshold - self._settled_threshold) <= STILL:
            return False
        self._settled_threshold = self.threshold
        states.wake_all(self.mesh.arrays, self._state, self._counter)
        self._stirred = True
        return True

    def _dials(self, length: float) -> speed.Dials:
        p = self.params
        return speed.Dials(
            model=speed.THRESHOLD if p.model == "threshold" else speed.GRADIENT,
            threshold=self.threshold,
            balloon=float(p.balloon),
            length=float(length),
            step=float(p.step),
            bend=float(p.curvature_weight),
            slide=float(p.tangential_weight),
            front=float(p.front_gap),
            rear=float(p.rear_gap),
            opposed=float(p.opposed),
            rear_opposed=float(p.rear_opposed),
            damping=float(p.damping),
            aging=NO_AGING if p.aging_limit is None else p.aging_limit,
            patience=p.patience,
            window=p.window,
            rest=float(p.rest),
            stir=float(p.stir),
            least_scale=float(p.least_scale),
        )

    def _make_room(self) -> None:
        """Give every vertex slot its row, after the mesh has grown."""
        n, had = self.mesh.vertex_slots, len(self._state)
        if n > had:
            self._state = np.concatenate((self._state, np.zeros((n - had, states.STATE_COLUMNS))))
            self._counter = np.concatenate((self._counter, np.zeros((n - had, states.COUNTER_COLUMNS), dtype=np.int32)))
            self._clear = np.concatenate((self._clear, np.zeros(n - had, dtype=np.int8)))
        if len(self._target) != n:
            self._target = np.zeros((n, 3))
            self._movers = np.zeros(n, dtype=np.int32)
            self._collapse = np.zeros(n, dtype=np.int8)


def _finite(
    field: NDArray[np.float32], allowed: NDArray[np.bool_] | None
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Return the field without values that are not finite, and where the surface may go; empty: everywhere."""
    values = np.ascontiguousarray(field, dtype=np.float32)
    finite = np.isfinite(values)
    if finite.all():
        gate = None if allowed is None else np.ascontiguousarray(allowed, dtype=np.bool_)
    else:
        values = np.where(finite, values, np.float32(0.0))
        gate = finite if allowed is None else finite & allowed
    return values, np.zeros((0, 0, 0), dtype=np.uint8) if gate is None else gate.view(np.uint8)

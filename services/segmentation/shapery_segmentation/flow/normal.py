"""The normal surface flow (3.4.1): a closed surface moves along its normals until it rests on the object."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume, check_affine
from shapery_segmentation.flow import _flow_kernels as kernels
from shapery_segmentation.mesh import _motion_kernels as motion
from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh


@dataclass(frozen=True, slots=True)
class NormalFlowParams:
    """How to flow."""

    edge_lengths: tuple[float, ...] = (1.5, 1.0)
    model: Literal["threshold", "gradient"] = "threshold"
    step: float = 0.3
    curvature_weight: float = 0.12
    tangential_weight: float = 0.4
    threshold_share: float | None = 0.45
    threshold_range: tuple[float, float] = (1.2, 2.25)
    threshold_interval: int = 10
    remesh_interval: int = 4
    front_gap: float = 1.0
    rear_gap: float = 0.6
    opposed: float = 0.4
    aging_limit: int = 8
    patience: int = 6
    window: int = 6
    rest: float = 0.03
    stir: float = 0.15
    balloon: float = 1.0
    max_iterations: int = 400
    topology: Literal["preserve"] = "preserve"


@dataclass(frozen=True, slots=True)
class FlowState:
    """Where the flow is, as told to `on_iteration`."""

    iteration: int
    stage: int
    vertices: int
    awake: int
    threshold: float


@dataclass(frozen=True, slots=True)
class StageRecord:
    """What one stage did."""

    edge_length: float
    iterations: int
    converged: bool
    vertices: int
    threshold: float


@dataclass(frozen=True, slots=True)
class FlowResult:
    """The surface at rest."""

    mesh: TriangleMesh
    threshold: float
    iterations: int
    converged: bool
    vanished: bool
    asleep: int
    frozen: int
    aged: int
    stages: tuple[StageRecord, ...]


def normal_flow(
    field: NDArray[np.float32],
    allowed: NDArray[np.bool_] | None,
    affine: NDArray[np.float64],
    seed: TriangleMesh,
    params: NormalFlowParams | None = None,
    *,
    threshold: float,
    on_iteration: Callable[[FlowState], None] | None = None,
) -> FlowResult:
    """Flow."""
    p = params or NormalFlowParams()
    affine = check_affine(affine)
    inverse = np.linalg.inv(affine)[:3]
    u = np.ascontiguousarray(field, dtype=np.float32)
    gate = np.zeros((0, 0, 0), np.uint8) if allowed is None else np.ascontiguousarray(allowed).view(np.uint8)
    mesh = DynamicMesh(seed, p.edge_lengths[0])
    mesh.remesh(rounds=12)
    mesh.compact()
    state = np.zeros((mesh.vertex_slots, kernels.STATE_COLUMNS))
    state[:, kernels.GAIN] = 1.0
    counter = np.zeros((mesh.vertex_slots, kernels.COUNTER_COLUMNS), dtype=np.int32)
    mesh.clear_touched()
    iteration = 0
    records: list[StageRecord] = []
    vanished = False
    tau = float(threshold)
    tau_slept = tau
    for number, length in enumerate(p.edge_lengths):
        if number:
            mesh.edge_length = length
            mesh.remesh(rounds=4)
            mesh.compact()
            state, counter = _fitting(mesh, state[:0], counter[:0])
        first = iteration
        converged = False
        stale = True
        target = np.zeros((mesh.vertex_slots, 3))
        old = np.zeros((mesh.vertex_slots, 3))
        moved = np.zeros(mesh.vertex_slots, dtype=np.int8)
        movers = np.zeros(mesh.vertex_slots, dtype=np.int32)
        while iteration - first < p.max_iterations:
            if p.threshold_share is not None and iteration % p.threshold_interval == 0 and iteration:
                inside = _median_inside(u, affine, mesh.to_triangle_mesh())
                if inside is not None:
                    tau = float(np.clip(p.threshold_share * inside, *p.threshold_range))
                    if abs(tau - tau_slept) > 0.05:
                        kernels.wake_all(mesh.arrays, state, counter, True)
                        tau_slept = tau
            if stale:
                mesh.sort_cells()
                stale = False
            count = kernels.propose(
                mesh.arrays, *mesh.cells, state, counter, u, gate, inverse,
                kernels.THRESHOLD, tau, p.balloon, length, p.step, p.curvature_weight, p.tangential_weight,
                p.aging_limit, p.front_gap, p.rear_gap, p.opposed, p.patience, target, movers,
            )  # fmt: skip
            motion.move_vertices(mesh.arrays, *mesh.cells, movers[:count], target, old, moved, mesh.next_batch())
            awake = kernels.settle(mesh.arrays, state, counter, moved, movers, count, length, p.window, p.rest, p.stir)
            iteration += 1
            if iteration % p.remesh_interval == 0:
                active = (counter[:, kernels.MODE] == kernels.AWAKE).astype(np.int8)
                mesh.remesh(active)
                stale = True
                if mesh.vertex_slots > len(state):
                    state, counter = _fitting(mesh, state, counter)
                    target = np.zeros((mesh.vertex_slots, 3))
                    old = np.zeros((mesh.vertex_slots, 3))
                    moved = np.zeros(mesh.vertex_slots, dtype=np.int8)
                    movers = np.zeros(mesh.vertex_slots, dtype=np.int32)
                kernels.adopt_touched(mesh.arrays, state, counter)
                if mesh.volume < 2.0 * length**3:
                    vanished = True
                    break
            if on_iteration is not None:
                on_iteration(FlowState(iteration, number, mesh.vertex_count, int(awake), tau))
            if awake <= 0.005 * mesh.vertex_count:
                converged = True
                break
        records.append(StageRecord(length, iteration - first, converged, mesh.vertex_count, tau))
        if vanished:
            break
    modes = counter[mesh.live, kernels.MODE]
    return FlowResult(
        mesh=mesh.to_triangle_mesh(),
        threshold=tau,
        iterations=iteration,
        converged=records[-1].converged,
        vanished=vanished,
        asleep=int((modes == kernels.ASLEEP).sum()),
        frozen=int((modes == kernels.FROZEN).sum()),
        aged=int((modes == kernels.AGED).sum()),
        stages=tuple(records),
    )


def _fitting(
    mesh: DynamicMesh, state: NDArray[np.float64], counter: NDArray[np.int32]
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return state and counters with a row for every slot."""
    n = mesh.vertex_slots
    new_state = np.zeros((n, kernels.STATE_COLUMNS))
    new_state[:, kernels.GAIN] = 1.0
    new_state[: len(state)] = state[:n]
    new_counter = np.zeros((n, kernels.COUNTER_COLUMNS), dtype=np.int32)
    new_counter[: len(counter)] = counter[:n]
    return new_state, new_counter


def _median_inside(u: NDArray[np.float32], affine: NDArray[np.float64], mesh: TriangleMesh) -> float | None:
    """Return the median of `u` over the voxels inside `mesh`; none where it encloses no voxel."""
    grid = Volume(u, affine)
    index = grid.to_index(mesh.vertices)
    low = np.maximum(np.floor(index.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(index.max(axis=0)).astype(int) + 1, u.shape)
    if (high <= low).any():
        return None
    box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
    shifted = affine.copy()
    shifted[:3, 3] = affine[:3, :3] @ low + affine[:3, 3]
    part = u[box]
    mask = rasterize(mesh, Volume(part, shifted))
    return float(np.median(part[mask])) if mask.any() else None

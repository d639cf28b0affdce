"""One object from each candidate: gate, seed surface, normal flow, labels, and whether it is a tumor after all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.brain import Brain
from shapery_segmentation.calibration import Calibration
from shapery_segmentation.flow.normal import NormalFlowParams, normal_flow
from shapery_segmentation.gate import Region, reach
from shapery_segmentation.labels import close_seam, fill_enclosed
from shapery_segmentation.seeding.ball import ball_inside, surface_of
from shapery_segmentation.seeding.candidates import Candidate

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

FINAL_EDGE = 1.0
"""mm: length of the final mesh's edges by default. On the way 1.5 times as long, which moves in fewer, larger steps."""

COARSE_EDGE = 1.5
"""Length of the edges while the surface is still on its way, relative to the final ones."""

LEAST_CONFIDENCE = 0.5
"""Objects found automatically that are less likely tumors than not are not reported."""

LEAST_NEW = 0.5
"""A candidate of which less than this share is new belongs to an object that was recovered before."""


@dataclass(frozen=True, eq=False)
class Recovered:
    """One object.

    Parameters
    ----------
    seed : (3,) float64
        The point its seed surface was grown from, RAS mm.
    seeded_by
    confidence
        In [0, 1].
    surface
        Closed, RAS mm.
    inside, enclosed : bool
        Voxels of the enhancing part, and of what it encloses, on the grid that was given.
    threshold, iterations, converged
        Of the flow.
    """

    seed: NDArray[np.float64]
    seeded_by: Literal["automatic", "user"]
    confidence: float
    surface: TriangleMesh
    inside: BoolArray
    enclosed: BoolArray
    threshold: float
    iterations: int
    converged: bool


def recover(
    brain: Brain,
    calibration: Calibration,
    candidates: Sequence[Candidate],
    params: SegmentationParams,
    *,
    check_cancelled: Callable[[], None],
    on_progress: Callable[[float, str], None],
) -> list[Recovered]:
    """Recover an object from each candidate that leads to one.

    Parameters
    ----------
    brain, calibration
        Working grid, mask and calibrated difference.
    candidates
        By falling evidence; automatic ones are dropped where what evolves from them is no tumor.
    params
        Of these `max_objects`, `edge_length`, `smoothing` and `topology`.

    Returns
    -------
    By falling confidence.
    """
    free = brain.mask.copy()
    found: list[Recovered] = []
    for number, candidate in enumerate(candidates):
        check_cancelled()
        if len(found) == params.max_objects:
            break
        if candidate.seeded_by == "automatic" and candidate.confidence < LEAST_CONFIDENCE:
            continue
        seed = candidate.voxels & free
        if np.count_nonzero(seed) <= LEAST_NEW * np.count_nonzero(candidate.voxels):
            continue
        on_progress(number / len(candidates), f"object {len(found) + 1}")
        region = reach(calibration.field, free, seed, brain.grid.spacing)
        item = _recover_one(brain, calibration, candidate, region, params, check_cancelled)
        if item is not None:
            found.append(item)
        # What belongs to one object is closed to the others, with a voxel between the surfaces.
        free[region.box] &= ~region.allowed
    return sorted(found, key=lambda item: -item.confidence)


def _recover_one(
    brain: Brain,
    calibration: Calibration,
    candidate: Candidate,
    region: Region,
    params: SegmentationParams,
    check_cancelled: Callable[[], None],
) -> Recovered | None:
    grid = brain.grid
    affine = grid.affine.copy()
    affine[:3, 3] += affine[:3, :3] @ [s.start for s in region.box]
    values = np.ascontiguousarray(calibration.field[region.box])
    ball, start = ball_inside(region.inside)
    edge = params.edge_length if params.edge_length is not None else max(FINAL_EDGE, grid.spacing)

    def on_iteration(*_: object) -> None:
        check_cancelled()

    flow = normal_flow(
        values,
        region.allowed,
        affine,
        surface_of(ball, affine),
        NormalFlowParams(edge_lengths=(COARSE_EDGE * edge, edge), curvature_weight=params.smoothing),
        threshold=region.threshold,
        on_iteration=on_iteration,
    )
    check_cancelled()
    if flow.vanished:
        return None
    inside, enclosed = _voxels(brain, region, affine, values, flow.mesh, flow.threshold)
    return Recovered(
        seed=affine[:3, :3] @ start + affine[:3, 3],
        seeded_by=candidate.seeded_by,
        confidence=candidate.confidence,
        surface=flow.mesh,
        inside=inside,
        enclosed=enclosed,
        threshold=float(flow.threshold),
        iterations=int(flow.iterations),
        converged=bool(flow.converged),
    )


def _voxels(
    brain: Brain,
    region: Region,
    affine: NDArray[np.float64],
    values: FloatArray,
    surface: TriangleMesh,
    threshold: float,
) -> tuple[BoolArray, BoolArray]:
    """Return the voxels of the enhancing part and those it encloses, on the grid that was given."""
    grid = brain.grid
    inside = rasterize(surface, Volume(values, affine))
    whole = close_seam(inside, (values > threshold) & region.allowed, grid.spacing)
    core = fill_enclosed(whole, grid.spacing) & brain.mask[region.box]

    def given(mask: BoolArray) -> BoolArray:
        full = np.zeros(grid.shape, dtype=np.bool_)
        full[region.box] = mask
        return grid.to_source(full)

    if grid.reorientation is not None:
        return given(whole), given(core)
    # On another grid than the working one the surface itself says what is inside, to the fraction of a voxel.
    source = rasterize(surface, grid.source) | (given(whole) & ~given(inside))
    return source, given(core | whole) & ~source

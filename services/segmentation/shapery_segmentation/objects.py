"""One object from each candidate: gate, seed surface, normal flow, labels, and whether it is a tumor after all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.concurrent import both
from shapery_geometry.intersections import self_intersections
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.brain import Brain
from shapery_segmentation.calibration import Calibration
from shapery_segmentation.evolution import Frame, Recorder, Scene
from shapery_segmentation.flow.normal import FlowState, NormalFlowParams, normal_flow
from shapery_segmentation.gate import LEVEL_RANGE, Region, on_even_ground, reach
from shapery_segmentation.ground import ground_of, shell, standing_out
from shapery_segmentation.labels import close_seam, enhancing_part, fill_enclosed, fill_indentations, with_enclosed
from shapery_segmentation.neighborhoods import box_around, depths, within
from shapery_segmentation.seeding.ball import seed_ball, surface_of
from shapery_segmentation.seeding.candidates import LEAST_WEIGHT, Candidate
from shapery_segmentation.shrinking import shrinking_note

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

FINAL_EDGE = 1.0
"""mm: length of the final mesh's edges by default. On the way longer, which moves in fewer, larger steps."""

COARSE_EDGE, THIN_EDGE = 2.0, 1.5
"""Length of the edges while the surface is still on its way, relative to the final ones: where voxels of twice the size
can hold the region, and where it is too thin for that."""

THIN_RIM = 1.5
"""mm from what an object encloses within which enhancing voxels of its region belong to its rim; thicker rims are the
surface's matter."""

HALF_CONFIDENCE_MM3 = 400.0
"""Evidence (mm³ weighted by it) at which a compact object is as likely a tumor as not. On cases with expert labels,
vessels and plexus that pass the other tests have up to 230, tumors 440 and more."""

COMPACT = (1.7, 0.12)
"""Centre and width of a step in the spread of an object (see `spread`): tumors have 0.8 to 1.4, trees of sinuses and
veins 2.4 and more."""

DISTINCT = (2.4, 0.15)
"""Centre and width of a step in the contrast of an object to its ground (see `shapery_segmentation.ground`). Normal
tissue that a bias field raised has 1.7 to 2.0; the weakest tumors with expert labels have 2.9."""

LONG = (3.0, 0.25)
"""Centre and width of a step in the length of an object relative to its thickness (see `elongation`): round tumors have
1.2 to 2, long ones up to 4.2, pieces of dural sinuses 4 and more."""

ALONG_THE_EDGE = (8.0, 1.0)
"""Centre and width of a step in the median distance of an object from the brain's edge in mm. What is long and lies
nearer is a dural sinus: its inner side is too deep for the evidence of single voxels to tell (see
`shapery_segmentation.seeding.evidence`), but all of it follows the edge."""

PARTED = 0.85
"""Confidence in what only a stricter gate parted from a tree or a sheet, relative: it may be a part of that."""

LEAST_SHARE = 0.2
"""Share of an object that must have evidence of its own; below, what evolved is not what was found."""

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
    seed_mm3
        Volume that the seed surface enclosed.
    self_intersections
        Pairs of faces of the surface that intersect.
    frames
        The surface on its way.
    polarity
        Relative to what surrounds it.
    notes
        Sentences for the user.
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
    seed_mm3: float
    self_intersections: int
    frames: tuple[Frame, ...] = ()
    polarity: Literal["bright", "dark", "between"] = "bright"
    notes: tuple[str, ...] = ()


def recover(
    brain: Brain,
    calibration: Calibration,
    candidates: Sequence[Candidate],
    weight: FloatArray,
    params: SegmentationParams,
    *,
    check_cancelled: Callable[[], None],
    on_progress: Callable[[float, str], None],
    scene: Scene | None = None,
) -> list[Recovered]:
    """Recover an object from each candidate that leads to one.

    Parameters
    ----------
    brain, calibration
        Working grid, mask and calibrated difference.
    candidates
        By falling evidence; automatic ones are dropped where what evolves from them is no tumor.
    weight : (I, J, K) float32
        Evidence of every voxel of the working grid.
    params
        Of these `max_objects`, `edge_length`, `smoothing` and `topology`.
    scene
        Where the surfaces are seen while they flow.

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
        automatic = candidate.seeded_by == "automatic"
        if automatic and _confidence(candidate.evidence_mm3, calibration) < LEAST_CONFIDENCE:
            continue
        seed = candidate.voxels & free
        if np.count_nonzero(seed) <= LEAST_NEW * np.count_nonzero(candidate.voxels):
            continue
        on_progress(number / len(candidates), f"object {len(found) + 1}")
        region = reach(
            calibration.field,
            free,
            seed,
            brain.grid.spacing,
            likely_shape=(lambda inside: _likely_shape(inside, brain.grid.spacing)) if automatic else None,
        )
        if automatic and region.likely < LEAST_CONFIDENCE:
            continue
        confidence, start = _judged(candidate, region, weight, brain, calibration, params)
        if automatic and confidence < LEAST_CONFIDENCE:
            continue
        item = _recover_one(brain, start, candidate, region, confidence, check_cancelled, scene)
        if item is not None:
            found.append(item)
        # What belongs to one object is closed to the others, with a voxel between the surfaces.
        free[region.box] &= ~region.allowed
    return sorted(found, key=lambda item: -item.confidence)


def spread(mask: BoolArray) -> float:
    """Return the radius of gyration of a mask over the radius of the ball of its volume: 0.77 for a ball.

    Parameters
    ----------
    mask : (I, J, K) bool
        At least one voxel.
    """
    inside = np.flatnonzero(mask)
    variances = [float(np.var(index.astype(np.float64))) for index in np.unravel_index(inside, mask.shape)]
    # A voxel itself has a radius of gyration of half a voxel's diagonal over √3.
    gyration = np.sqrt(sum(variances) + 0.25)
    return float(gyration / (3.0 * len(inside) / (4.0 * np.pi)) ** (1 / 3))


def elongation(mask: BoolArray) -> float:
    """Return how long a mask is relative to its thickness: standard deviations along its first and last main axes.

    Parameters
    ----------
    mask : (I, J, K) bool
        At least one voxel.
    """
    places = np.stack(np.unravel_index(np.flatnonzero(mask), mask.shape)).astype(np.float64)
    places -= places.mean(axis=1, keepdims=True)
    # A voxel itself has a variance of a twelfth.
    variances = np.linalg.eigvalsh(places @ places.T / places.shape[1] + np.eye(3) / 12.0)
    return float(np.sqrt(variances[2] / variances[0]))


def _confidence(evidence_mm3: float, calibration: Calibration) -> float:
    confidence = evidence_mm3 / (evidence_mm3 + HALF_CONFIDENCE_MM3)
    # After contrast alone brightness says half as much.
    return confidence if calibration.subtracted else 0.5 + 0.5 * (confidence - 0.5) if confidence > 0.5 else confidence


def _judge(
    candidate: Candidate,
    region: Region,
    whole: BoolArray,
    around: BoolArray,
    weight: FloatArray,
    brain: Brain,
    calibration: Calibration,
) -> float:
    """Return the confidence that the region which a candidate reached is a tumor.

    `whole` is the region with what it encloses, `around` the shell around that. The confidence is the product of what
    the region is made of, its shape, how far it stands out, and whether it is no piece of a sinus: each of these can
    refuse it by itself, however large it is.
    """
    own = weight[region.box][region.inside]
    evidence = float(own[own > LEAST_WEIGHT].sum()) * brain.grid.spacing**3
    if candidate.seeded_by == "automatic":
        # What a strict gate left out says nothing for the region. A user's seed is a few voxels: there what it reached
        # must speak for itself.
        evidence = min(evidence, candidate.evidence_mm3)
    field = calibration.field[region.box]
    stands_out = standing_out(field[region.inside], ground_of(field[around]))
    share = min(1.0, float(own.mean()) / LEAST_SHARE)
    return (
        _confidence(evidence, calibration)
        * share
        * (PARTED if region.parted else 1.0)
        * _compact(whole)
        * _logistic((stands_out - DISTINCT[0]) / DISTINCT[1])
        * (1.0 - _follows_the_edge(whole, region, brain))
    )


def _judged(
    candidate: Candidate,
    region: Region,
    weight: FloatArray,
    brain: Brain,
    calibration: Calibration,
    params: SegmentationParams,
) -> tuple[float, FlowStart]:
    """Return what `_judge` and `flow_start` do: most of what comes as far as to be judged is a tumor, and flows."""
    whole = with_enclosed(region.inside, brain.grid.spacing)
    around = shell(whole, brain.mask[region.box], brain.grid.spacing)
    return both(
        lambda: _judge(candidate, region, whole, around, weight, brain, calibration),
        lambda: flow_start(brain, calibration, region, around, params),
    )


def _follows_the_edge(core: BoolArray, region: Region, brain: Brain) -> float:
    """Return how likely an object is a piece of a dural sinus, by its shape and place; in [0, 1]."""
    long = _logistic((elongation(core) - LONG[0]) / LONG[1])
    if long < 0.01:
        return 0.0
    # What is twice as deep is deep enough, so no farther around needs to be looked at.
    margin = int(np.ceil(2.0 * ALONG_THE_EDGE[0] / brain.grid.spacing))
    whole = np.zeros(brain.mask.shape, dtype=np.bool_)
    whole[region.box] = core
    around = box_around(whole, whole.shape, margin)
    depth = depths(brain.mask[around], margin)[whole[around]] * brain.grid.spacing
    return long * _logistic((ALONG_THE_EDGE[0] - float(np.median(depth))) / ALONG_THE_EDGE[1])


def _compact(core: BoolArray) -> float:
    """Return how likely a tumor has such a shape, in [0, 1]."""
    return _logistic((COMPACT[0] - spread(core)) / COMPACT[1])


def _likely_shape(inside: BoolArray, spacing: float) -> float:
    """Return how likely a tumor has the shape of a region, by itself or with what it encloses; in [0, 1]."""
    bare = _compact(inside)
    return bare if bare >= 0.5 else max(bare, _compact(with_enclosed(inside, spacing)))


def _logistic(x: float) -> float:
    return float(1.0 / (1.0 + np.exp(-np.clip(x, -30.0, 30.0))))


@dataclass(frozen=True, eq=False)
class FlowStart:
    """What `normal_flow` takes to recover one object, and the point that its seed was grown from (RAS mm)."""

    field: FloatArray
    allowed: BoolArray
    affine: NDArray[np.float64]
    seed: TriangleMesh
    threshold: float
    params: NormalFlowParams
    point: NDArray[np.float64]


def flow_start(
    brain: Brain, calibration: Calibration, region: Region, around: BoolArray, params: SegmentationParams
) -> FlowStart:
    """Return what the flow of a region starts from.

    Parameters
    ----------
    brain, calibration
        Working grid and calibrated difference.
    region
        What a candidate reaches.
    around : bool
        The shell around that, in the region's box (see `shapery_segmentation.ground`).
    params
        Of these `edge_length`, `smoothing` and `topology`.
    """
    affine = brain.grid.affine.copy()
    affine[:3, 3] += affine[:3, :3] @ [s.start for s in region.box]
    ball, to_ball, start = seed_ball(region.inside, affine)
    edge = params.edge_length if params.edge_length is not None else max(FINAL_EDGE, brain.grid.spacing)
    coarse = THIN_EDGE if np.array_equal(to_ball, affine) else COARSE_EDGE
    return FlowStart(
        field=on_even_ground(calibration.field[region.box], region, around, brain.grid.spacing),
        allowed=region.allowed,
        affine=affine,
        seed=surface_of(ball, to_ball, even=True),
        threshold=region.threshold,
        params=NormalFlowParams(
            edge_lengths=(coarse * edge, edge),
            curvature_weight=params.smoothing,
            topology=params.topology,
            threshold_ground=region.ground,
            threshold_range=(region.floor, LEVEL_RANGE[1]),
        ),
        point=to_ball[:3, :3] @ start + to_ball[:3, 3],
    )


def _recover_one(
    brain: Brain,
    start: FlowStart,
    candidate: Candidate,
    region: Region,
    confidence: float,
    check_cancelled: Callable[[], None],
    scene: Scene | None,
) -> Recovered | None:
    recorder = Recorder(scene)

    def on_iteration(state: FlowState) -> None:
        check_cancelled()
        recorder.watch(state)

    flow = normal_flow(
        start.field,
        start.allowed,
        start.affine,
        start.seed,
        start.params,
        threshold=start.threshold,
        on_iteration=on_iteration,
    )
    check_cancelled()
    if flow.vanished:
        return None
    # The report asks for the genus, which takes about as long as the voxels.
    (inside, enclosed), (note, _) = both(
        lambda: _voxels(brain, region, start, flow.mesh, flow.threshold),
        lambda: (shrinking_note(start.seed, flow.mesh, start.field, start.affine, flow.threshold), flow.mesh.genus),
    )
    return Recovered(
        seed=start.point,
        seeded_by=candidate.seeded_by,
        confidence=confidence,
        surface=flow.mesh,
        inside=inside,
        enclosed=enclosed,
        threshold=float(flow.threshold),
        iterations=int(flow.iterations),
        converged=bool(flow.converged),
        seed_mm3=float(start.seed.volume),
        # Found apart on the safe side, they need not be told apart exactly.
        self_intersections=0 if flow.untouched else len(self_intersections(flow.mesh)),
        frames=recorder.frames(flow.mesh),
        notes=() if note is None else (note,),
    )


def _voxels(
    brain: Brain,
    region: Region,
    start: FlowStart,
    surface: TriangleMesh,
    threshold: float,
) -> tuple[BoolArray, BoolArray]:
    """Return the voxels of the enhancing part and those it encloses, on the grid that was given."""
    grid = brain.grid
    inside = rasterize(surface, Volume(start.field, start.affine), known_closed=True)
    enhancing = start.field > threshold
    whole = close_seam(inside, enhancing & region.allowed, grid.spacing)
    # Where the rim is thinner than the surface's triangles, what it encloses still tells which voxels are rim.
    enclosed = fill_enclosed(whole | region.inside, grid.spacing)
    whole |= region.inside & within(enclosed, THIN_RIM / grid.spacing)
    tissue = brain.mask[region.box]
    core = (enclosed & tissue) | whole
    core |= fill_indentations(core, grid.spacing) & tissue
    bright = enhancing_part(whole, core & ~whole, enhancing)

    def given(mask: BoolArray) -> BoolArray:
        full = np.zeros(grid.shape, dtype=np.bool_)
        full[region.box] = mask
        return grid.to_source(full)

    if grid.reorientation is not None:
        return given(bright), given(core & ~bright)
    # On another grid than the working one the surface itself says where its outside ends, to the fraction of a voxel.
    source = rasterize(surface, grid.source, known_closed=True) & ~given(inside & ~bright)
    source |= given(bright) & ~given(inside)
    return source, given(core) & ~source

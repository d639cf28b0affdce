"""From volumes to labelled voxels and surfaces: the whole of chapter 3 in one call.

::

    volumes ─ register ─┬─ brain ─ calibrate ─ seed ─ gate ─ normal flow ─┬─ vessels, bleedings ─ label ─ result
                        └─ region at a seed or in a box ─── normal flow ──┘

The upper way is that of tumors, the lower that of any object (see `shapery_segmentation.general`). Results lie on the
grid of the volume after contrast and in RAS mm.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_contracts.segmentation import Alignment, SegmentationParams, SegmentationResult, StageTime
from shapery_geometry.concurrent import both
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.volume import Volume
from shapery_segmentation.brain import Brain, find_brain
from shapery_segmentation.calibration import compare
from shapery_segmentation.evolution import Frame, Scene, Show, numbered
from shapery_segmentation.labels import ENCLOSED, MICROHEMORRHAGE, OBJECT, VESSEL
from shapery_segmentation.modes import choose_mode
from shapery_segmentation.objects import Recovered, recover
from shapery_segmentation.preparation import check_overlap, check_volume
from shapery_segmentation.registration import align
from shapery_segmentation.report import describe, describe_surroundings, versions
from shapery_segmentation.seeding.candidates import find_candidates
from shapery_segmentation.seeding.points import (
    candidates_from_points,
    check_box,
    check_points,
    check_vessel_seeds,
)
from shapery_segmentation.seeding.symmetry import find_symmetry

Progress = Callable[[str, float, str], None]
"""Called with the name of a stage, the fraction of the whole work done, and a message."""

STAGE_FRACTIONS = {"register": 0.0, "calibrate": 0.1, "seed": 0.3, "evolve": 0.45, "vessels": 0.75, "label": 0.95}
"""Fraction of the work of `segment` done when each stage begins, as measured on heads of 1 mm."""

EVOLVED = 0.3
"""Fraction of the work that the evolution is."""


@dataclass(frozen=True, eq=False)
class Segmentation:
    """What `segment` found.

    Parameters
    ----------
    labels
        uint8 on the grid of the volume after contrast: 1 object, 2 what it encloses, 3 vessel, 4 microhemorrhage.
    surfaces
        One per object of the report, in its order: closed, RAS mm.
    report
        What ``report.json`` holds.
    vessel_surfaces
        One per vessel of the report, in its order: closed, RAS mm.
    bleeding_surface
        Of all microhemorrhages; None without any.
    evolution
        The objects' surfaces on their way.
    """

    labels: Volume
    surfaces: tuple[TriangleMesh, ...]
    report: SegmentationResult
    vessel_surfaces: tuple[TriangleMesh, ...] = ()
    bleeding_surface: TriangleMesh | None = None
    evolution: tuple[Frame, ...] = ()


@dataclass
class _Run:
    """Progress, cancellation and times of one call."""

    on_progress: Progress | None
    check_cancelled: Callable[[], None] | None
    scene: Scene
    stages: list[StageTime] = field(default_factory=list)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        self.check()
        self.tell(name, STAGE_FRACTIONS[name], "")
        start = time.perf_counter()
        yield
        self.stages.append(StageTime(name=name, seconds=round(time.perf_counter() - start, 4)))

    def tell(self, name: str, fraction: float, message: str) -> None:
        if self.on_progress is not None:
            self.on_progress(name, fraction, message)

    def evolving(self, share: float, message: str) -> None:
        self.tell("evolve", STAGE_FRACTIONS["evolve"] + EVOLVED * share, message)

    def check(self) -> None:
        if self.check_cancelled is not None:
            self.check_cancelled()


def segment(
    post: Volume,
    pre: Volume | None = None,
    vessels: Volume | None = None,
    *,
    params: SegmentationParams | None = None,
    on_progress: Progress | None = None,
    check_cancelled: Callable[[], None] | None = None,
    on_surfaces: Show | None = None,
) -> Segmentation:
    """Recover the surfaces of enhancing brain tumors and of the vessels around them, or of any object.

    Parameters
    ----------
    post
        T1-weighted volume after contrast, of a whole head or stripped of the skull; for any object any volume.
    pre
        The same before contrast, on any grid; it is moved onto `post` where it lies elsewhere. Without it enhancement
        cannot be told from tissue that is bright anyway: seeds that the user gives work nearly as well, an automatic
        result comes with a warning and half the confidence.
    vessels
        A volume of the same head that shows vessels: SWI, MRA, time-of-flight, CTA. It is moved onto `post` likewise.
    params
        See `SegmentationParams`; the defaults need no seed.
    on_progress
        Called with stage, fraction in [0, 1] and message.
    check_cancelled
        Called several times a second; what it raises ends the work and passes through.
    on_surfaces
        Called with the objects' surfaces, coarse, as they are while they grow.

    Returns
    -------
    Labels, surfaces and report. Where nothing enhances like a tumor, labels are all 0, there are no surfaces, and a
    warning says so: a healthy head is no error. An object that was pointed at and is not there is one.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` for volumes that hold no brain; ``grid_mismatch`` where a volume lies elsewhere than `post`
        and cannot be moved onto it; ``different_subjects`` where `pre` shows another head; ``invalid_params`` for seeds
        outside the volume; ``no_object_found`` where none of the user's seeds leads to anything.
    """
    params = params or SegmentationParams()
    run = _Run(on_progress, check_cancelled, Scene(on_surfaces))
    check_volume(post, "post-contrast")
    check_points(params.seeds, post)
    check_box(params.box, post)
    check_vessel_seeds(params, vessels)
    warnings = list(post.warnings)
    for volume, name in ((pre, "pre-contrast"), (vessels, "vessel")):
        if volume is not None:
            check_volume(volume, name)
            warnings += volume.warnings
    mode = choose_mode(post, params)
    alignments: list[Alignment] = []
    certainty = 1.0
    brain: Brain | None = None
    with run.stage("register"):
        rng = np.random.default_rng(params.random_seed)
        if pre is not None and mode == "object":
            warnings.append("Any object is looked for in the volume after contrast alone; the other was not used.")
            pre = None
        if pre is not None:
            before = pre
            (placed, certainty), brain = both(
                lambda: align(before, post, "pre", params.register_volumes, alignments, warnings, rng=rng),
                lambda: _brain_meanwhile(before, post),
            )
            if placed is not before:
                pre, brain = placed, None
            warnings += check_overlap(placed, post)
        run.check()
        if vessels is not None:
            vessels, _ = align(vessels, post, "vessels", params.register_volumes, alignments, warnings, rng=rng)
            check_overlap(post, vessels)

    if mode == "object":
        found = _objects(post, params, run, warnings)
    else:
        found = _tumors(post, pre, brain, params, run, warnings)
    found = [replace(item, confidence=item.confidence * certainty) for item in found]

    labels = _labels(post, found)
    around = None
    if vessels is not None:
        # Imported here, as the general mode is: most heads come without.
        from shapery_segmentation.surroundings import find_surroundings

        with run.stage("vessels"):
            around = find_surroundings(vessels, labels > 0, post, params, check_cancelled=run.check)
            warnings += around.warnings
    with run.stage("label"):
        if around is not None:
            labels[(labels == 0) & around.vessel_voxels] = VESSEL
            labels[(labels != OBJECT) & (labels != ENCLOSED) & around.bleeding_voxels] = MICROHEMORRHAGE
        counts = np.bincount(labels[labels > 0], minlength=5)
        described = [describe(item, number, post.voxel_volume) for number, item in enumerate(found, start=1)]
        told = {} if around is None else describe_surroundings(around)

    report = SegmentationResult(
        objects=described,
        mode=mode,
        **told,
        alignments=alignments,
        voxel_counts={str(value): int(counts[value]) for value in range(1, 5)},
        voxel_volume_mm3=post.voxel_volume,
        stages=run.stages,
        versions=versions(),
        warnings=warnings,
    )
    run.tell("label", 1.0, "")
    return Segmentation(
        post.with_data(labels),
        tuple(item.surface for item in found),
        report,
        () if around is None else around.vessels.surfaces,
        None if around is None else around.bleeding_surface,
        tuple(frame for number, item in enumerate(found, start=1) for frame in numbered(item.frames, number)),
    )


def _brain_meanwhile(pre: Volume, post: Volume) -> Brain | None:
    """Return the brain as it is if `pre` need not be moved; None where it shows only then whether there is one."""
    try:
        return find_brain(pre, post)
    except InvalidInput:
        return None


def _tumors(
    post: Volume,
    pre: Volume | None,
    brain: Brain | None,
    params: SegmentationParams,
    run: _Run,
    warnings: list[str],
) -> list[Recovered]:
    """Return the enhancing tumors of a head, by falling confidence; the brain is looked for unless it is known."""
    with run.stage("calibrate"):
        brain = brain or find_brain(pre if pre is not None else post, post)
        run.check()
        comparison = compare(brain, post, pre)
        run.check()
        mask, spacing = brain.mask, brain.grid.spacing
        calibration, plane = both(comparison.calibrated, lambda: find_symmetry(comparison.before, mask, spacing))

    with run.stage("seed"):
        search = find_candidates(calibration, mask, spacing, plane=plane, check_cancelled=run.check)
        candidates = list(search.candidates)
        if params.seeds:
            candidates = candidates_from_points(params.seeds, brain, calibration, search.weight, warnings)
        elif not calibration.subtracted:
            warnings.append(
                "Without a volume before contrast, enhancement is told from bright tissue by its brightness alone: "
                "check the result, or give a seed."
            )

    def recovered() -> list[Recovered]:
        return recover(
            brain,
            calibration,
            candidates,
            search.weight,
            params,
            check_cancelled=run.check,
            on_progress=run.evolving,
            scene=run.scene,
        )

    with run.stage("evolve"):
        found = recovered()
        if not found and not params.seeds and pre is not None:
            # A second look: what is small and weak may be hidden by a drift between the volumes.
            calibration = comparison.calibrated(without_drift=True)
            search = find_candidates(calibration, mask, spacing, plane=plane, check_cancelled=run.check)
            candidates = list(search.candidates)
            found = recovered()
        if not found and not params.seeds:
            warnings.append("Nothing was found that enhances like a tumor; a seed can be given to look closer.")
        elif not found:
            raise InvalidInput(
                "no_object_found",
                "The surfaces that started at the seeds shrank to nothing: what enhances there is too thin or weak.",
                "Place a seed in the middle of what enhances, or leave seeds out to search the whole brain.",
            )
    return found


def _objects(post: Volume, params: SegmentationParams, run: _Run, warnings: list[str]) -> list[Recovered]:
    """Return the object at each seed, or in the box."""
    from shapery_segmentation.general import recover_object, targets

    pointed = targets(params)
    if not pointed:
        raise InvalidInput(
            "invalid_params",
            "In the mode object a seed or a box has to say which object is meant.",
            "Give --seed X,Y,Z or --box X0,Y0,Z0,X1,Y1,Z1 in RAS millimetres, or use the mode tumor.",
        )
    found: list[Recovered] = []
    refusals: list[InvalidInput] = []
    with run.stage("evolve"):
        for number, target in enumerate(pointed[: params.max_objects]):
            run.evolving(number / len(pointed), f"object {number + 1}")
            try:
                found.append(recover_object(post, target, params, check_cancelled=run.check, scene=run.scene))
            except InvalidInput as refusal:
                refusals.append(refusal)
    if not found:
        raise refusals[0]
    warnings += [refusal.message for refusal in refusals]
    return sorted(found, key=lambda item: -item.confidence)


def _labels(post: Volume, found: list[Recovered]) -> NDArray[np.uint8]:
    labels = np.zeros(post.shape, dtype=np.uint8)
    for item in found:
        labels[item.enclosed & (labels == 0)] = ENCLOSED
    for item in found:
        labels[item.inside] = OBJECT
    return labels

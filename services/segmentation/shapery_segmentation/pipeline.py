"""From two volumes to labelled voxels and surfaces: the whole of chapter 3's first stage.

::

    volumes ─ prepare ─ brain ─ calibrate ─ seed ─ gate ─ normal flow ─ label ─ result

Everything between works on the working grid (see `shapery_segmentation.preparation`); results lie on the grid of the
volume after contrast and in RAS mm.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.segmentation import SegmentationParams, SegmentationResult, StageTime
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.volume import Volume
from shapery_segmentation.brain import Brain, find_brain
from shapery_segmentation.calibration import calibrate
from shapery_segmentation.labels import ENCLOSED, OBJECT
from shapery_segmentation.objects import Recovered, recover
from shapery_segmentation.preparation import check_overlap, check_volume
from shapery_segmentation.report import describe, versions
from shapery_segmentation.seeding.candidates import find_candidates
from shapery_segmentation.seeding.points import candidates_from_points, check_points

BoolArray = NDArray[np.bool_]

Progress = Callable[[str, float, str], None]
"""Called with the name of a stage, the fraction of the whole work done, and a message."""

STAGE_FRACTIONS = {"calibrate": 0.0, "seed": 0.25, "evolve": 0.45, "label": 0.9}
"""Fraction of the work of `segment` done when each stage begins, as measured on heads of 1 mm."""


@dataclass(frozen=True, eq=False)
class Segmentation:
    """What `segment` found.

    Parameters
    ----------
    labels
        uint8 on the grid of the volume after contrast: 1 object (the enhancing tumor), 2 what it encloses.
    surfaces
        One per object of the report, in its order: closed, RAS mm.
    report
        What ``report.json`` holds.
    """

    labels: Volume
    surfaces: tuple[TriangleMesh, ...]
    report: SegmentationResult


@dataclass
class _Run:
    """Progress, cancellation and times of one call."""

    on_progress: Progress | None
    check_cancelled: Callable[[], None] | None
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

    def check(self) -> None:
        if self.check_cancelled is not None:
            self.check_cancelled()


def segment(
    post: Volume,
    pre: Volume | None = None,
    *,
    params: SegmentationParams | None = None,
    on_progress: Progress | None = None,
    check_cancelled: Callable[[], None] | None = None,
) -> Segmentation:
    """Recover the surfaces of enhancing brain tumors.

    Parameters
    ----------
    post
        T1-weighted volume after contrast; of a whole head, or stripped of the skull.
    pre
        The same before contrast, on any grid of the same frame. Without it enhancement cannot be told from tissue that
        is bright anyway: seeds that the user gives work nearly as well, an automatic result comes with a warning and
        half the confidence.
    params
        See `SegmentationParams`; the defaults need no seed.
    on_progress
        Called with stage, fraction in [0, 1] and message.
    check_cancelled
        Called several times a second; what it raises ends the work and passes through.

    Returns
    -------
    Labels, surfaces and report. Where nothing enhances like a tumor, labels are all 0, there are no surfaces, and a
    warning says so: a healthy head is no error.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` for volumes that hold no brain; ``grid_mismatch`` where `pre` lies elsewhere than `post`;
        ``invalid_params`` for seeds outside the volume; ``no_object_found`` where none of the user's seeds reaches
        anything that enhances.
    """
    params = params or SegmentationParams()
    run = _Run(on_progress, check_cancelled)
    check_volume(post, "post-contrast")
    warnings = list(post.warnings)
    if pre is not None:
        check_volume(pre, "pre-contrast")
        warnings += [*pre.warnings, *check_overlap(pre, post)]
    check_points(params.seeds, post)

    with run.stage("calibrate"):
        brain = find_brain(pre if pre is not None else post, post)
        run.check()
        calibration = calibrate(brain, post, pre)

    with run.stage("seed"):
        search = find_candidates(calibration, brain.mask, brain.grid.spacing, check_cancelled=run.check)
        candidates = list(search.candidates)
        if params.seeds:
            candidates = candidates_from_points(params.seeds, brain, calibration, search.weight, warnings)
        elif not calibration.subtracted:
            warnings.append(
                "Without a volume before contrast, enhancement is told from bright tissue by its brightness alone: "
                "check the result, or give a seed."
            )

    with run.stage("evolve"):
        found = recover(
            brain,
            calibration,
            candidates,
            search.weight,
            params,
            check_cancelled=run.check,
            on_progress=lambda share, message: run.tell("evolve", 0.45 + 0.45 * share, message),
        )
        if not found and not params.seeds:
            warnings.append("Nothing was found that enhances like a tumor; a seed can be given to look closer.")

    with run.stage("label"):
        labels = _labels(brain, found)

    counts = np.bincount(labels.ravel(), minlength=5)
    report = SegmentationResult(
        objects=[describe(item, number, post.voxel_volume) for number, item in enumerate(found, start=1)],
        voxel_counts={str(value): int(counts[value]) for value in range(1, 5)},
        voxel_volume_mm3=post.voxel_volume,
        stages=run.stages,
        versions=versions(),
        warnings=warnings,
    )
    run.tell("label", 1.0, "")
    return Segmentation(post.with_data(labels), tuple(item.surface for item in found), report)


def _labels(brain: Brain, found: list[Recovered]) -> NDArray[np.uint8]:
    labels = np.zeros(brain.grid.source.shape, dtype=np.uint8)
    for item in found:
        labels[item.enclosed & (labels == 0)] = ENCLOSED
    for item in found:
        labels[item.inside] = OBJECT
    return labels

"""Candidates for a seed: connected enhancing voxels in the octree's cells, ranked by the evidence in them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.concurrent import both
from shapery_segmentation.calibration import Calibration
from shapery_segmentation.gate import LEVEL, LEVEL_RANGE, dense
from shapery_segmentation.neighborhoods import parts
from shapery_segmentation.seeding.evidence import SEED_THRESHOLD, evidence
from shapery_segmentation.seeding.octree import OctreeCandidates, search_octree
from shapery_segmentation.seeding.symmetry import SymmetryPlane, find_symmetry

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

LEAST_EVIDENCE_MM3 = 100.0
"""Candidates with less are not looked at: half of the evidence that is asked for in the end, and some margin."""

LEAST_WEIGHT = 0.25
"""Evidence below which a voxel joins no candidate: vessels that touch a tumor are parted from it here."""

CLEARLY_MORE = (2.8, 0.2)
"""Centre and width of a step in the median enhancement of a candidate: bias fields that differ between the volumes
raise whole lobes of white matter to 2.0 to 2.5."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A place to start from.

    Parameters
    ----------
    voxels : (I, J, K) bool
        On the working grid.
    evidence_mm3
        Volume of the voxels, each weighted by its evidence; less where they hardly enhance more than normal brain.
    peak
        Of the second class of the octree's cells, in units of the calibrated difference.
    median
        Median enhancement, in the same units.
    seeded_by
        Whether it was found, or given by the user.
    """

    voxels: BoolArray
    evidence_mm3: float
    peak: float
    median: float
    seeded_by: Literal["automatic", "user"] = "automatic"


@dataclass(frozen=True, eq=False)
class Search:
    """What the automatic seeding found.

    Parameters
    ----------
    candidates
        By falling evidence.
    weight : (I, J, K) float32
        Evidence of every voxel.
    octree, plane
        The first stage, and the plane between the halves of the brain.
    """

    candidates: tuple[Candidate, ...]
    weight: FloatArray
    octree: OctreeCandidates
    plane: SymmetryPlane


def find_candidates(
    calibration: Calibration,
    brain: BoolArray,
    spacing: float,
    *,
    plane: SymmetryPlane | None = None,
    limit: int = 16,
    check_cancelled: Callable[[], None] = lambda: None,
) -> Search:
    """Find places to start from, by falling evidence for a tumor.

    Parameters
    ----------
    calibration
        The calibrated difference and the volume before contrast.
    brain : (I, J, K) bool
    spacing
        Edge of a voxel in mm.
    plane
        Between the halves of the brain, where it is known; by default it is looked for.
    limit
        How many are returned at the most.
    check_cancelled
        Called between the steps.
    """
    field = calibration.field
    middle = find_symmetry(calibration.before, brain, spacing) if plane is None else plane
    check_cancelled()

    def weighed() -> tuple[FloatArray, BoolArray]:
        weight = evidence(field, calibration.before, brain, middle, spacing)
        return weight, dense((field > SEED_THRESHOLD) & brain, spacing) & (weight > LEAST_WEIGHT)

    (weight, solid), octree = both(weighed, lambda: search_octree(field, brain, spacing, SEED_THRESHOLD))
    check_cancelled()
    peak = octree.on_grid((field.shape[0], field.shape[1], field.shape[2]))
    solid &= peak > 0
    found = []
    pieces = parts(solid)
    masses = np.array([weight.ravel()[piece].sum(dtype=np.float64) for piece in pieces]) * spacing**3
    for n in np.argsort(-masses, kind="stable")[:limit]:
        part, mass = pieces[n], float(masses[n])
        if mass < LEAST_EVIDENCE_MM3:
            break
        median = float(np.median(field.ravel()[part]))
        clear = 1.0 / (1.0 + float(np.exp((CLEARLY_MORE[0] - median) / CLEARLY_MORE[1])))
        voxels = np.zeros(solid.shape, dtype=np.bool_)
        voxels.ravel()[part] = True
        found.append(Candidate(voxels, mass * clear, float(np.median(peak.ravel()[part])), median))
    found.sort(key=lambda candidate: -candidate.evidence_mm3)
    return Search(tuple(found), weight, octree, middle)


def first_threshold(peak: float) -> float:
    """Return the threshold that the second peak of the histogram gives (3.5.2)."""
    return float(np.clip(LEVEL * peak, *LEVEL_RANGE))

"""Candidates for a seed: connected enhancing voxels in the octree's cells, ranked by the evidence in them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_segmentation.calibration import Calibration
from shapery_segmentation.gate import LEVEL, LEVEL_RANGE, dense
from shapery_segmentation.seeding.evidence import evidence
from shapery_segmentation.seeding.octree import OctreeCandidates, search_octree
from shapery_segmentation.seeding.symmetry import SymmetryPlane, find_symmetry

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

SEED_THRESHOLD = 2.0
"""Enhancement, in units of the calibrated difference, above which voxels make a seed. The surface's own threshold,
which may be lower, follows from the seed."""

LEAST_WEIGHT = 0.25
"""Evidence below which a voxel joins no candidate: vessels that touch a tumor are parted from it here."""

HALF_CONFIDENCE_MM3 = 900.0
"""Evidence (mm³ weighted by it) at which a candidate is as likely a tumor as not."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A place to start from.

    Parameters
    ----------
    voxels : (I, J, K) bool
        On the working grid.
    evidence_mm3
        Volume of the voxels, each weighted by its evidence.
    peak
        Of the second class of the octree's cells, in units of the calibrated difference.
    seeded_by
        Whether it was found, or given by the user.
    """

    voxels: BoolArray
    evidence_mm3: float
    peak: float
    seeded_by: Literal["automatic", "user"] = "automatic"

    @property
    def confidence(self) -> float:
        """In [0, 1]: 0.5 at the evidence of the largest false alarms."""
        return self.evidence_mm3 / (self.evidence_mm3 + HALF_CONFIDENCE_MM3)


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
    limit
        How many are returned at the most.
    check_cancelled
        Called between the steps.
    """
    field = calibration.field
    plane = find_symmetry(calibration.before, brain, spacing)
    check_cancelled()
    octree = search_octree(field, brain, spacing, SEED_THRESHOLD)
    check_cancelled()
    weight = evidence(field, calibration.before, brain, plane, spacing)
    check_cancelled()
    peak = octree.on_grid((field.shape[0], field.shape[1], field.shape[2]))
    solid = dense((field > SEED_THRESHOLD) & brain, spacing) & (weight > LEAST_WEIGHT) & (peak > 0)
    labels, count = ndimage.label(solid, np.ones((3, 3, 3)))
    if count == 0:
        return Search((), weight, octree, plane)
    numbers = np.arange(1, count + 1)
    masses = np.asarray(ndimage.sum_labels(weight, labels, numbers)) * spacing**3
    peaks = np.asarray(ndimage.median(peak, labels, numbers))
    order = np.argsort(-masses, kind="stable")[:limit]
    found = tuple(
        Candidate(np.asarray(labels == numbers[n]), float(masses[n]), float(peaks[n])) for n in order if masses[n] > 0
    )
    return Search(found, weight, octree, plane)


def first_threshold(peak: float) -> float:
    """Return the threshold that the second peak of the histogram gives (3.5.2)."""
    return float(np.clip(LEVEL * peak, *LEVEL_RANGE))

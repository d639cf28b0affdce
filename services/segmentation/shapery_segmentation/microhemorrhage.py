"""Microhemorrhages: clusters of bleeding around a tumor and its vessels (3.5.3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Volume
from shapery_segmentation.objects import spread
from shapery_segmentation.vessels import _border_kernels as kernels
from shapery_segmentation.vessels.border import find_border, within
from shapery_segmentation.vessels.evidence import BLOCK, gather_evidence
from shapery_segmentation.vessels.outside import measured

BoolArray = NDArray[np.bool_]

REACH = 8.0
"""mm around vessels and tumor within which a bleeding must begin."""

BESIDE = 1.5
"""Voxels around a vessel that are mixed with it."""

LEAST_SCATTER, LEAST_SHARE = 6.0, 0.4
"""What a first voxel must differ from the background: multiples of its scatter, and share of the contrast of vessels
(of the strongest voxels where none are known)."""

LARGEST_SHARE = 0.05
"""Share of the volume at which growth stops: bleedings are small."""

LEAST_VOXELS, LEAST_OF_LARGEST = 8, 0.1
"""Voxels of a cluster, and its volume relative to the largest one: smaller ones are noise, or no major cluster."""

COMPACT = 1.6
"""Largest spread (see `shapery_segmentation.objects.spread`) of a cluster: a ball has 0.77, a vessel four times as long
as thick 1.1, one that is missing from the vessels more than 2."""


@dataclass(frozen=True, slots=True)
class Cluster:
    """One bleeding: its volume in mm³, the mean of its voxels in RAS mm, and how many they are."""

    volume_mm3: float
    centroid: tuple[float, float, float]
    voxels: int


@dataclass(frozen=True, eq=False)
class Microhemorrhages:
    """What `find_microhemorrhages` found.

    Parameters
    ----------
    mask : (I, J, K) bool
        On the grid of the volume that was given.
    clusters
        By falling volume.
    threshold
        Value of the volume at which growth began, the median over the clusters; none without clusters.
    polarity
        Whether bleedings were taken for bright or for dark.
    """

    mask: BoolArray
    clusters: tuple[Cluster, ...]
    threshold: float | None
    polarity: Literal["bright", "dark"]


def find_microhemorrhages(
    volume: Volume,
    *,
    vessels: BoolArray | None = None,
    tumor: BoolArray | None = None,
    polarity: Literal["bright", "dark"] = "dark",
    reach: float = REACH,
    check_cancelled: Callable[[], None] | None = None,
) -> Microhemorrhages:
    """Find clusters of bleeding around vessels and tumor.

    Parameters
    ----------
    volume
        SWI shows bleedings dark, as it shows veins; CT and T1-weighted images show fresh ones bright.
    vessels, tumor : (I, J, K) bool
        On the grid of `volume`; at least one of them with a voxel.
    polarity
        Of the bleedings; usually that of the vessels.
    reach
        mm around vessels and tumor within which a bleeding begins. It may extend further.
    check_cancelled
        Called between the steps; what it raises passes through.

    Returns
    -------
    Microhemorrhages
        Without clusters where nothing bleeds: that is no error.

    Raises
    ------
    InvalidInput
        ``grid_mismatch`` for masks of another shape, ``invalid_params`` where both are empty.

    Notes
    -----
    Voxels beyond a threshold around vessel and tumor enter a queue, and their neighbours by the same rule until there
    are no more. The threshold, which the dissertation leaves to experts, is the larger of two: six times the scatter of
    tissue, and two fifths of the contrast of the vessels. Then the clusters are enlarged: what is nearer to the cluster
    than to the tissue around it belongs to it, both measured on the spot, as for vessels. Clusters much smaller than
    the largest are left out, and so are long ones, which are vessels.

    References
    ----------
    Section 3.5.3 of the dissertation.
    """
    for mask in (vessels, tumor):
        if mask is not None and mask.shape != volume.shape:
            raise InvalidInput(
                "grid_mismatch", f"A mask of shape {mask.shape} does not fit a volume of {volume.shape}."
            )
    given = [mask for mask in (vessels, tumor) if mask is not None and mask.any()]
    if not given:
        raise InvalidInput("invalid_params", "Bleedings are looked for around vessels and tumors, and there are none.")
    check = check_cancelled if check_cancelled is not None else _nothing
    canonical, order = volume.canonical()
    values, outside = measured(canonical)
    grid = Volume(values, canonical.affine)
    objects = np.ascontiguousarray(order.apply_array(np.logical_or.reduce(given)))
    vessel = np.zeros(grid.shape, dtype=np.bool_)
    if vessels is not None:
        vessel = np.ascontiguousarray(order.apply_array(vessels))

    around = within(objects, grid.spacing, reach) & ~objects
    blocked = within(vessel, (1.0, 1.0, 1.0), BESIDE)
    if outside is not None:
        around &= ~outside
        blocked |= outside
    check()
    evidence = gather_evidence(values, grid.spacing, polarity, around, outside)
    excess = _excess(evidence.smoothed, evidence.background)
    contrast = float(np.median(excess[_middle(vessel)])) if vessel.any() else float(np.percentile(excess[around], 99.9))
    least = max(LEAST_SCATTER * evidence.scatter, LEAST_SHARE * contrast)
    start = np.argwhere(around & ~blocked & (excess > least))
    nothing = Microhemorrhages(np.zeros(volume.shape, dtype=np.bool_), (), None, polarity)
    if not len(start):
        return nothing
    check()
    # The tumor's own voxels may bleed too; those of vessels are vessel.
    border = find_border(evidence, start, most=max(int(LARGEST_SHARE * values.size), len(start)), blocked=blocked)
    check()
    labels, count = ndimage.label(border.inside == 1, np.ones((3, 3, 3)))
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    sizes[0] = 0
    kept = np.zeros(grid.shape, dtype=np.bool_)
    clusters: list[Cluster] = []
    for label, place in enumerate(ndimage.find_objects(labels), start=1):
        if sizes[label] < LEAST_VOXELS or spread(labels[place] == label) > COMPACT:
            sizes[label] = 0
    for label in np.argsort(-sizes, kind="stable"):
        if sizes[label] < max(LEAST_VOXELS, LEAST_OF_LARGEST * sizes.max()):
            break
        part = labels == label
        kept |= part
        x, y, z = grid.to_world(np.argwhere(part).mean(axis=0)).tolist()
        clusters.append(Cluster(float(sizes[label]) * grid.voxel_volume, (x, y, z), int(sizes[label])))
    if not clusters:
        return nothing
    ground = np.median([kernels.sample_blocks(evidence.background, BLOCK, *voxel) for voxel in np.argwhere(kept)[::7]])
    threshold = float(ground + least) * (1.0 if polarity == "bright" else -1.0)
    return Microhemorrhages(np.ascontiguousarray(order.undo_array(kept)), tuple(clusters), threshold, polarity)


def _excess(smoothed: NDArray[np.float32], background: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return how far each voxel rises above the background."""
    where = [
        np.clip((np.arange(n) + 0.5) / BLOCK - 0.5, 0, m - 1)
        for n, m in zip(smoothed.shape, background.shape, strict=True)
    ]
    ground: NDArray[np.float32] = background
    for axis, at in enumerate(where):
        low = np.minimum(at.astype(int), max(background.shape[axis] - 2, 0))
        share = (at - low).astype(np.float32).reshape([-1 if a == axis else 1 for a in range(3)])
        high = np.minimum(low + 1, background.shape[axis] - 1)
        ground = ground.take(low, axis=axis) * (1 - share) + ground.take(high, axis=axis) * share
    return np.asarray(smoothed - ground)


def _middle(vessel: BoolArray) -> BoolArray:
    """Return the inner voxels of vessels, or all where none is inner."""
    inner = ndimage.binary_erosion(vessel)
    return np.asarray(inner if inner.any() else vessel)


def _nothing() -> None:
    return None

"""How well one mask agrees with another: overlap, volume, and distances between their surfaces (S14)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_contracts.errors import InvalidInput

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class MaskMetrics:
    """Agreement of a result with a reference.

    Overlaps of two empty masks are 1: they agree. Distances are NaN where both masks are empty and infinite where one
    of them is.
    """

    iou: float
    """|A ∩ B| / |A ∪ B|, the accuracy of Table 3.1."""
    dice: float
    """2 |A ∩ B| / (|A| + |B|)."""
    result_mm3: float
    reference_mm3: float
    volume_difference: float
    """(|A| − |B|) / |B|; infinite where the reference alone is empty."""
    assd_mm: float
    """Average symmetric surface distance: the mean over the surface voxels of both masks."""
    hd95_mm: float
    """The larger of the two directed 95th percentiles of surface distances."""
    hd_mm: float
    """Hausdorff distance: the largest of all."""


def intersection_over_union(result: NDArray[Any], reference: NDArray[Any]) -> float:
    """Return |A ∩ B| / |A ∪ B| of two masks of equal shape; 1 if both are empty."""
    a, b = _checked(result, reference)
    union = int(np.count_nonzero(a | b))
    return int(np.count_nonzero(a & b)) / union if union else 1.0


def dice(result: NDArray[Any], reference: NDArray[Any]) -> float:
    """Return 2 |A ∩ B| / (|A| + |B|) of two masks of equal shape; 1 if both are empty."""
    a, b = _checked(result, reference)
    total = int(np.count_nonzero(a)) + int(np.count_nonzero(b))
    return 2 * int(np.count_nonzero(a & b)) / total if total else 1.0


def surface_distances(
    result: NDArray[Any], reference: NDArray[Any], spacing: Sequence[float] = (1.0, 1.0, 1.0)
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distances in mm from each surface voxel of one mask to the nearest surface voxel of the other.

    Parameters
    ----------
    result, reference : (I, J, K) bool
        Neither may be empty. A surface voxel is one of the mask with a face neighbour that is not; what lies outside
        the array is not.
    spacing
        Distance between voxel centres along each axis in mm.

    Returns
    -------
    From `result` to `reference`, and from `reference` to `result`.
    """
    a, b = _checked(result, reference)
    steps = _checked_spacing(spacing)
    if not a.any() or not b.any():
        raise ValueError("a mask without voxels has no surface")
    box = ndimage.find_objects((a | b).astype(np.uint8))[0]
    # One voxel around, so that what touches the border of the box has a surface there.
    a, b = np.pad(a[box], 1), np.pad(b[box], 1)
    inner = ndimage.generate_binary_structure(3, 1)
    surface_a = a & ~ndimage.binary_erosion(a, inner)
    surface_b = b & ~ndimage.binary_erosion(b, inner)
    to_b = ndimage.distance_transform_edt(~surface_b, sampling=steps)[surface_a]
    to_a = ndimage.distance_transform_edt(~surface_a, sampling=steps)[surface_b]
    return np.asarray(to_b, dtype=np.float64), np.asarray(to_a, dtype=np.float64)


def mask_metrics(
    result: NDArray[Any], reference: NDArray[Any], spacing: Sequence[float] = (1.0, 1.0, 1.0)
) -> MaskMetrics:
    """Compare two masks on one grid.

    Parameters
    ----------
    result, reference : (I, J, K) bool or convertible
        Every value other than zero belongs to the mask.
    spacing
        Distance between voxel centres along each axis in mm.

    Raises
    ------
    InvalidInput
        ``grid_mismatch`` for masks of different shapes.
    """
    a, b = _checked(result, reference)
    steps = _checked_spacing(spacing)
    voxel = float(np.prod(steps))
    count_a, count_b = int(np.count_nonzero(a)), int(np.count_nonzero(b))
    if count_a and count_b:
        to_b, to_a = surface_distances(a, b, steps)
        assd = float((to_b.sum() + to_a.sum()) / (len(to_b) + len(to_a)))
        hd95 = max(float(np.percentile(to_b, 95)), float(np.percentile(to_a, 95)))
        hd = max(float(to_b.max()), float(to_a.max()))
    else:
        assd = hd95 = hd = float("nan") if count_a == count_b else float("inf")
    change = count_a - count_b
    difference = change / count_b if count_b else (float("inf") if change else 0.0)
    return MaskMetrics(
        iou=intersection_over_union(a, b),
        dice=dice(a, b),
        result_mm3=count_a * voxel,
        reference_mm3=count_b * voxel,
        volume_difference=difference,
        assd_mm=assd,
        hd95_mm=hd95,
        hd_mm=hd,
    )


def _checked(result: NDArray[Any], reference: NDArray[Any]) -> tuple[BoolArray, BoolArray]:
    a, b = np.asarray(result), np.asarray(reference)
    if a.shape != b.shape:
        raise InvalidInput("grid_mismatch", f"The masks have the shapes {a.shape} and {b.shape}.")
    if a.ndim != 3:
        raise InvalidInput("invalid_volume", f"A mask has 3 dimensions, not {a.ndim}.")
    return a.astype(np.bool_), b.astype(np.bool_)


def _checked_spacing(spacing: Sequence[float]) -> tuple[float, float, float]:
    steps = tuple(float(s) for s in spacing)
    if len(steps) != 3 or not all(np.isfinite(s) and s > 0 for s in steps):
        raise ValueError(f"the spacing is three positive lengths, not {spacing!r}")
    return steps[0], steps[1], steps[2]

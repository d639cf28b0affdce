"""What the user points with: refused where it points at nothing, and candidates from points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.volume import Volume
from shapery_segmentation.brain import Brain
from shapery_segmentation.calibration import Calibration
from shapery_segmentation.gate import LEVEL_RANGE, dense
from shapery_segmentation.seeding.candidates import Candidate

SEARCH = 25.0
"""mm around a point in which enhancing voxels are looked for: a point in the middle of a necrosis is a good one too."""

NEAR = 3.0
"""mm around the nearest enhancing voxel that make the seed."""


def check_points(points: Sequence[Sequence[float]], post: Volume) -> None:
    """Refuse points outside the volume.

    Raises
    ------
    InvalidInput
        ``invalid_params``, with the point and the range of the volume.
    """
    for point in points:
        if not np.isfinite(point).all() or not bool(post.contains(point)):
            low, high = post.corners().min(axis=0), post.corners().max(axis=0)
            ranges = ", ".join(f"{name} {a:.0f} to {b:.0f}" for name, a, b in zip("xyz", low, high, strict=True))
            raise InvalidInput(
                "invalid_params",
                f"The seed ({', '.join(f'{x:g}' for x in point)}) lies outside the volume ({ranges} mm).",
                "Seeds are points in RAS millimetres: x to the patient's right, y to the front, z to the head.",
            )


def candidates_from_points(
    points: Sequence[Sequence[float]],
    brain: Brain,
    calibration: Calibration,
    weight: NDArray[np.float32],
    warnings: list[str],
) -> list[Candidate]:
    """Return a candidate for each point near which something enhances.

    Parameters
    ----------
    points
        RAS mm.
    brain, calibration
        Working grid, mask and calibrated difference.
    weight : (I, J, K) float32
        Evidence of every voxel.
    warnings
        A sentence is added for each point that leads nowhere.

    Raises
    ------
    InvalidInput
        ``no_object_found`` if no point leads anywhere.
    """
    grid, field = brain.grid, calibration.field
    enhancing = (field > LEVEL_RANGE[0]) & brain.mask
    solid = dense(enhancing, grid.spacing)
    found: list[Candidate] = []
    for point in points:
        index = np.linalg.solve(grid.affine[:3, :3], np.asarray(point, dtype=np.float64) - grid.affine[:3, 3])
        low = np.clip(np.floor(index - SEARCH / grid.spacing), 0, np.array(grid.shape) - 1).astype(int)
        high = np.clip(np.ceil(index + SEARCH / grid.spacing) + 1, 1, grid.shape).astype(int)
        box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
        # Dense enhancement is preferred; a thin object still has its single voxels.
        near = np.argwhere(solid[box])
        if not len(near):
            near = np.argwhere(enhancing[box])
        distance = np.linalg.norm(near + low - index, axis=1) * grid.spacing if len(near) else np.empty(0)
        if not len(near) or distance.min() > SEARCH:
            warnings.append(f"Nothing enhances within {SEARCH:.0f} mm of the seed ({_shown(point)}).")
            continue
        nearest = near[int(distance.argmin())] + low
        voxels = np.zeros(grid.shape, dtype=np.bool_)
        around = near[np.linalg.norm(near + low - nearest, axis=1) * grid.spacing <= NEAR] + low
        voxels[tuple(around.T)] = True
        found.append(
            Candidate(
                voxels,
                float(weight[voxels].sum()) * grid.spacing**3,
                float(np.median(field[voxels])),
                float(np.median(field[voxels])),
                "user",
            )
        )
    if not found:
        raise InvalidInput(
            "no_object_found",
            f"None of the {len(points)} seeds has anything within {SEARCH:.0f} mm that enhances.",
            "Place a seed on the bright rim after contrast, or leave seeds out to search the whole brain.",
        )
    return found


def _shown(point: Sequence[float]) -> str:
    return ", ".join(f"{x:g}" for x in point)


def check_box(box: Sequence[float] | None, volume: Volume) -> None:
    """Refuse a box that is flat or lies outside the volume.

    Raises
    ------
    InvalidInput
        ``invalid_params``.
    """
    if box is None:
        return
    low, high = np.sort(np.asarray(box, dtype=np.float64).reshape(2, 3), axis=0)
    if not np.isfinite([low, high]).all() or ((high - low) < 2.0 * min(volume.spacing)).any():
        raise InvalidInput(
            "invalid_params",
            f"The box of {' × '.join(f'{e:.3g}' for e in high - low)} mm is too flat to hold an object.",
            "A box is x0, y0, z0, x1, y1, z1 in RAS millimetres: two opposite corners.",
        )
    if not bool(volume.contains((low + high) / 2)):
        raise InvalidInput(
            "invalid_params",
            f"The middle of the box ({', '.join(f'{c:.4g}' for c in (low + high) / 2)}) lies outside the volume.",
            "A box is x0, y0, z0, x1, y1, z1 in RAS millimetres: two opposite corners.",
        )


def check_vessel_seeds(params: SegmentationParams, volume: Volume | None) -> None:
    """Refuse seeds for vessels without a volume that shows them.

    Raises
    ------
    InvalidInput
        ``missing_input``.
    """
    if params.vessel_seeds and volume is None:
        raise InvalidInput(
            "missing_input",
            f"{len(params.vessel_seeds)} seeds for vessels were given, but no volume that shows vessels.",
            "Give it as the input vessels (--vessels).",
        )

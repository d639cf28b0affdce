"""What damping, aging (S5) and geometric interpolation (S8) do for the flow: each with and without."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.flow.normal import normal_flow
from shapery_segmentation.flow.params import NormalFlowParams

WITHOUT: dict[str, dict[str, float | None]] = {
    "damping": {"damping": 1.0},
    "aging": {"aging_limit": None},
    "interpolation": {"interpolation_share": None},
}
"""How each part is switched off."""

COMBINATIONS: tuple[tuple[str, ...], ...] = (
    (),
    ("aging",),
    ("interpolation",),
    ("aging", "interpolation"),
    ("damping",),
    ("damping", "aging"),
    ("damping", "interpolation"),
    ("damping", "aging", "interpolation"),
)
"""What is left out, row by row. Damping is not in the dissertation: without it the others have more to do."""


@dataclass(frozen=True, slots=True)
class AblationRow:
    """One run of the flow.

    Parameters
    ----------
    without
        The parts that were left out.
    iou
        Of the voxels inside the surface with the truth.
    iterations, converged
        Of the flow.
    oscillating, oscillations
        The most vertices that were oscillating at once, and their sum over all iterations.
    aged, interpolations
        Vertices that ended stopped for their age, and how often vertices were interpolated.
    cpu_seconds
    """

    without: tuple[str, ...]
    iou: float
    iterations: int
    converged: bool
    oscillating: int
    oscillations: int
    aged: int
    interpolations: int
    cpu_seconds: float


def ablate(
    field: NDArray[np.float32],
    allowed: NDArray[np.bool_] | None,
    affine: NDArray[np.float64],
    seed: TriangleMesh,
    truth: NDArray[np.bool_],
    params: NormalFlowParams | None = None,
    *,
    threshold: float,
) -> tuple[AblationRow, ...]:
    """Run the flow with and without damping, aging and interpolation.

    Parameters
    ----------
    field, allowed, affine, seed, params, threshold
        As `normal_flow` takes them.
    truth : (I, J, K) bool
        The object, on the grid of `field`.

    Returns
    -------
    A row for each of `COMBINATIONS`, in their order.
    """
    base = params if params is not None else NormalFlowParams()
    rows = []
    for without in COMBINATIONS:
        changes: dict[str, Any] = {}
        for part in without:
            changes |= WITHOUT[part]
        start = time.process_time()
        result = normal_flow(field, allowed, affine, seed, replace(base, **changes), threshold=threshold)
        seconds = time.process_time() - start
        inside = rasterize(result.mesh, Volume(field, affine))
        union = int(np.count_nonzero(inside | truth))
        rows.append(
            AblationRow(
                without=without,
                iou=np.count_nonzero(inside & truth) / union if union else 1.0,
                iterations=result.iterations,
                converged=result.converged,
                oscillating=result.oscillating,
                oscillations=result.oscillations,
                aged=result.aged,
                interpolations=result.interpolations,
                cpu_seconds=seconds,
            )
        )
    return tuple(rows)

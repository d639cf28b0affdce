"""Why a surface ended smaller than it began: what is reported of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume

NOTICED = 0.995
"""Share of the seed's volume from which a surface counts as no smaller: less is rounding of corners."""


def shrinking_note(
    seed: TriangleMesh, end: TriangleMesh, field: NDArray[np.float32], affine: NDArray[np.float64], threshold: float
) -> str | None:
    """Return a sentence that says why a surface is smaller than its seed; none where it is not.

    Parameters
    ----------
    seed, end
        The surface before and after its flow, RAS mm.
    field : (I, J, K) float32
        What it flowed in.
    affine : (4, 4) float64
        From index to RAS mm.
    threshold
        Above which a voxel is inside, at the end.
    """
    share = float(end.volume / seed.volume)
    if share >= NOTICED:
        return None
    grid = Volume(field, affine)
    lost = rasterize(seed, grid, known_closed=True) & ~rasterize(end, grid, known_closed=True)
    below = float(np.mean(field[lost] <= threshold)) if lost.any() else 0.0
    if below >= 0.5:
        why = f"{below:.0%} of what it left lies below the threshold that follows from what is inside"
    else:
        why = "it is thinner there than its smoothing allows"
    return f"The surface ended with {share:.0%} of the volume of its seed: {why}."

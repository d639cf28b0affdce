"""Whether a volume shows a head, so that the way of tumors applies, or something else."""

from __future__ import annotations

from typing import Literal

import numpy as np

from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.volume import Volume
from shapery_segmentation.brain import largest_part, otsu
from shapery_segmentation.neighborhoods import filled
from shapery_segmentation.preparation import working_grid

COARSE = 4.0
"""mm."""

HEAD_EXTENT = (90.0, 290.0)
"""mm that a head, or a brain alone, has along each axis; a head with its neck is longer only along one."""

LONGEST = 380.0

HEAD_VOLUME = (0.5e6, 9.0e6)
"""mm³ of a stripped brain, and of a head with its neck."""

LEAST_FILL = 0.3
"""Share of its bounding box that a head fills; a ball has 0.52."""

AIR = -200.0
"""Below this only CT has values, and its air fills much of the volume."""


def choose_mode(post: Volume, params: SegmentationParams) -> Literal["tumor", "object"]:
    """Return the mode that the parameters ask for, or that follows from what the volume shows.

    Whoever points at nothing gets the search for tumors, whose refusals say what is wrong with a volume that is no
    head.
    """
    if params.mode != "auto":
        return params.mode
    if params.box is not None:
        return "object"
    return "object" if params.seeds and not looks_like_head(post) else "tumor"


def looks_like_head(volume: Volume) -> bool:
    """Tell whether a volume shows a head in MRI: by the size and the roundness of what is brighter than its background.

    A rough test: it tells heads from trunks, limbs, phantoms and CT.
    """
    values = volume.filled()
    if float(np.mean(values.data < AIR)) > 0.05:
        return False
    grid = working_grid(values, spacing=COARSE)
    image = grid.sample(values)
    known = np.isfinite(image)
    if not known.any():
        return False
    tissue = largest_part(np.where(known, image, -np.inf) > otsu(image[known]))
    tissue = filled(tissue)
    index = np.argwhere(tissue)
    if not len(index):
        return False
    extent = np.sort((np.ptp(index, axis=0) + 1) * COARSE)
    volume_mm3 = len(index) * COARSE**3
    return bool(
        HEAD_EXTENT[0] <= extent[0]
        and extent[1] <= HEAD_EXTENT[1]
        and extent[2] <= LONGEST
        and HEAD_VOLUME[0] <= volume_mm3 <= HEAD_VOLUME[1]
        and volume_mm3 / float(np.prod(extent)) >= LEAST_FILL
    )

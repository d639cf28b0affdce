"""Our own setting, left open: what a case gets when the others choose the setting (leave one case out)."""

from __future__ import annotations

from typing import Any
from unittest import mock

import numpy as np

from benchmarks.segmentation.cases import Case
from benchmarks.segmentation.flows import recorded
from benchmarks.segmentation.ours import agreement
from shapery_geometry.volume_io import read_volume
from shapery_segmentation import gate, segment

SETTINGS: list[dict[str, float]] = [
    {"level": level, "curvature_weight": weight}
    for level in (0.35, 0.4, 0.45, 0.5, 0.55)
    for weight in (0.06, 0.12, 0.2)
]
"""The two constants that the result depends on most: the share of the median at which the border lies, and how much
the surface smooths itself."""


def measure(case: Case) -> list[dict[str, Any]]:
    """Return the agreement with the expert for each setting."""
    post = read_volume(case.post)
    pre = read_volume(case.pre) if case.pre is not None else None
    reference = read_volume(case.reference).data
    rows = []
    for setting in SETTINGS:
        level, weight = setting["level"], setting["curvature_weight"]
        with (
            mock.patch.object(gate, "LEVEL", level),
            recorded(threshold_share=level, curvature_weight=weight),
        ):
            labels = segment(post, pre).labels
        rows.append(
            {
                "setting": setting,
                "enhancing": agreement(labels.data == 1, np.isin(reference, case.enhancing), labels),
                "core": agreement(np.isin(labels.data, (1, 2)), np.isin(reference, case.core), labels),
            }
        )
    return rows

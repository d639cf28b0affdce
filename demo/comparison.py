"""How far a result agrees with the truth of a phantom."""

from __future__ import annotations

from pathlib import Path

from shapery_geometry.mask_metrics import MaskMetrics, mask_metrics
from shapery_geometry.volume_io import read_volume

PARTS = {"enhancing tumor": (1,), "core (with necrosis)": (1, 2)}
"""Parts that are compared, with the labels they consist of, alike in results and truth."""


def compare(labels: Path, truth: Path) -> dict[str, MaskMetrics]:
    """Compare label volumes on one grid, part by part."""
    found, known = read_volume(labels), read_volume(truth)
    spacing = tuple(float(step) for step in known.spacing)
    return {
        part: mask_metrics(sum(found.data == v for v in values), sum(known.data == v for v in values), spacing)
        for part, values in PARTS.items()
    }

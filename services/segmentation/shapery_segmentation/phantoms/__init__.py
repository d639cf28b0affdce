"""Phantoms: generated heads and vessels with known truth."""

from __future__ import annotations

from shapery_segmentation.phantoms.head import DrawnTumor, HeadPhantom, TumorSpec, head_phantom
from shapery_segmentation.phantoms.vessels import (
    DrawnBranch,
    VesselPhantom,
    phantom_of_label,
    tube_phantom,
    vessel_tree_phantom,
)

__all__ = [
    "DrawnBranch",
    "DrawnTumor",
    "HeadPhantom",
    "TumorSpec",
    "VesselPhantom",
    "head_phantom",
    "phantom_of_label",
    "tube_phantom",
    "vessel_tree_phantom",
]

"""Phantoms: generated heads with known truth."""

from __future__ import annotations

from shapery_segmentation.phantoms.head import DrawnTumor, HeadPhantom, TumorSpec, head_phantom

__all__ = ["DrawnTumor", "HeadPhantom", "TumorSpec", "head_phantom"]

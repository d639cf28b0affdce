"""Blood vessels: seeded, tracked by the tangential flow, measured."""

from __future__ import annotations

from shapery_segmentation.vessels.centerline import Branch
from shapery_segmentation.vessels.recover import Vessels, VesselTree, segment_vessels

__all__ = ["Branch", "VesselTree", "Vessels", "segment_vessels"]

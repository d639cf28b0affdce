"""Blobs with a known border through the general mode, from a seed: both contrasts, noise, bias, thick slices."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.segmentation.ours import agreement
from shapery_contracts.errors import InvalidInput
from shapery_contracts.segmentation import SegmentationParams
from shapery_segmentation import segment
from shapery_segmentation.phantoms.blob import blob_phantom

BLOBS: dict[str, dict[str, Any]] = {
    "128³, bright, SNR 10": {"shape": (128, 128, 128), "radius": 32.0},
    "bright, SNR 10": {},
    "dark, SNR 10": {"polarity": "dark"},
    "bright, SNR 10, bias 40 %": {"bias": 0.4},
    "dark, SNR 10, bias 40 %": {"polarity": "dark", "bias": 0.4},
    "bright, SNR 5": {"snr": 5.0},
    "dark, SNR 5, bias 40 %": {"polarity": "dark", "snr": 5.0, "bias": 0.4},
    "bright, SNR 10, slices of 3 mm": {"shape": (64, 64, 22), "affine": np.diag([1.0, 1.0, 3.0, 1.0])},
}


def measure(name: str) -> dict[str, Any]:
    """Return how one blob is recovered."""
    phantom = blob_phantom(np.random.default_rng(1), **BLOBS[name])
    start = time.process_time()
    try:
        result = segment(phantom.volume, params=SegmentationParams(mode="object", seeds=[phantom.center.tolist()]))
    except InvalidInput as refusal:
        return {"name": name, "refused": refusal.message}
    (item,) = result.report.objects
    return {
        "name": name,
        "refused": None,
        "cpu_seconds": time.process_time() - start,
        "polarity": item.polarity,
        "closed": item.closed,
        "genus": item.genus,
        "self_intersections": item.self_intersections,
        "notes": item.notes,
        **agreement(result.labels.data == 1, phantom.truth.data, phantom.volume),
    }

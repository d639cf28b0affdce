"""``python -m shapery_segmentation.warm``: compile every kernel once, so that no job waits for the compiler.

Set-up and the worker's image run it; numba keeps what it compiled in its cache (`NUMBA_CACHE_DIR`, or beside the code).
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from shapery_segmentation import segment, write_outputs
from shapery_segmentation.phantoms import head_phantom


def warm() -> None:
    """Segment a small head with a tumor, from both volumes to all outputs."""
    head = head_phantom(np.random.default_rng(0), shape=(64, 72, 64), spacing=(2.8, 2.8, 2.8))
    with tempfile.TemporaryDirectory() as folder:
        write_outputs(segment(head.post, head.pre), Path(folder))


if __name__ == "__main__":
    warm()

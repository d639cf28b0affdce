"""After `warm` the first job compiles nothing, whatever its mode."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba.core import caching

from shapery_contracts.segmentation import SegmentationParams
from shapery_segmentation import segment
from shapery_segmentation.phantoms import TumorSpec, head_phantom
from shapery_segmentation.phantoms.blob import blob_phantom
from shapery_segmentation.warm import warm


@pytest.mark.slow
def test_nothing_is_left_to_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    head = head_phantom(np.random.default_rng(2), (160, 192, 160), tumors=[TumorSpec(radius=14.0)])
    blob = blob_phantom(np.random.default_rng(2))
    warm()
    compiled: list[str] = []
    save = caching.FunctionCache.save_overload

    def noted(self: Any, *given: Any) -> None:
        compiled.append(self._name)
        save(self, *given)

    monkeypatch.setattr(caching.FunctionCache, "save_overload", noted)
    assert segment(head.post, head.pre).report.objects
    middle = blob.center
    segment(blob.volume, params=SegmentationParams(mode="object", seeds=[middle.tolist()]))
    segment(blob.volume, params=SegmentationParams(box=[*(middle - 24.0), *(middle + 24.0)]))
    assert compiled == []

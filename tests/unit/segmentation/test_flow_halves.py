"""The normal flow on two threads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from shapery_geometry.mesh import icosphere
from shapery_segmentation.flow import NormalFlowParams, evolving
from shapery_segmentation.flow.evolving import Evolution
from shapery_segmentation.mesh import contacts


@pytest.mark.parametrize("thorough", [False, True])
def test_two_halves_at_once_give_the_same_bytes_as_one(thorough: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    rng = np.random.default_rng(11)
    field = (3.0 * (ndimage.gaussian_filter(rng.normal(size=(24, 24, 24)), 1.2) * 6.0 + 0.4)).astype(np.float32)
    params = NormalFlowParams(threshold_share=None, edge_lengths=(1.5,))
    ends = []
    for many in (1, 10**9):
        monkeypatch.setattr(contacts, "MANY", many)
        monkeypatch.setattr(evolving, "MANY", many)
        seed = icosphere((12.0, 12.0, 12.0), 6.0, 3)
        evolution = Evolution(field, None, np.eye(4), seed, params, 0.0, thorough)
        evolution.run_stage(0, None)
        ends.append(evolution.result(evolution.mesh.mend()))
    first, second = ends
    assert first.iterations > 20
    assert first.frozen > 0
    assert first.mesh.same_as(second.mesh)
    assert replace(first, mesh=second.mesh) == second

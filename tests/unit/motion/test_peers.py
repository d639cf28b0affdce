"""The peers of the motion benchmark reach the error they are asked for, with what they coded."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.motion.case import Case, Method, to_target
from benchmarks.motion.quantised import delta_lzma, delta_parallelogram
from benchmarks.motion.subspaces import clustered_pca, principal, rounded, shape_pca, trajectory_pca
from shapery_geometry.mesh import icosphere


@pytest.fixture(scope="module")
def case() -> Case:
    ball = icosphere(subdivisions=2)
    x, y, z = ball.vertices.T
    bends = 0.4 * np.sin(0.4 * np.arange(16))
    frames = [np.stack((x + b * np.sin(2 * z), y + 0.1 * b * x, z - b * x * x), axis=1) for b in bends]
    return Case("ball", np.stack(frames), ball.faces)


@pytest.mark.parametrize(
    "method",
    [delta_lzma, delta_parallelogram, trajectory_pca, shape_pca, lambda case, kg: clustered_pca(case, kg, (2, 4)),
     lambda case, kg: clustered_pca(case, kg, (2, 4), plain=True)],
    ids=["lzma", "parallelogram", "trajectory", "shape", "clustered", "plain"],
)  # fmt: skip
def test_a_peer_reaches_the_error(case: Case, method: Method) -> None:
    coarse, fine = method(case, 2.0), method(case, 0.2)
    assert coarse is not None
    assert fine is not None
    assert 1.0 < case.kg(coarse.decoded) <= 2.0
    assert 0.1 < case.kg(fine.decoded) <= 0.2
    assert coarse.motion_bytes < fine.motion_bytes < case.frames.astype(np.float32).nbytes


def test_all_components_at_a_fine_step_are_the_data(case: Case) -> None:
    data = case.frames.transpose(1, 0, 2).reshape(case.frames.shape[1], -1)
    part = principal(np.arange(len(data)), data)
    np.testing.assert_allclose(rounded(part, 1e-6, 0.0).decoded(1e-6), data, atol=1e-4)


def test_the_step_is_brought_to_the_target() -> None:
    assert to_target(lambda step: 0.3 * step**1.2, 0.01, 0.5) == pytest.approx((0.5 / 0.3) ** (1 / 1.2), rel=0.01)
    # an error that never gets small enough
    assert to_target(lambda _step: 1.0, 1.0, 0.5) == 0

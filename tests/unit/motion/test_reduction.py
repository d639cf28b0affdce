"""Trajectories in fewer directions: what is left out is a small part of what may be lost."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_motion.trajectory.reduction import LOST, Trajectories


@pytest.mark.parametrize(("vertices", "frames"), [(60, 12), (10, 25)])
@pytest.mark.parametrize("allowed", [1e-6, 0.5, 40.0])
def test_what_lies_outside_is_a_small_part_of_what_is_allowed(vertices: int, frames: int, allowed: float) -> None:
    rng = np.random.default_rng(4)
    strengths = np.exp(-np.arange(3.0 * frames) / 4.0)
    full = (rng.normal(size=(vertices, 3 * frames)) * strengths).reshape(vertices, frames, 3)
    found = Trajectories.of(full, allowed)
    flat = full.reshape(vertices, -1)
    assert np.allclose(found.directions @ found.directions.T, np.eye(len(found.directions)), atol=1e-9)
    assert np.allclose(found.points, flat @ found.directions.T, atol=1e-9)
    assert ((flat - found.points @ found.directions) ** 2).sum() <= LOST * allowed
    assert found.size == pytest.approx(np.sqrt((flat**2).sum()))
    # one direction less would not have done
    fewer = found.points[:, :-1] @ found.directions[:-1]
    assert ((flat - fewer) ** 2).sum() > LOST * allowed


def test_vertices_that_do_not_move_need_one_direction() -> None:
    found = Trajectories.of(np.zeros((5, 3, 3)), 1e-12)
    assert found.points.shape == (5, 1)
    assert not found.points.any()
    assert found.size == 0.0

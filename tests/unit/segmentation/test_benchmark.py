"""The peers that segmentation is measured beside do what they are there for, and the tables say what was measured."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.segmentation import page, tables
from benchmarks.segmentation.cache import Cache, digest, digest_arrays
from benchmarks.segmentation.peers import PEERS
from shapery_geometry.mask_metrics import intersection_over_union

pytestmark = pytest.mark.slow

SIDE = 28

LEAST = {"fast_marching": 0.6, "two_gaussians": 0.6}
"""IoU of those that do not end half-way up the border: the one has no end, the other ends where noise does."""


@pytest.fixture(scope="module")
def ball() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A field of 5 in a ball and 0 outside, with noise; the ball; a seed in it."""
    axis = np.arange(SIDE) - (SIDE - 1) / 2
    far = np.sqrt(axis[:, None, None] ** 2 + axis[:, None] ** 2 + axis**2)
    field = 5.0 / (1.0 + np.exp((far - 8.0) / 0.5)) + np.random.default_rng(0).normal(0.0, 0.3, far.shape)
    return field.astype(np.float32), far <= 8.0, far <= 3.0


@pytest.mark.parametrize("name", PEERS)
def test_each_peer_finds_a_ball_at_its_best_setting(ball: tuple[np.ndarray, np.ndarray, np.ndarray], name: str) -> None:
    field, truth, seed = ball
    _, method, settings = PEERS[name]
    allowed = np.ones(field.shape, dtype=bool)
    best = max(intersection_over_union(method(field, seed, allowed, 1.0, s)[0], truth) for s in settings)

    assert best > LEAST.get(name, 0.85)


def rows(*values: float) -> list[dict[str, Any]]:
    return [{"enhancing": {"iou": value}} for value in values]


def test_leave_one_case_out_chooses_on_the_others() -> None:
    by_case = {"a": rows(0.9, 0.1), "b": rows(0.2, 0.8), "c": rows(0.3, 0.7)}
    assert tables.best_setting(by_case, ["a", "b", "c"]) == 1
    # For a the others choose 1; for b and c, whose rest includes a, 0.9 + 0.3 > 0.1 + 0.7 and 0.9 + 0.2 > 0.1 + 0.8.
    assert tables.held_out(by_case, ["a", "b", "c"]) == {"a": 0.1, "b": 0.2, "c": 0.3}


def test_a_measurement_is_made_once(tmp_path: Path) -> None:
    made = []

    def measure() -> dict[str, int]:
        made.append(1)
        return {"n": len(made)}

    cache = Cache(tmp_path)
    assert cache.get("a case", "k1", measure) == {"n": 1}
    assert Cache(tmp_path).get("a case", "k1", measure) == {"n": 1}
    assert cache.get("a case", "k2", measure) == {"n": 2}


def run_of(peers: list[str], cases: list[str], load: float) -> dict[str, Any]:
    by_peer = {peer: {case: rows(0.5) for case in cases} for peer in peers}
    return {
        "measured": {"peers": {"load_at_start": load}},
        "peers": [{"peers": peers, "ours": [{"name": case} for case in cases], "rows": {"plain": by_peer}}],
    }


def test_a_part_measured_again_takes_the_place_of_what_it_covers() -> None:
    before = page.merged({"measured": {"real": 1}, "real": [1], "growth": [2]}, run_of(["a", "b"], ["x"], 1.0))
    assert before["real"] == [1]
    assert before["growth"] == [2]
    assert before["measured"] == {"real": 1, "peers": {"load_at_start": 1.0}}
    # Fewer peers, or other cases, stand beside what was measured before.
    both = page.merged(before, run_of(["a"], ["x", "y"], 2.0))
    assert [run["peers"] for run in both["peers"]] == [["a"], ["a", "b"]]
    again = page.merged(both, run_of(["a", "b", "c"], ["x", "y"], 3.0))
    assert [run["peers"] for run in again["peers"]] == [["a", "b", "c"]]
    assert again["measured"]["peers"] == {"load_at_start": 3.0}


def test_digests_tell_values_and_shapes_apart() -> None:
    assert digest(1, "a") == digest(1, "a") != digest(1, "b")
    zeros = np.zeros((2, 3))
    assert digest_arrays(zeros) != digest_arrays(zeros.T)
    assert digest_arrays(zeros) != digest_arrays(zeros.astype(np.float32))

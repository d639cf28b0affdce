"""Local scales, the gate, re-ranking, and that a row of the matrix is a pure query."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shapery_retrieval.arg import Arg
from shapery_retrieval.describe import Description
from shapery_retrieval.ranking import affinity, contrast, diffuse, gate, local_scale
from shapery_retrieval.search import Searcher, score_matrix


def test_affinity_is_one_at_no_distance_and_free_of_unit() -> None:
    distances = np.array([0.0, 1.0, 3.0])
    found = affinity(distances, 2.0, np.array([1.0, 2.0, 4.0]))
    assert found[0] == 1
    np.testing.assert_allclose(affinity(7 * distances, 14.0, np.array([7.0, 14.0, 28.0])), found)


def test_the_local_scale_is_the_distance_to_the_twelfth() -> None:
    assert local_scale(np.arange(1.0, 40.0)) == 12
    # in a small bank to the middle one, and never zero
    assert local_scale(np.array([1.0, 2.0, 3.0, np.inf])) == 2
    assert local_scale(np.zeros(50)) > 0
    assert local_scale(np.array([])) == 1


def test_the_gate_follows_the_clearer_cue() -> None:
    clear, vague = np.zeros(100), np.full(100, 0.5)
    clear[:10] = 0.9
    weights = gate({"parts": contrast(clear), "intrinsic": contrast(vague)})
    assert weights["parts"] > 0.95
    assert sum(weights.values()) == pytest.approx(1)


def clusters(sizes: list[int], rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Scores of shapes in chains: neighbours in a class are alike, its ends no more than strangers."""
    labels = np.repeat(np.arange(len(sizes)), sizes)
    place = np.concatenate([np.linspace(0, 1, size) for size in sizes])
    same = labels[:, None] == labels[None]
    scores = np.where(same, np.exp(-3 * np.abs(place[:, None] - place[None])), 0.1)
    scores = scores + 0.06 * rng.random(scores.shape)
    np.fill_diagonal(scores, 1.0)
    return np.clip(scores, 0, 1), labels


def first_tier(scores: np.ndarray, labels: np.ndarray) -> float:
    found = []
    for i, row in enumerate(scores):
        order = [j for j in np.argsort(-row, kind="stable") if j != i]
        count = int((labels == labels[i]).sum()) - 1
        found.append(np.mean(labels[order[:count]] == labels[i]))
    return float(np.mean(found))


@pytest.mark.parametrize("size", [5, 20])
def test_similarity_flows_along_chains(size: int) -> None:
    scores, labels = clusters([size] * 8, np.random.default_rng(1))
    flowed = diffuse(scores)
    assert first_tier(flowed, labels) >= first_tier(scores, labels)
    assert first_tier(flowed, labels) > 0.97
    np.testing.assert_allclose(flowed, flowed.T, atol=2e-4)
    np.testing.assert_allclose(np.diag(flowed), 1, atol=1e-9)
    assert flowed.min() >= 0
    assert flowed.max() <= 1 + 1e-9


def test_re_ranking_does_not_depend_on_the_order_of_the_bank() -> None:
    scores, _ = clusters([6, 9, 4], np.random.default_rng(2))
    order = np.random.default_rng(3).permutation(len(scores))
    np.testing.assert_allclose(diffuse(scores[np.ix_(order, order)]), diffuse(scores)[np.ix_(order, order)], atol=1e-9)


def bank(egg: Arg, torus: Arg, count: int) -> list[Arg]:
    """Graphs around two shapes."""
    rng = np.random.default_rng(0)
    result = []
    for i in range(count):
        arg = egg if i % 2 == 0 else torus
        whole = {
            name: values
            if name.startswith("view")
            else (values + 0.02 * rng.normal(size=values.shape)).astype(np.float32)
            for name, values in arg.whole.items()
        }
        levels = tuple(
            replace(level, features=(level.features + 0.05 * rng.normal(size=level.features.shape)).astype(np.float16))
            for level in arg.levels
        )
        result.append(replace(arg, whole={**whole, "wave_words": np.abs(whole["wave_words"])}, levels=levels))
    return result


def test_each_row_is_a_pure_query(described_egg: Description, described_torus: Description) -> None:
    args = bank(described_egg.arg, described_torus.arg, 30)
    scores = score_matrix(args)
    labels = np.arange(30) % 2
    assert first_tier(scores, labels) == 1
    assert ((scores >= 0) & (scores <= 1)).all()
    # the row of a shape is what a search gives in a bank that has never seen it
    others = {f"{i:02d}": arg for i, arg in enumerate(args) if i != 4}
    answer = Searcher(others).search(args[4], limit=29)
    found = {int(hit.shape_id): hit.score for hit in answer.hits}
    np.testing.assert_allclose([found[i] for i in sorted(found)], np.delete(scores[4], 4), atol=1e-3)
    assert sum(answer.cues.values()) == pytest.approx(1)


def test_banks_of_any_size_answer(described_egg: Description, described_torus: Description) -> None:
    for count in (1, 2, 3, 5):
        args = bank(described_egg.arg, described_torus.arg, count)
        scores = score_matrix(args, rerank=True)
        assert scores.shape == (count, count)
        assert np.isfinite(scores).all()
        answer = Searcher({str(i): arg for i, arg in enumerate(args)}).search(described_egg.arg, rerank=True)
        assert len(answer.hits) == count
        assert int(answer.hits[0].shape_id) % 2 == 0
    assert Searcher({}).search(described_egg.arg).hits == ()

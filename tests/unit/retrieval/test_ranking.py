"""Local scales, the gate, re-ranking, and that a row of the matrix is a pure query."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shapery_contracts.retrieval import Candidate
from shapery_retrieval.arg import Arg
from shapery_retrieval.describe import Description
from shapery_retrieval.laid_out import GoneError, Searchers
from shapery_retrieval.packing import joined, pack_levels, part_distances
from shapery_retrieval.ranking import affinity, diffuse, gate, local_scale, local_scales
from shapery_retrieval.search import BLOCK, Searcher, score_matrix
from shapery_retrieval.vector import SEGMENTS, cue_distances, pack, vector_of
from shapery_retrieval.vocabulary import vocabulary


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


@pytest.mark.parametrize("count", [1, 2, 3, 9, 40])
def test_local_scales_of_a_bank_that_lacks_a_shape_are_those_of_the_others(count: int) -> None:
    points = np.random.default_rng(count).normal(size=(count, 3))
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    apart = np.where(np.eye(count, dtype=bool), np.inf, distances)
    np.testing.assert_allclose(local_scales(distances), [local_scale(row) for row in apart])
    without = local_scales(distances, without=np.arange(count))
    for left_out in range(count):
        others = np.delete(np.arange(count), left_out)
        expected = [local_scale(row) for row in apart[np.ix_(others, others)]]
        np.testing.assert_allclose(without[left_out, others], expected)


def test_the_gate_follows_the_clearer_cue() -> None:
    clear, vague = np.zeros(100), np.full(100, 0.5)
    clear[:10] = 0.9
    weights = gate({"parts": clear, "intrinsic": vague})
    assert weights["parts"] > 0.95
    assert sum(weights.values()) == pytest.approx(1)


def test_the_gate_follows_what_cues_agree_on() -> None:
    near, elsewhere = np.zeros(100), np.zeros(100)
    near[:10] = elsewhere[50:60] = 0.9
    same = gate({"parts": near, "intrinsic": near, "views": near})
    assert same["views"] == pytest.approx(0.5)  # as far as they are trusted
    apart = gate({"parts": near, "intrinsic": near, "views": elsewhere})
    assert apart["views"] < 0.1
    assert apart["parts"] == pytest.approx(apart["intrinsic"])


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
    spread = 0.3 * vocabulary().node_spread
    result = []
    for i in range(count):
        arg = egg if i % 2 == 0 else torus
        whole = {
            name: values
            if name.startswith("view")
            else (values + 0.02 * rng.normal(size=values.shape)).astype(np.float32)
            for name, values in arg.whole.items()
        }
        levels = []
        for level in arg.levels:
            features = level.features + spread * rng.normal(size=level.features.shape)
            levels.append(replace(level, features=features.astype(np.float16)))
        result.append(replace(arg, whole={**whole, "wave_words": np.abs(whole["wave_words"])}, levels=tuple(levels)))
    return result


def test_each_row_is_a_pure_query(described_egg: Description, described_torus: Description) -> None:
    args = bank(described_egg.arg, described_torus.arg, 30)
    scores = score_matrix(args)
    labels = np.arange(30) % 2
    assert first_tier(scores, labels) == 1
    assert ((scores >= 0) & (scores <= 1)).all()
    # the row of a shape is what a search gives in a bank that has never seen it
    others = {f"{i:02d}": arg for i, arg in enumerate(args) if i != 4}
    answer = Searcher.of(others).search(args[4], limit=29)
    found = {int(hit.shape_id): hit.score for hit in answer.hits}
    np.testing.assert_allclose([found[i] for i in sorted(found)], np.delete(scores[4], 4), atol=1e-3)
    assert sum(answer.cues.values()) == pytest.approx(1)


def test_banks_of_any_size_answer(described_egg: Description, described_torus: Description) -> None:
    for count in (1, 2, 3, 5):
        args = bank(described_egg.arg, described_torus.arg, count)
        scores = score_matrix(args, rerank=True)
        assert scores.shape == (count, count)
        assert np.isfinite(scores).all()
        answer = Searcher.of({str(i): arg for i, arg in enumerate(args)}).search(described_egg.arg, rerank=True)
        assert len(answer.hits) == count
        assert int(answer.hits[0].shape_id) % 2 == 0
    assert Searcher.of({}).search(described_egg.arg).hits == ()


def test_vectors_come_near_to_what_a_matching_gives(described_egg: Description, described_torus: Description) -> None:
    graphs = pack([described_egg.arg, described_torus.arg])
    for cue in SEGMENTS:
        apart = cue_distances(graphs.vectors, graphs.vectors, cue)
        np.testing.assert_allclose(apart, apart.T, atol=1e-5)
        own = cue_distances(graphs.vectors[1], graphs.vectors, cue)
        np.testing.assert_allclose(own, apart[1], atol=1e-5)
    estimated = cue_distances(graphs.vectors[0], graphs.vectors, "parts")
    matched = part_distances(graphs.levels, 0, graphs.levels, np.arange(2))
    assert estimated[0] < 0.5 * estimated[1]
    # the embedding may take off or add a third
    assert estimated[1] == pytest.approx(matched[1], rel=0.34)


def test_graphs_laid_out_one_by_one_are_those_laid_out_at_once(
    described_egg: Description, described_torus: Description
) -> None:
    args = [described_egg.arg, described_torus.arg, replace(described_egg.arg, levels=described_egg.arg.levels)]
    for together, apart in zip(pack_levels(args), joined([pack_levels([arg]) for arg in args]), strict=True):
        for name, values in vars(together).items():
            np.testing.assert_allclose(getattr(apart, name), values, rtol=1e-6, err_msg=name)


class Bank:
    """A bank that counts what is read of it, and may lose shapes."""

    def __init__(self, args: dict[str, Arg]) -> None:
        self.stored = {name: arg.to_bytes() for name, arg in args.items()}
        self.read = 0

    def args(self, ids: list[str]) -> dict[str, bytes]:
        self.read += len(ids)
        return {name: self.stored[name] for name in ids if name in self.stored}


def candidates(args: dict[str, Arg]) -> list[Candidate]:
    vectors = pack(list(args.values())).vectors
    return [Candidate(name, 0.0, vector.tobytes()) for name, vector in zip(args, vectors, strict=True)]


@pytest.mark.slow
def test_a_fast_search_finds_what_an_exhaustive_one_finds_and_reads_less(
    described_egg: Description, described_torus: Description
) -> None:
    count = 4 * BLOCK
    args = {f"{i:03d}": arg for i, arg in enumerate(bank(described_egg.arg, described_torus.arg, count))}
    stored, searchers = Bank(args), Searchers()
    near = candidates(args)
    fast = searchers.over(stored, near).search(described_egg.arg, limit=10)
    assert fast.compared < count
    assert stored.read == fast.compared
    full = Searcher.of(args).search(described_egg.arg, limit=10, exhaustive=True)
    assert full.compared == count
    assert len({hit.shape_id for hit in fast.hits} & {hit.shape_id for hit in full.hits}) >= 9
    again = searchers.over(stored, near).search(described_egg.arg, limit=10)
    assert [hit.shape_id for hit in again.hits] == [hit.shape_id for hit in fast.hits]
    assert stored.read == fast.compared, "what was read is kept"


def test_shapes_that_vanish_meanwhile_are_told(described_egg: Description, described_torus: Description) -> None:
    args = {f"{i}": arg for i, arg in enumerate(bank(described_egg.arg, described_torus.arg, 6))}
    stored, near = Bank(args), candidates(args)
    del stored.stored["4"]
    with pytest.raises(GoneError) as gone:
        Searchers().over(stored, near).search(described_egg.arg)
    assert gone.value.ids == {"4"}


def test_a_stored_shape_is_known_by_the_id_that_it_has_in_results(described_egg: Description) -> None:
    class Lenient(Bank):
        def args(self, ids: list[str]) -> dict[str, bytes]:
            return super().args([name.lower() for name in ids])

    searchers, bank = Searchers(), Lenient({"ab": described_egg.arg})
    assert searchers.stored(bank, "ab") is not None
    assert searchers.stored(bank, "AB") is None
    assert searchers.stored(bank, "cd") is None


def test_the_vector_is_that_of_the_stored_graph(described_egg: Description) -> None:
    again = Arg.from_bytes(described_egg.arg.to_bytes())
    np.testing.assert_array_equal(vector_of(again), vector_of(described_egg.arg))


def test_a_query_is_ranked_by_itself_and_not_by_what_is_left_out(
    described_egg: Description, described_torus: Description
) -> None:
    args = {f"{i:02d}": arg for i, arg in enumerate(bank(described_egg.arg, described_torus.arg, 30))}
    searcher = Searcher.of(args)
    free = searcher.search(described_egg.arg, limit=30)
    left_out = searcher.search(described_egg.arg, limit=30, exclude="01")
    scores = {hit.shape_id: hit.score for hit in free.hits}
    assert [hit.shape_id for hit in left_out.hits if int(hit.shape_id) % 2 == 0][:5] == [
        hit.shape_id for hit in free.hits if int(hit.shape_id) % 2 == 0
    ][:5]
    assert all(hit.score == pytest.approx(scores[hit.shape_id], abs=0.1) for hit in left_out.hits)
    known = searcher.search(described_egg.arg, limit=30, vector=vector_of(described_egg.arg))
    assert [hit.score for hit in known.hits] == pytest.approx([hit.score for hit in free.hits])

"""Patches of parts are those of the whole, and parts find what they were cut from."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.repair import submesh
from shapery_retrieval.coverage import WORDS, asked_of, coverage_of, covered_by
from shapery_retrieval.describe import Description, describe
from shapery_retrieval.patches import FEATURES, SHARES, Patches, closed_by_caps, nearest_patches, patches_of
from shapery_retrieval.search import Searcher, parts_in, region_of

from .conftest import cylinder, egg, torus


def half(mesh: TriangleMesh) -> TriangleMesh:
    """The half of the surface above a plane."""
    height = mesh.corners.mean(axis=1) @ [0.3, 0.2, 1.0]
    order = np.argsort(height)
    return submesh(mesh, order[np.cumsum(mesh.face_areas[order]) <= 0.5 * mesh.area]).mesh


@pytest.fixture(scope="module")
def described_half() -> Description:
    return describe(half(egg()))


def test_caps_close_what_is_open() -> None:
    mesh = half(torus())
    closed = closed_by_caps(mesh)
    assert len(closed.boundary_edges) == 0
    np.testing.assert_array_equal(closed.vertices[: len(mesh.vertices)], mesh.vertices)
    np.testing.assert_array_equal(closed.faces[: len(mesh.faces)], mesh.faces)
    # two openings of a tube, each closed in its own plane
    assert len(closed.vertices) == len(mesh.vertices) + 2
    whole = torus()
    assert closed_by_caps(whole) is whole


def test_a_graph_holds_its_patches(described_egg: Description) -> None:
    patches = patches_of(described_egg.arg)
    assert patches.features.shape == (len(patches.masses), FEATURES)
    assert patches.masses.sum() == pytest.approx(1, abs=1e-5)
    assert np.isfinite(patches.features).all()
    # every finest part has at least one
    assert set(described_egg.arg.whole["patch_parts"].tolist()) == set(range(described_egg.arg.levels[-1].parts))


def test_nearest_patches_are_those_of_an_exhaustive_search() -> None:
    rng = np.random.default_rng(0)

    def some(count: int) -> Patches:
        return Patches(np.full(count, 1 / count, np.float32), rng.normal(size=(count, FEATURES)).astype(np.float32))

    query, others = some(7), [some(int(rng.integers(1, 9))) for _ in range(230)]
    found = nearest_patches(query, others)
    for j, other in enumerate(others):
        apart = np.linalg.norm(query.features[:, None] - other.features[None], axis=2)
        np.testing.assert_allclose(found[:, j], apart.min(axis=1), rtol=1e-3)


def test_about_the_right_size_makes_a_half_fit_best(described_egg: Description, described_half: Description) -> None:
    whole = patches_of(described_egg.arg)
    fits = {
        share: float(patches.masses @ nearest_patches(patches, [whole])[:, 0])
        for share, patches in zip(SHARES, described_half.hypotheses(), strict=True)
    }
    assert min(fits, key=fits.__getitem__) in (0.5, 0.7)
    assert fits[0.5] < min(fits[1.0], fits[0.35])


def test_a_half_finds_its_whole(
    described_egg: Description, described_torus: Description, described_half: Description
) -> None:
    bank = {"egg": described_egg.arg, "torus": described_torus.arg, "cylinder": describe(cylinder()).arg}
    answer = Searcher.of(bank).search(described_half.arg, partial=True, hypotheses=described_half.hypotheses())
    assert answer.hits[0].shape_id == "egg"
    assert 0 <= answer.hits[-1].score <= answer.hits[0].score <= 1


def test_a_region_keeps_its_patches_alone(described_egg: Description) -> None:
    arg = described_egg.arg
    shares = [np.ones(level.parts) for level in arg.levels]
    for level in range(1, len(shares)):
        shares[level][arg.levels[level].parts // 2 :] = 0.0
    region = region_of(arg, shares)
    kept = set(parts_in(arg, shares)[-1].tolist())
    assert set(region.whole["patch_parts"].tolist()) == kept
    assert len(region.whole["patch_masses"]) == len(region.whole["patch_features"]) < len(arg.whole["patch_masses"])
    assert float(nearest_patches(patches_of(region), [patches_of(arg)]).max()) < 1e-2


def test_what_a_shape_covers_and_a_part_asks_for(
    described_egg: Description, described_torus: Description, described_half: Description
) -> None:
    covered = covered_by([patches_of(described_egg.arg), patches_of(described_torus.arg)])
    # in single precision, whose products are summed in another order for several shapes at once
    np.testing.assert_allclose(covered[0], coverage_of(described_egg.arg), rtol=1e-5)
    assert ((covered[:, :WORDS] >= 0) & (covered[:, :WORDS] <= 1)).all()
    np.testing.assert_allclose(np.square(covered).sum(axis=1), WORDS)
    hypotheses = described_half.hypotheses()
    asked = asked_of(hypotheses)
    assert asked @ asked == pytest.approx(WORDS)
    assert asked[WORDS] == 0
    # so the nearest is what covers most of what is asked for
    apart = np.square(covered - asked).sum(axis=1)
    np.testing.assert_allclose(apart, 2 * WORDS - 2 * covered @ asked)
    assert apart[0] < apart[1], "half an egg is of an egg"
    # 16 bits, in which PostgreSQL keeps vectors, hold what tells shapes apart
    rounded = np.square(covered.astype(np.float16).astype(float) - asked.astype(np.float16)).sum(axis=1)
    assert abs((rounded[1] - rounded[0]) / (apart[1] - apart[0]) - 1) < 0.02
    # what covers everything alike is hardly what is asked for
    plain = asked[:WORDS] - asked.min()
    alike = np.full(WORDS, np.sqrt(np.square(covered[0, :WORDS]).mean()))
    assert 0 < alike @ asked[:WORDS] < 0.4 * alike @ plain
    # every hypothesis has a say
    shares = np.stack([asked_of([one])[:WORDS] for one in hypotheses], axis=1)
    say, rest = np.linalg.lstsq(shares, asked[:WORDS], rcond=None)[:2]
    assert (say > 0.05).all()
    assert rest == pytest.approx(0, abs=1e-9)


def test_of_each_word_the_nearest_patch_counts() -> None:
    rng = np.random.default_rng(3)
    many = Patches(np.full(40, 1 / 40, np.float32), rng.normal(size=(40, FEATURES)).astype(np.float32))
    some = Patches(np.full(15, 1 / 15, np.float32), many.features[:15])
    rest = Patches(np.full(25, 1 / 25, np.float32), many.features[15:])
    whole, first, second = covered_by([many, some, rest])[:, :WORDS]
    np.testing.assert_allclose(whole, np.maximum(first, second), atol=1e-6)

"""Generated heads."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from shapery_geometry.volume_io import read_volume
from shapery_segmentation.phantoms import HeadPhantom, TumorSpec, head_phantom
from shapery_segmentation.phantoms.__main__ import main

COARSE = ((54, 64, 54), (3.0, 3.0, 3.0))


def test_the_same_seed_gives_the_same_head() -> None:
    first, again, other = (head_phantom(np.random.default_rng(s), *COARSE) for s in (1, 1, 2))
    for name in ("pre", "post", "truth"):
        np.testing.assert_array_equal(getattr(first, name).data, getattr(again, name).data)
        assert (getattr(first, name).data != getattr(other, name).data).any()
    assert first.tumors[0].center == again.tumors[0].center


def test_truth_agrees_with_what_was_drawn(head: HeadPhantom) -> None:
    voxel = head.truth.voxel_volume
    (tumor,) = head.tumors
    rim, core = ((head.truth.data == value).sum() * voxel for value in (1, 2))
    # Voxels are counted whole in the labels and by their share in the figures.
    assert rim == pytest.approx(tumor.enhancing_mm3, rel=0.05)
    assert rim + core == pytest.approx(tumor.core_mm3, rel=0.02)
    index = np.argwhere(head.truth.data > 0)
    assert np.linalg.norm(head.truth.to_world(index.mean(axis=0)) - tumor.center) < 10


def test_only_what_enhances_is_brighter_after_contrast(head: HeadPhantom) -> None:
    pre, post, truth = (v.data.astype(float) for v in (head.pre, head.post, head.truth))
    brain = (pre > np.percentile(pre, 70)) & (truth == 0)
    ratio = np.median(post[brain] / pre[brain])
    assert np.median(post[truth == 1] / pre[truth == 1]) > 1.5 * ratio
    assert np.median(post[truth == 2] / pre[truth == 2]) < 1.4 * ratio
    # The two scales are unrelated.
    assert not 0.8 < ratio < 1.25


def test_two_tumors_keep_apart_and_none_is_none() -> None:
    two = head_phantom(np.random.default_rng(8), *COARSE, tumors=[TumorSpec(radius=14), TumorSpec(radius=12)])
    assert len(two.tumors) == 2
    assert np.linalg.norm(np.subtract(two.tumors[0].center, two.tumors[1].center)) > 26
    assert not head_phantom(np.random.default_rng(8), *COARSE, tumors=()).truth.data.any()
    with pytest.raises(ValueError, match="no room"):
        head_phantom(np.random.default_rng(8), *COARSE, tumors=[TumorSpec(radius=60)])


def test_sites_are_where_they_say() -> None:
    midline = head_phantom(np.random.default_rng(9), *COARSE, tumors=[TumorSpec(site="midline", radius=18)])
    x = midline.truth.to_world(np.argwhere(midline.truth.data > 0))[:, 0]
    assert x.min() < -3
    assert x.max() > 3


def test_the_head_is_drawn_in_space_not_in_the_array() -> None:
    """Another order of the axes shows the same head."""
    axes = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    plain = head_phantom(np.random.default_rng(2), *COARSE, noise=0.0, bias=0.0)
    other = head_phantom(np.random.default_rng(2), (64, 54, 54), COARSE[1], axes=axes, noise=0.0, bias=0.0)
    again = other.pre.canonical()[0]
    np.testing.assert_allclose(again.affine, plain.pre.affine, atol=1e-9)
    # Rounding to whole numbers may fall to either side.
    assert np.abs(again.data.astype(int) - plain.pre.data).max() <= 1


def test_thick_slices_average_thin_ones() -> None:
    thin = head_phantom(np.random.default_rng(2), (54, 64, 162), (3.0, 3.0, 1.0), noise=0.0, bias=0.0)
    thick = head_phantom(np.random.default_rng(2), *COARSE, noise=0.0, bias=0.0)
    mean = thin.pre.data.reshape(54, 64, 54, 3).mean(axis=3)
    difference = np.abs(mean - thick.pre.data) / np.percentile(mean, 99)
    assert np.median(difference) < 0.02
    assert np.corrcoef(mean.ravel(), thick.pre.data.ravel())[0, 1] > 0.99


def test_command_line_writes_volumes_and_truth(tmp_path: Path) -> None:
    arguments = ["--seed", "5", "--shape", "54", "64", "54", "--spacing", "3", "3", "3", "--stripped"]
    main([str(tmp_path / "head"), *arguments])
    pre, post, truth = (read_volume(tmp_path / "head" / f"{name}.nii.gz") for name in ("pre", "post", "truth"))
    assert pre.same_grid(post)
    assert pre.same_grid(truth)
    assert (pre.data[0, 0] == 0).all()
    told = json.loads((tmp_path / "head" / "truth.json").read_text())
    assert told["seed"] == 5
    assert told["voxel_counts"] == {"1": int((truth.data == 1).sum()), "2": int((truth.data == 2).sum())}
    assert len(told["tumors"]) == 1

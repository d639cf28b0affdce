"""Any object that a seed or a box points at: phantoms of both polarities, real CT, and refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.mask_metrics import intersection_over_union
from shapery_geometry.volume import Volume
from shapery_segmentation import segment
from shapery_segmentation._flood_kernels import grow
from shapery_segmentation.modes import choose_mode, looks_like_head
from shapery_segmentation.phantoms import HeadPhantom
from shapery_segmentation.phantoms.blob import BlobPhantom, blob_phantom

pytestmark = pytest.mark.slow

GRIDS = {"cubes": None, "slices of 2 mm": np.diag([1.0, 1.0, 2.0, 1.0])}


def blob(**options: object) -> BlobPhantom:
    return blob_phantom(np.random.default_rng(1), **options)  # type: ignore[arg-type]


def test_a_region_grows_by_the_cheapest_path_and_its_links_are_told() -> None:
    values = np.full((3, 4, 5), 40.0, dtype=np.float32)
    values[1, 1] = (0.0, 1.0, 30.0, 2.0, 0.0)
    values[1, 0] = (40.0, 3.0, 3.0, 3.0, 40.0)
    order, held = np.empty(60, dtype=np.int64), np.empty(60)
    assert grow(values, np.array([1, 1, 0]), 0.0, 1.0, 0.5, 2.0, 60, order, held) == 60
    # Around the 30 through the row of 3, one after the other.
    places = [tuple(int(i) for i in np.unravel_index(at, values.shape)) for at in order[:7]]
    assert places == [(1, 1, 0), (1, 1, 1), (1, 0, 1), (1, 0, 2), (1, 0, 3), (1, 1, 3), (1, 1, 4)]
    assert sorted(order.tolist()) == list(range(60))
    inside = np.zeros(values.shape, dtype=np.bool_)
    for at, told in zip(order, held, strict=True):
        inside.ravel()[at] = True
        expected = 0.0
        for axis in range(3):
            first = tuple(slice(None, -1) if a == axis else slice(None) for a in range(3))
            second = tuple(slice(1, None) if a == axis else slice(None) for a in range(3))
            links = np.exp(-np.abs(values[first] - values[second]) / 2.0)
            expected += float(links[inside[first] != inside[second]].sum())
        assert told == pytest.approx(expected, abs=1e-4)
    assert grow(values, np.array([1, 1, 0]), 0.0, 1.0, 0.5, 2.0, 9, order, held) == 9


@pytest.mark.parametrize("polarity", ["bright", "dark"])
@pytest.mark.parametrize("bias", [0.0, 0.4])
def test_a_blob_at_snr_10(polarity: str, bias: float) -> None:
    phantom = blob(polarity=polarity, bias=bias, snr=10.0)
    result = segment(phantom.volume, params=SegmentationParams(seeds=[list(phantom.center)]))
    (item,) = result.report.objects
    assert result.report.mode == "object"
    assert item.polarity == polarity
    assert item.closed
    assert item.genus == 0
    assert item.self_intersections == 0
    assert intersection_over_union(result.labels.data == 1, phantom.truth.data) >= (0.96 if bias else 0.97)
    if item.volume_mm3 < item.seed_volume_mm3:
        assert any("of its seed" in note for note in item.notes)


def test_a_box_instead_of_a_seed_in_thick_slices() -> None:
    phantom = blob(shape=(64, 64, 32), affine=np.diag([1.0, 1.0, 2.0, 1.0]))
    inside = phantom.truth.to_world(np.argwhere(phantom.truth.data))
    box = [*(inside.min(axis=0) - 4), *(inside.max(axis=0) + 4)]
    result = segment(phantom.volume, params=SegmentationParams(box=box))
    assert intersection_over_union(result.labels.data == 1, phantom.truth.data) >= 0.96


def test_the_noise_of_an_object_is_no_border() -> None:
    """A ball with a sharp border and hardly any noise: the ring around what is found first still holds some of it."""
    at = np.moveaxis(np.indices((48, 56, 40)), 0, -1)
    truth = np.linalg.norm(at - (20.0, 34.0, 18.0), axis=-1) < 9.0
    values = 300 + 600 * truth + np.random.default_rng(4).normal(0, 12, truth.shape)
    result = segment(Volume(values.astype(np.float32), np.eye(4)), params=SegmentationParams(seeds=[[20, 34, 18]]))
    (item,) = result.report.objects
    assert item.polarity == "bright"
    assert intersection_over_union(result.labels.data == 1, truth) >= 0.97


@pytest.mark.parametrize(("blur", "least"), [(0.6, 0.98), (1.5, 0.93)])
def test_the_blur_of_a_scanner_moves_no_border(blur: float, least: float) -> None:
    at = np.moveaxis(np.indices((48, 48, 48)), 0, -1) - 23.5
    inside = np.linalg.norm(at, axis=-1) < 14.0
    noise = np.random.default_rng(5).normal(0.0, 0.06, inside.shape)
    values = ndimage.gaussian_filter(np.where(inside, 1.0, 2.0), blur) + noise
    result = segment(Volume(values.astype(np.float32), np.eye(4)), params=SegmentationParams(seeds=[[23.5] * 3]))
    assert intersection_over_union(result.labels.data == 1, inside) >= least


def test_nothing_leaves_the_box() -> None:
    """A bar that goes on, as bright as before, beyond the box that is drawn around a part of it."""
    values = np.random.default_rng(4).normal(0, 10, (64, 40, 40))
    values[8:56, 12:28, 12:28] += 100.0
    result = segment(Volume(values.astype(np.float32), np.eye(4)), params=SegmentationParams(box=[4, 8, 8, 30, 31, 31]))
    found = np.argwhere(result.labels.data == 1)
    np.testing.assert_allclose(found.min(axis=0), (8, 12, 12), atol=1)
    np.testing.assert_allclose(found.max(axis=0), (30, 27, 27), atol=1)


@pytest.mark.parametrize("radius", [9.0, 11.0])
def test_an_object_in_a_box_that_no_two_values_tell_from_its_surroundings(radius: float) -> None:
    """A dark core in a bright rim, and around both what lies half-way between them."""
    at = np.moveaxis(np.indices((56, 56, 56)), 0, -1) - 28.0
    truth, core = np.linalg.norm(at, axis=-1) < 14.0, np.linalg.norm(at - np.array((-2.0, 0.0, 0.0)), axis=-1) < radius
    noise = np.random.default_rng(6).normal(0.0, 8.0, truth.shape)
    values = np.where(core, 0.0, np.where(truth, 100.0, 50.0)) + noise
    result = segment(Volume(values.astype(np.float32), np.eye(4)), params=SegmentationParams(box=[12] * 3 + [44] * 3))
    (item,) = result.report.objects
    assert item.self_intersections == 0
    assert item.closed
    assert intersection_over_union(result.labels.data == 1, truth) >= 0.88


def test_a_head_is_told_from_other_things(head: HeadPhantom, tilted_head: HeadPhantom) -> None:
    assert looks_like_head(head.post)
    assert looks_like_head(tilted_head.post)
    phantom = blob()
    assert not looks_like_head(phantom.volume)
    seeded = SegmentationParams(seeds=[[0.0, 0.0, 0.0]])
    assert choose_mode(head.post, seeded) == "tumor"
    assert choose_mode(phantom.volume, seeded) == "object"
    assert choose_mode(phantom.volume, SegmentationParams()) == "tumor"
    assert choose_mode(head.post, SegmentationParams(box=[0, 0, 0, 9, 9, 9])) == "object"


def refusal(volume: Volume, **params: object) -> InvalidInput:
    with pytest.raises(InvalidInput) as caught:
        segment(volume, params=SegmentationParams(**params))  # type: ignore[arg-type]
    assert caught.value.message
    return caught.value


def test_what_is_not_there_is_refused() -> None:
    noise = Volume(np.random.default_rng(2).normal(size=(40, 40, 40)).astype(np.float32), np.eye(4))
    assert refusal(noise, mode="object", seeds=[[20, 20, 20]]).code == "no_object_found"
    phantom = blob()
    assert refusal(phantom.volume, mode="object").code == "invalid_params"
    assert refusal(phantom.volume, seeds=[[500, 0, 0]]).code == "invalid_params"
    assert refusal(phantom.volume, box=[10, 10, 10, 10, 30, 30]).code == "invalid_params"
    assert refusal(phantom.volume, box=[500, 10, 10, 520, 30, 30]).code == "invalid_params"


def test_one_seed_of_two_that_leads_nowhere_is_told() -> None:
    phantom = blob(shape=(96, 48, 48), radius=10.0)
    two = phantom.volume.data.copy()
    params = SegmentationParams(mode="object", seeds=[list(phantom.center), [1.0, 1.0, 1.0]])
    result = segment(phantom.volume.with_data(two), params=params)
    assert result.report.objects
    assert len(result.surfaces) == len(result.report.objects)


@pytest.mark.data
def test_the_aorta_in_ct(shared_data: Path) -> None:
    from scipy import ndimage

    from shapery_geometry.volume_io import read_volume

    folder = shared_data / "volumes/vessel_aorta_ct_vmtk"
    volume, reference = read_volume(folder / "aorta.mha"), read_volume(folder / "reference_levelset.mha").data < 0
    depth = ndimage.distance_transform_edt(reference)
    seed = volume.to_world(np.unravel_index(int(depth.argmax()), depth.shape))
    result = segment(volume, params=SegmentationParams(seeds=[seed.tolist()]))
    assert result.report.mode == "object"
    (item,) = result.report.objects
    assert item.self_intersections == 0
    # The reference covers one segment only; the surface goes on into the rest of the tree.
    assert (result.labels.data[reference] == 1).mean() > 0.85

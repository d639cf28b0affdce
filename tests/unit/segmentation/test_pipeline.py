"""From two volumes to labels, surfaces and report."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapery_contracts.errors import InvalidInput, JobCancelled
from shapery_contracts.segmentation import SegmentationParams, SegmentationResult
from shapery_geometry.mask_metrics import intersection_over_union
from shapery_geometry.mesh_io import read_mesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume
from shapery_segmentation import Segmentation, segment, write_outputs
from shapery_segmentation.objects import elongation, spread
from shapery_segmentation.phantoms import HeadPhantom, TumorSpec, head_phantom
from shapery_segmentation.registration import rigid

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def result(head: HeadPhantom) -> Segmentation:
    return segment(head.post, head.pre)


def overlaps(result: Segmentation, head: HeadPhantom) -> tuple[float, float]:
    labels, truth = result.labels.data, head.truth.data
    return intersection_over_union(labels == 1, truth == 1), intersection_over_union(labels > 0, truth > 0)


def test_the_tumor_of_a_head_is_found(result: Segmentation, head: HeadPhantom) -> None:
    rim, core = overlaps(result, head)
    # The rim is 4.5 mm thick: half a voxel at either side is already a quarter of it.
    assert rim > 0.7
    assert core > 0.8
    assert len(result.report.objects) == 1
    assert result.labels.same_grid(head.post)
    assert result.labels.data.dtype == np.uint8


def test_the_report_tells_the_truth_about_the_surface(result: Segmentation, head: HeadPhantom) -> None:
    (item,), (surface,) = result.report.objects, result.surfaces
    assert item.closed
    assert item.genus == surface.genus
    assert item.self_intersections == 0
    assert item.volume_mm3 == pytest.approx(surface.volume)
    assert item.area_mm2 == pytest.approx(surface.area)
    assert (item.vertices, item.faces) == (len(surface.vertices), len(surface.faces))
    assert item.seeded_by == "automatic"
    assert 0.5 <= item.confidence <= 1
    counts = np.bincount(result.labels.data.ravel(), minlength=5)
    assert result.report.voxel_counts == {str(v): int(counts[v]) for v in (1, 2, 3, 4)}
    voxel = head.post.voxel_volume
    assert item.core_volume_mm3 == pytest.approx((counts[1] + counts[2]) * voxel)
    assert [stage.name for stage in result.report.stages] == ["register", "calibrate", "seed", "evolve", "label"]
    assert result.report.versions["shapery-segmentation"]
    # Labels follow the surface: they differ by closed seams, and by flecks inside that do not enhance.
    inside = rasterize(surface, head.post)
    assert (result.labels.data[inside] > 0).all()
    assert (result.labels.data[inside] == 1).mean() > 0.95
    assert np.count_nonzero((result.labels.data == 1) & ~inside) < 0.1 * counts[1]
    # The seed lies inside the object.
    seed = tuple(np.round(head.post.to_index(item.seed)).astype(int))
    assert result.labels.data[seed] == 1


def test_a_healthy_head_is_no_error(healthy_head: HeadPhantom) -> None:
    result = segment(healthy_head.post, healthy_head.pre)
    assert result.report.objects == []
    assert result.surfaces == ()
    assert not result.labels.data.any()
    assert any("Nothing was found" in warning for warning in result.report.warnings)


def test_a_tilted_stripped_brain(tilted_head: HeadPhantom) -> None:
    rim, core = overlaps(segment(tilted_head.post, tilted_head.pre), tilted_head)
    assert rim > 0.7
    assert core > 0.75


def stored(volume: Volume, axes: tuple[int, ...], flips: tuple[bool, ...]) -> Volume:
    matrix = np.eye(4)
    matrix[:3, 3] = volume.affine[:3, 3]
    for k, (axis, flip) in enumerate(zip(axes, flips, strict=True)):
        column = volume.affine[:3, axis]
        matrix[:3, k] = -column if flip else column
        if flip:
            matrix[:3, 3] += column * (volume.shape[axis] - 1)
    data = volume.data.transpose(axes)[tuple(slice(None, None, -1 if f else 1) for f in flips)]
    return Volume(np.ascontiguousarray(data), matrix)


ORDERS, FLIPS = list(itertools.permutations(range(3))), list(itertools.product((False, True), repeat=3))


@pytest.mark.parametrize(("axes", "flips"), [((1, 2, 0), (True, False, True)), ((2, 1, 0), (False, True, True))])
def test_the_order_of_the_axes_changes_nothing(
    head: HeadPhantom, result: Segmentation, axes: tuple[int, ...], flips: tuple[bool, ...]
) -> None:
    check_orientation(head, result, axes, flips)


@pytest.mark.slow
@pytest.mark.parametrize(("axes", "flips"), list(zip(ORDERS, FLIPS[1:7], strict=True)))
def test_no_order_of_the_axes_changes_anything(
    head: HeadPhantom, result: Segmentation, axes: tuple[int, ...], flips: tuple[bool, ...]
) -> None:
    check_orientation(head, result, axes, flips)


def test_all_48_orders_of_the_axes_are_read_as_one(head: HeadPhantom) -> None:
    for axes, flips in itertools.product(ORDERS, FLIPS):
        volume, _ = stored(head.post, axes, flips).canonical()
        np.testing.assert_array_equal(volume.data, head.post.canonical()[0].data)
        np.testing.assert_allclose(volume.affine, head.post.canonical()[0].affine, atol=1e-9)


def check_orientation(head: HeadPhantom, result: Segmentation, axes: tuple[int, ...], flips: tuple[bool, ...]) -> None:
    post, pre = stored(head.post, axes, flips), stored(head.pre, axes, flips)
    other = segment(post, pre)
    assert other.labels.same_grid(post)
    np.testing.assert_array_equal(other.labels.canonical()[0].data, result.labels.canonical()[0].data)
    np.testing.assert_allclose(other.surfaces[0].vertices, result.surfaces[0].vertices, atol=1e-6)


def test_anisotropic_oblique_volumes() -> None:
    angle = np.deg2rad(12)
    axes = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    phantom = head_phantom(
        np.random.default_rng(6),
        (160, 192, 54),
        (1.0, 1.0, 3.0),
        axes=axes[:, [1, 2, 0]][:, [2, 0, 1]],
        tumors=[TumorSpec(radius=15.0, rim=6.0)],
    )
    result = segment(phantom.post, phantom.pre)
    assert result.labels.same_grid(phantom.post)
    rim, core = overlaps(result, phantom)
    assert rim > 0.6
    assert core > 0.7


def test_the_same_input_gives_the_same_bytes(head: HeadPhantom, result: Segmentation, tmp_path: Path) -> None:
    again = segment(head.post, head.pre)
    np.testing.assert_array_equal(again.labels.data, result.labels.data)
    assert again.surfaces[0].same_as(result.surfaces[0])
    for name, one in (("a", result), ("b", again)):
        write_outputs(one, tmp_path / name)
    for name in ("labels.nii.gz", "surface.ply", "scene.glb", "surfaces/1.ply", "evolution.bin"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_outputs_are_read_back(head: HeadPhantom, result: Segmentation, tmp_path: Path) -> None:
    write_outputs(result, tmp_path / "out")
    names = {str(p.relative_to(tmp_path / "out")) for p in (tmp_path / "out").rglob("*") if p.is_file()}
    assert names == {
        "labels.nii.gz", "surface.ply", "surfaces/1.ply", "scene.glb", "evolution.bin", "report.json",
    }  # fmt: skip
    labels = read_volume(tmp_path / "out" / "labels.nii.gz")
    assert labels.same_grid(head.post)
    np.testing.assert_array_equal(labels.data, result.labels.data)
    surface = read_mesh(tmp_path / "out" / "surface.ply")
    assert surface.same_as(result.surfaces[0])
    told = json.loads((tmp_path / "out" / "report.json").read_text())
    assert SegmentationResult.model_validate(told) == result.report


def test_nothing_found_still_writes_every_file(healthy_head: HeadPhantom, tmp_path: Path) -> None:
    labels = healthy_head.post.with_data(np.zeros(healthy_head.post.shape, np.uint8))
    report = SegmentationResult(
        objects=[], voxel_counts={}, voxel_volume_mm3=1.0, stages=[], versions={}, warnings=["nothing"]
    )
    write_outputs(Segmentation(labels, (), report), tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {
        "labels.nii.gz",
        "surface.ply",
        "surfaces",
        "scene.glb",
        "report.json",
    }


def test_a_user_seed_starts_there_and_says_so(head: HeadPhantom, result: Segmentation) -> None:
    params = SegmentationParams(seeds=[list(head.tumors[0].center), list(head.tumors[0].center)])
    seeded = segment(head.post, head.pre, params=params)
    # Both seeds lead to one object.
    (item,) = seeded.report.objects
    assert item.seeded_by == "user"
    assert intersection_over_union(seeded.labels.data == 1, result.labels.data == 1) > 0.9


def test_after_contrast_alone_says_that_it_is_less_sure(tilted_head: HeadPhantom) -> None:
    params = SegmentationParams(seeds=[list(tilted_head.tumors[0].center)])
    seeded = segment(tilted_head.post, params=params)
    assert overlaps(seeded, tilted_head)[1] > 0.6
    automatic = segment(tilted_head.post)
    assert any("Without a volume before contrast" in warning for warning in automatic.report.warnings)
    assert all(item.confidence <= 0.75 for item in automatic.report.objects)


def test_another_grid_of_the_same_frame_is_resampled(head: HeadPhantom) -> None:
    pre = head.pre
    moved = Volume(np.ascontiguousarray(pre.data[4:-4, 6:-6, 2:-2]), pre.affine.copy())
    affine = pre.affine.copy()
    affine[:3, 3] = pre.to_world((4, 6, 2))
    result = segment(head.post, Volume(moved.data, affine))
    assert any("resampled" in warning for warning in result.report.warnings)
    assert overlaps(result, head)[1] > 0.8


def test_a_volume_that_lies_elsewhere_is_moved_unless_that_is_forbidden(
    head: HeadPhantom, result: Segmentation
) -> None:
    away = Volume(head.pre.data, rigid((3.0, -5.0, 8.0), (400.0, 20.0, -10.0), (0.0, 0.0, 0.0)) @ head.pre.affine)
    moved = segment(head.post, away)
    (alignment,) = moved.report.alignments
    assert alignment.moved
    assert any("was moved by" in warning for warning in moved.report.warnings)
    assert intersection_over_union(moved.labels.data == 1, result.labels.data == 1) > 0.9
    assert not result.report.alignments[0].moved
    with pytest.raises(InvalidInput) as caught:
        segment(head.post, away, params=SegmentationParams(register_volumes=False))
    assert caught.value.code == "grid_mismatch"


def test_cancelling_passes_through_from_every_stage(head: HeadPhantom) -> None:
    calls = 0

    def count() -> None:
        nonlocal calls
        calls += 1

    stages: list[tuple[str, float]] = []
    segment(head.post, head.pre, check_cancelled=count, on_progress=lambda s, f, _: stages.append((s, f)))
    assert calls > 20
    fractions = [fraction for _, fraction in stages]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    assert list(dict.fromkeys(stage for stage, _ in stages)) == ["register", "calibrate", "seed", "evolve", "label"]
    for last in (1, calls // 3, calls - 1):
        left = last

        def stop() -> None:
            nonlocal left
            left -= 1
            if left == 0:
                raise JobCancelled

        with pytest.raises(JobCancelled):
            segment(head.post, head.pre, check_cancelled=stop)


def test_spread_tells_balls_from_trees() -> None:
    index = np.stack(np.meshgrid(*(np.arange(41),) * 3, indexing="ij"), axis=-1) - 20
    assert spread(np.linalg.norm(index, axis=-1) <= 15) == pytest.approx(np.sqrt(3 / 5), rel=0.01)
    assert spread(np.hypot(index[..., 0], index[..., 1]) <= 2) > 1.7
    assert 0 < spread(index.any(axis=-1) == 0) < 1.0


def test_elongation_is_that_of_an_ellipsoid_however_it_lies() -> None:
    index = np.stack(np.meshgrid(*(np.arange(61),) * 3, indexing="ij"), axis=-1) - 30.0
    turned = index @ Rotation.from_euler("xyz", (20, -35, 50), degrees=True).as_matrix()
    for axes, expected in (((12, 12, 12), 1.0), ((24, 12, 8), 3.0), ((28, 6, 6), 28 / 6)):
        assert elongation(((turned / np.array(axes)) ** 2).sum(axis=-1) <= 1) == pytest.approx(expected, rel=0.04)
    assert elongation(np.ones((1, 1, 1), dtype=np.bool_)) == pytest.approx(1.0)


@pytest.mark.parametrize("seed", [7, 1011, 1030])
def test_a_wide_dural_sinus_is_no_tumor(seed: int) -> None:
    shape, spacing = {
        7: ((100, 120, 100), (1.6, 1.6, 1.6)),
        1011: ((128, 154, 128), (1.25, 1.25, 1.25)),
        1030: ((160, 192, 54), (1.0, 1.0, 3.0)),
    }[seed]
    spec = TumorSpec(radius=8.0, rim=9.0) if seed == 1011 else TumorSpec()
    phantom = head_phantom(np.random.default_rng(seed), shape, spacing, tumors=[spec])
    found = segment(phantom.post, phantom.pre)
    assert len(found.report.objects) == 1
    assert overlaps(found, phantom)[1] > 0.85


@pytest.mark.parametrize("seed", [1008, 1009, 1023])
def test_a_tumor_across_the_middle_is_found(seed: int) -> None:
    spec = TumorSpec(site="midline", radius=14.0)
    phantom = head_phantom(
        np.random.default_rng(seed), (126, 150, 126), (1.25, 1.25, 1.25), tumors=[spec], rotation=(0, 5, 9)
    )
    found = segment(phantom.post, phantom.pre)
    assert len(found.report.objects) == 1
    assert overlaps(found, phantom)[1] > 0.9


def test_a_rim_that_is_thin_on_one_side_is_found_all_around() -> None:
    # On the side of the ventricle this tumor's rim is one voxel wide.
    phantom = head_phantom(np.random.default_rng(101))
    found = segment(phantom.post, phantom.pre)
    assert len(found.surfaces) == 1
    core = np.isin(found.labels.data, (1, 2))
    assert intersection_over_union(core, np.isin(phantom.truth.data, (1, 2))) > 0.93
    assert intersection_over_union(found.labels.data == 1, phantom.truth.data == 1) > 0.87

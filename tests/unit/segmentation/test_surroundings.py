"""One call, one scene: an object, the vessels around it and the bleedings beside them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.mask_metrics import dice
from shapery_geometry.mesh_io import read_mesh
from shapery_geometry.volume import Volume
from shapery_segmentation import Segmentation, segment, write_outputs
from shapery_segmentation.phantoms import VesselPhantom, vessel_tree_phantom

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def phantom() -> VesselPhantom:
    """Dark vessels, as in SWI, around a tumor, with bleedings."""
    return vessel_tree_phantom(
        np.random.default_rng(5), (80, 80, 80), polarity="dark", tumor_radius=9.0, microhemorrhages=3, snr=12.0
    )


@pytest.fixture(scope="module")
def scene(phantom: VesselPhantom) -> Segmentation:
    """The tumor is seen after contrast, where vessels and bleedings are not."""
    tumor = phantom.truth.data == 1
    noise = np.random.default_rng(6).normal(0.0, 0.05, tumor.shape)
    post = Volume((1.0 + tumor + noise).astype(np.float32), phantom.truth.affine)
    seed = phantom.truth.to_world(np.argwhere(tumor).mean(axis=0))
    params = SegmentationParams(mode="object", seeds=[seed.tolist()], register_volumes=False)
    return segment(post, vessels=phantom.volume, params=params)


def test_tumor_vessels_and_bleedings_are_labelled(phantom: VesselPhantom, scene: Segmentation) -> None:
    labels, truth = scene.labels.data, phantom.truth.data
    assert dice(labels == 1, truth == 1) > 0.95
    assert dice(labels == 3, truth == 3) > 0.85
    assert dice(labels == 4, truth == 4) > 0.8
    assert scene.report.voxel_counts == {str(v): int(np.count_nonzero(labels == v)) for v in (1, 2, 3, 4)}


def test_the_report_measures_them(phantom: VesselPhantom, scene: Segmentation) -> None:
    report = scene.report
    assert report.vessel_polarity == "dark"
    assert [stage.name for stage in report.stages] == ["register", "evolve", "vessels", "label"]
    drawn = sum(float(np.linalg.norm(np.diff(b.points, axis=0), axis=1).sum()) for b in phantom.branches)
    assert sum(item.length_mm for item in report.vessels) == pytest.approx(drawn, rel=0.25)
    for item, surface in zip(report.vessels, scene.vessel_surfaces, strict=True):
        assert item.closed
        assert item.self_intersections == 0
        assert 0 < item.least_radius_mm <= item.mean_radius_mm <= item.largest_radius_mm
        assert item.volume_mm3 == pytest.approx(surface.volume, rel=1e-6)
    volumes = [item.volume_mm3 for item in report.microhemorrhages]
    assert volumes == sorted(volumes, reverse=True)
    assert 1 <= len(volumes) <= 4


def test_every_structure_has_its_file_and_its_node(scene: Segmentation, tmp_path: Path) -> None:
    write_outputs(scene, tmp_path)
    names = {path.name for path in (tmp_path / "surfaces").iterdir()}
    vessels = {f"vessel-{item.label}.ply" for item in scene.report.vessels}
    assert names == {"1.ply", "microhemorrhages.ply"} | vessels
    bleeding = read_mesh(tmp_path / "surfaces" / "microhemorrhages.ply")
    assert bleeding.closed
    scene_bytes = (tmp_path / "scene.glb").read_bytes()
    for node in ("object 1", "vessel 1", "microhemorrhages"):
        assert node.encode() in scene_bytes


def test_bleedings_can_be_left_out(phantom: VesselPhantom, scene: Segmentation) -> None:
    assert scene.bleeding_surface is not None
    params = SegmentationParams(
        mode="object", seeds=[scene.report.objects[0].seed], register_volumes=False, microhemorrhages="off"
    )
    post = phantom.truth.with_data((phantom.truth.data == 1).astype(np.float32))
    other = segment(post, vessels=phantom.volume, params=params)
    assert other.report.microhemorrhages == []
    assert not (other.labels.data == 4).any()

"""``python -m shapery_segmentation.warm``: compile every kernel of the service once, so that the first job is fast.

numba keeps what it compiled beside the sources (or in ``NUMBA_CACHE_DIR``); later processes load it.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.segmentation import SegmentationParams


def warm() -> None:
    """Run the whole service on a small head: all its kernels, readers and writers."""
    from shapery_geometry.volume import Volume
    from shapery_geometry.volume_io import read_volume
    from shapery_segmentation.phantoms import TumorSpec, head_phantom
    from shapery_segmentation.phantoms.__main__ import write_phantom
    from shapery_segmentation.pipeline import segment
    from shapery_segmentation.report import write_outputs

    _warm_vessels()
    _warm_general()
    _warm_repairs()
    spacing = 3.0
    phantom = head_phantom(
        np.random.default_rng(1), (54, 64, 54), (spacing,) * 3, tumors=[TumorSpec(radius=18.0, rim=7.0)], noise=0.01
    )
    with tempfile.TemporaryDirectory() as folder:
        write_phantom(phantom, Path(folder))
        post, pre = (read_volume(Path(folder) / name) for name in ("post.nii.gz", "pre.nii.gz"))
        # A seed in the middle of the tumor, so that something evolves whatever the search thinks of this coarse head.
        params = SegmentationParams(seeds=[list(phantom.tumors[0].center)])
        write_outputs(segment(post, pre, params=params), Path(folder) / "resampled")
        # Voxels of the working spacing take another path than resampled ones, and so do other types of voxels.
        fine = Volume(np.repeat(np.repeat(np.repeat(post.data, 3, 0), 3, 1), 3, 2), _thirds(post.affine))
        before = Volume(np.repeat(np.repeat(np.repeat(pre.data, 3, 0), 3, 1), 3, 2), fine.affine)
        segment(Volume(fine.data.astype(np.float32), fine.affine), before, params=params)


def _warm_vessels() -> None:
    """Run vessels and bleedings on a small tube."""
    from shapery_segmentation.microhemorrhage import find_microhemorrhages
    from shapery_segmentation.phantoms.vessels import tube_phantom
    from shapery_segmentation.vessels import segment_vessels

    volume = tube_phantom(np.random.default_rng(1), (36, 36, 36), radius=2.5).volume
    find_microhemorrhages(volume, vessels=segment_vessels(volume).mask, polarity="bright")


def _warm_general() -> None:
    """Recover a blob at a seed."""
    from shapery_segmentation.phantoms.blob import blob_phantom
    from shapery_segmentation.pipeline import segment

    phantom = blob_phantom(np.random.default_rng(1))
    segment(phantom.volume, params=SegmentationParams(mode="object", seeds=[phantom.center.tolist()]))


def _warm_repairs() -> None:
    """Do what few surfaces need: mend contacts, cut faces into four, release what cannot rest, follow a threshold."""
    from shapery_geometry.mesh import TriangleMesh, icosphere
    from shapery_segmentation.flow.normal import NormalFlowParams, normal_flow
    from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh

    ball = icosphere((8.0, 8.0, 8.0), 5.0, 2)
    both = np.concatenate((ball.faces, ball.faces + len(ball.vertices)))
    DynamicMesh(TriangleMesh(np.concatenate((ball.vertices, ball.vertices + 1.0)), both), 2.0, test=False).mend(1)
    mesh = DynamicMesh(ball, 2.0)
    mesh.subdivide()
    mesh.contacts()
    at = np.moveaxis(np.indices((16, 16, 16)), 0, -1)
    field = (5.0 - np.linalg.norm(at - 8.0, axis=-1)).astype(np.float32)
    params = NormalFlowParams(threshold_interval=2, release_interval=2, max_iterations=12, interpolation_share=0.0)
    normal_flow(field, None, np.eye(4), ball, params, threshold=-2.0)


def _thirds(affine: NDArray[np.float64]) -> NDArray[np.float64]:
    fine = affine.copy()
    fine[:3, :3] /= 3.0
    fine[:3, 3] += affine[:3, :3] @ np.full(3, -1.0 / 3.0)
    return fine


if __name__ == "__main__":
    warm()

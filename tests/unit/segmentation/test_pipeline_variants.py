"""Real heads as other scanners would have taken them: the tumor is found all the same."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from shapery_geometry.mask_metrics import intersection_over_union
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume
from shapery_segmentation import segment

pytestmark = [pytest.mark.data, pytest.mark.slow]

Scanner = Callable[[Volume], Volume]


def thick_slices(volume: Volume) -> Volume:
    """Means of three slices each."""
    count = volume.shape[2] // 3 * 3
    data = volume.data[..., :count].reshape(*volume.shape[:2], -1, 3).astype(np.float32).mean(axis=3)
    affine = volume.affine.copy()
    affine[:3, 3] += affine[:3, 2]
    affine[:3, 2] *= 3
    return Volume(data, affine)


def blurred(volume: Volume) -> Volume:
    """A resolution of 2.5 mm in voxels of 1 mm."""
    return volume.with_data(ndimage.gaussian_filter(volume.data.astype(np.float32), 1.0))


def other_contrast(volume: Volume) -> Volume:
    """Intensities that grow faster than in proportion."""
    data = np.maximum(volume.data, 0).astype(np.float32)
    return volume.with_data(data.max() * (data / data.max()) ** np.float32(1.4))


def coil(weights: tuple[float, float, float]) -> Scanner:
    """Brightness that changes by a factor of 1.6 to 1.8 through the head."""

    def scan(volume: Volume) -> Volume:
        x, y, z = np.meshgrid(
            *(np.linspace(-1, 1, n, dtype=np.float32) for n in volume.shape), indexing="ij", sparse=True
        )
        light: NDArray[np.float32] = np.exp(0.3 * (weights[0] * x + weights[1] * y + weights[2] * z * z))
        return volume.with_data((volume.data * light).astype(np.float32))

    return scan


def unchanged(volume: Volume) -> Volume:
    return volume


@pytest.mark.parametrize(
    ("post_scanner", "pre_scanner", "least"),
    [
        (thick_slices, thick_slices, 0.80),
        (blurred, blurred, 0.78),
        (other_contrast, unchanged, 0.80),
        (coil((0.5, 0.4, -0.3)), coil((-0.3, 0.4, -0.3)), 0.76),
    ],
    ids=["slices of 3 mm", "blurred", "other contrast", "coils that differ"],
)
def test_a_tumor_near_a_sinus_is_kept_apart_from_it(
    shared_data: Path, post_scanner: Scanner, pre_scanner: Scanner, least: float
) -> None:
    # Here the sinus and the meninges are as bright as the tumor, and a step away from it.
    folder = shared_data / "volumes" / "tumor_brats21_00006"
    pre, post, labels = (read_volume(folder / f"{name}.nii.gz") for name in ("t1", "t1c", "seg"))
    expert = labels.data == 4
    if post_scanner is thick_slices:
        expert = thick_slices(labels.with_data(expert.astype(np.float32))).data > 0.5
    found = segment(post_scanner(post), pre_scanner(pre))
    assert len(found.surfaces) == 1
    assert intersection_over_union(found.labels.data == 1, expert) >= least

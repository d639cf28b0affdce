"""A lobed blob with a known border, for flows and for the general mode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapery_geometry.volume import Volume

SUBVOXELS = 3
"""Samples along each axis of a voxel from which its share of the blob is counted."""


@dataclass(frozen=True, eq=False)
class BlobPhantom:
    """A volume with one blob.

    Parameters
    ----------
    volume
        float32; about 1 outside; the blob is a half brighter or darker.
    truth
        bool on the same grid: voxels of which at least half lie in the blob.
    center : (3,) float64
        RAS mm.
    """

    volume: Volume
    truth: Volume
    center: NDArray[np.float64]


def blob_phantom(
    rng: np.random.Generator,
    shape: tuple[int, int, int] = (64, 64, 64),
    affine: ArrayLike | None = None,
    *,
    radius: float = 16.0,
    lobes: float = 0.2,
    polarity: Literal["bright", "dark"] = "bright",
    snr: float = 10.0,
    bias: float = 0.0,
) -> BlobPhantom:
    """Draw a blob in the middle of a volume.

    Parameters
    ----------
    rng
        Of lobes, bias and noise.
    shape, affine
        The grid; 1 mm by default.
    radius
        Mean radius in mm.
    lobes
        By which share of itself the radius varies with the direction.
    polarity
        Whether the blob is brighter or darker than what is around it.
    snr
        Contrast of the blob over the deviation of the noise.
    bias
        Largest deviation from 1 of the smooth field that the volume is multiplied by.
    """
    matrix = np.eye(4) if affine is None else np.asarray(affine, dtype=np.float64)
    grid = Volume(np.zeros(shape, dtype=np.uint8), matrix)
    center = grid.to_world((np.array(shape) - 1) / 2)
    waves = rng.normal(size=(6, 3))
    waves *= (rng.uniform(1.5, 3.5, 6) / np.linalg.norm(waves, axis=1))[:, None]
    phases = rng.uniform(0, 2 * np.pi, 6)
    share = np.zeros(shape, dtype=np.float32)
    index = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1)
    offsets = (np.arange(SUBVOXELS) + 0.5) / SUBVOXELS - 0.5
    for offset in np.stack(np.meshgrid(offsets, offsets, offsets), axis=-1).reshape(-1, 3):
        away = grid.to_world(index + offset) - center
        distance = np.linalg.norm(away, axis=-1)
        direction = away / np.maximum(distance, 1e-9)[..., None]
        wave = np.cos(direction @ waves.T + phases).mean(axis=-1)
        share += distance < radius * (1.0 + lobes * 1.5 * wave)
    share /= SUBVOXELS**3
    contrast = 0.5 if polarity == "bright" else -0.5
    values = 1.0 + contrast * share
    if bias:
        t = (index / np.maximum(np.array(shape) - 1, 1) - 0.5) * 2
        slope = rng.normal(size=3)
        slope /= np.abs(slope).sum()
        values = values * (1.0 + bias * np.clip(t @ slope, -1, 1)).astype(np.float32)
    values = values + rng.normal(0.0, 0.5 / snr, shape)
    return BlobPhantom(Volume(values.astype(np.float32), matrix), Volume(share >= 0.5, matrix), center)

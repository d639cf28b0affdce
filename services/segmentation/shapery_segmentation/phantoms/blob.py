"""A lobed blob with a known border, for flows and for the general mode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

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
    shape
        What `distance` is measured to.
    """

    volume: Volume
    truth: Volume
    center: NDArray[np.float64]
    shape: _Shape

    def distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far points (..., 3) in RAS mm are outside of the blob, along the way from its center, in mm."""
        return self.shape.distance(points - self.center)


@dataclass(frozen=True, eq=False)
class _Shape:
    """A radius that varies with the direction."""

    radius: float
    lobes: float
    waves: NDArray[np.float64]
    phases: NDArray[np.float64]

    @classmethod
    def drawn(cls, rng: np.random.Generator, radius: float, lobes: float) -> _Shape:
        waves = rng.normal(size=(6, 3))
        waves *= (rng.uniform(1.5, 3.5, 6) / np.linalg.norm(waves, axis=1))[:, None]
        return cls(radius, lobes, waves, rng.uniform(0, 2 * np.pi, 6))

    def distance(self, away: NDArray[np.float64]) -> NDArray[np.float64]:
        distance = np.linalg.norm(away, axis=-1)
        direction = away / np.maximum(distance, 1e-9)[..., None]
        wave = np.cos(direction @ self.waves.T + self.phases).mean(axis=-1)
        return np.asarray(distance - self.radius * (1.0 + self.lobes * 1.5 * wave))


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
    blob = _Shape.drawn(rng, radius, lobes)
    share = np.zeros(shape, dtype=np.float32)
    index = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1)
    offsets = (np.arange(SUBVOXELS) + 0.5) / SUBVOXELS - 0.5
    for offset in np.stack(np.meshgrid(offsets, offsets, offsets), axis=-1).reshape(-1, 3):
        share += blob.distance(grid.to_world(index + offset) - center) < 0.0
    share /= SUBVOXELS**3
    contrast = 0.5 if polarity == "bright" else -0.5
    values = 1.0 + contrast * share
    if bias:
        t = (index / np.maximum(np.array(shape) - 1, 1) - 0.5) * 2
        slope = rng.normal(size=3)
        slope /= np.abs(slope).sum()
        values = values * (1.0 + bias * np.clip(t @ slope, -1, 1)).astype(np.float32)
    values = values + rng.normal(0.0, 0.5 / snr, shape)
    return BlobPhantom(Volume(values.astype(np.float32), matrix), Volume(share >= 0.5, matrix), center, blob)


Defect = Literal["noise", "gap", "stripes", "patches"]
"""``noise``: SNR 1.2. ``gap``: in a cone from the center the border is lost. ``stripes``: two of seven slices are lost.
``patches``: of three tenths of the volume nothing is known, in patches some voxels across."""


def defective_blob(rng: np.random.Generator, defect: Defect, *, snr: float = 5.0) -> BlobPhantom:
    """Draw a blob in data that are not all there: what is lost is as likely inside as outside, and noise.

    Parameters
    ----------
    rng
    defect
    snr
        Contrast over the deviation of the noise, but for ``noise``.

    Returns
    -------
    The volume is 0 at the border, positive inside, in units of the noise, and smoothed as the general mode does it.
    """
    clean = blob_phantom(rng, snr=np.inf)
    values = 4.0 * (np.asarray(clean.volume.data, dtype=np.float64) - 1.25)
    index = np.stack(np.meshgrid(*(np.arange(n) for n in values.shape), indexing="ij"), axis=-1)
    noise = 2.0 / (1.2 if defect == "noise" else snr)
    lost = np.zeros(values.shape, dtype=np.bool_)
    if defect == "gap":
        away = clean.volume.to_world(index) - clean.center
        axis = rng.normal(size=3)
        distance = np.linalg.norm(away, axis=-1)
        lost = (away @ (axis / np.linalg.norm(axis)) > np.cos(np.deg2rad(30.0)) * distance) & (distance > 8.0)
    elif defect == "stripes":
        lost = index[..., 2] % 7 < 2
    elif defect == "patches":
        random = ndimage.gaussian_filter(rng.normal(size=values.shape), 2.5)
        lost = random > np.quantile(random, 0.7)
    values = np.where(lost, 0.0, values) + rng.normal(0.0, noise, values.shape)
    field = ndimage.gaussian_filter((values / noise).astype(np.float32), 0.6)
    return BlobPhantom(clean.volume.with_data(field), clean.truth, clean.center, clean.shape)

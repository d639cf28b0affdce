"""What an object borders on: darker tissue, brighter, or both, and at which value the border lies (general mode)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Volume
from shapery_segmentation.neighborhoods import within_each

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

LOCAL = 10.0
"""mm: deviation of the Gaussian within which inside and outside are averaged for the border between them; the
sensitivity of coils varies over more."""

FARTHEST = 10
"""Voxels beyond which an object's surroundings are not looked at."""

RING_FROM, RING = 1, 2
"""Voxels from the region at which its surroundings begin at the earliest, and how far they are looked at."""

FLAT = 0.05
"""Share of the contrast; where a further voxel adds less, the surroundings are themselves and no mixture."""

LEAST_SIDE = 0.1
"""Share of the ring that must be darker (brighter) for the object to have a border to that side."""

BEYOND = 1.25
"""How much further from the object's median than the darker (brighter) half of its own voxels that share must be. Where
the region stops short of the border, the ring holds voxels of the object, and their noise is no border."""

LEAST_CONTRAST = 2.5
"""Units of the noise by which the ring must differ, or there is no border to find."""

LARGEST_VALUE = 20.0
"""U is cut to this; further inside it says nothing more."""

Polarity = Literal["bright", "dark", "between"]


def borders(volume: Volume, inside: BoolArray, noise: float) -> tuple[FloatArray, Polarity, float]:
    """Return U, the polarity, and the contrast to the nearer side in units of the noise.

    Parameters
    ----------
    volume
    inside : (I, J, K) bool
        Roughly the object, on the volume's grid.
    noise
        Deviation, in the volume's units.

    Returns
    -------
    (I, J, K) float32
        Distance to the nearer border in units of the noise, positive inside.
    str
    float

    Raises
    ------
    InvalidInput
        ``no_object_found`` where nothing around stands out from what is inside.
    """
    data = volume.data.astype(np.float32)
    outwards = _layers(inside)
    if not (outwards[1] & ~inside).any():
        raise InvalidInput("no_object_found", "The object fills the whole volume: it has no border in it.")
    low = _border_below(data, outwards, noise, volume.spacing)
    high = _border_below(-data, outwards, noise, volume.spacing)
    contrasts = [side.contrast for side in (low, high) if side is not None]
    if not contrasts:
        raise InvalidInput(
            "no_object_found",
            f"What surrounds the seed differs from it by less than {LEAST_CONTRAST:g} times the noise: there is no "
            "border to find.",
            "Place the seed in the middle of the object, or draw a box around it.",
        )
    polarity: Polarity = "bright" if high is None else "dark" if low is None else "between"
    above = data - low.level if low is not None else np.float32(np.inf)
    below = -high.level - data if high is not None else np.float32(np.inf)
    field = np.minimum(above, below) / np.float32(noise)
    field = np.clip(field, -LARGEST_VALUE, LARGEST_VALUE).astype(np.float32)
    sigma = 0.6 * float(volume.voxel_volume ** (1 / 3)) / np.array(volume.spacing)
    return ndimage.gaussian_filter(field, sigma, mode="nearest"), polarity, float(min(contrasts))


@dataclass(frozen=True, eq=False)
class _Side:
    """The border to one side: its level from place to place, and the contrast in units of the noise."""

    level: FloatArray
    contrast: float


def _border_below(
    data: FloatArray, outwards: list[BoolArray], noise: float, spacing: tuple[float, float, float]
) -> _Side | None:
    """Return the border to what is darker than the object; None where there is none.

    It lies half-way between what is inside and what is outside, the latter taken where it no longer changes with the
    distance from the region: next to the border the blur of the scanner mixes them, and the region often stops short.
    """
    inside = outwards[0]
    middle = float(np.median(data[inside]))
    darker = data < middle
    profile = []
    for near, far in pairwise(outwards):
        shell = data[far & ~near & darker]
        profile.append(middle - float(np.median(shell)) if shell.size else 0.0)
    start = _flat(profile, RING_FROM)
    ring = outwards[min(start + RING, len(outwards) - 1)] & ~outwards[start]
    beyond = ring & darker
    if np.count_nonzero(beyond) < LEAST_SIDE * np.count_nonzero(ring):
        return None
    outside = float(np.median(data[beyond]))
    own_darker = BEYOND * abs(float(np.percentile(data[inside], 25.0)) - middle)
    if middle - outside < max(LEAST_CONTRAST * noise, own_darker):
        return None
    level = np.float32(0.5) * (_local(data, inside, middle, spacing) + _local(data, beyond, outside, spacing))
    return _Side(level, (middle - outside) / noise)


def _layers(mask: BoolArray) -> list[BoolArray]:
    """Return the voxels within 0, 1, … voxels of `mask`."""
    wide = within_each(np.pad(mask, FARTHEST), range(FARTHEST + 1))
    return [layer[tuple(slice(FARTHEST, -FARTHEST) for _ in range(3))] for layer in wide]


def _flat(profile: list[float], start: int) -> int:
    """Return from which place on, at `start` or later, a profile no longer rises."""
    for at in range(start, len(profile) - 1):
        if profile[at + 1] - profile[at] < FLAT * profile[at + 1]:
            return at
    return max(len(profile) - 1, 0)


def _local(data: FloatArray, where: BoolArray, usual: float, spacing: tuple[float, float, float]) -> FloatArray:
    """Return the mean of `data` over `where`, weighted by nearness; `usual` where there is none of it near."""
    sigma = LOCAL / np.array(spacing)
    weight = ndimage.gaussian_filter(where.astype(np.float32), sigma, mode="constant", truncate=3.0)
    total = ndimage.gaussian_filter(np.where(where, data - np.float32(usual), 0), sigma, mode="constant", truncate=3.0)
    return np.asarray(np.float32(usual) + total / (weight + np.float32(0.02)), dtype=np.float32)

"""Where vessels might be: whether they are bright or dark, how the tissue around them looks, and where to start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_segmentation.blocks import block_mean
from shapery_segmentation.vessels import _border_kernels as border
from shapery_segmentation.vessels import _evidence_kernels as kernels

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]
Polarity = Literal["bright", "dark"]

BLOCK = 16
"""Voxels along the edge of the cubes whose medians are the background."""

LARGEST_SEARCH = 3_000_000
"""Voxels in which tubes are looked for at the most; of a larger volume, means of cubes are."""

TOP = 40
"""Strongest responses that tell how strong a vessel's response is."""

SEED_SHARE = 0.3
"""Share of that which the response of a seed must have."""

SEED_NOISE = 4.0
"""Multiple of the 90th percentile of all responses at its scale that it must exceed."""

SEEDS = 400
"""Seeds at the most; by then every vessel of some length has several."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """A volume seen as bright vessels on a dark background.

    Parameters
    ----------
    polarity
        Of the volume as it was given; of dark vessels the values are negated.
    values, smoothed : (I, J, K) float32
    background : (A, B, C) float32
        Medians of cubes of `BLOCK` voxels without what is as bright as vessels.
    noise
        Standard deviation of a voxel of `values`.
    scatter
        Robust standard deviation of what remains of `smoothed` without the background.
    seeds : (n, 3) int64
        Voxels, the most tube-like first.
    contrast
        How far typical seeds rise above the background.
    """

    polarity: Polarity
    values: FloatArray
    smoothed: FloatArray
    background: FloatArray
    noise: float
    scatter: float
    seeds: IntArray
    contrast: float


def gather_evidence(
    values: FloatArray,
    spacing: tuple[float, float, float],
    polarity: Literal["auto", "bright", "dark"] = "auto",
    where: BoolArray | None = None,
    outside: BoolArray | None = None,
) -> Evidence:
    """Find out how vessels look in a volume, and where to start.

    Parameters
    ----------
    values : (I, J, K) float32
        Finite.
    spacing
        mm.
    polarity
        ``auto``: whichever of the two has the stronger tubes, see Notes.
    where : (I, J, K) bool
        Where seeds may lie; everywhere if it is not given.
    outside : (I, J, K) bool
        What was never measured, which says nothing about the noise.

    Notes
    -----
    A voxel lies on a bright tube where the second derivatives across are negative and larger than that along it
    (eigenvalues λ1 ≤ λ2 < 0 and |λ3| of the Hessian: −λ2 − |λ3|). This is looked at on means of 1, 2, 4 and 8 voxels,
    so for radii from about 1 to 12. Polarity is decided by the sum over the squares of the strongest responses, in the
    region where seeds may lie.
    """
    smoothed = np.empty_like(values)
    kernels.smooth(values, smoothed)
    bright, dark = _tubes(smoothed, spacing, where)
    chosen: Polarity = polarity if polarity != "auto" else ("bright" if _power(bright) >= _power(dark) else "dark")
    if chosen == "dark":
        values, smoothed = -values, -smoothed
    response, places = bright if chosen == "bright" else dark
    seeds = _strongest(response, places, values.shape)
    noise = _noise(values, outside)

    background = block_medians(smoothed, BLOCK)
    if not len(seeds):
        return Evidence(chosen, values, smoothed, background, noise, 0.0, seeds, 0.0)
    peaks = np.array([_peak(smoothed, seed) for seed in seeds])
    ground = np.array([border.sample_blocks(background, BLOCK, *seed) for seed in seeds])
    contrast = float(np.median((peaks - ground)[:TOP]))
    # Where vessels fill most of a cube its median is theirs.
    level = float(np.median((0.5 * (peaks + ground))[:TOP]))
    if np.isfinite(level) and (background > level).any():
        background = _without_bright(background, level)
    rest = smoothed[1::3, 1::3, 1::3] - _spread_background(background, smoothed.shape)
    if outside is not None:
        rest = rest[~outside[1::3, 1::3, 1::3]]
    if not rest.size:
        return Evidence(chosen, values, smoothed, background, noise, 0.0, seeds[:0], 0.0)
    scatter = 1.4826 * float(np.median(np.abs(rest - np.median(rest))))
    return Evidence(chosen, values, smoothed, background, noise, scatter, seeds, contrast)


def block_medians(values: FloatArray, size: int) -> FloatArray:
    """Return medians of cubes, of every other voxel along each axis."""
    thin = values[::2, ::2, ::2]
    half = size // 2
    pad = [(0, -n % half) for n in thin.shape]
    full = np.pad(thin, pad, mode="edge")
    a, b, c = (n // half for n in full.shape)
    cubes = full.reshape(a, half, b, half, c, half).transpose(0, 2, 4, 1, 3, 5).reshape(a, b, c, -1)
    return np.ascontiguousarray(np.median(cubes, axis=3), dtype=np.float32)


def _spread_background(background: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Return the background at every third voxel."""
    at = [np.arange(1, n, 3) // BLOCK for n in shape]
    return background[np.ix_(*at)]


def _without_bright(background: FloatArray, level: float) -> FloatArray:
    """Return the background with cubes above `level` replaced by the nearest below it."""
    bad = background > level
    if bad.all():
        return np.full_like(background, background.min())
    nearest = ndimage.distance_transform_edt(bad, return_distances=False, return_indices=True)
    return np.ascontiguousarray(background[tuple(nearest)])


def _noise(values: FloatArray, outside: BoolArray | None) -> float:
    """Return the standard deviation of noise, from differences of neighbours along each axis."""
    found = []
    for axis in range(3):
        thin = np.moveaxis(values, axis, 0)[:, ::2, ::2]
        pairs = len(thin) // 2
        steps = np.abs(thin[1 : 2 * pairs : 2] - thin[0 : 2 * pairs : 2])
        if outside is not None:
            beyond = np.moveaxis(outside, axis, 0)[:, ::2, ::2]
            steps = steps[~(beyond[1 : 2 * pairs : 2] | beyond[0 : 2 * pairs : 2])]
        if steps.size:
            found.append(float(np.median(steps)))
    return 1.4826 / np.sqrt(2.0) * min(found) if found else 0.0


Tubes = tuple[FloatArray, IntArray]


def _tubes(smoothed: FloatArray, spacing: tuple[float, float, float], where: BoolArray | None) -> tuple[Tubes, Tubes]:
    """Return the local maxima of both responses over all scales: strengths, and voxels (n, 3)."""
    low, high = np.zeros(3, dtype=np.int64), np.array(smoothed.shape)
    if where is not None:
        if not where.any():
            empty = (np.zeros(0, np.float32), np.zeros((0, 3), np.int64))
            return empty, empty
        for axis in range(3):
            hit = np.flatnonzero(where.any(axis=tuple(a for a in range(3) if a != axis)))
            low[axis], high[axis] = max(int(hit[0]) - 12, 0), min(int(hit[-1]) + 13, smoothed.shape[axis])
    box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
    part = np.ascontiguousarray(smoothed[box])
    allowed = None if where is None else where[box]
    found: tuple[list[Tubes], list[Tubes]] = ([], [])
    for factor in (1, 2, 4, 8):
        if part.size / factor**3 > LARGEST_SEARCH:
            continue
        if min(part.shape) < 5 * factor:
            break
        values = block_mean(part, factor)
        if factor > 1:
            plain, values = values, np.empty_like(values)
            kernels.smooth(plain, values)
        bright, dark = np.zeros_like(values), np.zeros_like(values)
        steps = np.array(spacing) * factor
        kernels.tubeness(values, steps, float(steps.min()), bright, dark)
        for response, into in zip((bright, dark), found, strict=True):
            peak = (response >= ndimage.maximum_filter(response, 3)) & (response > 0)
            if allowed is not None:
                peak &= block_mean(allowed.astype(np.float32), factor) > 0
            index = np.argwhere(peak)
            strength = response[peak]
            # What noise and tissue give differs from scale to scale; vessels fill less than a tenth.
            keep = strength > SEED_NOISE * float(np.percentile(response, 90.0))
            centers = np.minimum(factor * index[keep] + factor // 2, np.array(part.shape) - 1)
            into.append((strength[keep], centers + low))
    joined = [
        (np.concatenate([s for s, _ in group]), np.concatenate([p for _, p in group]))
        if group
        else (np.zeros(0, np.float32), np.zeros((0, 3), np.int64))
        for group in found
    ]
    return joined[0], joined[1]


def _power(tubes: Tubes) -> float:
    strength = np.sort(tubes[0])[::-1][: 5 * TOP].astype(np.float64)
    return float((strength**2).sum())


def _strongest(strength: FloatArray, places: IntArray, shape: tuple[int, ...]) -> IntArray:
    """Return the places with the strongest responses, each once, strongest first."""
    if not len(strength):
        return np.zeros((0, 3), dtype=np.int64)
    order = np.lexsort((places[:, 2], places[:, 1], places[:, 0], -strength))
    typical = float(np.median(strength[order[:TOP]]))
    order = order[strength[order] >= SEED_SHARE * typical]
    _, first = np.unique(np.ravel_multi_index(tuple(places[order].T), shape), return_index=True)
    return places[order[np.sort(first)]][:SEEDS]


def _peak(smoothed: FloatArray, seed: IntArray) -> float:
    i, j, k = (slice(max(int(x) - 2, 0), int(x) + 3) for x in seed)
    return float(smoothed[i, j, k].max())

"""How much each voxel took up of the contrast agent, on a scale that is the same for every scanner (3.3, 3.5.1).

The dissertation subtracts the volume before contrast from the one after it. Real files have unrelated scales, so the
one is fitted to the other first, and the difference is measured in units of the normal brain's own variation.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Volume
from shapery_segmentation.blocks import local_mean
from shapery_segmentation.brain import Brain
from shapery_segmentation.neighborhoods import eroded
from shapery_segmentation.smoothing import gaussian

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

SUBTRACTED = 0.65
"""Share of the fitted volume before contrast that is subtracted. All of it would also subtract the noise and the
misregistration of that volume; the share was measured on cases with expert labels, and its optimum is broad."""

SMOOTHING = 0.6
"""Standard deviation in mm of the Gaussian over the difference: less than a voxel, against noise alone."""

LEFT_BY_SMOOTHING = 0.93
"""Share of the deviation of the difference that this Gaussian leaves where there is no more than the usual noise (the
median of cases with expert labels): one unit is the deviation before it, as far as it is not noise."""

TRIM = 2.5
"""Residuals beyond this many deviations (vessels, the tumor itself, borders) take no part in the fit."""

DRIFT_TRIM = 2.0
"""The same for the fit of the drift: enhancement that is left in would be taken for it."""

DRIFT_TERMS = ((0,), (1,), (2,), (0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Axes whose coordinates are multiplied in each term of the drift: a polynomial of second order, as coils cause it."""

STEADIER = 1.1
"""How much the deviation of the difference must fall, relative, where what shades the one volume is taken out: less may
as well be a large tumor on one side, which the fit would follow. On volumes with expert labels it fell by up to 1.05,
by 1.11 and 1.26 where the coils differed, and rose where the fit followed something else."""

SHADING_TERMS = 3
"""The first terms, the linear ones: those of second order also follow what enhances at the brain's rim."""

LIGHT = (0.5, 2.0)
"""Bounds of the factor by which the light of one volume may differ from the other's."""

SAMPLES, DRIFT_SAMPLES = 100_000, 20_000
"""Voxels the fits are made from; more change their third digit."""

TISSUE_PERCENTILE = 65.0
"""Without a volume before contrast: percentile of the brain that counts as zero. It lies in the brighter of the two
normal tissues, which would otherwise enhance."""

EVENING_SCALE = 25.0
"""mm: standard deviation of the Gaussian that follows the coil's brightness, but no tumor."""

MAD_TO_SIGMA = 1.4826
"""Median absolute deviation of a normal distribution to its standard deviation."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """The calibrated difference.

    Parameters
    ----------
    field : (I, J, K) float32
        U: zero in normal brain, in units of its deviation; 0 outside the brain's mask.
    before : (I, J, K) float32
        The volume before contrast in the same way: zero in normal brain, negative in fluid and in vessels with flow.
        Where there was none, the one after contrast, cut off above.
    slope, offset
        Of the fit ``post ≈ slope · pre + offset``; (0, median) without `pre`.
    noise
        One unit of `field`, in intensities of `post`.
    subtracted
        Whether there was a volume before contrast.
    """

    field: FloatArray
    before: FloatArray
    slope: float
    offset: float
    noise: float
    subtracted: bool


@dataclass(frozen=True, eq=False)
class Fit:
    """How one volume follows from the other.

    Parameters
    ----------
    after : (I, J, K) float32
        The volume after contrast, in the light of the other.
    slope, offset
        As `Calibration` has them.
    steadier
        Where what shades the volume after contrast relative to the other was taken out of it: how much the deviation of
        the difference fell by that; 1 where it was left.
    """

    after: FloatArray
    slope: float
    offset: float
    steadier: float = 1.0


@dataclass(frozen=True, eq=False)
class Comparison:
    """The two volumes on the brain's working grid: what every calibrated difference is made of.

    Parameters
    ----------
    after, reference : (I, J, K) float32
        The volume after contrast, and the one before it; without that twice the one after, its brightness evened.
    mask : (I, J, K) bool
        The brain where both are known.
    chosen : (n,) int64
        Voxels within it that everything is fitted to.
    subtracted
        As `Calibration` has it.
    spacing
        Edge of a voxel in mm.
    """

    after: FloatArray
    reference: FloatArray
    mask: BoolArray
    chosen: NDArray[np.int64]
    subtracted: bool
    spacing: float

    @cached_property
    def fit(self) -> Fit:
        """The one volume fitted to the other (trimmed least squares), once and again in even light."""
        y = self._of(self.after)
        if not self.subtracted:
            return Fit(self.after, 0.0, float(np.median(y)))
        x = self._of(self.reference)
        slope, offset = trimmed_fit(x, y)
        zero = float(np.nanpercentile(self.after[::3, ::3, ::3], 0.1))
        terms = _terms(self.chosen, self.after.shape)[:, :SHADING_TERMS]
        light, steadier = _light(x, y - zero, slope * x + offset - zero, terms)
        if steadier < STEADIER:
            return Fit(self.after, slope, offset)
        after = (self.after - np.float32(zero)) / np.clip(1.0 + _drift_on(self.after.shape, light), *LIGHT)
        return Fit(after, *trimmed_fit(x, self._of(after)), steadier)

    def calibrated(self, *, without_drift: bool = False) -> Calibration:
        """Return the calibrated difference.

        Parameters
        ----------
        without_drift
            Whether a smooth drift between the two volumes is taken out first. It shows small tumors that the drift
            hides, and raises the brain's rim, which is grey and less bright, with its veins and dura: good for a second
            look.

        Raises
        ------
        InvalidInput
            ``invalid_volume`` if the brain shows no variation.

        Notes
        -----
        With the slope a of the fit, D = G₀.₆ ∗ (post − 0.65·a·pre − median) and U = 0.93·D / (1.4826·MAD(D)), median
        and MAD over the brain. The deviation is that of the smoothed difference: noise that the smoothing takes away
        hides no tumor, and must not make the unit larger. Where the volumes were lit differently and that was taken
        out, the unit is the geometric mean of the deviations with it and without: with the smaller one alone surfaces
        would grow past half maximum. Without `pre`, a = 0 and the median gives way to the 65th
        percentile, after `post` was divided by its own local brightness: U then also carries the contrast between
        normal tissues.
        """
        fit = self.fit
        # A tumor brightens after contrast only; a falling fit means that the volumes are unlike, and must not be
        # amplified.
        share = SUBTRACTED * max(fit.slope, 0.0)
        residual = self._of(fit.after)
        drift = np.zeros(len(DRIFT_TERMS))
        if self.subtracted:
            residual = residual - share * self._of(self.reference)
            if without_drift:
                terms = _terms(self.chosen, self.after.shape)
                every = max(1, len(terms) // DRIFT_SAMPLES)
                drift = trimmed_drift(terms[::every], residual[::every])
                residual = residual - terms @ drift
        middle = float(np.percentile(residual, 50.0 if self.subtracted else TISSUE_PERCENTILE))
        with np.errstate(invalid="ignore"):
            field = fit.after - np.float32(share) * self.reference if self.subtracted else fit.after.copy()
            if drift.any():
                field -= _drift_on(self.after.shape, drift)
            field -= np.float32(middle)
        field[~self.mask] = 0.0
        field = gaussian(field, SMOOTHING / self.spacing)
        noise = _deviation(self._of(field)) / LEFT_BY_SMOOTHING * float(np.sqrt(fit.steadier))
        if not (_deviation(residual) > 0 and noise > 0):
            raise InvalidInput(
                "invalid_volume",
                "More than half of the brain has one and the same intensity.",
                "Give the original volumes, not masks or heavily quantised copies.",
            )
        field /= np.float32(noise)
        return Calibration(field, self.before, fit.slope, fit.offset, noise, self.subtracted)

    @cached_property
    def before(self) -> FloatArray:
        """What `Calibration.before` is."""
        values = self._of(self.reference)
        spread = max(_deviation(values), 1e-30)
        normal = (self.reference - np.float32(np.median(values))) / np.float32(spread)
        normal[~self.mask] = 0.0
        if not self.subtracted:
            # After contrast a tumor is bright itself: that says nothing about its tissue.
            np.minimum(normal, 0.0, out=normal)
        return normal

    def _of(self, volume: FloatArray) -> NDArray[np.float64]:
        return volume.ravel()[self.chosen].astype(np.float64)


def compare(brain: Brain, post: Volume, pre: Volume | None) -> Comparison:
    """Bring both volumes onto the brain's working grid.

    Parameters
    ----------
    brain
        Grid and mask.
    post, pre
        The volumes after and before contrast, on any grids of one frame.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` or ``grid_mismatch`` if too little of the brain is known.
    """
    after = brain.grid.sample(post)
    before = brain.grid.sample(pre) if pre is not None else None
    known = np.isfinite(after) if before is None else np.isfinite(after) & np.isfinite(before)
    mask = brain.mask & known
    if before is None:
        after = evened(after, mask, brain.grid.spacing)
    inner = eroded(eroded(mask))
    stride = max(1, int(np.count_nonzero(inner)) // SAMPLES)
    chosen = np.flatnonzero(inner)[::stride]
    if len(chosen) < 1000:
        raise InvalidInput(
            "grid_mismatch" if before is not None else "invalid_volume",
            f"Only {int(np.count_nonzero(mask))} voxels of brain are known in all volumes: too few to compare them.",
            "Give volumes that cover the same part of the head.",
        )
    return Comparison(after, after if before is None else before, mask, chosen, before is not None, brain.grid.spacing)


def calibrate(brain: Brain, post: Volume, pre: Volume | None, *, without_drift: bool = False) -> Calibration:
    """Return the calibrated difference of two volumes: see `compare` and `Comparison.calibrated`."""
    return compare(brain, post, pre).calibrated(without_drift=without_drift)


def _deviation(values: NDArray[np.float64]) -> float:
    """Return 1.4826 times the median absolute deviation."""
    return MAD_TO_SIGMA * float(np.median(np.abs(values - np.median(values))))


def _light(
    before: NDArray[np.float64], after: NDArray[np.float64], expected: NDArray[np.float64], terms: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """Return by how much the light of the volume after contrast differs, and how much steadier the difference gets.

    Parameters
    ----------
    before, after, expected : (n,)
        Intensities, and what is expected after contrast of those before. These two count from where no signal is, which
        files need not have at 0.
    terms : (n, k)
        Smooth.

    Returns
    -------
    The weights (k,) of ``after ≈ (1 + Σ weight·term)·expected + constant``, and the deviation of the difference with
    that light over the one without. Coils work by a factor on all tissues alike; a sum that is fitted to the
    difference would follow the contrast that is left between them, which is that of the brain's middle and its rim.
    """
    every = slice(None, None, max(1, len(terms) // DRIFT_SAMPLES))
    x, y, smooth, usual = before[every], after[every], terms[every], expected[every, None]
    weights = trimmed_drift(np.hstack((smooth * usual, usual)), y)
    if weights[-1] <= 0.0:
        return np.zeros(terms.shape[1]), 1.0
    light = weights[:-1] / weights[-1]
    even = y / np.clip(1.0 + smooth @ light, *LIGHT)
    with_light, without = (
        _deviation(values - SUBTRACTED * max(trimmed_fit(x, values)[0], 0.0) * x) for values in (y, even)
    )
    return light, with_light / without if without > 0.0 else 1.0


def trimmed_drift(terms: NDArray[np.float64], residual: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weights (k,) of smooth terms (n, k) that most of the residuals (n,) follow, but for a constant.

    Fitted and trimmed in up to ten rounds, as in `trimmed_fit`.
    """
    columns = np.hstack((terms, np.ones((len(terms), 1))))
    weights: NDArray[Any] = np.zeros(columns.shape[1])
    keep = np.ones(len(residual), dtype=np.bool_)
    for _ in range(10):
        part = columns[keep]
        weights = np.linalg.lstsq(part.T @ part, part.T @ residual[keep], rcond=None)[0]
        left = residual - columns @ weights
        middle = float(np.median(left))
        spread = MAD_TO_SIGMA * float(np.median(np.abs(left - middle)))
        kept, keep = keep, np.abs(left - middle) < DRIFT_TRIM * spread
        if spread == 0 or np.array_equal(kept, keep):
            break
    return np.asarray(weights[:-1])


def _terms(chosen: NDArray[np.intp], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return the terms (n, k) of the drift at voxels given by their flat index; coordinates run from −1 to 1."""
    index = np.unravel_index(chosen, shape)
    place = [2.0 * i / max(n - 1, 1) - 1.0 for i, n in zip(index, shape, strict=True)]
    return np.stack([np.prod([place[axis] for axis in term], axis=0) for term in DRIFT_TERMS], axis=1)


def _drift_on(shape: tuple[int, ...], weights: NDArray[np.floating]) -> FloatArray:
    """Return the sum of the first terms with these weights on a whole grid."""
    place = np.meshgrid(*(np.linspace(-1.0, 1.0, n, dtype=np.float32) for n in shape), indexing="ij", sparse=True)
    out = np.zeros(shape, dtype=np.float32)
    for term, weight in zip(DRIFT_TERMS, weights, strict=False):
        part = np.float32(weight) * place[term[0]]
        out += part * place[term[1]] if len(term) == 2 else part
    return out


def evened(image: FloatArray, mask: BoolArray, spacing: float) -> FloatArray:
    """Return `image` divided by its local brightness: the coil's sensitivity taken out; 1 is usual tissue.

    Parameters
    ----------
    image : (I, J, K) float32
        Finite where `mask` is.
    mask : (I, J, K) bool
        The brain. Outside, the result is 0.
    spacing
        Edge of a voxel in mm.
    """
    values = np.where(mask, image, 0.0).astype(np.float32)
    usual = float(np.median(values[mask])) if mask.any() else 0.0
    if not usual > 0:
        return values
    # What enhances is cut off, or a tumor would raise its own surroundings.
    light = np.minimum(values, np.float32(1.3 * usual))
    local = local_mean(light, mask.astype(np.float32), spacing, EVENING_SCALE, 1e-3)
    return np.where(mask, values / np.maximum(local, np.float32(0.1 * usual)), np.float32(0.0))


def trimmed_fit(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float]:
    """Return slope and offset of ``y ≈ slope · x + offset`` by least squares over the voxels that agree with it.

    Parameters
    ----------
    x, y : (n,)
        Intensities of the same voxels. The extreme 2 % of `x` at either end are left out: they have the most leverage
        and are fluid, fat and borders.

    Notes
    -----
    Up to ten rounds of fitting and dropping residuals beyond 2.5 robust deviations; the start, over all, is already
    within the basin because enhancing voxels are few.
    """
    low, high = np.percentile(x, (2, 98))
    usable = (x > low) & (x < high)
    if np.count_nonzero(usable) < 100 or not float(np.ptp(x[usable])) > 0:
        return 0.0, float(np.median(y))
    x, y = x[usable], y[usable]
    keep = np.ones(len(x), dtype=np.bool_)
    slope, offset = 0.0, 0.0
    for _ in range(10):
        u, v = x[keep], y[keep]
        centre = u.mean()
        variance = float(((u - centre) ** 2).mean())
        if variance == 0:
            break
        slope = float(((u - centre) * (v - v.mean())).mean() / variance)
        offset = float(v.mean() - slope * centre)
        residual = y - slope * x - offset
        middle = float(np.median(residual))
        spread = MAD_TO_SIGMA * float(np.median(np.abs(residual - middle)))
        kept, keep = keep, np.abs(residual - middle) < TRIM * spread
        if spread == 0 or np.array_equal(kept, keep):
            break
    return slope, offset

"""The edge indicator g of Eq. 3.3 around a surface, on a scale that does not depend on the field's units."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

FloatArray = NDArray[np.float64]
Volume32 = NDArray[np.float32]

MARGIN = 12.0
"""mm around the surface in which g is worked out at once; it is worked out anew when the surface gets near its end."""

NEAR = 3.0
"""mm from the end of that region at which this happens."""

TRUNCATE = 3.0
"""Standard deviations at which the Gaussian ends."""

SHARPNESS = 3.0
"""Multiple of the percentile's unit in which the gradient enters g: an edge of that strength has g = 0.1."""


class EdgeIndicator:
    """g = 1/(1 + (c·|∇(Gσ ∗ I)|/q)²) in a box that follows the surface.

    Parameters
    ----------
    field : (I, J, K) float32
        I.
    affine : (4, 4) float64
        From index to RAS mm.
    sigma
        Standard deviation of the Gaussian in mm.
    percentile
        q is this percentile of the gradient in the first box.

    Notes
    -----
    Eq. 3.3 has c/q = 1, so its g depends on the intensity's unit. The gradient is taken in mm through the inverse of
    the affine, so it is right for any spacing and orientation; the Gaussian follows the spacing along each axis.
    """

    def __init__(self, field: Volume32, affine: FloatArray, sigma: float, percentile: float) -> None:
        self._field = field
        self._affine = affine
        self._inverse = np.linalg.inv(affine).astype(np.float64)
        self._sigma = sigma
        self._percentile = percentile
        self._unit: float | None = None
        self._low = np.zeros(3, dtype=np.int64)
        self._high = np.zeros(3, dtype=np.int64)
        self.values: Volume32 = np.zeros((0, 0, 0), dtype=np.float32)
        """g in the box."""
        self.inverse: FloatArray = self._inverse[:3]
        """(3, 4) from RAS mm to an index of `values`."""

    def follow(self, points: FloatArray) -> None:
        """Make the box hold `points` (n, 3) with room around them."""
        low, high = self._box(points, NEAR)
        if self.values.size and (low >= self._low).all() and (high <= self._high).all():
            return
        low, high = self._box(points, MARGIN)
        if self.values.size:
            low, high = np.minimum(low, self._low), np.maximum(high, self._high)
        if (high <= low).any():
            return
        spacing = np.sqrt((self._affine[:3, :3] ** 2).sum(axis=0))
        sigma = self._sigma / spacing
        # What the Gaussian and the central difference read beyond the box.
        pad = np.ceil(TRUNCATE * sigma).astype(np.int64) + 1
        outer_low, outer_high = np.maximum(low - pad, 0), np.minimum(high + pad, self._field.shape)
        box = tuple(slice(a, b) for a, b in zip(outer_low, outer_high, strict=True))
        smooth = ndimage.gaussian_filter(self._field[box], sigma, truncate=TRUNCATE, mode="nearest")
        inner = tuple(slice(a, b) for a, b in zip(low - outer_low, high - outer_low, strict=True))
        # Chain rule: the gradient in mm is the transposed inverse affine times the gradient by index.
        by_index = [
            np.gradient(smooth, axis=axis)[inner] if smooth.shape[axis] > 1 else np.zeros_like(smooth[inner])
            for axis in range(3)
        ]
        squared = np.zeros(by_index[0].shape, dtype=np.float32)
        for world in range(3):
            part = sum(np.float32(self._inverse[axis, world]) * by_index[axis] for axis in range(3))
            squared += np.square(part)
        if self._unit is None:
            unit = float(np.sqrt(np.percentile(squared, self._percentile)))
            self._unit = unit if unit > 0 else 1.0
        self.values = np.ascontiguousarray(1.0 / (1.0 + squared * np.float32((SHARPNESS / self._unit) ** 2)))
        self._low, self._high = low, high
        inverse = self._inverse[:3].copy()
        inverse[:, 3] -= low
        self.inverse = inverse

    def _box(self, points: FloatArray, margin: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return first and past-the-end index of the box around `points`, cut to the field."""
        index = points @ self._inverse[:3, :3].T + self._inverse[:3, 3]
        # A ball of the margin, in index coordinates.
        reach = margin * np.sqrt((self._inverse[:3, :3] ** 2).sum(axis=1))
        low = np.floor(index.min(axis=0) - reach).astype(np.int64)
        high = np.ceil(index.max(axis=0) + reach).astype(np.int64) + 1
        shape = np.array(self._field.shape)
        return np.clip(low, 0, shape), np.clip(high, 0, shape)

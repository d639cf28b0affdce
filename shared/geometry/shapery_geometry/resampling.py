"""Resampling of one volume onto another's grid."""

from __future__ import annotations

from typing import Literal

import numpy as np

from shapery_geometry import _resampling_kernels as kernels
from shapery_geometry.volume import Volume


def resample(
    volume: Volume,
    grid: Volume,
    *,
    method: Literal["linear", "nearest"] = "linear",
    fill: float = float("nan"),
) -> Volume:
    """Return the values of `volume` at the voxel centres of `grid`.

    The target is written in one pass without an array of coordinates: beside `volume` and the result (float32) it
    needs a C-contiguous float copy of `volume` at the most.

    Parameters
    ----------
    volume
        The values.
    grid
        The volume on whose grid they are wanted; its own values are not read.
    method
        ``"linear"`` (trilinear) for intensities, ``"nearest"`` for labels.
    fill
        Value outside the field of view of `volume`, which ends half a voxel beyond the outermost voxel centres;
        inside that margin the outermost value holds.

    Returns
    -------
    On the grid of `grid`. Linear: float32, float64 if `volume` is float64; non-finite voxels carry no weight, and
    where they would carry more than half of it, the result is `fill`. Nearest: the type of `volume`; a `fill` that
    the type cannot hold becomes 0.
    """
    # From the target's index to the source's, composed relative to the source's origin to keep the digits.
    inverse = np.ascontiguousarray(volume.inverse_affine[:3, :3])
    matrix = np.ascontiguousarray(inverse @ grid.affine[:3, :3])
    offset = inverse @ (grid.affine[:3, 3] - volume.affine[:3, 3])
    # Grids that agree but for rounding must meet voxel centres, or borders and labels would flicker.
    matrix[np.abs(matrix - np.round(matrix)) < 1e-9] = np.round(matrix)[np.abs(matrix - np.round(matrix)) < 1e-9]
    offset = np.where(np.abs(offset - np.round(offset)) < 1e-6, np.round(offset), offset)
    if method == "linear":
        kind = np.float64 if volume.data.dtype == np.float64 else np.float32
        out = np.empty(grid.shape, dtype=kind)
        data = np.ascontiguousarray(volume.data, dtype=kind)
        scale = np.diagonal(matrix).copy()
        # What is not parallel only by rounding moves no voxel by more than a millionth of its size.
        crooked = float((np.abs(matrix - np.diag(scale)) @ np.array(grid.shape, dtype=np.float64)).max())
        if min(data.shape) > 1 and crooked < 1e-6:
            kernels.linear_aligned(data, scale, offset, out, fill)
        else:
            kernels.linear(data, matrix, offset, out, fill)
    elif method == "nearest":
        dtype = volume.data.dtype
        out = np.empty(grid.shape, dtype=dtype)
        value = dtype.type(fill) if dtype.kind == "f" else dtype.type(fill if _fits(fill, dtype) else 0)
        kernels.nearest(np.ascontiguousarray(volume.data), matrix, offset, out, value)
    else:
        raise ValueError(f"method is 'linear' or 'nearest', not {method!r}")
    return Volume(out, grid.affine)


def _fits(value: float, dtype: np.dtype[np.generic]) -> bool:
    """Tell whether an integer or bool type holds `value` exactly."""
    if not np.isfinite(value) or value != int(value):
        return False
    if dtype.kind == "b":
        return value in (0, 1)
    limits = np.iinfo(dtype)  # type: ignore[type-var]
    return bool(limits.min <= value <= limits.max)

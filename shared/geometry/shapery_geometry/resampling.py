"""Resampling of a volume onto another's grid; `Volume.resampled_to` is its face."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from shapery_geometry import _resampling_kernels as kernels
from shapery_geometry.concurrent import in_slabs


def resample(
    data: NDArray[Any],
    affine: NDArray[np.float64],
    shape: tuple[int, int, int],
    onto: NDArray[np.float64],
    *,
    method: Literal["linear", "nearest"] = "linear",
    fill: float = float("nan"),
) -> NDArray[Any]:
    """Return the values of a volume at the voxel centres of another grid.

    The target is written in one pass without an array of coordinates: beside `data` and the result (float32) it needs a
    C-contiguous float copy of `data` at the most.

    Parameters
    ----------
    data
        The values, (i, j, k).
    affine
        From their voxel indices to mm, 4 x 4, invertible.
    shape, onto
        The grid on which they are wanted: its voxels along each axis, and its affine.
    method
        ``"linear"`` (trilinear) for intensities, ``"nearest"`` for labels.
    fill
        Value outside the field of view of `data`, which ends half a voxel beyond the outermost voxel centres; inside
        that margin the outermost value holds.

    Returns
    -------
    An array of `shape`. Linear: float32, float64 if `data` is; non-finite voxels carry no weight, and where they
    would carry more than half of it, the result is `fill`. Nearest: the type of `data`; a `fill` that the type cannot
    hold becomes 0.
    """
    # From the target's index to the source's, composed relative to the source's origin to keep the digits.
    inverse = np.ascontiguousarray(np.linalg.inv(affine)[:3, :3])
    matrix = np.ascontiguousarray(inverse @ onto[:3, :3])
    offset = inverse @ (onto[:3, 3] - affine[:3, 3])
    # Grids that agree but for rounding must meet voxel centres, or borders and labels would flicker.
    matrix[np.abs(matrix - np.round(matrix)) < 1e-9] = np.round(matrix)[np.abs(matrix - np.round(matrix)) < 1e-9]
    offset = np.where(np.abs(offset - np.round(offset)) < 1e-6, np.round(offset), offset)
    if method == "linear":
        kind = np.float64 if data.dtype == np.float64 else np.float32
        out = np.empty(shape, dtype=kind)
        values = np.ascontiguousarray(data, dtype=kind)
        scale = np.diagonal(matrix).copy()
        # What is not parallel only by rounding moves no voxel by more than a millionth of its size.
        crooked = float((np.abs(matrix - np.diag(scale)) @ np.array(shape, dtype=np.float64)).max())
        if min(values.shape) > 1 and crooked < 1e-6:
            kernels.linear_aligned(values, scale, offset, out, fill)
        else:
            in_slabs(lambda begin, end: kernels.linear(values, matrix, offset, out, fill, begin, end), shape)
    elif method == "nearest":
        dtype = data.dtype
        out = np.empty(shape, dtype=dtype)
        value = dtype.type(fill) if dtype.kind == "f" else dtype.type(fill if _fits(fill, dtype) else 0)
        kernels.nearest(np.ascontiguousarray(data), matrix, offset, out, value)
    else:
        raise ValueError(f"method is 'linear' or 'nearest', not {method!r}")
    return out


def _fits(value: float, dtype: np.dtype[np.generic]) -> bool:
    """Tell whether an integer or bool type holds `value` exactly."""
    if not np.isfinite(value) or value != int(value):
        return False
    if dtype.kind == "b":
        return value in (0, 1)
    limits = np.iinfo(dtype)  # type: ignore[type-var]
    return bool(limits.min <= value <= limits.max)

"""From the volumes as they were given to the grid that all work is done on (S10 without registration).

Everything inside happens on a *working grid*: axes nearest to right, anterior, superior; spacing close to 1 mm; cropped
to the head. Volumes whose voxels are near enough to that keep their voxels (they are only reordered, so the result does
not depend on how the file stores its axes); others are resampled. Lengths are millimetres throughout.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import Reorientation, Volume
from shapery_segmentation.blocks import block_means

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

WORKING_SPACING = 1.0
"""mm. Enhancing rims are 3 to 6 mm thick: coarser voxels lose them, finer ones cost time and show noise."""

KEPT_SPACING = (0.8, 1.25)
"""Voxels with all edges in this range (mm) are kept, because resampling would blur them for nothing."""

LEAST_EXTENT = 16.0
"""mm along every axis; less holds no brain to compare with."""

LEAST_COVERAGE = 0.5
"""Least share of the head after contrast that the volume before contrast must cover."""


@dataclass(frozen=True, eq=False)
class WorkingGrid:
    """The grid all work is done on, and the way back to the grid that was given.

    Parameters
    ----------
    shape, affine
        The grid; the affine leads from voxel index to RAS mm.
    source
        The volume after contrast, on whose grid results lie.
    reorientation, corner
        Where voxels were kept: the reordering of `source`, and the voxel of the reordered grid that is the working
        grid's first. Otherwise `reorientation` is None.
    """

    shape: tuple[int, int, int]
    affine: NDArray[np.float64]
    source: Volume
    reorientation: Reorientation | None
    corner: tuple[int, int, int] = (0, 0, 0)

    @property
    def spacing(self) -> float:
        """Edge of a voxel in mm: the cube root of its volume."""
        return float(abs(np.linalg.det(self.affine[:3, :3])) ** (1 / 3))

    def volume(self, data: NDArray[Any]) -> Volume:
        """Return `data` with this grid's affine."""
        return Volume(data, self.affine)

    def to_source(self, mask: BoolArray) -> BoolArray:
        """Return a mask of this grid on the grid that was given: bit for bit if voxels were kept, else interpolated."""
        if self.reorientation is not None:
            full = np.zeros(self.reorientation.target_shape, dtype=np.bool_)
            full[self._box] = mask
            return np.ascontiguousarray(self.reorientation.undo_array(full))
        out = np.zeros(self.source.shape, dtype=np.bool_)
        if mask.any():
            box = self._box_on_source(mask)
            part = np.broadcast_to(np.zeros((), np.uint8), tuple(s.stop - s.start for s in box))
            affine = self.source.affine.copy()
            affine[:3, 3] = self.source.to_world([s.start for s in box])
            values = Volume(mask.astype(np.float32), self.affine).resampled_to(Volume(part, affine), fill=0.0).data
            out[box] = values >= 0.5
        return out

    def _box_on_source(self, mask: BoolArray) -> tuple[slice, slice, slice]:
        """Return the part of the grid that was given that voxels of `mask`, not empty, reach."""
        ends = [
            np.flatnonzero(mask.any(axis=tuple(a for a in range(3) if a != axis)))[[0, -1]] + (-1, 1)
            for axis in range(3)
        ]
        corners = np.array(list(itertools.product(*ends)), dtype=np.float64)
        index = self.source.to_index(corners @ self.affine[:3, :3].T + self.affine[:3, 3])
        low = np.clip(np.floor(index.min(axis=0)), 0, np.array(self.source.shape) - 1).astype(int)
        high = np.clip(np.ceil(index.max(axis=0)) + 1, low + 1, self.source.shape).astype(int)
        i, j, k = (slice(int(a), int(b)) for a, b in zip(low, high, strict=True))
        return i, j, k

    def sample(self, volume: Volume) -> FloatArray:
        """Return `volume` on this grid: interpolated, averaged first where its voxels are finer; NaN outside."""
        if self.reorientation is not None and volume.same_grid(self.source):
            values = self.reorientation.apply_array(volume.data)[self._box]
            return np.ascontiguousarray(values, dtype=np.float32)
        grid = Volume(np.broadcast_to(np.zeros((), np.uint8), self.shape), self.affine)
        # In canonical order first: then blocks and sums are the same however the file stores its axes.
        coarse = averaged(volume.canonical()[0], self.spacing)
        return np.asarray(coarse.resampled_to(grid).data, dtype=np.float32)

    def cropped(self, low: NDArray[np.int64], high: NDArray[np.int64]) -> WorkingGrid:
        """Return the part from voxel `low` to before voxel `high`."""
        affine = self.affine.copy()
        affine[:3, 3] += affine[:3, :3] @ low
        a, b, c = (int(v) for v in high - low)
        i, j, k = (int(v) + w for v, w in zip(low, self.corner, strict=True))
        return WorkingGrid((a, b, c), affine, self.source, self.reorientation, (i, j, k))

    @property
    def _box(self) -> tuple[slice, slice, slice]:
        i, j, k = (slice(c, c + n) for c, n in zip(self.corner, self.shape, strict=True))
        return i, j, k


def check_volume(volume: Volume, name: str) -> None:
    """Refuse what cannot hold a head.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` for volumes of less than 16 mm or 3 voxels along an axis, without finite voxels, or without
        contrast.
    """
    extent = np.array(volume.shape) * volume.spacing
    if extent.min() < LEAST_EXTENT or min(volume.shape) < 3:
        raise InvalidInput(
            "invalid_volume",
            f"The {name} volume is {' × '.join(f'{e:.4g}' for e in extent)} mm in {' × '.join(map(str, volume.shape))} "
            "voxels: too small to hold a brain.",
            "Give the whole volume; if its header has a wrong spacing, mend that.",
        )
    figures = volume.statistics()
    if figures.finite == 0:
        raise InvalidInput("invalid_volume", f"None of the {volume.data.size} voxels of the {name} volume is finite.")
    if figures.minimum == figures.maximum:
        raise InvalidInput(
            "invalid_volume",
            f"Every voxel of the {name} volume is {figures.minimum:g}: it shows nothing.",
            "Check that the right file was given.",
        )
    if figures.finite < 0.5 * volume.data.size:
        raise InvalidInput(
            "invalid_volume",
            f"Only {figures.finite} of {volume.data.size} voxels of the {name} volume are finite.",
            "Replace NaN and infinite voxels by numbers.",
        )


def working_grid(source: Volume, spacing: float | None = None) -> WorkingGrid:
    """Return the working grid over all of `source`.

    Parameters
    ----------
    source
        The volume after contrast.
    spacing
        Edge of a voxel in mm. By default the source's own voxels if they are nearly cubes of 1 mm, else 1 mm.
    """
    axes = source.affine[:3, :3] / np.array(source.spacing)
    orthogonal = bool(np.abs(axes.T @ axes - np.eye(3)).max() < 0.01)
    near = all(KEPT_SPACING[0] <= s <= KEPT_SPACING[1] for s in source.spacing)
    reorientation = Reorientation.to_canonical(source)
    if spacing is None and orthogonal and near:
        return WorkingGrid(reorientation.target_shape, reorientation.target_affine, source, reorientation)
    step = WORKING_SPACING if spacing is None else spacing
    # The nearest rotation to the volume's own axes, so that thick slices stay parallel to the grid.
    canonical = reorientation.target_affine[:3, :3]
    u, _, vt = np.linalg.svd(canonical / np.sqrt((canonical**2).sum(axis=0)))
    rotation = u @ vt
    corners = source.corners() @ rotation
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    extent = corners.max(axis=0) - corners.min(axis=0)
    count = np.maximum(np.ceil(extent / step - 1e-6).astype(int) + 1, 1)
    affine = np.eye(4)
    affine[:3, :3] = rotation * step
    # Centred on the volume's centre: the same points whichever way the file stores its axes.
    affine[:3, 3] = rotation @ (middle - (count - 1) / 2 * step)
    return WorkingGrid((int(count[0]), int(count[1]), int(count[2])), affine, source, None)


def averaged(volume: Volume, step: float) -> Volume:
    """Return `volume` averaged over blocks of whole voxels, as large as fit into `step` mm.

    Point samples of finer voxels would carry their full noise into the coarser grid.
    """
    factors = [max(1, int(step / s + 0.25)) for s in volume.spacing]
    if max(factors) == 1:
        return volume
    counts = [max(1, n // f) for n, f in zip(volume.shape, factors, strict=True)]
    factors = [min(f, n) for f, n in zip(factors, volume.shape, strict=True)]
    # What does not fill a block is left out, half at either end.
    starts = [(n - c * f) // 2 for n, c, f in zip(volume.shape, counts, factors, strict=True)]
    data = volume.data[tuple(slice(a, a + c * f) for a, c, f in zip(starts, counts, factors, strict=True))]
    f, g, h = factors
    mean = block_means(data, (f, g, h))
    affine = volume.affine.copy()
    affine[:3, 3] += affine[:3, :3] @ (np.array(starts) + (np.array(factors) - 1) / 2)
    affine[:3, :3] = affine[:3, :3] * np.array(factors)
    return Volume(mean, affine)


def check_overlap(pre: Volume, post: Volume) -> list[str]:
    """Refuse a volume before contrast that evidently does not belong to the one after it; returns doubts as warnings.

    Raises
    ------
    InvalidInput
        ``grid_mismatch`` if `pre` covers less than half of the field of view of `post`.
    """
    if pre.same_grid(post):
        return []
    places = np.meshgrid(*(np.linspace(0, n - 1, 24) for n in post.shape), indexing="ij")
    share = float(pre.contains(post.to_world(np.stack(places, axis=-1))).mean())
    if share < LEAST_COVERAGE:
        raise InvalidInput(
            "grid_mismatch",
            f"The volume before contrast covers {share:.0%} of the one after contrast.",
            "Give two volumes of one session in one scanner frame, or register them first.",
        )
    return [f"The volume before contrast was resampled onto the grid of the one after it (it covers {share:.0%})."]

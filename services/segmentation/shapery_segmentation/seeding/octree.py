"""Octree search for cells whose histogram has two peaks (3.5.1–3.5.2, Fig. 3.11)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.concurrent import in_halves
from shapery_segmentation.seeding import _octree_kernels as kernels

LEVELS = (4, 8, 16)
"""Cells along each axis. The dissertation stops at 16 × 16 × 5 voxels of 256 × 256 × 100, which is about the 16 of the
last level; of a brain's 140 × 170 × 140 mm a cell then has 9 × 11 × 9 mm."""

LEAST_SEPARATION = 2.0
"""Ashman's D: distance of the peaks over the root mean square of their deviations. Above 2 two peaks are seen."""

LEAST_UPPER_MM3 = 60.0
"""The upper class must have this volume: less is a vessel's cross-section."""

LEAST_GAIN = 0.01
"""Nats per voxel by which two normal distributions must describe a cell better than one. With 500 voxels the Bayesian
information criterion asks for 3·ln(500)/(2·500) = 0.019 of a small cell, and for less of a large one."""


@dataclass(frozen=True, eq=False)
class OctreeCandidates:
    """Where the search found two classes.

    Parameters
    ----------
    peak : (cells, cells, cells) float32
        Mean of the upper class in the cells of the last level that are candidates at any level; 0 elsewhere. The
        finest level that found a cell says its peak.
    edges : (3, cells + 1) int64
        Voxels at which those cells begin and end along each axis.
    levels
        Number of candidates per level.
    """

    peak: NDArray[np.float32]
    edges: NDArray[np.int64]
    levels: tuple[int, ...]

    def on_grid(self, shape: tuple[int, int, int]) -> NDArray[np.float32]:
        """Return `peak` of the cell that each voxel lies in, (I, J, K)."""
        out: NDArray[np.float32] = np.zeros(shape, dtype=np.float32)
        spans = [np.diff(e) for e in self.edges]
        values = self.peak
        for axis, span in enumerate(spans):
            values = np.repeat(values, span, axis=axis)
        i, j, k = (slice(int(e[0]), int(e[-1])) for e in self.edges)
        out[i, j, k] = values
        return out


def search_octree(
    field: NDArray[np.float32], brain: NDArray[np.bool_], spacing: float, threshold: float
) -> OctreeCandidates:
    """Find the cells in which two classes of voxels are told apart, one of them enhancing.

    Parameters
    ----------
    field : (I, J, K) float32
        Calibrated difference.
    brain : (I, J, K) bool
    spacing
        Edge of a voxel in mm.
    threshold
        What the upper class must exceed on average, in units of `field`.

    Notes
    -----
    A candidate: Ashman's D above 2, an upper class of at least 60 mm³ with its mean above `threshold`, and a
    description shorter than with one normal distribution. Deviations from the text, which stops at the first level
    with a sign of a tumor: all levels are searched, because a second, smaller tumor may be seen on a finer one; and a
    cell that lies in a tumor altogether, so has one peak, is a candidate if that peak exceeds `threshold`.

    References
    ----------
    K. A. Ashman, C. M. Bird, S. E. Zepf, "Detecting bimodality in astronomical datasets", Astron. J. 108 (1994),
    doi:10.1086/117248.
    """
    finest = LEVELS[-1]
    bounds = _bounding_box(brain)
    bottom, top = -6.0, max(4.0 * threshold, float(np.percentile(field[brain], 99.9)))
    width = (top - bottom) / kernels.BINS
    peak = np.zeros((finest,) * 3, dtype=np.float32)
    fine_edges = _edges(bounds, finest)
    found = []
    for cells in LEVELS:
        # The finest edges, taken in groups, so that the cells of a level are made of whole cells of the next.
        edges = np.ascontiguousarray(fine_edges[:, :: finest // cells])
        candidate, mean = _judge(_fits(field, brain, edges, bottom, width, threshold), spacing, threshold)
        found.append(int(candidate.sum()))
        ratio = finest // cells
        for axis in range(3):
            candidate, mean = np.repeat(candidate, ratio, axis=axis), np.repeat(mean, ratio, axis=axis)
        peak[candidate] = mean[candidate]
    return OctreeCandidates(peak, fine_edges, tuple(found))


def _fits(
    field: NDArray[np.float32],
    brain: NDArray[np.bool_],
    edges: NDArray[np.int64],
    bottom: float,
    width: float,
    threshold: float,
) -> NDArray[np.float64]:
    """Return what `_octree_kernels.scan` writes, for all cells of a level."""
    cells = edges.shape[1] - 1
    results = np.zeros((cells, cells, cells, 8))

    def scan(begin: int, end: int) -> None:
        kernels.scan(field, brain, edges, bottom, width, threshold, begin, end, results)

    in_halves(scan, cells, 2)
    return results


def _judge(
    results: NDArray[np.float64], spacing: float, threshold: float
) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
    lower, upper = results[..., 0:3], results[..., 3:6]
    gain, total = results[..., 6], results[..., 7]
    with np.errstate(divide="ignore", invalid="ignore"):
        separation = np.sqrt(2.0) * (upper[..., 1] - lower[..., 1]) / np.hypot(upper[..., 2], lower[..., 2])
    volume = upper[..., 0] * total * spacing**3
    two = (separation > LEAST_SEPARATION) & (volume > LEAST_UPPER_MM3) & (gain > LEAST_GAIN)
    two &= upper[..., 1] > threshold
    whole = (lower[..., 0] * lower[..., 1] + upper[..., 0] * upper[..., 1] > threshold) & (
        total * spacing**3 > LEAST_UPPER_MM3
    )
    mean = np.where(two, upper[..., 1], np.maximum(lower[..., 1], upper[..., 1]))
    return two | whole, np.asarray(mean, dtype=np.float32)


def _bounding_box(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    bounds = []
    for axis in range(3):
        line = np.flatnonzero(mask.any(axis=tuple(a for a in range(3) if a != axis)))
        bounds.append((line[0], line[-1] + 1))
    return np.array(bounds, dtype=np.int64)


def _edges(bounds: NDArray[np.int64], cells: int) -> NDArray[np.int64]:
    return np.array([np.round(np.linspace(a, b, cells + 1)) for a, b in bounds], dtype=np.int64)

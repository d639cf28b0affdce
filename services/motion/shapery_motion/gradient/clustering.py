"""Grouping of the faces by how they move: Algorithm 1, step 3 of section 5.4."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from shapery_motion.gradient import _cluster_kernels as kernels
from shapery_motion.gradient import _deformation_kernels as deformation_kernels
from shapery_motion.gradient.deformation import FaceFrames, FloatArray

Representative = Literal["least_squares", "member"]

SAMPLE: Final = 8
"""Faces for each cluster that move the centres, where there are more."""
LEAST: Final = 4096
"""Faces that do so at least."""


@dataclass(frozen=True, eq=False)
class FaceClusters:
    """Faces grouped by their transformations."""

    labels: NDArray[np.int32]
    """(m,) the cluster of each face."""
    centres: FloatArray
    """(k, 9) the mean transformation of each cluster, row by row."""

    @property
    def count(self) -> int:
        """Number k of clusters."""
        return len(self.centres)


def cluster_faces(
    gradients: FloatArray,
    solid: NDArray[np.bool_],
    count: int,
    rng: np.random.Generator,
    *,
    initial: FloatArray | None = None,
    iterations: int = 12,
    tolerance: float = 1e-3,
) -> FaceClusters:
    """Group faces by their transformations with k-means.

    Parameters
    ----------
    gradients : (m, 3, 3)
        Q of each face; the distance is the Frobenius norm of differences.
    solid : (m,) bool
        Degenerate faces, whose Q says nothing, get a label but move no centre.
    count
        Number of clusters; with as many as solid faces each gets its own, and the result is exact.
    rng
        Draws the first centres (k-means++).
    initial : (k, 9)
        Centres to start from instead, such as those of the frame before, which saves most of the iterations. Where
        there are fewer than `count`, the points that lie farthest from them are added.
    iterations
        At most this many.
    tolerance
        Ends the iteration when the sum of squares falls by less than this share.

    Returns
    -------
    FaceClusters
        With at most `count` clusters: fewer where fewer different transformations exist. They are numbered by the first
        face that has them; or as in `initial`, so that numbers keep their meaning from frame to frame, and then some
        may have no faces.
    """
    points = np.ascontiguousarray(gradients.reshape(-1, 9))
    active = np.ascontiguousarray(points[solid])
    labels = np.zeros(len(points), dtype=np.int32)
    if count < 1:
        raise ValueError(f"the number of clusters must be positive, not {count}")
    if not len(active):
        return FaceClusters(labels, np.eye(3).reshape(1, 9))
    if count >= len(active):
        labels[solid] = np.arange(len(active), dtype=np.int32)
        return FaceClusters(labels, active.copy())
    sample = max(SAMPLE * count, LEAST)
    # centres move by a part of the faces, evenly spread; at last all have a label
    part = active if len(active) <= sample else active[np.arange(sample) * len(active) // sample]
    centres = _first_centres(part, count, rng) if initial is None else _extended(part, initial, count)
    found = np.empty(len(part), dtype=np.int32)
    distances = np.empty(len(part))
    before = np.inf
    for _ in range(iterations):
        kernels.assign(part, np.ascontiguousarray(centres.T), found, distances)
        total = float(distances.sum())
        counts = np.empty(len(centres), dtype=np.int64)
        kernels.means(part, found, centres, counts)
        _fill_empty(part, distances, centres, counts)
        if before - total <= tolerance * total:
            break
        before = total
    found, distances = np.empty(len(active), dtype=np.int32), np.empty(len(active))
    kernels.assign(active, np.ascontiguousarray(centres.T), found, distances)
    labels[solid] = found
    return _numbered(labels, solid, centres) if initial is None else FaceClusters(labels, centres)


def cluster_matrices(
    clusters: FaceClusters,
    source: FaceFrames,
    target: NDArray[Any],
    gradients: FloatArray,
    *,
    representative: Representative = "least_squares",
) -> FloatArray:
    """Return one transformation (k, 3, 3) for each cluster.

    Parameters
    ----------
    clusters
        The groups of faces.
    source
        The faces of the key frame.
    target : (n, 3)
        The vertices of the intermediate frame.
    gradients : (m, 3, 3)
        Q of each face between the two.
    representative
        ``least_squares`` minimises Eq. 5.10; ``member`` takes the transformation of one face of the cluster, which the
        text found to do as well (here that nearest to the mean).

    Notes
    -----
    Eq. 5.10 has the solution (Σ Ṽ Vᵀ)(Σ V Vᵀ)⁻¹. Where the second sum is singular to rounding, which takes a cluster of
    needles in one plane, the mean of the transformations is used.
    """
    points = np.ascontiguousarray(gradients.reshape(-1, 9))
    if representative == "member":
        members = np.empty(clusters.count, dtype=np.int64)
        kernels.nearest_members(points, clusters.labels, clusters.centres, source.solid, members)
        chosen = np.where((members >= 0)[:, None], points[members], clusters.centres)
        return np.ascontiguousarray(chosen.reshape(-1, 3, 3))
    frames = deformation_kernels.edge_frames(target, source.faces)
    cross, square = (np.empty((clusters.count, 3, 3)) for _ in range(2))
    kernels.moments(clusters.labels, source.columns, frames, source.solid, cross, square)
    result = clusters.centres.reshape(-1, 3, 3).copy()
    values = np.linalg.eigvalsh(square)
    sound = values[:, 0] > 1e-12 * values[:, 2]
    # square is symmetric, so Q = cross · square⁻¹ is the transpose of square⁻¹ · crossᵀ
    result[sound] = np.linalg.solve(square[sound], cross[sound].transpose(0, 2, 1)).transpose(0, 2, 1)
    return result


def _first_centres(points: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    """k-means++: each further centre is a point drawn in proportion to its squared distance from those before."""
    chosen = np.empty(count, dtype=np.int64)
    found = kernels.draw_centres(points, int(rng.integers(len(points))), rng.random(count - 1), chosen)
    return points[chosen[:found]].copy()


def _extended(points: FloatArray, initial: FloatArray, count: int) -> FloatArray:
    """Return `count` centres: the first of `initial`, then the points that lie farthest from those."""
    centres = initial[:count].copy()
    missing = count - len(centres)
    if not missing:
        return centres
    labels = np.empty(len(points), dtype=np.int32)
    distances = np.empty(len(points))
    kernels.assign(points, np.ascontiguousarray(centres.T), labels, distances)
    far = np.argsort(-distances, kind="stable")[:missing]
    return np.concatenate((centres, points[far]))


def _fill_empty(points: FloatArray, distances: FloatArray, centres: FloatArray, counts: NDArray[np.int64]) -> None:
    """Move centres that lost all their points to the points that lie farthest from their own centres."""
    empty = np.flatnonzero(counts == 0)
    if len(empty):
        centres[empty] = points[np.argsort(-distances, kind="stable")[: len(empty)]]


def _numbered(labels: NDArray[np.int32], solid: NDArray[np.bool_], centres: FloatArray) -> FaceClusters:
    """Drop clusters without faces and number the others in the order in which faces first name them."""
    used, first = np.unique(labels[solid], return_index=True)
    order = used[np.argsort(first)]
    numbers = np.zeros(len(centres), dtype=np.int32)
    numbers[order] = np.arange(len(order), dtype=np.int32)
    renumbered = np.where(solid, numbers[labels], 0).astype(np.int32)
    return FaceClusters(renumbered, centres[order])

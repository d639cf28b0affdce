"""Prediction by one global affine transformation for each cluster of vertices (section 5.3.3, Fig. 5.3).

The text takes this from a method of others: vertices with a similar motion are grouped, and each group is moved by a
matrix in homogeneous coordinates. Neighbours in different groups move apart, which shows as cracks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_motion.baselines import _affine_kernels as kernels
from shapery_motion.gradient.clustering import cluster_faces

FloatArray = NDArray[np.float64]

TEXT_CLUSTERS = 256
"""How many matrices the text uses."""


@dataclass(frozen=True, eq=False)
class AffinePrediction:
    """Clusters of vertices and their transformations from the key frame to one frame."""

    labels: NDArray[np.int32]
    """(n,) the cluster of each vertex."""
    transforms: FloatArray
    """(k, 3, 4) the transformation of each."""
    vertices: FloatArray
    """(n, 3) the predicted frame."""


def predict_affine(
    key: NDArray[Any],
    target: NDArray[Any],
    clusters: int,
    rng: np.random.Generator,
    *,
    iterations: int = 30,
) -> AffinePrediction:
    """Group vertices by affine motion and move each group by its own transformation.

    Parameters
    ----------
    key, target : (n, 3)
        The key frame and the frame to predict.
    clusters
        Number k of groups; at most n.
    rng
        Draws the first groups.
    iterations
        At most this many rounds of fitting and regrouping, each of which lowers the error.

    Notes
    -----
    Starts from compact groups of the key frame's vertices. A transformation is fitted by least squares about the
    centre of its group; directions in which a group has no extent keep their length.
    """
    source, wanted = (np.ascontiguousarray(frame, dtype=np.float64) for frame in (key, target))
    n = len(source)
    centre = source.mean(axis=0)
    scale = max(float(np.abs(source - centre).max(initial=0.0)), 1e-300)
    local, moved = (source - centre) / scale, (wanted - centre) / scale
    # nine columns, as k-means over matrices has them: the six others are empty
    padded = np.zeros((n, 3, 3))
    padded[:, 0] = local
    labels = cluster_faces(padded, np.ones(n, dtype=bool), min(clusters, n), rng).labels
    count = int(labels.max(initial=0)) + 1
    errors = np.empty(n)
    before = np.inf
    transforms = _fitted(local, moved, labels, count)
    for _ in range(iterations):
        kernels.assign(local, moved, transforms, labels, errors)
        total = float(errors.sum())
        transforms = _fitted(local, moved, labels, count)
        if before - total <= 1e-4 * total:
            break
        before = total
    predicted = np.einsum("nij,nj->ni", transforms[labels][:, :, :3], local) + transforms[labels][:, :, 3]
    shifted = transforms.copy()
    shifted[:, :, 3] = scale * transforms[:, :, 3] + centre - transforms[:, :, :3] @ centre
    return AffinePrediction(labels, shifted, predicted * scale + centre)


def _fitted(source: FloatArray, target: FloatArray, labels: NDArray[np.int32], count: int) -> FloatArray:
    """Return the transformation (k, 3, 4) of least squares of each group; that of an empty group is the identity."""
    square, cross = np.empty((count, 4, 4)), np.empty((count, 3, 4))
    kernels.moments(source, target, labels, square, cross)
    sizes = np.maximum(square[:, 3, 3], 1.0)
    middle, moved = square[:, :3, 3] / sizes[:, None], cross[:, :, 3] / sizes[:, None]
    spread = square[:, :3, :3] - sizes[:, None, None] * middle[:, :, None] * middle[:, None, :]
    joint = cross[:, :, :3] - sizes[:, None, None] * moved[:, :, None] * middle[:, None, :]
    # drawn towards the identity by as much as decides only where there is nothing to fit
    little = 1e-10 * np.maximum(np.trace(spread, axis1=1, axis2=2), 1e-12)[:, None, None] * np.eye(3)
    linear = np.linalg.solve(spread + little, (joint + little).transpose(0, 2, 1)).transpose(0, 2, 1)
    empty = square[:, 3, 3] == 0
    linear[empty] = np.eye(3)
    return np.concatenate((linear, (moved - np.einsum("kij,kj->ki", linear, middle))[:, :, None]), axis=2)

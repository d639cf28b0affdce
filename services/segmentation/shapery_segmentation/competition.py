"""What in a box is the object: its voxels and those around the box compete for the rest (the general mode).

Whoever draws a box says three things: the middle of it is object, what lies just outside is not, and the object fills
it, more or less. From these follow a histogram of either side, and a weak expectation for every place. What a voxel's
own value leaves open, its neighbours decide: a random walker that starts there is held back by edges and ends at what
the values and the place say (a random walk with priors). Organs that touch others of the same intensity end so where
the edges are, or else where the box expects them, and not at the box's walls.

References
----------
L. Grady, "Multilabel random walker image segmentation using prior models", CVPR 2005, doi:10.1109/CVPR.2005.239.
C. Rother et al., "GrabCut", ACM Trans. Graph. 23 (2004), doi:10.1145/1015706.1015720: a box, and histograms that are
worked out anew from what was found.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.linalg import cg

from shapery_segmentation.neighborhoods import box_around

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

AROUND = 3
"""Voxels around the box that are known not to be object."""

CORE = 0.5
"""Share of the half axes of the box's ellipsoid within which voxels are object at first."""

STEEPNESS = 4.0
"""Of the expectation, across the ellipsoid's border: at its middle it is 0.98."""

BINS = 32
"""Of the histograms; their limits hold equal parts of the box's range without its extremes."""

PRIOR = 0.3
"""What a voxel's own value and place weigh, where an edge between neighbours without a step weighs 1."""

FIRM = 10.0
"""The same for voxels around the box."""

ROUNDS = 3
"""Times that histograms and the walk are worked out."""

SMOOTHING = 0.5
"""Voxels: deviation of the Gaussian over the values before."""

ORDINARY = 0.9
"""Share of the steps between neighbours, the smallest ones, whose mean square is the unit of a step."""

LEAST_LINK = 1e-4
"""What the largest step leaves of a link."""


def compete(values: NDArray[np.float32], usable: BoolArray) -> NDArray[np.float32]:
    """Return how likely each voxel belongs to the object in a box.

    Parameters
    ----------
    values : (I, J, K) float32
        Finite.
    usable : (I, J, K) bool
        The box, along the grid's axes.

    Returns
    -------
    (I, J, K) float32 in [0, 1]; 0 outside the box.
    """
    box = box_around(usable, usable.shape, AROUND)
    inside = usable[box]
    smooth = ndimage.gaussian_filter(values[box].astype(np.float64), SMOOTHING)
    away = _from_middle(inside)
    place = np.where(inside, 1.0 / (1.0 + np.exp(STEEPNESS * (away - 1.0))), 0.0)
    low, high = np.quantile(smooth[inside], (0.005, 0.995))
    bins = np.clip((smooth - low) / max(float(high - low), 1e-12) * BINS, 0, BINS - 1).astype(np.int64)
    links = _links(smooth)
    weight = np.where(inside, PRIOR, FIRM).ravel()
    system = (links + sparse.diags_array(weight)).tocsr()
    scale = sparse.diags_array(1.0 / system.diagonal())
    own = ((away < CORE) & inside).astype(np.float64)
    other = (~inside).astype(np.float64)
    likely = own
    for _ in range(ROUNDS):
        for_object = _histogram(bins, own) * place
        against = _histogram(bins, other) * (1.0 - place)
        prior = np.where(inside, for_object / np.maximum(for_object + against, 1e-30), 0.0)
        solution, _ = cg(system, weight * prior.ravel(), x0=likely.ravel(), rtol=1e-3, maxiter=200, M=scale)
        likely = solution.reshape(inside.shape)
        own, other = np.where(inside & (likely > 0.5), likely, 0.0), 1.0 - likely
    found = np.zeros(values.shape, dtype=np.float32)
    found[box] = np.where(inside, np.clip(likely, 0.0, 1.0), 0.0)
    return found


def _from_middle(inside: BoolArray) -> FloatArray:
    """Return the distance of every voxel from the middle of a box, 1 on the ellipsoid that fills it."""
    index = np.argwhere(inside)
    low, high = index.min(axis=0), index.max(axis=0)
    axes = [
        ((np.arange(n) - 0.5 * (a + b)) / (0.5 * (b - a + 1))) ** 2
        for n, a, b in zip(inside.shape, low, high, strict=True)
    ]
    return np.asarray(np.sqrt(axes[0][:, None, None] + axes[1][None, :, None] + axes[2][None, None, :]))


def _histogram(bins: NDArray[np.int64], weights: FloatArray) -> FloatArray:
    """Return the share of each voxel's bin in a weighted histogram, smoothed, as an array over the voxels."""
    counts = np.bincount(bins.ravel(), weights.ravel(), minlength=BINS)
    shares = ndimage.gaussian_filter1d(counts, 1.0) + 1e-3
    return np.asarray((shares / shares.sum())[bins])


def _links(values: FloatArray) -> sparse.csr_array:
    """Return the Laplacian of the grid, its links weakened by steps of the values."""
    number = np.arange(values.size).reshape(values.shape)
    pairs = [
        (number[a].ravel(), number[b].ravel())
        for axis in range(3)
        for a, b in [
            (
                tuple(slice(None, -1) if k == axis else slice(None) for k in range(3)),
                tuple(slice(1, None) if k == axis else slice(None) for k in range(3)),
            )
        ]
    ]
    start, end = (np.concatenate(side) for side in zip(*pairs, strict=True))
    steps = np.abs(values.ravel()[start] - values.ravel()[end])
    usual = float(np.mean(np.square(steps[steps <= np.quantile(steps, ORDINARY)])))
    link = np.exp(-np.square(steps) / max(2.0 * usual, 1e-30)) + LEAST_LINK
    both = sparse.csr_array(
        (np.concatenate((link, link)), (np.concatenate((start, end)), np.concatenate((end, start)))),
        shape=(values.size, values.size),
    )
    return sparse.csr_array(sparse.diags_array(np.asarray(both.sum(axis=1)).ravel()) - both)

"""What in a box is the object: its voxels and those around the box compete for the rest (the general mode).

Whoever draws a box says three things: the middle of it is object, what lies just outside is not, and the object fills
it, more or less. From these follow a histogram of either side, and a weak expectation for every place. What a voxel's
own value leaves open, its neighbours decide: a random walker that starts there is held back by edges and ends at what
the values and the place say (a random walk with priors). Organs that touch others of the same intensity end so where
the edges are, or else where the box expects them, and not at the box's walls.

Most objects are one tissue, whose values are one interval; what else was in the middle of the box, or has been won, is
then no reason to win more of it: fat around a spleen, lung above a liver. Others are not (a tumor with its necrosis).
Both are worked out. An object that is one tissue must still reach as far as the box tells; where it doesn't, it is not.

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

SEED_CORE = 0.25
"""The same around a seed, which is known to be object where the middle of the box need not be."""

STEEPNESS = 4.0
"""Of the expectation, across the ellipsoid's border: at its middle it is 0.98."""

BINS, SPREAD = 64, 2.0
"""Of the histograms, and the deviation in bins over which they are smoothed. All bins hold as many of the box's voxels:
where there is air or bone beside soft tissue, as in CT, bins of equal width would have all tissue in a few of them."""

ELSEWHERE = 0.05
"""What is left of the object's histogram outside of its interval, if it is one tissue."""

ANYTHING = 0.3
"""Share of what surrounds one tissue that is any value which the box holds: what was seen on neither side is not it."""

REACHED = 0.75
"""Share that the extents of one tissue, multiplied, have of those of the mixed object at the least; nine tenths along
each axis are 0.73."""

PRIOR = 0.2
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


def compete(values: NDArray[np.float32], usable: BoolArray, known: BoolArray | None = None) -> NDArray[np.float32]:
    """Return how likely each voxel belongs to the object in a box.

    Parameters
    ----------
    values : (I, J, K) float32
        Finite.
    usable : (I, J, K) bool
        The box, along the grid's axes.
    known : (I, J, K) bool, optional
        Voxels in the box that are taken for object at first; without them, the middle of the box is.

    Returns
    -------
    (I, J, K) float32 in [0, 1]; 0 outside the box.
    """
    box = box_around(usable, usable.shape, AROUND)
    inside = usable[box]
    smooth = ndimage.gaussian_filter(values[box].astype(np.float64), SMOOTHING)
    away = _away(inside)
    place = np.where(inside, 1.0 / (1.0 + np.exp(STEEPNESS * (away - 1.0))), 0.0)
    limits = np.quantile(smooth[inside], np.arange(1, BINS) / BINS)
    bins = np.searchsorted(limits, smooth)
    links = _links(smooth)
    weight = np.where(inside, PRIOR, FIRM).ravel()
    system = (links + sparse.diags_array(weight)).tocsr()
    scale = sparse.diags_array(1.0 / system.diagonal())
    core = inside & (away < CORE)
    begun = core if known is None else known[box] & inside

    def walk(start: BoolArray, one_tissue: bool) -> FloatArray:
        own = start.astype(np.float64)
        likely, other = own, (~inside).astype(np.float64)
        for _ in range(ROUNDS):
            mine, theirs = _histogram(bins, own), _histogram(bins, other)
            if one_tissue:
                theirs = (1.0 - ANYTHING) * theirs + ANYTHING / BINS
                mine = _interval(mine, theirs)
            for_object, against = mine[bins] * place, theirs[bins] * (1.0 - place)
            prior = np.where(inside, for_object / np.maximum(for_object + against, 1e-30), 0.0)
            solution, _ = cg(system, weight * prior.ravel(), x0=likely.ravel(), rtol=1e-3, maxiter=200, M=scale)
            likely = solution.reshape(inside.shape)
            own, other = np.where(inside & (likely > 0.5), likely, 0.0), 1.0 - likely
        return likely

    single, mixed = walk(begun, True), walk(core, False)
    likely = single if _extent(inside & (single > 0.5)) >= REACHED * _extent(inside & (mixed > 0.5)) else mixed
    found = np.zeros(values.shape, dtype=np.float32)
    found[box] = np.where(inside, np.clip(likely, 0.0, 1.0), 0.0)
    return found


def around(usable: BoolArray, seed: NDArray[np.int64]) -> BoolArray:
    """Return the voxels of a box around one of them that are object if that one is.

    Parameters
    ----------
    usable : (I, J, K) bool
        The box, along the grid's axes.
    seed : (3,) int64
    """
    return np.asarray(usable & (_away(usable, seed) < SEED_CORE))


def _away(inside: BoolArray, middle: NDArray[np.int64] | None = None) -> FloatArray:
    """Return the distance of every voxel from the middle of a box, 1 on the ellipsoid that fills it.

    With `middle`, (3,), from that voxel, in the same units.
    """
    index = np.argwhere(inside)
    low, high = index.min(axis=0), index.max(axis=0)
    center = 0.5 * (low + high) if middle is None else middle
    axes = [
        ((np.arange(n) - c) / (0.5 * (b - a + 1))) ** 2
        for n, c, a, b in zip(inside.shape, center, low, high, strict=True)
    ]
    return np.asarray(np.sqrt(axes[0][:, None, None] + axes[1][None, :, None] + axes[2][None, None, :]))


def _histogram(bins: NDArray[np.int64], weights: FloatArray) -> FloatArray:
    """Return a weighted histogram (BINS,), smoothed, of sum 1."""
    counts = np.bincount(bins.ravel(), weights.ravel(), minlength=BINS)
    shares = ndimage.gaussian_filter1d(counts, SPREAD) + 1e-3
    return np.asarray(shares / shares.sum())


def _interval(mine: FloatArray, theirs: FloatArray) -> FloatArray:
    """Return the histogram of an object that is one tissue: what it has in the interval that tells it best from others.

    That is the interval in which it has the most more than the others have.
    """
    ahead = np.concatenate(([0.0], np.cumsum(mine - theirs)))
    gains = ahead[None, :] - ahead[:, None]
    start, end = np.unravel_index(int(np.argmax(np.triu(gains, 1))), gains.shape)
    kept = np.full(BINS, ELSEWHERE)
    kept[start:end] = 1.0
    shares = mine * ndimage.gaussian_filter1d(kept, 1.0, mode="nearest") + 1e-4
    return np.asarray(shares / shares.sum())


def _extent(mask: BoolArray) -> float:
    """Return the volume of the box around the largest piece of a mask, in voxels."""
    labels, count = ndimage.label(mask)
    if not count:
        return 0.0
    place = ndimage.find_objects(labels)[int(np.argmax(np.bincount(labels.ravel())[1:]))]
    return float(np.prod([s.stop - s.start for s in place]))


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

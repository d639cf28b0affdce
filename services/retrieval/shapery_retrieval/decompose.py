"""Decomposition of a surface into nested parts: adaptive manifold mean shift, then normalized cut (section 4.4).

The surface is represented by samples spread evenly over it, each standing for the cell of vertices nearest to it, so
that windows are geodesic disks looked up in one matrix.

References
----------
D. Comaniciu, P. Meer, Mean shift: a robust approach toward feature space analysis, IEEE PAMI 24(5), 2002,
doi:10.1109/34.1000236.
J. Shi, J. Malik, Normalized cuts and image segmentation, IEEE PAMI 22(8), 2000, doi:10.1109/34.868688.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from shapery_retrieval import _decompose_kernels as kernels
from shapery_retrieval.signals import Signals

SAMPLES = 120
PARTS = (16, 32)
"""Number of parts of the levels below the root; a surface of fewer samples has as many parts as samples."""
NEIGHBOUR = 8
"""The smallest window reaches, in the median, to the neighbour of this rank."""
LARGEST_WINDOW, WINDOW_STEP = 3.0, 0.5
"""w_MAX and δw, in smallest windows."""
FEATURE_WINDOW = 1.0
"""Bandwidth of the features, which are of about unit spread."""
STEPS = 12
STABLE_SHIFT, STABLE_DENSITY = 0.5, 0.2
MERGE = 0.35
"""Two-way cuts of the modes that cost more than this are not made: they would part siblings."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Points spread evenly over a surface.

    Attributes
    ----------
    vertices : (s,) int64
        The vertex of each.
    reach : (s, n) float64
        Geodesic distance of each to every vertex.
    cells : (n,) int64
        The sample nearest to each vertex.
    areas : (s,) float64
        Share of the surface in each cell; in sum 1.
    """

    vertices: NDArray[np.int64]
    reach: NDArray[np.float64]
    cells: NDArray[np.int64]
    areas: NDArray[np.float64]

    @property
    def distances(self) -> NDArray[np.float64]:
        """(s, s) geodesic distances between samples, symmetric."""
        square = self.reach[:, self.vertices]
        return np.asarray((square + square.T) / 2)


@dataclass(frozen=True, eq=False)
class Decomposition:
    """Nested parts of a surface.

    Attributes
    ----------
    samples
        What the parts consist of.
    modes : (s,) int64
        The sample where the mean shift of each sample comes to rest.
    windows : (s,) float64
        The window that each sample took.
    components : (s,) int64
        Feature-enriched components: samples of one mode together, and sibling modes merged.
    levels
        For each level of the hierarchy the (s,) part of every sample. The first is all zero.
    """

    samples: Samples
    modes: NDArray[np.int64]
    windows: NDArray[np.float64]
    components: NDArray[np.int64]
    levels: tuple[NDArray[np.int64], ...]

    def vertex_labels(self, level: int) -> NDArray[np.int64]:
        """(n,) part of each vertex."""
        return np.asarray(self.levels[level][self.samples.cells])


def take_samples(signals: Signals, count: int = SAMPLES) -> Samples:
    """Spread samples over a surface, beginning at the tip where most heat stays."""
    first = int(np.argmax(signals.heat[:, 6]))
    vertices, reach = signals.geodesics.farthest_points(min(count, len(signals.areas)), first)
    return samples_at(vertices, reach, signals.areas)


def samples_at(vertices: NDArray[np.int64], reach: NDArray[np.float64], areas: NDArray[np.float64]) -> Samples:
    """Give every vertex to the sample nearest to it; samples without a vertex are left out."""
    cells = np.argmin(reach, axis=0)
    used, cells = np.unique(cells, return_inverse=True)
    cells = cells.reshape(-1)
    return Samples(vertices[used], reach[used], cells, np.bincount(cells, weights=areas).astype(np.float64))


def sample_features(signals: Signals, samples: Samples) -> NDArray[np.float64]:
    """(s, c) features by which parts are told apart, over each cell, of about unit spread.

    Spreads are floored, so that on a sphere, where nothing differs, noise is not made into features.
    """
    chosen = np.concatenate(
        (
            signals.heat[:, 2:12:3] / 0.8,
            signals.thickness[:, None] / 0.5,
            signals.mean_curvature[:, 1:2] / 0.6,
            signals.gaussian_curvature[:, 1:2] / 1.0,
        ),
        axis=1,
    )
    weighted = signals.areas[:, None] * chosen
    sums = np.stack([np.bincount(samples.cells, w, len(samples.areas)) for w in weighted.T], axis=1)
    means = sums / samples.areas[:, None]
    centred = means - samples.areas @ means
    spread = np.sqrt(samples.areas @ centred**2)
    return np.asarray(centred / np.maximum(spread, 0.35) / np.sqrt(chosen.shape[1] / 3))


def decompose(signals: Signals) -> Decomposition:
    """Decompose a surface into components, and these into nested levels."""
    samples = take_samples(signals)
    return decompose_samples(samples, sample_features(signals, samples))


def decompose_samples(samples: Samples, features: NDArray[np.float64]) -> Decomposition:
    """Decompose from samples and their features."""
    distances, areas = samples.distances, samples.areas
    s = len(areas)
    smallest = float(np.median(np.sort(distances, axis=1)[:, min(NEIGHBOUR, s - 1)]))
    first, _ = kernels.seek_modes(np.full(s, smallest), FEATURE_WINDOW, distances, features, areas, STEPS)
    modes = np.unique(first)
    stable, _ = kernels.largest_stable_windows(
        modes, smallest, LARGEST_WINDOW * smallest, WINDOW_STEP * smallest, FEATURE_WINDOW,
        distances, features, areas, STABLE_SHIFT, STABLE_DENSITY,
    )  # fmt: skip
    covered = distances[:, modes] <= stable
    windows = np.where(covered, stable, smallest).max(axis=1)
    places, found = kernels.seek_modes(windows, FEATURE_WINDOW, distances, features, areas, STEPS)
    apart = _squares(found)
    near = np.exp(-((distances / (2 * smallest)) ** 2))
    weights = near * np.exp(-apart / FEATURE_WINDOW**2)
    levels = [np.zeros(s, dtype=np.int64)]
    for parts in PARTS:
        levels.append(split_further(levels[-1], weights, areas, parts))
    return Decomposition(samples, places, windows, merge_siblings(places, found, near, areas), tuple(levels))


def merge_siblings(
    places: NDArray[np.int64], found: NDArray[np.float64], near: NDArray[np.float64], areas: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Cluster the modes by what is found there: sibling modes, apart in place but alike in feature, become one.

    Eq. 4.3 between clusters of samples of one mode, with a scale in the exponential, over clusters near each other.
    """
    modes, group = np.unique(places, return_inverse=True)
    group = group.reshape(-1)
    mass = np.bincount(group, weights=areas)
    member = np.zeros((len(modes), len(places)))
    member[group, np.arange(len(places))] = areas / mass[group]
    contact = member @ near @ member.T
    contact /= np.sqrt(np.outer(np.diag(contact), np.diag(contact)))
    weights = np.exp(-_squares(member @ found) / (0.5 * FEATURE_WINDOW) ** 2) * np.maximum(contact, 1e-3)
    labels = np.zeros(len(modes), dtype=np.int64)
    following = 1
    waiting = [0]
    while waiting:
        part = waiting.pop()
        inside = np.flatnonzero(labels == part)
        if len(inside) < 2:
            continue
        second, cost = normalized_cut(weights[np.ix_(inside, inside)])
        if cost < MERGE:
            labels[inside[second]] = following
            waiting += [part, following]
            following += 1
    return np.asarray(labels[group])


def split_further(
    labels: NDArray[np.int64], weights: NDArray[np.float64], areas: NDArray[np.float64], parts: int
) -> NDArray[np.int64]:
    """Cut parts in two until there are so many, or nothing is left to cut.

    The next cut is that of least cost for the root of the area that it divides. That of the heaviest part would often
    be made elsewhere in the next pose; the cheapest one would shave off small parts.
    """
    result = labels.copy()
    count = int(result.max()) + 1
    cuts: dict[int, tuple[float, NDArray[np.int64]]] = {}
    waiting = list(range(count))
    while count < parts:
        for part in waiting:
            inside = np.flatnonzero(result == part)
            if len(inside) > 1:
                second, cost = normalized_cut(weights[np.ix_(inside, inside)])
                cuts[part] = cost / float(np.sqrt(areas[inside].sum())), inside[second]
        if not cuts:
            break
        part = min(cuts, key=lambda known: cuts[known][0])
        result[cuts.pop(part)[1]] = count
        waiting = [part, count]
        count += 1
    return result


def normalized_cut(weights: NDArray[np.float64]) -> tuple[NDArray[np.bool_], float]:
    """Cut a graph in two at the threshold on its Fiedler vector where Ncut is least.

    Parameters
    ----------
    weights : (k, k) float64
        Symmetric, not negative; k at least 2.

    Returns
    -------
    second : (k,) bool
        Which nodes form the second part, the one without the first node.
    cost
        cut/assoc(A) + cut/assoc(B), in [0, 2].
    """
    k = len(weights)
    degrees = weights.sum(axis=1)
    root = 1 / np.sqrt(np.maximum(degrees, 1e-300))
    normalised = np.eye(k) - root[:, None] * weights * root
    fiedler = root * eigh(normalised, subset_by_index=[1, 1], check_finite=False)[1][:, 0]
    order = np.argsort(fiedler, kind="stable")
    sorted_weights = weights[np.ix_(order, order)]
    assoc = np.cumsum(degrees[order])[:-1]
    # what each row and column adds to the sum of the leading block
    inner = np.cumsum(2 * np.tril(sorted_weights, -1).sum(axis=1) + np.diag(sorted_weights))
    cut = assoc - inner[:-1]
    costs = cut / assoc + cut / np.maximum(degrees.sum() - assoc, 1e-300)
    at = int(np.argmin(costs))
    second = np.zeros(k, dtype=bool)
    second[order[at + 1 :]] = True
    if second[0]:
        second = ~second
    return second, float(costs[at])


def _squares(points: NDArray[np.float64]) -> NDArray[np.float64]:
    difference = points[:, None, :] - points[None, :, :]
    return np.asarray(np.einsum("ijk,ijk->ij", difference, difference))

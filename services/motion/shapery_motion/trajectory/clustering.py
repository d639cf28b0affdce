"""Clusters of vertices whose trajectories lie in a small common space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from shapery_motion.graph import VertexGraph

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

REDUCED: Final = 100
"""Dimensions in which trajectories are compared."""
MANY: Final = 64
FEW: Final = 24
"""Clusters from which merging starts, when there is time and when there is none."""
BIT: Final = 2.0 * np.log(2.0) / 12.0
"""Squared error, in squared steps, that a bit is worth where all numbers are quantised finely."""
SHARE: Final = 0.5
"""Share of the bits of independent numbers that smoothness leaves, about."""


def reduced(trajectories: FloatArray, dimensions: int = REDUCED) -> FloatArray:
    """Return the coordinates (n, d) of trajectories (n, t) in their d most important directions."""
    n, t = trajectories.shape
    d = min(n, t, dimensions)
    if t <= n:
        _, vectors = np.linalg.eigh(trajectories.T @ trajectories)
        return np.asarray(trajectories @ vectors[:, ::-1][:, :d])
    values, vectors = np.linalg.eigh(trajectories @ trajectories.T)
    return np.asarray(vectors[:, ::-1][:, :d] * np.sqrt(np.maximum(values[::-1][:d], 0.0)))


def spread_out(points: FloatArray, count: int) -> IntArray:
    """Return a label for each point: the nearest of `count` centres, each taken farthest from those before it."""
    nearest = ((points - points.mean(axis=0)) ** 2).sum(axis=1)
    labels = np.zeros(len(points), dtype=np.int64)
    distances = np.full(len(points), np.inf)
    at = int(nearest.argmax())
    for label in range(count):
        here = ((points - points[at]) ** 2).sum(axis=1)
        closer = here < distances
        labels[closer] = label
        distances = np.where(closer, here, distances)
        at = int(distances.argmax())
        if distances[at] == 0.0:
            break
    return compact(labels)


def compact(labels: IntArray) -> IntArray:
    """Return the labels numbered from 0 without gaps, in the order of their first vertices."""
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return np.asarray(rank[inverse.reshape(-1)])


@dataclass(frozen=True, slots=True)
class Worth:
    """What a cluster's modes cost and spare, all squared errors in units of the squared step.

    A mode of energy w costs its numbers' bits, n for the vertices and 3 F for the frames, of which smoothness leaves a
    share, and the error of their quantisation; without it, w is lost.
    """

    frames: int

    def of_modes(self, energies: FloatArray, vertices: int) -> tuple[float, int]:
        """Return the loss of a cluster by the falling energies of its modes, and how many of them pay."""
        numbers = vertices + 3 * self.frames
        kept = BIT * (_bits(energies, SHARE * vertices) + _bits(energies, SHARE * 3 * self.frames))
        kept += np.minimum(energies, numbers / 12.0)
        return float(np.minimum(kept, energies).sum()), int((kept < energies).sum())


def _bits(energies: FloatArray, numbers: float) -> FloatArray:
    return np.asarray(0.5 * numbers * np.log2(1.0 + energies / numbers))


def merge(points: FloatArray, labels: IntArray, worth: Worth) -> IntArray:
    """Join clusters two by two as long as that lowers the loss of all, the most profitable first.

    Parameters
    ----------
    points : (n, d)
        Reduced trajectories in units of the step.
    labels : (n,)
        Clusters from 0 without gaps.
    worth
        What modes cost.
    """
    labels = labels.copy()
    count = int(labels.max()) + 1
    grams = {label: points[labels == label].T @ points[labels == label] for label in range(count)}
    sizes = {label: int((labels == label).sum()) for label in range(count)}

    def loss(gram: FloatArray, size: int) -> float:
        return worth.of_modes(np.maximum(np.linalg.eigvalsh(gram)[::-1], 0.0), size)[0]

    losses = {label: loss(grams[label], sizes[label]) for label in grams}

    def gain(a: int, b: int) -> float:
        return losses[a] + losses[b] - loss(grams[a] + grams[b], sizes[a] + sizes[b])

    gains = {(a, b): gain(a, b) for a in grams for b in grams if a < b}
    while gains:
        (a, b), best = max(gains.items(), key=lambda item: item[1])
        if best <= 0.0:
            break
        labels[labels == b] = a
        grams[a] = grams[a] + grams.pop(b)
        sizes[a] += sizes.pop(b)
        losses[a] = loss(grams[a], sizes[a])
        gains = {pair: value for pair, value in gains.items() if a not in pair and b not in pair}
        gains |= {(min(a, c), max(a, c)): gain(a, c) for c in grams if c != a}
    return compact(labels)


def regroup(
    points: FloatArray,
    graph: VertexGraph,
    labels: IntArray,
    *,
    coherence: float,
    rounds: int,
    worth: Worth | None = None,
    dimensions: int = 6,
) -> IntArray:
    """Move vertices to the cluster whose modes hold them best, and let the modes follow (Lloyd's algorithm).

    Parameters
    ----------
    points : (n, d)
        Reduced trajectories.
    graph
        The mesh.
    labels : (n,)
        Where to start.
    coherence
        Squared distance that each neighbour of equal label is worth.
    rounds
        How often at the most.
    worth
        What modes cost; then each cluster has those that pay, and the vertices pay for their share of the bits.
    dimensions
        How many modes a cluster has where `worth` is not given.
    """
    energy = (points**2).sum(axis=1)
    n = len(points)
    adjacency = csr_array((np.ones(len(graph.neighbours)), graph.neighbours, graph.starts), shape=(n, n))
    for _ in range(rounds):
        count = int(labels.max()) + 1
        loss = np.empty((n, count))
        for label in range(count):
            own = points[labels == label]
            energies, vectors = np.linalg.eigh(own.T @ own)
            rank = dimensions
            if worth is not None:
                rank = max(1, worth.of_modes(np.maximum(energies[::-1], 0.0), len(own))[1])
            inside = (points @ vectors[:, ::-1][:, :rank]) ** 2
            loss[:, label] = np.maximum(energy - inside.sum(axis=1), 0.0)
            if worth is not None:
                loss[:, label] += BIT * SHARE * 0.5 * np.log2(1.0 + inside).sum(axis=1)
        member = np.zeros((n, count))
        member[np.arange(n), labels] = coherence
        found = (loss - adjacency @ member).argmin(axis=1)
        changed = int((found != labels).sum())
        labels = compact(found)
        if changed <= n // 500:
            break
    return labels


def find_clusters(
    trajectories: FloatArray, graph: VertexGraph, step: float, *, count: int | None, thorough: bool
) -> IntArray:
    """Divide the vertices into clusters.

    Parameters
    ----------
    trajectories : (n, F, 3)
        Of all vertices, without the offset.
    graph
        The mesh.
    step
        About the step that will be used.
    count
        How many clusters at the most are wanted; None: as many as pay.
    thorough
        Whether to start from many and to move vertices after the clusters were merged.
    """
    n, frames, _ = trajectories.shape
    many = MANY if thorough else FEW
    start = min(count if count is not None else max(1, min(many, n // 24)), n)
    if start == 1:
        return np.zeros(n, dtype=np.int64)
    points = reduced(trajectories.reshape(n, -1)) / step
    labels = regroup(points, graph, spread_out(points, start), coherence=200.0, rounds=6)
    if count is not None:
        return labels
    worth = Worth(frames)
    labels = merge(points, labels, worth)
    if thorough:
        labels = regroup(points, graph, labels, coherence=3.0, rounds=8, worth=worth)
    return labels

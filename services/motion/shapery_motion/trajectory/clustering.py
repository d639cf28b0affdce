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
SHARES: Final = (0.5, 0.3, 0.8)
"""Shares of the bits of independent numbers that smoothness may leave: it depends on the motion which is right."""


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
    share: float

    def of_modes(self, energies: FloatArray, vertices: int) -> tuple[float, int]:
        """Return the loss of a cluster by the falling energies of its modes, and how many of them pay."""
        numbers = vertices + 3 * self.frames
        kept = BIT * (_bits(energies, self.share * vertices) + _bits(energies, self.share * 3 * self.frames))
        kept += np.minimum(energies, numbers / 12.0)
        return float(np.minimum(kept, energies).sum()), int((kept < energies).sum())


def _bits(energies: FloatArray, numbers: float) -> FloatArray:
    return np.asarray(0.5 * numbers * np.log2(1.0 + energies / numbers))


class Spectra:
    """Energies of clusters and of their unions, each computed once.

    Parameters
    ----------
    points : (n, d)
        Reduced trajectories in units of the step.
    labels : (n,)
        Clusters from 0 without gaps, the parts of which unions are made.
    """

    def __init__(self, points: FloatArray, labels: IntArray) -> None:
        self.labels = labels
        self._grams = [points[labels == label].T @ points[labels == label] for label in range(int(labels.max()) + 1)]
        self._sizes = np.bincount(labels)
        self._known: dict[frozenset[int], FloatArray] = {}

    def __len__(self) -> int:
        return len(self._grams)

    def loss(self, parts: frozenset[int], worth: Worth) -> float:
        """Return the loss of the union of some clusters."""
        if parts not in self._known:
            gram = np.sum([self._grams[part] for part in sorted(parts)], axis=0)
            self._known[parts] = np.maximum(np.linalg.eigvalsh(gram)[::-1], 0.0)
        return worth.of_modes(self._known[parts], int(self._sizes[list(parts)].sum()))[0]


def merge(spectra: Spectra, worth: Worth) -> IntArray:
    """Join clusters two by two as long as that lowers the loss of all, the most profitable first; return the labels."""
    unions = {part: frozenset({part}) for part in range(len(spectra))}
    losses = {part: spectra.loss(union, worth) for part, union in unions.items()}

    def gain(a: int, b: int) -> float:
        return losses[a] + losses[b] - spectra.loss(unions[a] | unions[b], worth)

    gains = {(a, b): gain(a, b) for a in unions for b in unions if a < b}
    while gains:
        (a, b), best = max(gains.items(), key=lambda item: item[1])
        if best <= 0.0:
            break
        unions[a] |= unions.pop(b)
        losses[a] = spectra.loss(unions[a], worth)
        gains = {pair: value for pair, value in gains.items() if a not in pair and b not in pair}
        gains |= {(min(a, c), max(a, c)): gain(a, c) for c in unions if c != a}
    home = np.empty(len(spectra), dtype=np.int64)
    for part, union in unions.items():
        home[list(union)] = part
    return compact(home[spectra.labels])


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
                loss[:, label] += BIT * worth.share * 0.5 * np.log2(1.0 + inside).sum(axis=1)
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
) -> list[IntArray]:
    """Divide the vertices into clusters, in one way or in several to choose from.

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
        Whether to start from many, to move vertices after the clusters were merged, and to give several ways.

    Returns
    -------
    list of (n,)
        Labels from 0 without gaps; no two alike.
    """
    n, frames, _ = trajectories.shape
    many = MANY if thorough else FEW
    start = min(count if count is not None else max(1, min(many, n // 24)), n)
    if start == 1:
        return [np.zeros(n, dtype=np.int64)]
    points = reduced(trajectories.reshape(n, -1)) / step
    labels = regroup(points, graph, spread_out(points, start), coherence=200.0, rounds=6 if thorough else 3)
    if count is not None:
        return [labels]
    found: list[IntArray] = []
    spectra = Spectra(points, labels)
    for share in SHARES if thorough else SHARES[:1]:
        worth = Worth(frames, share)
        merged = merge(spectra, worth)
        if thorough:
            merged = regroup(points, graph, merged, coherence=1.0, rounds=8, worth=worth)
        if not any(np.array_equal(merged, other) for other in found):
            found.append(merged)
    return found

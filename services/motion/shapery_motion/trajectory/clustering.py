"""Clusters of vertices whose trajectories lie in a small common space."""

from __future__ import annotations

from collections.abc import Sequence
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
COARSE: Final = 40
"""Dimensions in which they are while clusters have few modes."""
MANY: Final = (64, 112)
FEW: Final = (24,)
"""Numbers of clusters from which merging starts, when there is time and when there is none."""
NEAR: Final = 12
"""With how many others, to which it is nearest, a cluster may merge."""
LAST_COHERENCE: Final = 1.0
"""Squared distance that each neighbour of equal label is worth once modes are known to cost something."""
DIMENSIONS: Final = 5
"""Modes of a cluster, beside its mean, before it is known how many pay."""
BIT: Final = 2.0 * np.log(2.0) / 12.0
"""Squared error, in squared steps, that a bit is worth where all numbers are quantised finely."""
SHARE: Final = 0.5
"""Share of the bits of independent numbers that smoothness leaves, where it was not measured."""


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
    share, and the error of their quantisation; without it, w is lost. The mean trajectory costs the latter alone.
    """

    frames: int
    in_space: float
    """The share of a field's numbers."""
    in_time: float
    """The share of a function's numbers."""

    def of_modes(self, energies: FloatArray, vertices: int) -> tuple[float, int]:
        """Return the loss of a cluster by the falling energies of its modes, and how many of them pay."""
        numbers = vertices + 3 * self.frames
        kept = BIT * (_bits(energies, self.in_space * vertices) + _bits(energies, self.in_time * 3 * self.frames))
        kept += np.minimum(energies, numbers / 12.0)
        return float(np.minimum(kept, energies).sum()), int((kept < energies).sum())

    def of_mean(self, energy: float) -> float:
        """Return the loss of a mean trajectory by its energy, times the number of vertices."""
        numbers = 3.0 * self.frames
        return float(BIT * _bits(np.array([energy]), self.in_time * numbers)[0]) + min(energy, numbers / 12.0)


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
        self._sums = np.array([points[labels == label].sum(axis=0) for label in range(int(labels.max()) + 1)])
        self._sizes = np.bincount(labels)
        self._moments: dict[frozenset[int], tuple[FloatArray, FloatArray, int]] = {}
        self._known: dict[frozenset[int], tuple[FloatArray, float]] = {}

    def __len__(self) -> int:
        return len(self._grams)

    def loss(self, union: frozenset[int], other: frozenset[int], worth: Worth) -> float:
        """Return the loss of two unions of clusters together; the other one may be empty."""
        parts = union | other
        if parts not in self._known:
            (gram, total, count), (more, rest, others) = self._moments_of(union), self._moments_of(other)
            gram, total, count = gram + more, total + rest, count + others
            energies = np.linalg.eigvalsh(gram - np.outer(total, total) / count)[::-1]
            self._known[parts] = np.maximum(energies, 0.0), float(total @ total) / count
        energies, middle = self._known[parts]
        return worth.of_modes(energies, int(self._sizes[list(parts)].sum()))[0] + worth.of_mean(middle)

    def _moments_of(self, parts: frozenset[int]) -> tuple[FloatArray, FloatArray, int]:
        if parts not in self._moments:
            some = sorted(parts)
            gram = np.zeros_like(self._grams[0])
            for part in some:
                gram += self._grams[part]
            self._moments[parts] = gram, self._sums[some].sum(axis=0), int(self._sizes[some].sum())
        return self._moments[parts]

    def near(self) -> dict[int, set[int]]:
        """Return for each part the others that lie nearest to the space of its strongest modes, or it to theirs."""
        grams = np.stack(self._grams)
        traces = np.trace(grams, axis1=1, axis2=2)
        away = np.empty((len(self), len(self)))
        for part, gram in enumerate(grams):
            modes = np.linalg.eigh(gram)[1][:, ::-1][:, :DIMENSIONS]
            away[part] = (traces - ((grams @ modes) * modes).sum(axis=(1, 2))) / self._sizes
        result: dict[int, set[int]] = {part: set() for part in range(len(self))}
        for part, order in enumerate(np.argsort(np.minimum(away, away.T), axis=1, kind="stable").tolist()):
            for other in [other for other in order if other != part][:NEAR]:
                result[part].add(other)
                result[other].add(part)
        return result


def merge(spectra: Spectra, worth: Worth) -> IntArray:
    """Join near clusters two by two as long as that lowers the loss, the most profitable first; return the labels."""
    unions = {part: frozenset({part}) for part in range(len(spectra))}
    losses = {part: spectra.loss(union, frozenset(), worth) for part, union in unions.items()}
    near = spectra.near()

    def gain(a: int, b: int) -> float:
        return losses[a] + losses[b] - spectra.loss(unions[a], unions[b], worth)

    gains = {(a, b): gain(a, b) for a in unions for b in near[a] if a < b}
    while gains:
        (a, b), best = max(gains.items(), key=lambda item: item[1])
        if best <= 0.0:
            break
        unions[a] |= unions.pop(b)
        losses[a] = spectra.loss(unions[a], frozenset(), worth)
        near[a] = (near[a] | near.pop(b)) - {a, b}
        for c in near[a]:
            near[c] = (near[c] - {b}) | {a}
        gains = {pair: value for pair, value in gains.items() if a not in pair and b not in pair}
        gains |= {(min(a, c), max(a, c)): gain(a, c) for c in sorted(near[a])}
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
    dimensions: int = DIMENSIONS,
) -> IntArray:
    """Move vertices to the cluster whose mean and modes hold them best, and let the modes follow (Lloyd's algorithm).

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
    n = len(points)
    squares = (points**2).sum(axis=1)
    adjacency = csr_array((np.ones(len(graph.neighbours)), graph.neighbours, graph.starts), shape=(n, n))
    for _ in range(rounds):
        count = int(labels.max()) + 1
        loss = np.empty((n, count))
        for label in range(count):
            own = points[labels == label]
            middle = own.mean(axis=0)
            energies, vectors = np.linalg.eigh((own - middle).T @ (own - middle))
            rank = dimensions
            if worth is not None:
                rank = max(1, worth.of_modes(np.maximum(energies[::-1], 0.0), len(own))[1])
            chosen = vectors[:, ::-1][:, :rank]
            inside = (points @ chosen - middle @ chosen) ** 2
            away = squares - points @ (2.0 * middle) + middle @ middle
            loss[:, label] = np.maximum(away - inside.sum(axis=1), 0.0)
            if worth is not None:
                # single precision takes a quarter of the time
                bits = np.log2(1.0 + inside.astype(np.float32)).sum(axis=1)
                loss[:, label] += BIT * worth.in_space * 0.5 * bits
        member = np.zeros((n, count))
        member[np.arange(n), labels] = coherence
        found = (loss - adjacency @ member).argmin(axis=1)
        changed = int((found != labels).sum())
        labels = compact(found)
        if changed <= n // 500:
            break
    return labels


def share_of(bits: float, energies: list[FloatArray], numbers: list[int]) -> float:
    """Return the share at which modes of some energies, in squared steps, cost some bits.

    Parameters
    ----------
    bits
        What they took.
    energies, numbers
        For each cluster those of its modes, and how many numbers each of its modes has.
    """
    low, high = 0.02, 3.0
    for _ in range(20):
        share = 0.5 * (low + high)
        if sum(float(_bits(e, share * n).sum()) for e, n in zip(energies, numbers, strict=True)) > bits:
            high = share
        else:
            low = share
    return 0.5 * (low + high)


def find_clusters(
    points: FloatArray,
    graph: VertexGraph,
    step: float,
    worth: Worth,
    *,
    count: int | None,
    many: Sequence[int],
    moves: tuple[int, int],
) -> list[IntArray]:
    """Divide the vertices into clusters, in one way or in several to choose from.

    Parameters
    ----------
    points : (n, d)
        Trajectories in their most important directions.
    graph
        The mesh.
    step
        About the step that will be used.
    worth
        What modes cost.
    count
        How many clusters at the most are wanted; None: as many as pay.
    many
        Numbers of clusters from which merging starts: each leads to a way.
    moves
        How often vertices are moved, at the most, before and after clusters are merged.

    Returns
    -------
    list of (n,)
        Labels from 0 without gaps; no two alike.
    """
    n = len(points)
    starts = sorted({max(1, min(k, n // 24)) for k in many} if count is None else {min(count, n)})
    if starts == [1]:
        return [np.zeros(n, dtype=np.int64)]
    points = points[:, :REDUCED] / step
    coarse = np.ascontiguousarray(points[:, :COARSE])
    found: list[IntArray] = []
    for start in starts:
        labels = regroup(coarse, graph, spread_out(coarse, start), coherence=200.0, rounds=moves[0])
        if count is not None:
            return [labels]
        merged = merge(Spectra(points, labels), worth)
        if moves[1]:
            merged = regroup(points, graph, merged, coherence=LAST_COHERENCE, rounds=moves[1], worth=worth)
        if not any(np.array_equal(merged, other) for other in found):
            found.append(merged)
    return found

"""Clusters of vertices whose trajectories lie in a small common space."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from shapery_motion.graph import VertexGraph

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

REDUCED: Final = 100
"""Dimensions in which trajectories are compared."""


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


def space(points: FloatArray, dimensions: int) -> FloatArray:
    """Return an orthonormal basis (d, k) of the space that holds most of some points' energy."""
    _, vectors = np.linalg.eigh(points.T @ points)
    return np.asarray(vectors[:, ::-1][:, :dimensions])


def regroup(
    points: FloatArray, graph: VertexGraph, labels: IntArray, *, dimensions: int, coherence: float, rounds: int
) -> IntArray:
    """Move vertices to the cluster whose space holds them best, and let the spaces follow (Lloyd's algorithm).

    Parameters
    ----------
    points : (n, d)
        Trajectories, in units in which a squared distance of 1 is worth as much as a neighbour of equal label.
    graph
        The mesh.
    labels : (n,)
        Where to start.
    dimensions
        Of each cluster's space.
    coherence
        Worth of each neighbour of equal label.
    rounds
        How often at the most.
    """
    energy = (points**2).sum(axis=1)
    n = len(points)
    adjacency = csr_array((np.ones(len(graph.neighbours)), graph.neighbours, graph.starts), shape=(n, n))
    for _ in range(rounds):
        count = int(labels.max()) + 1
        loss = np.empty((n, count))
        for label in range(count):
            basis = space(points[labels == label], dimensions)
            loss[:, label] = energy - ((points @ basis) ** 2).sum(axis=1)
        member = np.zeros((n, count))
        member[np.arange(n), labels] = coherence
        found = (loss - adjacency @ member).argmin(axis=1)
        changed = int((found != labels).sum())
        labels = compact(found)
        if changed <= n // 500:
            break
    return labels

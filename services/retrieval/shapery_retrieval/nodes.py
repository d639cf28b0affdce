"""What the graph knows of each part of a surface, and of each pair of parts (sections 4.5 and 4.6)."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from shapery_retrieval.arg import Level
from shapery_retrieval.decompose import Decomposition, Samples
from shapery_retrieval.signals import Signals

_SIZES = (("heat", 16), ("wave", 16), ("thickness", 1), ("mean_curvature", 3), ("gaussian_curvature", 3))


def _columns() -> dict[str, slice]:
    result, place = {}, 0
    for name, size in _SIZES:
        for kind in ("mean", "dev"):
            result[f"{name}.{kind}"] = slice(place, place + size)
            place += size
    for name in ("geodesic.whole", "geodesic.mean", "geodesic.dev", "normal.dev"):
        result[name] = slice(place, place + 1)
        place += 1
    return result


COLUMNS = MappingProxyType(_columns())
"""Where each feature of a node lies. Means and deviations are weighted by area."""
FEATURES = max(columns.stop for columns in COLUMNS.values())

FV1 = (
    "normal.dev", "gaussian_curvature.dev", "gaussian_curvature.mean", "mean_curvature.dev", "mean_curvature.mean",
    "geodesic.dev", "geodesic.mean",
)  # fmt: skip
"""Eq. 4.4. The text writes n_dev and n_var for one thing; curvatures are those of the surface of unit area, spread at
three scales, because as they stand they are neither free of scale nor robust."""
FV2 = ("heat.mean",)
"""Eq. 4.5, over a component, with the square that it lacks."""


def columns_of(names: tuple[str, ...]) -> NDArray[np.int64]:
    """Return the columns of some features."""
    return np.concatenate([np.arange(COLUMNS[name].start, COLUMNS[name].stop) for name in names])


def stacked_signals(signals: Signals) -> NDArray[np.float64]:
    """(n, 39) the signals whose means and deviations are node features."""
    return np.concatenate(
        (
            signals.heat,
            signals.wave,
            signals.thickness[:, None],
            signals.mean_curvature,
            signals.gaussian_curvature,
        ),
        axis=1,
    )


def build_levels(signals: Signals, decomposition: Decomposition, edges: NDArray[np.integer]) -> tuple[Level, ...]:
    """Describe the parts of every level.

    Parameters
    ----------
    signals, decomposition
        Of one surface.
    edges : (e, 2)
        Pairs of vertices that touch.
    """
    levels: list[Level] = []
    values = stacked_signals(signals)
    samples = decomposition.samples
    distances = samples.distances
    mean_distance = float(samples.areas @ distances @ samples.areas)
    for number, labels in enumerate(decomposition.levels):
        k = int(labels.max()) + 1
        of_vertex = labels[samples.cells]
        masses = np.bincount(of_vertex, weights=signals.areas, minlength=k).astype(np.float64)
        masses /= masses.sum()
        share = np.zeros((k, len(labels)))
        share[labels, np.arange(len(labels))] = samples.areas / masses[labels]
        between = share @ distances @ share.T / mean_distance
        pairs = of_vertex[edges]
        touching = np.zeros((k, k), dtype=bool)
        touching[pairs[:, 0], pairs[:, 1]] = True
        touching |= touching.T
        np.fill_diagonal(touching, False)
        if number == 0:
            parents = np.full(1, -1, dtype=np.int32)
        else:
            parents = np.zeros(k, dtype=np.int32)
            parents[labels] = decomposition.levels[number - 1]
        features = _features(signals, values, samples, of_vertex, labels, masses, between)
        levels.append(
            Level(
                masses.astype(np.float32),
                features.astype(np.float16),
                ((between + between.T) / 2).astype(np.float32),
                touching,
                parents,
            )
        )
    return tuple(levels)


def _features(
    signals: Signals,
    values: NDArray[np.float64],
    samples: Samples,
    of_vertex: NDArray[np.int64],
    labels: NDArray[np.int64],
    masses: NDArray[np.float64],
    between: NDArray[np.float64],
) -> NDArray[np.float64]:
    k = len(masses)
    result = np.zeros((k, FEATURES))

    def means(columns: NDArray[np.float64]) -> NDArray[np.float64]:
        weighted = signals.areas[:, None] * columns
        sums = np.stack([np.bincount(of_vertex, w, k) for w in weighted.T], axis=1)
        return np.asarray(sums / masses[:, None])

    mean = means(values)
    deviation = np.sqrt(np.maximum(means((values - mean[of_vertex]) ** 2), 0.0))
    place = 0
    for name, size in _SIZES:
        result[:, COLUMNS[f"{name}.mean"]] = mean[:, place : place + size]
        result[:, COLUMNS[f"{name}.dev"]] = deviation[:, place : place + size]
        place += size
    # how far the part is from all others, and how far its points are from its centre for its size
    result[:, COLUMNS["geodesic.whole"]] = np.log(np.maximum(between @ masses, 1e-3))[:, None]
    distances = samples.distances
    for part in range(k):
        inside = np.flatnonzero(labels == part)
        local = distances[np.ix_(inside, inside)]
        weights = samples.areas[inside] / samples.areas[inside].sum()
        centre = inside[int(np.argmin(local @ weights))]
        vertices = of_vertex == part
        reach = samples.reach[centre, vertices]
        share = signals.areas[vertices] / signals.areas[vertices].sum()
        middle = float(share @ reach)
        size = np.sqrt(masses[part])
        result[part, COLUMNS["geodesic.mean"]] = middle / size
        result[part, COLUMNS["geodesic.dev"]] = np.sqrt(float(share @ (reach - middle) ** 2)) / size
    normal = means(signals.normals)
    result[:, COLUMNS["normal.dev"]] = np.sqrt(np.maximum(1 - (normal**2).sum(axis=1), 0.0))[:, None]
    return result

"""Measures of a ranking, leave one out.

References
----------
P. Shilane, P. Min, M. Kazhdan, T. Funkhouser, The Princeton Shape Benchmark, SMI 2004, doi:10.1109/SMI.2004.1314504.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measures:
    """Means over all queries."""

    nn: float
    """Share of queries whose nearest is of their class."""
    ft: float
    """First tier: recall among as many as the class has others; there precision equals recall (Table 4.1)."""
    st: float
    """Second tier: recall among twice as many."""
    map: float
    dcg: float

    def row(self) -> str:
        """Return the figures as cells of a Markdown table."""
        return " | ".join(f"{value:.3f}" for value in (self.nn, self.ft, self.st, self.map, self.dcg))


def relevance(scores: Array, labels: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(n, n − 1) whether what is ranked at each place, the query left out, is of the query's class."""
    n = len(labels)
    rows = np.empty((n, n - 1), dtype=bool)
    for i in range(n):
        others = np.flatnonzero(np.arange(n) != i)
        order = others[np.argsort(-scores[i, others], kind="stable")]
        rows[i] = labels[order] == labels[i]
    return rows


def per_query(relevant: NDArray[np.bool_]) -> dict[str, Array]:
    """Return each measure for each query."""
    m = relevant.shape[1]
    count = relevant.sum(axis=1)
    places = np.arange(1, m + 1)
    precision = np.cumsum(relevant, axis=1) / places
    gains = np.where(places == 1, 1.0, 1 / np.log2(np.maximum(places, 2)))
    ideal = np.cumsum(gains)[count - 1]
    within = np.cumsum(relevant, axis=1)
    rows = np.arange(len(relevant))
    return {
        "nn": relevant[:, 0].astype(np.float64),
        "ft": within[rows, count - 1] / count,
        "st": within[rows, np.minimum(2 * count, m) - 1] / count,
        "map": (precision * relevant).sum(axis=1) / count,
        "dcg": (relevant * gains).sum(axis=1) / ideal,
    }


def measure(scores: Array, labels: NDArray[np.int64]) -> Measures:
    """Return the means over all queries; `scores` are higher for what is more alike."""
    found = per_query(relevance(scores, labels))
    return Measures(**{name: float(values.mean()) for name, values in found.items()})


def precision_recall(relevant: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return mean precision and mean recall for each number of shapes retrieved (Fig. 4.9)."""
    hits = np.cumsum(relevant, axis=1)
    places = np.arange(1, relevant.shape[1] + 1)
    return (hits / places).mean(axis=0), (hits / relevant.sum(axis=1, keepdims=True)).mean(axis=0)


def class_matrix(scores: Array, labels: NDArray[np.int64]) -> Array:
    """(c, c) mean score between classes, the queries themselves left out (Fig. 4.8)."""
    classes = np.unique(labels)
    result = np.empty((len(classes), len(classes)))
    apart = ~np.eye(len(labels), dtype=bool)
    for a in classes:
        for b in classes:
            block = np.outer(labels == a, labels == b) & apart
            result[a, b] = scores[block].mean()
    return result

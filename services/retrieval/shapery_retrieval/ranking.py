"""From distances by many cues to one score: local scales, the gate between cues, and diffusion over the bank.

Nothing here knows labels. Each cue's distance becomes an affinity on the scale of both shapes' neighbourhoods, so that
cues of any unit can be averaged and one that says "far" stops voting; the gate then weighs groups of cues by how
clearly each one sets the nearest shapes apart, and by how far the other groups see the same.

References
----------
L. Zelnik-Manor, P. Perona, Self-tuning spectral clustering, NIPS 2004 (for local scales).
M. Donoser, H. Bischof, Diffusion processes for retrieval revisited, CVPR 2013, doi:10.1109/CVPR.2013.174.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

GROUPS: Mapping[str, Mapping[str, float]] = {
    "parts": {"parts": 1.0},
    "views": {"views": 1.0},
    "intrinsic": {"covariance": 0.4, "quantiles": 0.4, "wave_words": 0.2},
}
"""Cues of like nature vote together, with these weights; ``parts`` is the matching of the graphs below the root."""
TRUST: Mapping[str, float] = {"parts": 1.0, "views": 2.0, "intrinsic": 1.0}
"""How much a contrast is worth: views never set shapes apart as clearly as numbers of the surface do."""
RANK = 12
"""The scale of a neighbourhood is the distance to the neighbour of this rank."""
LEAST_SCALE = 1e-3
"""Below this lies what single precision makes of no distance at all."""
NEAR, FAR = 8, (16, 48)
"""Contrast is the mean affinity of so many nearest less that of these ranks."""
FLOOR = 0.02
NEIGHBOURHOOD = 600
"""So many nearest shapes are what a query is weighed against; a search compares no more by all cues."""
DAMPING = 0.9
MOST_NEIGHBOURS, NEIGHBOUR_SHARE = 10, 0.15
ONE_SIDED = 0.1

Array = NDArray[np.float64]


def local_scale(distances: Array) -> float:
    """Return the scale of a neighbourhood from the distances to all others, the item itself left out."""
    finite = distances[np.isfinite(distances)]
    if not len(finite):
        return 1.0
    rank = min(RANK, max(1, (len(finite) + 1) // 2))
    return max(float(np.partition(finite, rank - 1)[rank - 1]), LEAST_SCALE)


def local_scales(distances: Array, *, without: NDArray[np.int64] | None = None) -> Array:
    """Return the scales of all items' neighbourhoods from the (n, n) distances between them.

    With `without`, an (r,) list of items, the (r, n) scales of all others in a bank that lacks each one of these.
    """
    n = len(distances)
    if n < (2 if without is None else 3):
        return np.ones(n if without is None else (len(without), n))
    apart = distances.copy()
    np.fill_diagonal(apart, np.inf)
    if without is None:
        rank = min(RANK, max(1, n // 2))
        apart.partition(rank - 1, axis=1)
        return np.maximum(apart[:, rank - 1], LEAST_SCALE)
    rank = min(RANK, max(1, (n - 1) // 2))
    near = np.partition(apart, (rank - 1, rank), axis=1)[:, rank - 1 : rank + 1]
    # whoever is among the nearest makes room for the next one when it is left out
    scales = np.where(near[:, 0] < apart[:, without].T, near[:, 0], near[:, 1])
    return np.asarray(np.maximum(scales, LEAST_SCALE))


def affinity(distances: Array, scale: float | Array, scales: Array) -> Array:
    """exp(−d² / (r(q) r(x))): 1 at no distance."""
    return np.asarray(np.exp(-(distances**2) / (scale * scales)))


def contrast(affinities: Array) -> Array:
    """How clearly the nearest stand out, for each row; at least `FLOOR`."""
    n = affinities.shape[-1]
    if n <= FAR[0] + 1:
        return np.full(affinities.shape[:-1], 1.0)
    far = min(FAR[1], n)
    top = -np.sort(-np.partition(affinities, n - far, axis=-1)[..., n - far :], axis=-1)
    return np.asarray(np.maximum(top[..., :NEAR].mean(axis=-1) - top[..., FAR[0] : far].mean(axis=-1), FLOOR))


def gate(affinities: Mapping[str, Array]) -> dict[str, float]:
    """Weigh the groups by how clearly each sets shapes apart, and by how far the others bear it out.

    Parameters
    ----------
    affinities
        By each group the (n,) affinities of a query with all others.

    Returns
    -------
    Weights in sum 1: the squares of trust-weighted contrast times agreement, over their sum. A group agrees with
    another as far as their affinities correlate. Postures of two animals may look alike and set shapes apart as clearly
    as their surfaces do, but then the other groups know nothing of it. Of a large bank the `NEIGHBOURHOOD` alone
    counts, so that it makes no difference whether all shapes are looked at or the nearest ones.
    """
    groups = list(affinities)
    rows = np.stack([affinities[group] for group in groups])
    if rows.shape[1] > NEIGHBOURHOOD:
        rows = rows[:, np.argpartition(-rows.sum(axis=0), NEIGHBOURHOOD)[:NEIGHBOURHOOD]]
    contrasts = contrast(rows)
    agreement = np.ones(len(groups))
    if rows.shape[1] > FAR[0] + 1 and len(groups) > 1:
        rows = rows - rows.mean(axis=1, keepdims=True)
        rows /= np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-12)
        alike = np.maximum(rows @ rows.T, FLOOR)
        agreement = (alike.sum(axis=1) - np.diag(alike)) / (len(groups) - 1)
    strength = np.array([TRUST[group] for group in groups]) * (contrasts * agreement) ** 2
    return dict(zip(groups, (strength / strength.sum()).tolist(), strict=True))


def voted(group: str, affinities: Mapping[str, Array]) -> Array:
    """Return the affinities by a group from those by its cues."""
    return np.asarray(sum(weight * affinities[cue] for cue, weight in GROUPS[group].items()))


def diffuse(scores: Array) -> Array:
    """Re-rank: let similarity flow between neighbours.

    Parameters
    ----------
    scores : (n, n)
        In [0, 1]; 1 on the diagonal.

    Returns
    -------
    (n, n) symmetric, in [0, 1]
        (I − 0.9 N)⁻¹, normalised by its diagonal, where N is the normalised graph of mutual neighbours; one-sided ones
        count a tenth. How many neighbours an item has follows the density around it: of the nearest `MOST_NEIGHBOURS`
        each counts v²/(v² + s²), where v is its strength, the cube of the score, and s a share of that of the nearest
        three. With a threshold instead, scores that change by a hundredth would join or part whole classes.
    """
    n = len(scores)
    if n < 4:
        return scores
    strength = ((scores + scores.T) / 2) ** 3
    np.fill_diagonal(strength, 0.0)
    order = np.argsort(-strength, axis=1, kind="stable")[:, : min(MOST_NEIGHBOURS, n - 1)]
    values = np.take_along_axis(strength, order, axis=1)
    share = NEIGHBOUR_SHARE * values[:, :3].mean(axis=1, keepdims=True)
    near = np.zeros((n, n))
    np.put_along_axis(near, order, values**2 / np.maximum(values**2 + share**2, 1e-300), axis=1)
    graph = strength * ((1 - ONE_SIDED) * np.minimum(near, near.T) + ONE_SIDED * np.maximum(near, near.T))
    degrees = np.maximum(graph.sum(axis=1), 1e-12)
    flow = np.linalg.inv(np.eye(n) - DAMPING * graph / np.sqrt(np.outer(degrees, degrees)))
    root = np.sqrt(np.diag(flow))
    # where no path leads the first scores still order what remains
    return np.asarray((flow / np.outer(root, root) + 1e-3 * scores) / (1 + 1e-3))

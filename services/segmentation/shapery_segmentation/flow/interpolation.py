"""Geometric interpolation (S8, 3.4.4): where the data show no border, the vertices that lie on one say where it goes.

A vertex is trusted where the field differs between both of its sides, over a way long enough for noise to average out,
at least half as much as it does at a good part of the surface. Where slices are lost, a coil saw nothing, or noise has
the upper hand, the flow comes to rest on what happens to be there, or leaks. These vertices are put where Eq. 3.16
wants them between the trusted ones.

The text looks for this where many vertices oscillate. In a flow whose steps follow the field, as this one's do, what
oscillates is the steepest border, and what lies over lost data rests, so the trust decides alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

WORTHWHILE = 0.05
"""Share of the vertices that are not trusted above which it is worth while to interpolate."""

TRUSTED = 0.5
"""Share of the usual contrast from which a vertex is trusted."""

USUAL = 75.0
"""Percentile of the contrasts of all vertices that is the usual one."""

LEAST_TRUSTED = 0.5
"""Share of the vertices that must be trusted, or there is nothing to interpolate between."""

REACH, SAMPLES = 3.0, 6
"""Edge lengths to either side over which the contrast is taken, and points on each."""

SPREADS = 4
"""Averages over neighbours that it goes through."""

RINGS = 2
"""Rings of trusted vertices around the others that take part; the Laplacian of the first looks at the second."""

LEAST_WEIGHT = 0.1
"""Weight of a trusted vertex without any gradient. Zero would leave the system singular where all are such."""


def contrasts(
    points: FloatArray,
    faces: NDArray[np.int32],
    field: NDArray[np.float32],
    inverse: NDArray[np.floating[Any]],
    length: float,
) -> FloatArray:
    """Return how much more there is of the field inside than outside at each vertex, in units of what is usual.

    Parameters
    ----------
    points : (n, 3) float64
        RAS mm.
    faces : (m, 3) int32
        A closed, oriented mesh.
    field : (I, J, K) float32
    inverse : (3, 4) float64
        From RAS mm to index.
    length
        Edge length in mm.

    Returns
    -------
    (n,) float64; 0 where there is no contrast, 1 where it is the usual one. Which side has more is found out.
    """
    from scipy import ndimage, sparse

    corners = points[faces]
    normals = np.zeros(points.shape)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for k in range(3):
        np.add.at(normals, faces[:, k], across)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    start = points @ inverse[:, :3].T + inverse[:, 3]
    way = normals @ inverse[:, :3].T
    found = np.zeros(len(points))
    for step in REACH * length * np.arange(1, SAMPLES + 1) / SAMPLES:
        for side in (-1.0, 1.0):
            there = (start + side * step * way).T
            found -= side * ndimage.map_coordinates(field, there, order=1, mode="nearest")
    first, second = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    degree = np.maximum(np.bincount(first, minlength=len(points)), 1)
    mean = sparse.csr_array((1.0 / degree[first], (first, second)), shape=(len(points), len(points)))
    for _ in range(SPREADS):
        found = 0.5 * (found + mean @ found)
    found *= 1.0 if np.median(found) >= 0.0 else -1.0
    return np.asarray(found / max(float(np.percentile(found, USUAL)), 1e-30))


def interpolated(points: FloatArray, faces: NDArray[np.int32], trusted: BoolArray, weight: FloatArray) -> FloatArray:
    """Return the positions of vertices in the least-squares sense of Eq. 3.16.

    Parameters
    ----------
    points : (n, 3) float64
    faces : (m, 3) int32
        A closed, oriented mesh.
    trusted : (n,) bool
        C of Eq. 3.10, soft constraints.
    weight : (n,) float64
        ω of Eq. 3.16 in [0, 1] for the trusted ones: see `contrasts`.

    Returns
    -------
    (n, 3) float64; trusted vertices are returned as they are, and parts of the mesh that hold none.

    Notes
    -----
    Minimises ‖Lx‖² + Σ ω²‖x − v‖² through its normal equations (Lᵀ L + Ω²) x = Ω² v, with L the graph Laplacian of
    Eq. 3.14 (rows 1 and −1/valence). The text lets the trusted vertices move, too; here they only pull, because the
    flow has put them where its speed vanishes.
    """
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components
    from scipy.sparse.linalg import splu

    out = points.copy()
    n = len(points)
    # In a closed, oriented mesh every edge is met once in either direction.
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    adjacency = sparse.csr_matrix((np.ones(len(start)), (start, end)), shape=(n, n))
    _, piece = connected_components(adjacency, directed=False)
    loose = ~trusted & np.isin(piece, piece[trusted])
    if not loose.any():
        return out
    part = loose
    rows = part
    for ring in range(RINGS):
        part = part | (adjacency @ part.astype(np.float64) > 0)
        rows = part if ring + 1 < RINGS else rows
    valence = np.bincount(start, minlength=n)
    laplacian = sparse.eye(n, format="csr") - sparse.diags(1.0 / np.maximum(valence, 1)) @ adjacency
    a = laplacian[rows][:, part]
    squared = np.where(trusted, np.maximum(weight, LEAST_WEIGHT) ** 2, 0.0)[part]
    system = (a.T @ a + sparse.diags(squared)).tocsc()
    solution = splu(system, permc_spec="MMD_AT_PLUS_A").solve(squared[:, None] * points[part])
    out[loose] = solution[loose[part]]
    return out

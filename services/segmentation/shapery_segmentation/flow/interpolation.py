"""Geometric interpolation (S8, 3.4.4): where vertices keep oscillating, their trusted neighbours say where they belong.

Eq. 3.16 is solved around the vertices that have not come to rest only: further away nothing but trusted vertices lies,
and these stay where the flow has put them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

RINGS = 2
"""Rings of trusted vertices around the others that take part; the Laplacian of the first looks at the second."""

LEAST_WEIGHT = 0.1
"""Weight of a trusted vertex without any gradient. Zero would leave the system singular where all are such."""


def interpolated(points: FloatArray, faces: NDArray[np.int32], trusted: BoolArray, weight: FloatArray) -> FloatArray:
    """Return the positions of vertices in the least-squares sense of Eq. 3.16.

    Parameters
    ----------
    points : (n, 3) float64
    faces : (m, 3) int32
        A closed, oriented mesh.
    trusted : (n,) bool
        C of Eq. 3.10: vertices at rest, which are soft constraints.
    weight : (n,) float64
        ω of Eq. 3.16 in [0, 1] for the trusted ones: their gradients over the largest of them.

    Returns
    -------
    (n, 3) float64; trusted vertices are returned as they are.

    Notes
    -----
    Minimises ‖Lx‖² + Σ ω²‖x − v‖² through its normal equations (Lᵀ L + Ω²) x = Ω² v, with L the graph Laplacian of
    Eq. 3.14 (rows 1 and −1/valence). The text lets the trusted vertices move, too; here they only pull, because the
    flow has put them where its speed vanishes.
    """
    from scipy import sparse
    from scipy.sparse.linalg import splu

    out = points.copy()
    if trusted.all() or not trusted.any():
        return out
    n = len(points)
    # In a closed, oriented mesh every edge is met once in either direction.
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    adjacency = sparse.csr_matrix((np.ones(len(start)), (start, end)), shape=(n, n))
    part = ~trusted
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
    moved = ~trusted[part]
    out[~trusted] = solution[moved]
    return out
